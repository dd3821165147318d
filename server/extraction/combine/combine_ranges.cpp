#include "extraction/combine/combine_ranges.h"

#include <algorithm>
#include <string>

#include "base/parallel.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/cells/mesh_points.h"
#include "extraction/cells/mesh_sums.h"
#include "extraction/combine/combined_normals.h"
#include "extraction/combine/region_facets.h"
#include "extraction/combine/restrict_region.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/mesh/open_ends.h"

namespace isostrata {
namespace {

constexpr std::int64_t kRunsPerBlock = 512;

/// Fills the summaries' counts and volumes. A tetrahedron counts as inverted where rounding cannot be the cause; what is rounded
/// grows with each cut.
void summarise(const RegionMesh& mesh, std::size_t cuts, std::vector<IntervalSummary>& summaries, const Task& task) {
  const auto runs = static_cast<std::int64_t>(mesh.cell_runs.size());
  const std::int64_t blocks = (runs + kRunsPerBlock - 1) / kRunsPerBlock;
  std::vector<MeshSums> sums(blocks);
  parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t b = begin; b < end; ++b) {
      task.check();
      for (std::int64_t r = b * kRunsPerBlock; r < std::min(runs, (b + 1) * kRunsPerBlock); ++r) {
        const std::uint32_t first = mesh.cell_runs[r].first_tetrahedron;
        const auto last = r + 1 < runs ? mesh.cell_runs[r + 1].first_tetrahedron : static_cast<std::uint32_t>(mesh.count());
        Box3d box;
        for (std::uint32_t t = first; t < last; ++t)
          for (const std::uint32_t p : mesh.tetrahedra[t]) box.include(mesh.positions[p]);
        const double tolerance = handedness_of(0, box).tolerance * static_cast<double>(1 + cuts);
        std::vector<std::uint16_t> seen;
        for (std::uint32_t t = first; t < last; ++t) {
          IntervalSums& own = sums[b].of(mesh.labels[t]);
          if (std::find(seen.begin(), seen.end(), mesh.labels[t]) == seen.end()) {
            seen.push_back(mesh.labels[t]);
            ++own.active_cells;
          }
          const auto& p = mesh.tetrahedra[t];
          const double volume =
              orient3d(mesh.positions[p[0]], mesh.positions[p[1]], mesh.positions[p[2]], mesh.positions[p[3]]) / 6;
          ++own.tetrahedra;
          own.measure(volume, tolerance);
        }
      }
    }
  });
  for (const MeshSums& block : sums) block.add_to(summaries);
}

RegionMesh as_region(IntervalMesh& base, std::size_t intervals, std::vector<Buffer<double>> fields, bool facets) {
  RegionMesh region;
  region.positions = std::move(base.positions);
  region.fields = std::move(fields);
  region.tetrahedra = std::move(base.tetrahedra);
  region.labels = std::move(base.tetrahedron_interval);
  region.cell_runs = std::move(base.cell_runs);
  for (std::uint16_t& label : region.labels)
    if (label >= intervals) label = kOutsideRegion;
  if (!facets) return region;
  region.domain_facets.assign(region.tetrahedra.size(), 0);
  for (const BoundaryFacet& facet : base.facets) {
    if (facet.label != FacetLabel::domain) continue;
    const auto& points = region.tetrahedra[facet.tetrahedron];
    for (int i = 0; i < 4; ++i)
      if (std::find(facet.points.begin(), facet.points.end(), points[i]) == facet.points.end())
        region.domain_facets[facet.tetrahedron] |= static_cast<std::uint8_t>(1u << i);
  }
  return region;
}

}  // namespace

Combined combine_ranges(IntervalMesh base, std::size_t intervals, std::vector<Buffer<double>> fields,
                        std::span<const FieldTerm> terms, const CombineOptions& options, const Task& task) {
  Combined out;
  out.mesh.cells = base.cells;
  out.mesh.strict = base.strict;
  std::vector<RangeOfField> ranges;
  std::vector<std::uint16_t> own;  // [labels] into ranges
  for (std::size_t i = 0; i < intervals; ++i) {
    out.mesh.summaries.emplace_back();
    out.mesh.summaries.back().interval = base.summaries[i].interval;
    ranges.push_back({0, base.summaries[i].interval});
    own.push_back(static_cast<std::uint16_t>(i));
  }
  if (intervals + terms.size() >= kOutsideRegion)
    throw Error(ErrorCode::invalid_argument, std::to_string(intervals) + " intervals and " + std::to_string(terms.size()) +
                                                 " terms given; expected fewer than " + std::to_string(kOutsideRegion) +
                                                 " together");
  std::vector<RegionTerm> chain;
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const FieldTerm& term = terms[k];
    (void)IsoRules({&term.range, 1});  // throws if the range is not one
    chain.push_back({term.op, term.field, term.range, kOutsideRegion});
    ranges.push_back({term.field, term.range});
    if (!adds(term.op)) continue;
    chain.back().label = static_cast<std::uint16_t>(out.mesh.summaries.size());
    out.mesh.summaries.emplace_back();
    out.mesh.summaries.back().interval = with_open_ends(term.range.lower, term.range.upper);
    out.mesh.summaries.back().term = static_cast<int>(k);
    own.push_back(static_cast<std::uint16_t>(ranges.size() - 1));
  }

  RegionMesh region = as_region(base, intervals, std::move(fields), options.facets);
  base = {};
  for (std::size_t k = 0; k < chain.size(); ++k)
    region = restrict_region(region, std::span(chain).subspan(k), options.max_bytes, task);
  summarise(region, chain.size(), out.mesh.summaries, task);
  if (options.facets) out.mesh.facets = region_facets(region, ranges, own, options.max_bytes, task);
  out.mesh.active_cells = static_cast<std::int64_t>(region.cell_runs.size());
  out.mesh.positions = std::move(region.positions);
  out.mesh.tetrahedra = std::move(region.tetrahedra);
  out.mesh.tetrahedron_interval = std::move(region.labels);
  out.mesh.cell_runs = std::move(region.cell_runs);
  out.mesh.values = std::move(region.fields[0]);
  out.fields = std::move(region.fields);
  task.report(1.0, "combined");
  return out;
}

Buffer<double> exact_weights(const IntervalMesh& mesh, const PointArray& array) {
  Buffer<double> weights(mesh.origins.size());
  std::visit(
      [&](auto values) {
        parallel_for(static_cast<std::int64_t>(weights.size()), 1 << 15, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t i = begin; i < end; ++i) {
            const std::int64_t a = mesh.origins[i].a(), b = mesh.origins[i].b();
            weights[i] =
                a == b ? 0 : crossing_weight(static_cast<double>(values[a]), static_cast<double>(values[b]), mesh.values[i]);
          }
        });
      },
      array.values);
  return weights;
}

Buffer<double> carry_values(const IntervalMesh& mesh, std::span<const double> weights, const PointArray& array) {
  const auto on_edges = static_cast<std::int64_t>(mesh.origins.size());
  const auto inside = static_cast<std::int64_t>(mesh.inner.first.size()) - 1;
  Buffer<double> carried(static_cast<std::size_t>(on_edges + inside));
  std::visit(
      [&](auto values) {
        const auto check = [&](std::int64_t point) {
          if (static_cast<std::uint64_t>(point) < values.size()) return;
          throw Error(ErrorCode::invalid_argument, "array '" + array.name + "' has " + std::to_string(values.size()) +
                                                       " values; the mesh lies on a grid with a point " + std::to_string(point));
        };
        parallel_for(on_edges, 1 << 15, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t i = begin; i < end; ++i) {
            const std::int64_t a = mesh.origins[i].a(), b = mesh.origins[i].b();
            check(b);  // b >= a
            carried[i] = value_between(static_cast<double>(values[a]), static_cast<double>(values[b]), weights[i]);
          }
        });
        parallel_for(inside, 1 << 12, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t i = begin; i < end; ++i) {
            double sum = 0;
            for (std::uint32_t k = mesh.inner.first[i]; k < mesh.inner.first[i + 1]; ++k) {
              check(mesh.inner.points[k]);
              sum += mesh.inner.weights[k] * static_cast<double>(values[mesh.inner.points[k]]);
            }
            carried[on_edges + i] = sum;
          }
        });
      },
      array.values);
  return carried;
}

Combined combine_arrays(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                        std::span<const ArrayTerm> terms, std::span<const PointArray* const> carried, const ExtractBase& extract,
                        const CombineOptions& options, const Task& task) {
  for (const ArrayTerm& term : terms) (void)IsoRules({&term.range, 1});
  IntervalMesh base;
  {
    const std::vector<std::uint8_t> idle = find_idle_cells(grid, array, intervals, terms, task);
    Grid wanted = grid;
    wanted.hidden_cells = idle;
    ExtractOptions extraction;
    extraction.facets = options.facets;
    extraction.max_bytes = options.max_bytes;
    extraction.complement = needs_complement(terms);
    extraction.measure = false;
    base = extract(wanted, array, intervals, extraction);
  }
  // Each array once; the extracted one's values are there, exact on its isosurfaces.
  std::vector<const PointArray*> arrays{&array};
  const auto field_of = [&](const PointArray* wanted) {
    const auto index = std::find(arrays.begin(), arrays.end(), wanted) - arrays.begin();
    if (index == static_cast<std::ptrdiff_t>(arrays.size())) arrays.push_back(wanted);
    return static_cast<int>(index);
  };
  std::vector<FieldTerm> chain;
  for (const ArrayTerm& term : terms) chain.push_back({term.op, field_of(term.array), term.range});
  const std::size_t with_directions = options.normals ? arrays.size() : options.body_normals ? 1 : 0;
  std::vector<int> wanted;
  for (const PointArray* other : carried) wanted.push_back(field_of(other));
  const std::size_t fields_needed = arrays.size() + 3 * with_directions;
  check_budget(std::to_string(fields_needed) + " arrays at " + std::to_string(base.positions.size()) + " points",
               fields_needed * base.positions.size() * sizeof(double), options.max_bytes);
  std::vector<Buffer<double>> fields(1);
  {
    const Buffer<double> weights = exact_weights(base, array);
    for (std::size_t i = 1; i < arrays.size(); ++i) fields.push_back(carry_values(base, weights, *arrays[i]));
  }
  append_directions(grid, std::span(arrays).first(with_directions), base, fields, task);
  fields[0] = std::move(base.values);
  Combined out = combine_ranges(std::move(base), intervals.size(), std::move(fields), chain, options, task);
  const auto directions = std::span(out.fields).subspan(arrays.size());
  if (options.normals) {
    std::vector<int> array_of_range(intervals.size(), 0);
    for (const FieldTerm& term : chain) array_of_range.push_back(term.field);
    out.normals = surface_normals(out.mesh, array_of_range, directions);
  }
  if (options.body_normals) out.body_normals = unit_directions(directions.first(3));
  // fields[0] is empty; the carried arrays follow in their order, whichever of them are terms' too.
  std::vector<Buffer<double>> brought(1);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const bool again = std::find(wanted.begin() + static_cast<std::ptrdiff_t>(i) + 1, wanted.end(), wanted[i]) != wanted.end();
    if (wanted[i] == 0)
      brought.push_back(out.mesh.values);
    else if (again)
      brought.push_back(out.fields[wanted[i]]);
    else
      brought.push_back(std::move(out.fields[wanted[i]]));
  }
  out.fields = std::move(brought);
  return out;
}

}  // namespace isostrata
