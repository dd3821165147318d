#include "extraction/measure/components.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace isostrata {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t kCheckEvery = 1u << 20;  // elements between two looks at the task

class Forest {
 public:
  explicit Forest(std::size_t points) : parent_(points) { reset(); }
  void reset() { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t root(std::uint32_t point) {
    while (parent_[point] != point) point = parent_[point] = parent_[parent_[point]];
    return point;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// Element i has points(i) and lies in interval(i).
template <class Points, class IntervalOf>
Components find(std::uint64_t elements, std::size_t point_count, std::size_t intervals, const Points& points, const IntervalOf& interval_of, const Task& task) {
  Components found;
  found.of.resize(elements);
  Forest forest(point_count);
  std::vector<std::uint32_t> piece_of_root(point_count);
  for (std::size_t interval = 0; interval < intervals; ++interval) {
    if (interval > 0) forest.reset();
    const auto each = [&](const auto& what) {
      for (std::uint64_t i = 0; i < elements; ++i) {
        if (i % kCheckEvery == 0) task.check();
        if (interval_of(i) == interval) what(i);
      }
    };
    each([&](std::uint64_t i) {
      const auto& corners = points(i);
      for (std::size_t k = 1; k < corners.size(); ++k) forest.join(corners[0], corners[k]);
    });
    std::fill(piece_of_root.begin(), piece_of_root.end(), kNone);
    each([&](std::uint64_t i) {
      std::uint32_t& piece = piece_of_root[forest.root(points(i)[0])];
      if (piece == kNone) {
        piece = static_cast<std::uint32_t>(found.interval.size());
        found.interval.push_back(static_cast<std::uint16_t>(interval));
        found.first_tetrahedron.push_back(static_cast<std::uint32_t>(i));
      }
      found.of[i] = piece;
    });
  }
  return found;
}

}  // namespace

Components find_components(const IntervalMesh& mesh, const Task& task) {
  if (mesh.tetrahedra.empty())
    return find(
        mesh.facets.size(), mesh.positions.size(), mesh.summaries.size(), [&](std::uint64_t i) -> const auto& { return mesh.facets[i].points; },
        [&](std::uint64_t i) { return mesh.facets[i].interval; }, task);
  return find(
      mesh.tetrahedra.size(), mesh.positions.size(), mesh.summaries.size(), [&](std::uint64_t i) -> const auto& { return mesh.tetrahedra[i]; },
      [&](std::uint64_t i) { return mesh.tetrahedron_interval[i]; }, task);
}

}  // namespace isostrata
