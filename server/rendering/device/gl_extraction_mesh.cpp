#include "rendering/device/gl_extraction_mesh.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "data/dataset/analytic.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/cells/cell_triangulation.h"
#include "extraction/cells/mesh_points.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/facets/weld_seams.h"
#include "extraction/mesh/memory_budget.h"

namespace isostrata {
namespace {

constexpr std::size_t kRecordsPerBlock = 4096;

int case_of(const shaders::CellRecord& record) { return static_cast<int>(record.case_interval & RECORD_CASE_MASK); }
std::uint16_t interval_of(const shaders::CellRecord& record) {
  return static_cast<std::uint16_t>(record.case_interval >> RECORD_INTERVAL_SHIFT);
}

/// Calls each(first record, end, block) for blocks that end where a cell does.
template <class Each>
void for_blocks(std::span<const shaders::CellRecord> records, const Task& task, const Each& each) {
  const auto blocks = static_cast<std::int64_t>((records.size() + kRecordsPerBlock - 1) / kRecordsPerBlock);
  const auto boundary = [&](std::int64_t block) {
    std::size_t at = std::min(records.size(), static_cast<std::size_t>(block) * kRecordsPerBlock);
    while (at > 0 && at < records.size() && records[at].cell == records[at - 1].cell) ++at;
    return at;
  };
  parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t block = begin; block < end; ++block) {
      task.check();
      each(boundary(block), boundary(block + 1), static_cast<std::size_t>(block));
    }
  });
}

void locate_points(const Grid& grid, const PointArray& array, const IsoRules& rules, const GlMeshParts& parts, bool values,
                   IntervalMesh& mesh, const Task& task) {
  const auto count = static_cast<std::int64_t>(parts.origins.size());
  mesh.positions.resize(parts.origins.size());
  mesh.origins.resize(parts.origins.size());
  if (values) mesh.values.resize(parts.origins.size());
  const auto dims = grid.dims();
  const std::array<std::int64_t, 3> step{1, dims[0], dims[0] * dims[1]};
  const auto isovalues = static_cast<std::uint32_t>(rules.isovalues().size());
  std::visit(
      [&](auto field) {
        parallel_for(count, 8192, [&](std::int64_t begin, std::int64_t end) {
          task.check();
          for (std::int64_t i = begin; i < end; ++i) {
            const auto [point, slot] = parts.origins[static_cast<std::size_t>(i)];
            const std::int64_t a = point;
            const auto fa = static_cast<double>(field[a]);
            if (slot == 0) {
              set_kept_point(mesh, static_cast<std::uint32_t>(i), a, grid.point(a), fa);
              continue;
            }
            const std::int64_t b = a + step[(slot - 1) / isovalues];
            set_crossing(mesh, static_cast<std::uint32_t>(i), a, grid.point(a), fa, b, grid.point(b),
                         static_cast<double>(field[b]), rules.isovalues()[(slot - 1) % isovalues]);
          }
        });
      },
      array.values);
}

/// What a block adds to an interval's summary.
struct Volumes {
  double absolute = 0, with_sign = 0;
  std::int64_t inverted = 0;
};

void measure(const Grid& grid, const GlMeshParts& parts, IntervalMesh& mesh, const Task& task) {
  const std::span records(parts.records);
  std::vector<std::vector<std::pair<std::uint16_t, Volumes>>> blocks(records.size() / kRecordsPerBlock + 1);
  for_blocks(records, task, [&](std::size_t begin, std::size_t end, std::size_t block) {
    CellTriangulation triangulation(grid);
    std::array<Vec3d, 8> p;
    CellHandedness hand;
    for (std::size_t i = begin; i < end; ++i) {
      if (i == begin || records[i].cell != records[i - 1].cell) {
        triangulation.begin_cell(records[i].cell);
        for (int v = 0; v < 8; ++v) p[v] = grid.point(triangulation.ids()[v]);
        hand = grid.rectilinear() ? box_handedness(p[0], p[6]) : cell_handedness(triangulation.cell(), p);
      }
      auto& rows = blocks[block];
      auto row = std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.first == interval_of(records[i]); });
      if (row == rows.end()) row = rows.insert(row, {interval_of(records[i]), Volumes{}});
      const std::size_t last = i + 1 < records.size() ? parts.first_tetrahedron[i + 1] : mesh.tetrahedra.size();
      for (std::size_t t = parts.first_tetrahedron[i]; t < last; ++t) {
        const auto& q = mesh.tetrahedra[t];
        const auto& x = mesh.positions;
        const double volume = orient3d(x[q[0]], x[q[1]], x[q[2]], x[q[3]]) / 6;
        row->second.absolute += std::abs(volume);
        row->second.with_sign += volume;
        row->second.inverted += volume < -hand.tolerance;
      }
    }
  });
  for (const auto& rows : blocks)
    for (const auto& [interval, volumes] : rows) {
      IntervalSummary& summary = mesh.summaries[interval];
      summary.volume += volumes.absolute;
      summary.signed_volume += volumes.with_sign;
      summary.inverted += volumes.inverted;
    }
}

std::vector<FacetLabels> label_tetrahedra(const GlMeshParts& parts, std::size_t tetrahedra, const Task& task) {
  std::vector<FacetLabels> labels(tetrahedra);
  const HexahedronTable& table = hexahedron_table();
  for_blocks(parts.records, task, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      const shaders::CellRecord& record = parts.records[i];
      const std::uint32_t hand = record.case_interval >> RECORD_HAND_SHIFT & 3;
      const bool left = hand == 0 ? parts.left_handed : hand == 2;
      std::size_t to = parts.first_tetrahedron[i];
      for (auto t : table.of(case_of(record))) {
        if (left) std::swap(t[0], t[1]);
        labels[to++] = label_facets(table.masks[t[0]], table.masks[t[1]], table.masks[t[2]], table.masks[t[3]]);
      }
    }
  });
  return labels;
}

}  // namespace

IntervalMesh extract_intervals_on(GlExtraction& device, const Grid& grid, const PointArray& array,
                                  std::span<const Interval> intervals, const ExtractOptions& options, const Task& task) {
  const IsoRules rules(intervals);
  device.load(grid, array, task);
  const GlCounts counts = device.extract(intervals, GlExtent::tetrahedra, task);
  check_budget(std::to_string(counts.tetrahedra) + " tetrahedra with " + std::to_string(counts.points) + " points",
               static_cast<std::uint64_t>(counts.tetrahedra) * (18 + (options.facets ? 4 : 0)) +
                   static_cast<std::uint64_t>(counts.points) * (24 + 16 + 8 + 8) +
                   static_cast<std::uint64_t>(counts.records) * (12 + 16),
               options.max_bytes);
  IntervalMesh mesh;
  mesh.cells = counts.cells;
  mesh.active_cells = counts.active_cells;
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    IntervalSummary& summary = mesh.summaries.emplace_back();
    summary.interval = intervals[i];
    summary.active_cells = counts.intervals[i].active_cells;
    summary.tetrahedra = counts.intervals[i].tetrahedra;
  }
  GlMeshParts parts = device.read_mesh(task);
  mesh.tetrahedra = std::move(parts.tetrahedra);
  mesh.tetrahedron_interval.resize(mesh.tetrahedra.size());
  mesh.cell_runs.reserve(static_cast<std::size_t>(counts.active_cells));
  for (std::size_t i = 0; i < parts.records.size(); ++i) {
    if (i % 4096 == 0) task.check();
    const std::uint32_t first = parts.first_tetrahedron[i];
    const std::size_t end = i + 1 < parts.records.size() ? parts.first_tetrahedron[i + 1] : mesh.tetrahedra.size();
    if (i == 0 || parts.records[i].cell != parts.records[i - 1].cell) mesh.cell_runs.push_back({parts.records[i].cell, first});
    std::fill(mesh.tetrahedron_interval.begin() + first, mesh.tetrahedron_interval.begin() + static_cast<std::ptrdiff_t>(end),
              interval_of(parts.records[i]));
  }
  locate_points(grid, array, rules, parts, options.values, mesh, task);
  if (options.measure) measure(grid, parts, mesh, task);
  if (options.facets) {
    const std::vector<FacetLabels> labels = label_tetrahedra(parts, mesh.tetrahedra.size(), task);
    mesh.facets = boundary_facets(grid, array, mesh, labels, options.max_bytes, task);
  }
  weld_seams(grid, array, mesh, task);
  return mesh;
}

std::string check_gl_extraction(std::string_view device) {
  try {
    const Task task;
    const auto dataset = make_analytic("torus:17", {}, task);
    const PointArray& array = dataset->arrays.front();
    const std::vector<Interval> intervals{{0.1, 0.2}, {0.2, 0.35}};
    GlExtraction extraction(device);
    const IntervalMesh found = extract_intervals_on(extraction, dataset->grid, array, intervals, {}, task);
    const IntervalMesh expected = extract_intervals(dataset->grid, array, intervals, {}, task);
    for (std::size_t i = 0; i < intervals.size(); ++i) {
      const IntervalSummary &f = found.summaries[i], &e = expected.summaries[i];
      if (f.active_cells != e.active_cells || f.tetrahedra != e.tetrahedra || std::abs(f.signed_volume - e.signed_volume) > 1e-9)
        return extraction.device() + ": interval " + std::to_string(i) + " of torus:17 has " + std::to_string(f.active_cells) +
               " active cells and " + std::to_string(f.tetrahedra) + " tetrahedra of volume " + std::to_string(f.signed_volume) +
               "; expected " + std::to_string(e.active_cells) + ", " + std::to_string(e.tetrahedra) + " and " +
               std::to_string(e.signed_volume);
    }
    if (found.positions.size() != expected.positions.size())
      return extraction.device() + ": torus:17 has " + std::to_string(found.positions.size()) + " points; expected " +
             std::to_string(expected.positions.size());
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

}  // namespace isostrata
