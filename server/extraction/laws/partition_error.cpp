#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"
#include "extraction/laws/check_laws.h"

namespace isostrata {
namespace {

constexpr std::size_t kCellsAtATime = std::size_t{1} << 18;

/// The intervals in groups that do not overlap within themselves, each by increasing lower end.
std::vector<std::vector<Interval>> disjoint_groups(const IntervalMesh& mesh) {
  std::vector<Interval> order;
  for (const IntervalSummary& row : mesh.summaries)
    if (row.term < 0) order.push_back(row.interval);
  std::sort(order.begin(), order.end(), [](const Interval& a, const Interval& b) { return a.lower < b.lower; });
  std::vector<std::vector<Interval>> groups;
  for (const Interval& interval : order) {
    auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.back().upper <= interval.lower; });
    if (group == groups.end()) group = groups.emplace(groups.end());
    group->push_back(interval);
  }
  return groups;
}

double enclosed_volume(const IntervalMesh& mesh) {
  if (mesh.facets.empty()) return 0;
  const Vec3d from = mesh.positions[mesh.facets.front().points[0]];  // near the facets: nothing large cancels
  double volume = 0;
  for (const BoundaryFacet& facet : mesh.facets) {
    if (facet.label != FacetLabel::domain) continue;
    const auto& x = mesh.positions;
    volume += orient3d(from, x[facet.points[0]], x[facet.points[1]], x[facet.points[2]]) / 6;
  }
  return volume;
}

}  // namespace

std::optional<Partition> partition_error(const Grid& grid, const PointArray& array, const IntervalMesh& mesh,
                                         const ExtractOptions& options, const Task& task) {
  if (mesh.cell_runs.empty()) return std::nullopt;
  Grid part = grid;
  std::vector<std::uint8_t> hidden(static_cast<std::size_t>(grid.cell_count()), 1);
  part.hidden_cells = hidden;
  ExtractOptions own = options;
  own.facets = own.measure = own.complement = true;
  own.values = false;
  const Task quiet;  // its progress would run back and forth
  Partition worst;
  for (const std::vector<Interval>& group : disjoint_groups(mesh)) {
    double difference = 0, volume = 0;
    for (std::size_t first = 0; first < mesh.cell_runs.size(); first += kCellsAtATime) {
      task.check();
      const std::size_t last = std::min(mesh.cell_runs.size(), first + kCellsAtATime);
      for (std::size_t r = first; r < last; ++r) hidden[static_cast<std::size_t>(mesh.cell_runs[r].cell)] = 0;
      const IntervalMesh tiles = extract_intervals(part, array, group, own, quiet);
      for (std::size_t r = first; r < last; ++r) hidden[static_cast<std::size_t>(mesh.cell_runs[r].cell)] = 1;
      if (tiles.active_cells != static_cast<std::int64_t>(last - first))
        throw Error(ErrorCode::internal, "of " + std::to_string(last - first) + " cells, with all values, " +
                                             std::to_string(tiles.active_cells) + " have a part in some piece of the range");
      double sum = 0;
      for (const IntervalSummary& row : tiles.summaries) sum += row.signed_volume;
      const double enclosed = enclosed_volume(tiles);
      difference += std::abs(sum - enclosed);
      volume += std::abs(enclosed);
    }
    const double error = volume > 0 ? difference / volume : difference;
    if (!(error <= worst.error) || worst.volume == 0) worst = {error, volume};
  }
  return worst;
}

}  // namespace isostrata
