#include "rendering/order/face_graph.h"

#include <mutex>

namespace isostrata {
namespace {

constexpr std::uint64_t kMostKept = std::uint64_t{4} << 30;  // bytes

/// What a grid is known by: its storage, and where in it its arrays lie.
struct Identity {
  std::weak_ptr<const void> storage;
  const void* points = nullptr;
  const void* cells = nullptr;
  const void* hidden = nullptr;
  std::array<std::int64_t, 3> size{};

  bool is(const Identity& other) const {
    return !storage.owner_before(other.storage) && !other.storage.owner_before(storage) && !storage.expired() &&
           points == other.points && cells == other.cells && hidden == other.hidden && size == other.size;
  }
};

Identity identity_of(const Grid& grid) {
  const auto data = [](const PointSpan& points) {
    return std::visit([](auto span) { return static_cast<const void*>(span.data()); }, points);
  };
  Identity identity{grid.storage, nullptr, nullptr, grid.hidden_cells.data(), {grid.cell_count(), grid.point_count(), 0}};
  if (const auto* curvilinear = std::get_if<CurvilinearGrid>(&grid.shape)) {
    identity.points = data(curvilinear->points);
    identity.size = curvilinear->dims;
  } else if (const auto* unstructured = std::get_if<UnstructuredGrid>(&grid.shape)) {
    identity.points = data(unstructured->points);
    identity.cells = unstructured->connectivity.data();
  }
  return identity;
}

struct Kept {
  Identity identity;
  std::shared_ptr<const FaceGraph> graph;
};

std::mutex kept_mutex;
std::vector<Kept> kept;  // under kept_mutex; the last one was asked for last

std::shared_ptr<const FaceGraph> find_kept(const Identity& identity) {
  const std::lock_guard lock(kept_mutex);
  std::erase_if(kept, [](const Kept& k) { return k.identity.storage.expired(); });
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (!kept[i].identity.is(identity)) continue;
    std::rotate(kept.begin() + static_cast<std::ptrdiff_t>(i), kept.begin() + static_cast<std::ptrdiff_t>(i) + 1, kept.end());
    return kept.back().graph;
  }
  return nullptr;
}

void keep(const Identity& identity, const std::shared_ptr<const FaceGraph>& graph) {
  const std::lock_guard lock(kept_mutex);
  kept.push_back({identity, graph});
  std::uint64_t bytes = 0;
  for (const Kept& k : kept) bytes += k.graph->bytes;
  while (kept.size() > 1 && (kept.size() > 4 || bytes > kMostKept)) {
    bytes -= kept.front().graph->bytes;
    kept.erase(kept.begin());
  }
}

}  // namespace

Vec3d cell_middle(const Grid& grid, std::int64_t cell) {
  std::array<std::int64_t, kMaxCellVertices> ids{};
  const int count = grid.cell_points(cell, ids);
  Vec3d sum;
  for (int v = 0; v < count; ++v) sum = sum + grid.point(ids[static_cast<std::size_t>(v)]);
  return sum / static_cast<double>(count);
}

std::shared_ptr<const FaceGraph> build_face_graph(const Grid& grid) {
  constexpr std::int64_t kMost = std::int64_t{0xfffffff0};
  if (grid.rectilinear() || grid.cell_count() == 0 || grid.cell_count() > kMost / 6 || grid.point_count() > kMost) return nullptr;
  auto graph = std::make_shared<FaceGraph>();
  const Box3d bounds = grid.bounds();
  graph->cells = static_cast<std::uint32_t>(grid.cell_count());
  graph->center = bounds.center();
  graph->diagonal = bounds.diagonal();
  if (grid.structured())
    build_curvilinear(grid, *graph);
  else
    build_unstructured(grid, *graph);
  close_exterior(grid, *graph);
  graph->bytes = graph->neighbor.size() * sizeof(std::uint32_t) + graph->planes.size() * sizeof(FacePlane) + graph->faces.size() +
                 graph->exterior.capacity() * sizeof(ExteriorFace) + graph->joined.capacity() * sizeof(JoinedFace);
  return graph;
}

std::shared_ptr<const FaceGraph> face_graph(const Grid& grid) {
  if (!grid.storage) return build_face_graph(grid);  // nothing tells it from the next grid at its place
  const Identity identity = identity_of(grid);
  if (auto found = find_kept(identity)) return found;
  auto graph = build_face_graph(grid);
  if (graph) keep(identity, graph);
  return graph;
}

}  // namespace isostrata
