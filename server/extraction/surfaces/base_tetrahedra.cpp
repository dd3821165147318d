#include "extraction/surfaces/base_tetrahedra.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>

#include "base/parallel.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/unstructured/cell_clusters.h"

namespace isostrata {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr std::uint32_t kNone = 0xffffffffu;

/// The least float that is not below `value`.
float float_from(double value) {
  const auto f = static_cast<float>(value);
  return double{f} < value ? std::nextafter(f, kInfinity) : f;
}

double volume_of(const IntervalMesh& mesh, std::size_t t) {
  const auto& ids = mesh.tetrahedra[t];
  const auto& x = mesh.positions;
  return orient3d(x[ids[0]], x[ids[1]], x[ids[2]], x[ids[3]]) / 6;
}

/// All finite values, as one interval.
Interval everything(const PointArray& array) {
  const double upper =
      array.lower < array.upper ? array.upper : std::nextafter(array.lower, std::numeric_limits<double>::infinity());
  return {array.lower, upper};
}

/// mesh's tetrahedra in the order of the clusters, and its points in the order of their first use.
IntervalMesh reordered(const Grid& grid, const IntervalMesh& mesh, std::uint64_t max_bytes, const Task& task) {
  const CellClusters clusters(grid, max_bytes, task);
  Buffer<std::uint32_t> tetrahedron_of_cell(static_cast<std::size_t>(grid.cell_count()));
  std::fill(tetrahedron_of_cell.begin(), tetrahedron_of_cell.end(), kNone);
  for (const CellRun& run : mesh.cell_runs) tetrahedron_of_cell[static_cast<std::size_t>(run.cell)] = run.first_tetrahedron;
  task.check();

  IntervalMesh out;
  out.tetrahedra.reserve(mesh.tetrahedra.size());
  Buffer<std::uint32_t> new_tetrahedron(mesh.tetrahedra.size()), new_point(mesh.positions.size());
  std::fill(new_point.begin(), new_point.end(), kNone);
  out.positions.reserve(mesh.positions.size());
  for (std::int64_t c = 0; c < clusters.count(); ++c)
    for (const std::uint32_t cell : clusters.cells(c)) {
      const std::uint32_t t = tetrahedron_of_cell[cell];
      if (t == kNone) continue;
      new_tetrahedron[t] = static_cast<std::uint32_t>(out.tetrahedra.size());
      std::array<std::uint32_t, 4> ids = mesh.tetrahedra[t];
      for (std::uint32_t& id : ids) {
        if (new_point[id] == kNone) {
          new_point[id] = static_cast<std::uint32_t>(out.positions.size());
          out.positions.push_back(mesh.positions[id]);
        }
        id = new_point[id];
      }
      out.tetrahedra.push_back(ids);
    }
  task.check();
  out.values.resize(out.positions.size());
  for (std::size_t p = 0; p < new_point.size(); ++p)
    if (new_point[p] != kNone) out.values[new_point[p]] = mesh.values[p];
  out.facets = mesh.facets;
  for (BoundaryFacet& facet : out.facets) {
    facet.tetrahedron = new_tetrahedron[facet.tetrahedron];
    for (std::uint32_t& id : facet.points) id = new_point[id];
  }
  out.cells = mesh.cells;
  out.active_cells = mesh.active_cells;
  out.summaries = mesh.summaries;
  return out;
}

/// Surfaces in tetrahedra are turned by the order of their vertices. What has no volume goes with the most.
void make_positive(IntervalMesh& mesh) {
  std::mutex mutex;
  std::int64_t positive = 0, negative = 0;
  const auto each = [&](auto&& body) { parallel_for(static_cast<std::int64_t>(mesh.tetrahedra.size()), 1 << 14, body); };
  each([&](std::int64_t begin, std::int64_t end) {
    std::int64_t more = 0, less = 0;
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      const double volume = volume_of(mesh, t);
      more += volume > 0;
      less += volume < 0;
    }
    const std::lock_guard lock(mutex);
    positive += more;
    negative += less;
  });
  if (negative == 0) return;
  const bool mirrored = negative > positive;
  each([&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      const double volume = volume_of(mesh, t);
      if (volume < 0 || (volume == 0 && mirrored)) std::swap(mesh.tetrahedra[t][2], mesh.tetrahedra[t][3]);
    }
  });
  // The facets' own order was that of their cells before.
  for (BoundaryFacet& facet : mesh.facets) {
    const auto& ids = mesh.tetrahedra[facet.tetrahedron];
    std::array<std::size_t, 3> at{};
    for (std::size_t i = 0; i < 3; ++i)
      at[i] = static_cast<std::size_t>(std::find(ids.begin(), ids.end(), facet.points[i]) - ids.begin());
    const std::size_t opposite = 6 - at[0] - at[1] - at[2];
    // Opposite an even vertex the others in increasing order (or a rotation of it) are counter-clockwise seen from outside.
    const bool rising = (at[0] < at[1]) + (at[1] < at[2]) + (at[2] < at[0]) == 2;
    if (rising != (opposite % 2 == 0)) std::swap(facet.points[1], facet.points[2]);
  }
}

void find_ranges(BaseTetrahedra& base) {
  const IntervalMesh& mesh = *base.mesh;
  const std::vector<float>& values = *base.values;
  constexpr std::size_t kBlock = TetrahedronRanges::kBlock;
  const std::size_t count = mesh.tetrahedra.size(), blocks = (count + kBlock - 1) / kBlock;
  TetrahedronRanges& ranges = base.ranges;
  ranges.least.resize(blocks * kBlock);
  ranges.most.resize(blocks * kBlock);
  ranges.block_least.resize(blocks);
  ranges.block_most.resize(blocks);
  base.volume.resize(blocks * kBlock);
  base.block_volume.resize(blocks);
  parallel_for(static_cast<std::int64_t>(blocks), 256, [&](std::int64_t begin, std::int64_t end) {
    for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b) {
      float block_least = kInfinity, block_most = -kInfinity;
      double volume = 0;
      for (std::size_t t = b * kBlock; t < (b + 1) * kBlock; ++t) {
        float least = kInfinity, most = -kInfinity;
        if (t < count) {
          for (const std::uint32_t point : mesh.tetrahedra[t]) {
            least = std::min(least, values[point]);
            most = std::max(most, values[point]);
          }
        }
        base.volume[t] = t < count ? std::abs(volume_of(mesh, t)) : 0;
        volume += base.volume[t];
        ranges.least[t] = least;
        ranges.most[t] = most;
        block_least = std::min(block_least, least);
        block_most = std::max(block_most, most);
      }
      ranges.block_least[b] = block_least;
      ranges.block_most[b] = block_most;
      base.block_volume[b] = volume;
    }
  });
}

}  // namespace

std::vector<ValueBounds> value_bounds(std::span<const Interval> intervals) {
  std::vector<ValueBounds> bounds;
  for (const Interval& interval : intervals) {
    const bool touched =
        std::any_of(intervals.begin(), intervals.end(), [&](const Interval& other) { return other.lower == interval.upper; });
    float end = float_from(interval.upper);
    if (!touched && double{end} == interval.upper) end = std::nextafter(end, kInfinity);
    bounds.push_back({float_from(interval.lower), end});
  }
  return bounds;
}

std::uint64_t BaseTetrahedra::bytes() const {
  return mesh->positions.size() * sizeof(Vec3d) + mesh->tetrahedra.size() * sizeof(mesh->tetrahedra[0]) +
         mesh->facets.size() * sizeof(BoundaryFacet) + values->size() * sizeof(float) +
         (ranges.least.size() + ranges.most.size() + ranges.block_least.size() + ranges.block_most.size()) * sizeof(float) +
         (volume.size() + block_volume.size()) * sizeof(double);
}

bool only_tetrahedra(const Dataset& dataset) {
  return !dataset.grid.structured() && dataset.cell_types.size() == 1 && dataset.cell_types.begin()->first == "tetrahedron" &&
         dataset.grid.cell_count() > 0;
}

std::uint64_t base_tetrahedra_bytes(const Dataset& dataset) {
  const auto points = static_cast<std::uint64_t>(dataset.grid.point_count()),
             cells = static_cast<std::uint64_t>(dataset.grid.cell_count());
  // The extraction's mesh and the reordered one are there at once, with the clusters and what numbers anew.
  const std::uint64_t extracted = points * (sizeof(Vec3d) + sizeof(PointOrigin) + sizeof(double)) +
                                  cells * (sizeof(std::array<std::uint32_t, 4>) + sizeof(std::uint16_t) + sizeof(CellRun));
  const std::uint64_t made = points * (sizeof(Vec3d) + sizeof(double) + sizeof(float)) +
                             cells * (sizeof(std::array<std::uint32_t, 4>) + 2 * sizeof(float) + sizeof(double));
  return extracted + made + points * sizeof(std::uint32_t) + cells * (2 * sizeof(std::uint32_t) + 20);
}

std::shared_ptr<const BaseTetrahedra> make_base_tetrahedra(const Dataset& dataset, const std::string& name,
                                                           std::uint64_t max_bytes, const Task& task) {
  if (!only_tetrahedra(dataset))
    throw Error(ErrorCode::unsupported, dataset.name + ": only a grid of nothing but tetrahedra is drawn without being split");
  const PointArray& array = dataset.array(name);
  check_budget("a mesh of " + std::to_string(dataset.grid.cell_count()) + " tetrahedra that are drawn without being split",
               base_tetrahedra_bytes(dataset), max_bytes);
  auto base = std::make_shared<BaseTetrahedra>();
  auto mesh = std::make_shared<IntervalMesh>();
  mesh->cells = dataset.grid.cell_count();
  if (array.lower <= array.upper) {
    const Interval all = everything(array);
    ExtractOptions options;
    options.facets = true;
    options.measure = false;
    options.max_bytes = max_bytes;
    *mesh = reordered(dataset.grid, extract_intervals(dataset.grid, array, {&all, 1}, options, task), max_bytes, task);
  }
  make_positive(*mesh);
  base->values = std::make_shared<const std::vector<float>>(mesh->values.begin(), mesh->values.end());
  mesh->values = {};
  base->mesh = std::move(mesh);
  task.check();
  find_ranges(*base);
  return base;
}

bool resolves(const BaseTetrahedra& base, const Interval& interval) {
  float largest = 0;
  for (std::size_t b = 0; b < base.ranges.block_least.size(); ++b)
    largest = std::max({largest, std::abs(base.ranges.block_least[b]), std::abs(base.ranges.block_most[b])});
  return interval.upper - interval.lower >= double{largest} / (1 << 12);
}

double share_below(const double (&f)[4], double value) {
  const auto [a, b, c, d] = f;
  if (value <= a) return 0;
  if (value >= d) return 1;
  const auto cube = [](double x) { return x * x * x; };
  if (value <= b) return cube(value - a) / ((b - a) * (c - a) * (d - a));
  if (value >= c) return 1 - cube(d - value) / ((d - a) * (d - b) * (d - c));
  // A wedge between the edge a-b and the points on the four edges to c and d, as three tetrahedra.
  const double ac = (value - a) / (c - a), ad = (value - a) / (d - a), bc = (value - b) / (c - b), bd = (value - b) / (d - b);
  return ac * ad + bd * ac * (1 - ad) + (1 - ac) * bc * bd;
}

std::vector<IntervalSummary> measure_intervals(const BaseTetrahedra& base, std::span<const Interval> intervals) {
  const std::vector<ValueBounds> bounds = value_bounds(intervals);
  const std::size_t count = base.mesh->tetrahedra.size(), blocks = base.block_volume.size();
  const std::vector<float>& values = *base.values;
  std::vector<IntervalSummary> sums(intervals.size());
  constexpr std::size_t kChunk = 256;  // blocks; sums are added in their order, so that they do not depend on the threads
  const std::size_t chunks = (blocks + kChunk - 1) / kChunk;
  std::vector<double> volumes(chunks * intervals.size(), 0);
  std::vector<std::int64_t> actives(chunks * intervals.size(), 0);
  const auto measure = [&](std::size_t b, std::size_t i, double& volume, std::int64_t& active) {
    const std::size_t first = b * TetrahedronRanges::kBlock, last = std::min(count, first + TetrahedronRanges::kBlock);
    const TetrahedronRanges& ranges = base.ranges;
    if (ranges.block_least[b] >= bounds[i].begin && ranges.block_most[b] < bounds[i].end) {
      volume += base.block_volume[b];
      active += static_cast<std::int64_t>(last - first);
      return;
    }
    // Which are reached, and which of these lie across an end: without a branch, since neighbours differ.
    std::uint64_t reached = 0, across = 0;
    for (std::size_t k = 0; k < TetrahedronRanges::kBlock; ++k) {
      const bool reach = ranges.reaches(first + k, bounds[i]);
      const bool whole = (ranges.least[first + k] >= bounds[i].begin) & (ranges.most[first + k] < bounds[i].end);
      reached |= std::uint64_t{reach} << k;
      across |= std::uint64_t{reach > whole} << k;
    }
    active += std::popcount(reached);
    std::array<double, 4> whole{};
    for (std::size_t k = 0; k < TetrahedronRanges::kBlock; ++k) whole[k % 4] += (reached & ~across) >> k & 1 ? base.volume[first + k] : 0;
    volume += (whole[0] + whole[1]) + (whole[2] + whole[3]);
    for (; across; across &= across - 1) {
      const std::size_t t = first + static_cast<std::size_t>(std::countr_zero(across));
      double f[4];
      for (std::size_t v = 0; v < 4; ++v) f[v] = double{values[base.mesh->tetrahedra[t][v]]};
      for (const auto& [low, high] : {std::pair{0, 1}, {2, 3}, {0, 2}, {1, 3}, {1, 2}}) {  // a network: four numbers are sorted without a branch
        const double least = std::min(f[low], f[high]);
        f[high] = std::max(f[low], f[high]);
        f[low] = least;
      }
      const double share = (ranges.most[t] >= bounds[i].end ? share_below(f, intervals[i].upper) : 1) -
                           (ranges.least[t] < bounds[i].begin ? share_below(f, intervals[i].lower) : 0);
      volume += share * base.volume[t];
    }
  };
  parallel_for(static_cast<std::int64_t>(chunks), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c)
      for (std::size_t b = c * kChunk; b < std::min(blocks, (c + 1) * kChunk); ++b)
        for (std::size_t i = 0; i < intervals.size(); ++i)
          if (base.ranges.block_reaches(b, bounds[i]))
            measure(b, i, volumes[c * intervals.size() + i], actives[c * intervals.size() + i]);
  });
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    sums[i].interval = intervals[i];
    for (std::size_t c = 0; c < chunks; ++c) {
      sums[i].volume += volumes[c * intervals.size() + i];
      sums[i].active_cells += actives[c * intervals.size() + i];
    }
    sums[i].signed_volume = sums[i].volume;
    sums[i].tetrahedra = sums[i].active_cells;
  }
  return sums;
}

}  // namespace isostrata
