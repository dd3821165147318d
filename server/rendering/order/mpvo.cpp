#include "rendering/order/mpvo.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <mutex>
#include <utility>
#include <vector>

#include "rendering/order/boundary_gaps.h"
#include "rendering/order/cell_relation.h"

namespace isostrata {
namespace {

constexpr std::uint16_t kTaken = 0xffff;  // instead of a count: the cell is in the order
constexpr std::uint8_t kHasGaps = 0x80;   // in CellRelation::front: cells in front of it are not only its neighbours

/// Where a cell's neighbours are.
struct CurvilinearNeighbors {
  std::array<std::int32_t, 6> step;
  std::uint32_t operator()(std::uint32_t cell, unsigned slot) const { return cell + static_cast<std::uint32_t>(step[slot]); }
};
template <unsigned kSlots>
struct UnstructuredNeighbors {
  const std::uint32_t* neighbor;
  std::uint32_t operator()(std::uint32_t cell, unsigned slot) const { return neighbor[std::size_t{cell} * kSlots + slot]; }
};

template <class Neighbors>
class TopologicalSort {
 public:
  TopologicalSort(const Grid& grid, const FaceGraph& graph, const Camera& camera, Neighbors neighbors, CellRelation relation,
                  const std::vector<CellGap>& gaps, CellSequence& out)
      : grid_(grid),
        graph_(graph),
        camera_(camera),
        neighbors_(neighbors),
        relation_(std::move(relation)),
        gaps_(gaps),
        out_(out) {}

  void run() {
    for (const CellGap& gap : gaps_) {
      std::uint16_t& count = relation_.behind[gap.near];
      if (count >= kTaken - 1) continue;  // its order is lost among 65534 others
      ++count;
      relation_.front[gap.far] |= kHasGaps;
    }
    out_.cells.resize(graph_.cells);
    // Cells with nothing behind them, far ones first (MPVONC): what no gap was found for is likely right.
    std::vector<std::pair<double, std::uint32_t>> roots;
    for (std::uint32_t c = 0; c < graph_.cells; ++c)
      if (relation_.behind[c] == 0) roots.emplace_back(distance(c), c);
    std::sort(roots.begin(), roots.end(), std::greater<>());
    for (const auto& root : roots) {
      take(root.second);
      follow();
    }
    if (taken_ < graph_.cells) break_cycles();
  }

 private:
  double distance(std::uint32_t cell) const {
    const Vec3d from_eye = cell_middle(grid_, cell) - camera_.eye;
    return camera_.orthographic ? dot(from_eye, camera_.at - camera_.eye) : dot(from_eye, from_eye);
  }

  void take(std::uint32_t cell) {
    relation_.behind[cell] = kTaken;
    stack_.push_back(cell);
  }
  void release(std::uint32_t cell) {
    std::uint16_t& count = relation_.behind[cell];
    if (count != kTaken && --count == 0) take(cell);
  }
  void follow() {
    while (!stack_.empty()) {
      const std::uint32_t cell = stack_.back();
      stack_.pop_back();
      out_.cells[taken_++] = cell;
      for (unsigned front = relation_.front[cell] & 0x3f; front != 0; front &= front - 1)
        release(neighbors_(cell, static_cast<unsigned>(std::countr_zero(front))));
      if (relation_.front[cell] & kHasGaps)
        for (auto gap = std::lower_bound(gaps_.begin(), gaps_.end(), CellGap{cell, 0}); gap != gaps_.end() && gap->far == cell;
             ++gap)
          release(gap->near);
    }
  }

  bool left(std::uint32_t cell) const { return relation_.behind[cell] != kTaken; }

  /// Every cell that is left waits for one that is left: walking back from any of them ends in a cycle. Its farthest cell is
  /// taken though it should wait.
  void break_cycles() {
    std::vector<std::pair<double, std::uint32_t>> rest;
    for (std::uint32_t c = 0; c < graph_.cells; ++c)
      if (left(c)) rest.emplace_back(distance(c), c);
    std::sort(rest.begin(), rest.end(), std::greater<>());
    std::vector<CellGap> backwards(gaps_);  // by the nearer cell
    for (CellGap& gap : backwards) std::swap(gap.far, gap.near);
    std::sort(backwards.begin(), backwards.end());
    Buffer<std::uint32_t> step(graph_.cells);  // of the walk on which a cell was met
    std::fill(step.begin(), step.end(), 0u);
    std::uint32_t steps = 0;
    std::vector<std::uint32_t> walk;
    for (const auto& [far, start] : rest)
      while (left(start)) {
        walk.clear();
        const std::uint32_t before = steps;
        std::uint32_t cell = start;
        while (cell != kNoCell && step[cell] <= before) {
          step[cell] = ++steps;
          walk.push_back(cell);
          cell = one_behind(cell, backwards);
        }
        std::uint32_t farthest = walk.back();
        if (cell != kNoCell) {
          double most = -1e300;
          for (std::size_t i = step[cell] - before - 1; i < walk.size(); ++i)
            if (const double d = distance(walk[i]); d > most) most = d, farthest = walk[i];
        }
        ++out_.cycles;
        take(farthest);
        follow();
      }
  }

  /// Some cell behind it that is left, or kNoCell.
  std::uint32_t one_behind(std::uint32_t cell, const std::vector<CellGap>& backwards) const {
    const unsigned slots = graph_.slots == 0 ? 6 : static_cast<unsigned>(graph_.slots);
    for (unsigned slot = 0; slot < slots; ++slot) {
      if (!has_neighbor(cell, slot)) continue;
      const std::uint32_t other = neighbors_(cell, slot);
      if (left(other) && hides(cell, other)) return other;
    }
    for (auto gap = std::lower_bound(backwards.begin(), backwards.end(), CellGap{cell, 0});
         gap != backwards.end() && gap->far == cell; ++gap)
      if (left(gap->near)) return gap->near;
    return kNoCell;
  }
  bool has_neighbor(std::uint32_t cell, unsigned slot) const {
    if (graph_.slots != 0) return neighbors_(cell, slot) != kNoCell;
    const std::int64_t other = std::int64_t{cell} + static_cast<std::int32_t>(neighbors_(cell, slot) - cell);
    return other >= 0 && other < std::int64_t{graph_.cells};
  }
  bool hides(std::uint32_t near, std::uint32_t far) const {
    for (unsigned front = relation_.front[far] & 0x3f; front != 0; front &= front - 1)
      if (neighbors_(far, static_cast<unsigned>(std::countr_zero(front))) == near) return true;
    return false;
  }

  const Grid& grid_;
  const FaceGraph& graph_;
  const Camera& camera_;
  Neighbors neighbors_;
  CellRelation relation_;
  const std::vector<CellGap>& gaps_;
  CellSequence& out_;
  std::vector<std::uint32_t> stack_;
  std::size_t taken_ = 0;
};

}  // namespace

CellSequence sort_cells(const Grid& grid, const FaceGraph& graph, const Camera& camera, int width, int height) {
  CellSequence out;
  std::vector<CellGap> gaps = boundary_gaps(grid, graph, camera, width, height);
  out.gaps = static_cast<std::int64_t>(gaps.size());
  const OrderView view = order_view(camera);
  const double margin = side_margin(view, graph);
  for (const JoinedFace& joined : graph.joined) {
    const int side = side_of(joined.plane, view, graph.center, margin);
    if (side > 0) gaps.push_back({joined.from, joined.to});
    if (side < 0) gaps.push_back({joined.to, joined.from});
  }
  std::sort(gaps.begin(), gaps.end());
  gaps.erase(std::unique(gaps.begin(), gaps.end()), gaps.end());
  CellRelation relation = relate_cells(grid, graph, camera);
  const auto sort = [&](auto neighbors) {
    TopologicalSort(grid, graph, camera, neighbors, std::move(relation), gaps, out).run();
  };
  if (graph.slots == 0) {
    const auto x = static_cast<std::int32_t>(graph.cell_dims[0]),
               y = static_cast<std::int32_t>(graph.cell_dims[0] * graph.cell_dims[1]);
    sort(CurvilinearNeighbors{{-1, 1, -x, x, -y, y}});
  } else if (graph.slots == 4) {
    sort(UnstructuredNeighbors<4>{graph.neighbor.data()});
  } else {
    sort(UnstructuredNeighbors<6>{graph.neighbor.data()});
  }
  out.convex = graph.convex;
  out.exact = graph.convex && graph.plane_faces && out.cycles == 0;
  return out;
}

std::shared_ptr<const CellSequence> cell_sequence(const Grid& grid, const std::shared_ptr<const FaceGraph>& graph,
                                                  const Camera& camera, int width, int height) {
  struct Kept {
    std::weak_ptr<const FaceGraph> graph;
    Camera camera;
    int width = 0, height = 0;
    std::shared_ptr<const CellSequence> sequence;
  };
  static std::mutex mutex;
  static Kept kept;  // under mutex
  {
    const std::lock_guard lock(mutex);
    if (kept.graph.lock() == graph && kept.camera == camera && kept.width == width && kept.height == height) return kept.sequence;
  }
  auto sequence = std::make_shared<const CellSequence>(sort_cells(grid, *graph, camera, width, height));
  const std::lock_guard lock(mutex);
  kept = {graph, camera, width, height, sequence};
  return sequence;
}

}  // namespace isostrata
