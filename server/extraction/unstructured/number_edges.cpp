#include "extraction/unstructured/number_edges.h"

#include <algorithm>
#include <atomic>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "extraction/mesh/passing_array.h"
#include "extraction/unstructured/small_table.h"
#include "extraction/unstructured/sorted_tetrahedron.h"

namespace isostrata {
namespace {

constexpr std::int64_t kAtOnce = 1 << 13;
constexpr std::uint32_t kShared = ~std::uint32_t{0};

/// Each tetrahedron is told to its first, second and third vertex. A point so hears of all edges that run from it and of all faces
/// whose first vertex it is, and what it hears of fits a core's nearest cache.
class Numbering {
 public:
  Numbering(std::span<const std::array<std::uint32_t, 4>> vertices, std::size_t points, const Task& task)
      : vertices_(vertices), points_(points), task_(task) {}

  NumberedEdges run() {
    list_corners();
    out_.edges.resize(vertices_.size());
    out_.open.resize(vertices_.size());
    std::fill(out_.open.begin(), out_.open.end(), std::uint8_t{0});
    find();
    return std::move(out_);
  }

 private:
  static constexpr std::array<std::array<std::uint8_t, 4>, 3> kEdge{{{0, 0, 1, 2}, {0, 0, 3, 4}, {0, 0, 0, 5}}};  // between the i-th vertex and the j-th

  /// 4 times the tetrahedron, and the place of the vertex.
  void list_corners() {
    first_corner_.resize(points_ + 1);
    std::fill(first_corner_.begin(), first_corner_.end(), 0u);
    each(vertices_.size(), [&](std::size_t t) {
      for (std::size_t i = 0; i < 3; ++i) std::atomic_ref(first_corner_[vertices_[t][i]]).fetch_add(1, std::memory_order_relaxed);
    });
    std::uint32_t sum = 0;
    for (std::uint32_t& count : first_corner_) count = std::exchange(sum, sum + count);
    corners_ = PassingArray<std::uint32_t>(sum);
    Buffer<std::uint32_t> next(first_corner_);
    each(vertices_.size(), [&](std::size_t t) {
      for (std::size_t i = 0; i < 3; ++i)
        corners_[std::atomic_ref(next[vertices_[t][i]]).fetch_add(1, std::memory_order_relaxed)] = static_cast<std::uint32_t>(4 * t + i);
    });
  }

  std::span<const std::uint32_t> corners(std::size_t point) const {
    return {corners_.data() + first_corner_[point], corners_.data() + first_corner_[point + 1]};
  }

  /// Numbers the edges within a part of the points, then, when it is known how many are before, in all.
  void find() {
    struct Part {
      std::vector<std::uint32_t> ends;
      std::uint32_t before = 0;
    };
    std::vector<Part> parts((points_ + kPointsPerPart - 1) / kPointsPerPart);
    out_.first.resize(points_ + 1);
    parallel_for(static_cast<std::int64_t>(parts.size()), 1, [&](std::int64_t begin, std::int64_t end) {
      SmallTable table;
      for (auto part = static_cast<std::size_t>(begin); part < static_cast<std::size_t>(end); ++part) {
        task_.check();
        for (std::size_t p = part * kPointsPerPart; p < std::min(points_, (part + 1) * kPointsPerPart); ++p) {
          out_.first[p] = static_cast<std::uint32_t>(parts[part].ends.size());
          number_from(p, table, parts[part].ends);
          find_open_faces(p, table);
        }
      }
    });
    std::uint32_t sum = 0;
    for (Part& part : parts) part.before = std::exchange(sum, sum + static_cast<std::uint32_t>(part.ends.size()));
    corners_ = PassingArray<std::uint32_t>();
    out_.ends.resize(sum);
    out_.first[points_] = sum;
    parallel_for(static_cast<std::int64_t>(parts.size()), 1, [&](std::int64_t begin, std::int64_t end) {
      for (auto part = static_cast<std::size_t>(begin); part < static_cast<std::size_t>(end); ++part) {
        std::copy(parts[part].ends.begin(), parts[part].ends.end(), out_.ends.begin() + parts[part].before);
        for (std::size_t p = part * kPointsPerPart; p < std::min(points_, (part + 1) * kPointsPerPart); ++p) out_.first[p] += parts[part].before;
      }
    });
    each(vertices_.size(), [&](std::size_t t) {
      for (std::size_t e = 0; e < 6; ++e) out_.edges[t][e] += parts[vertices_[t][kSortedEdges[e][0]] / kPointsPerPart].before;
    });
  }

  void number_from(std::size_t point, SmallTable& table, std::vector<std::uint32_t>& ends) {
    const auto corners = this->corners(point);
    table.start(3 * corners.size());
    const std::size_t first = ends.size();
    for (const std::uint32_t corner : corners) {
      const auto& v = vertices_[corner / 4];
      for (std::size_t j = corner % 4 + 1; j < 4; ++j) {
        SmallTable::Entry& entry = table.at(v[j]);
        if (entry.key != SmallTable::kFree) continue;
        entry.key = v[j];
        ends.push_back(v[j]);
      }
    }
    std::sort(ends.begin() + static_cast<std::ptrdiff_t>(first), ends.end());
    for (std::size_t e = first; e < ends.size(); ++e) table.at(ends[e]).value = static_cast<std::uint32_t>(e);
    for (const std::uint32_t corner : corners) {
      const auto& v = vertices_[corner / 4];
      for (std::size_t i = corner % 4, j = i + 1; j < 4; ++j) out_.edges[corner / 4][kEdge[i][j]] = table.at(v[j]).value;
    }
  }

  void find_open_faces(std::size_t point, SmallTable& table) {
    const auto corners = this->corners(point);
    table.start(3 * corners.size());
    const auto tell = [&](std::uint32_t second, std::uint32_t third, std::uint32_t of) {
      SmallTable::Entry& entry = table.at(std::uint64_t{second} << 32 | third);
      entry = {std::uint64_t{second} << 32 | third, entry.key == SmallTable::kFree ? of : kShared};
    };
    for (const std::uint32_t corner : corners) {
      const std::uint32_t t4 = corner & ~3u;
      const auto& v = vertices_[corner / 4];
      if (corner % 4 == 0) {
        tell(v[1], v[2], t4 + 3);
        tell(v[1], v[3], t4 + 2);
        tell(v[2], v[3], t4 + 1);
      } else if (corner % 4 == 1) {
        tell(v[2], v[3], t4);
      }
    }
    table.each([&](const SmallTable::Entry& entry) {
      if (entry.value == kShared) return;
      std::atomic_ref(out_.open[entry.value / 4]).fetch_or(static_cast<std::uint8_t>(1u << entry.value % 4), std::memory_order_relaxed);
    });
  }

  template <class Visit>
  void each(std::size_t count, const Visit& visit) {
    parallel_for(static_cast<std::int64_t>(count), kAtOnce, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t i = begin; i < end; ++i) visit(static_cast<std::size_t>(i));
    });
  }

  static constexpr std::size_t kPointsPerPart = 1 << 12;

  const std::span<const std::array<std::uint32_t, 4>> vertices_;
  const std::size_t points_;
  const Task& task_;
  Buffer<std::uint32_t> first_corner_;   // [points + 1] into corners_
  PassingArray<std::uint32_t> corners_;  // 4 times the tetrahedron, and the place of the point there
  NumberedEdges out_;
};

}  // namespace

NumberedEdges number_edges(std::span<const std::array<std::uint32_t, 4>> vertices, std::size_t points, const Task& task) {
  return Numbering(vertices, points, task).run();
}

}  // namespace isostrata
