#include "rendering/order/visibility_order.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "rendering/order/cell_order.h"
#include "rendering/order/mpvo.h"

namespace isostrata {
namespace {

constexpr std::int64_t kItemsAtOnce = 8192;

bool is_drawn(const IntervalMesh& mesh, std::span<const std::uint8_t> drawn, std::size_t tetrahedron) {
  return drawn[mesh.tetrahedron_interval[tetrahedron]] != 0;
}

std::vector<std::uint32_t> drawn_tetrahedra(const IntervalMesh& mesh, std::span<const std::uint8_t> drawn) {
  std::vector<std::uint32_t> ids;
  ids.reserve(mesh.tetrahedra.size());
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    if (is_drawn(mesh, drawn, t)) ids.push_back(static_cast<std::uint32_t>(t));
  return ids;
}

/// The bits of a float as an integer that is smaller for larger numbers.
std::uint32_t far_first_key(float distance) {
  const auto bits = std::bit_cast<std::uint32_t>(distance);
  return bits >> 31 ? bits : ~bits & 0x7fffffffu;
}

struct Keyed {
  std::uint32_t key;
  std::uint32_t id;
};

/// Stable, by increasing key: least significant digit first, 11 bits at a time.
void radix_sort(std::vector<Keyed>& items) {
  constexpr int kBits = 11;
  std::vector<Keyed> other(items.size());
  for (int shift = 0; shift < 32; shift += kBits) {
    std::array<std::size_t, (1u << kBits) + 1> start{};
    const auto digit = [shift](std::uint32_t key) { return key >> shift & ((1u << kBits) - 1); };
    for (const Keyed& item : items) ++start[digit(item.key) + 1];
    if (*std::max_element(start.begin(), start.end()) == items.size()) continue;  // one digit only: in order already
    for (std::size_t d = 1; d < start.size(); ++d) start[d] += start[d - 1];
    for (const Keyed& item : items) other[start[digit(item.key)]++] = item;
    items.swap(other);
  }
}

/// The index of the cell that holds x along one axis of `points` points, clamped into [0, points - 2].
template <class Coordinate>
std::int64_t cell_index(double x, std::int64_t points, Coordinate coordinate) {
  if (points < 2) return 0;
  const bool rising = coordinate(points - 1) > coordinate(0);
  std::int64_t low = 0,
               high = points -
                      1;  // invariant: x is past coordinate(low), or low is 0; x is before coordinate(high), or high is the last
  while (high - low > 1) {
    const std::int64_t middle = (low + high) / 2;
    if (rising ? x >= coordinate(middle) : x <= coordinate(middle))
      low = middle;
    else
      high = middle;
  }
  return low;
}

/// Parallel rays come from infinitely far away, however near the camera's eye is.
std::array<std::int64_t, 3> eye_cell(const Grid& grid, const Camera& camera) {
  Vec3d eye = camera.eye;
  if (camera.orthographic)
    for (int axis = 0; axis < 3; ++axis)
      eye[axis] = std::copysign(std::numeric_limits<double>::infinity(), camera.eye[axis] - camera.at[axis]);
  std::array<std::int64_t, 3> cell{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (const auto* uniform = std::get_if<UniformGrid>(&grid.shape))
      cell[a] = cell_index(eye[axis], uniform->dims[a], [&](std::int64_t i) {
        return uniform->origin[axis] + static_cast<double>(i) * uniform->spacing[axis];
      });
    else if (const auto* rectilinear = std::get_if<RectilinearGrid>(&grid.shape))
      cell[a] = cell_index(eye[axis], rectilinear->dims[a],
                           [&](std::int64_t i) { return rectilinear->axes[a][static_cast<std::size_t>(i)]; });
  }
  return cell;
}

/// The mesh's runs of cells, far cells first.
std::vector<std::uint32_t> sort_runs(const Grid& grid, const IntervalMesh& mesh, const Camera& camera) {
  const auto dims = grid.dims();
  const std::int64_t nx = std::max<std::int64_t>(dims[0] - 1, 1), ny = std::max<std::int64_t>(dims[1] - 1, 1);
  const auto origin = eye_cell(grid, camera);
  std::vector<std::uint32_t> keys(mesh.cell_runs.size());
  const auto farthest = static_cast<std::size_t>(dims[0] + dims[1] + dims[2]);
  std::vector<std::size_t> start(farthest + 2, 0);
  for (std::size_t r = 0; r < keys.size(); ++r) {
    const std::int64_t cell = mesh.cell_runs[r].cell;
    const std::int64_t i = cell % nx, j = cell / nx % ny, k = cell / (nx * ny);
    const auto distance = static_cast<std::size_t>(std::abs(i - origin[0]) + std::abs(j - origin[1]) + std::abs(k - origin[2]));
    keys[r] = static_cast<std::uint32_t>(farthest - std::min(distance, farthest));
    ++start[keys[r] + 1];
  }
  for (std::size_t d = 1; d < start.size(); ++d) start[d] += start[d - 1];
  std::vector<std::uint32_t> order(keys.size());
  for (std::size_t r = 0; r < keys.size(); ++r) order[start[keys[r]]++] = static_cast<std::uint32_t>(r);
  return order;
}

}  // namespace

VisibilityOrder mesh_order(const IntervalMesh& mesh, const OrderRequest& request) {
  return {drawn_tetrahedra(mesh, request.drawn), "none needed", true};
}

Vec3d ordering_eye(const Camera& camera) {
  if (!camera.orthographic) return camera.eye;
  const Vec3d back = camera.eye - camera.at;
  const double distance = length(back);
  return camera.eye + back * (1e7 * std::max(distance, half_height(camera)) / distance);
}

VisibilityOrder centroid_order(const IntervalMesh& mesh, const OrderRequest& request, const Camera& camera) {
  VisibilityOrder order{drawn_tetrahedra(mesh, request.drawn), "centroid (approximate)", false};
  std::vector<Keyed> items(order.tetrahedra.size());
  const Vec3d forward = normalized(camera.at - camera.eye);
  parallel_for(static_cast<std::int64_t>(items.size()), kItemsAtOnce, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const std::uint32_t id = order.tetrahedra[i];
      Vec3d sum;
      for (const std::uint32_t p : mesh.tetrahedra[id]) sum = sum + mesh.positions[p];
      const Vec3d from_eye = sum * 0.25 - camera.eye;
      const double distance = camera.orthographic ? dot(forward, from_eye) : length(from_eye);
      items[i] = {far_first_key(static_cast<float>(distance)), id};
    }
  });
  radix_sort(items);
  for (std::size_t i = 0; i < items.size(); ++i) order.tetrahedra[i] = items[i].id;
  return order;
}

namespace {

/// The tetrahedra of these runs of cells, in this order of the cells.
VisibilityOrder order_in_cells(const IntervalMesh& mesh, const OrderRequest& request, Vec3d eye,
                               std::span<const std::uint32_t> runs, std::int64_t& unresolved_pairs) {
  std::vector<std::uint32_t> first(runs.size() + 1, 0);  // where each run's tetrahedra go
  const auto run_end = [&](std::uint32_t r) {
    return r + 1 < mesh.cell_runs.size() ? mesh.cell_runs[r + 1].first_tetrahedron
                                         : static_cast<std::uint32_t>(mesh.tetrahedra.size());
  };
  for (std::size_t i = 0; i < runs.size(); ++i) {
    std::uint32_t count = 0;
    for (std::uint32_t t = mesh.cell_runs[runs[i]].first_tetrahedron; t < run_end(runs[i]); ++t)
      count += is_drawn(mesh, request.drawn, t);
    first[i + 1] = first[i] + count;
  }
  VisibilityOrder order;
  order.tetrahedra.resize(first.back());
  std::atomic<std::int64_t> unresolved{0};
  parallel_for(static_cast<std::int64_t>(runs.size()), 512, [&](std::int64_t begin, std::int64_t end) {
    CellOrder cell_order(request.one_color);
    std::int64_t mine = 0;
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      std::uint32_t out = first[i];
      for (std::uint32_t t = mesh.cell_runs[runs[i]].first_tetrahedron; t < run_end(runs[i]); ++t)
        if (is_drawn(mesh, request.drawn, t)) order.tetrahedra[out++] = t;
      mine += cell_order.sort(mesh, eye, std::span(order.tetrahedra).subspan(first[i], out - first[i]));
    }
    unresolved += mine;
  });
  unresolved_pairs = unresolved;
  return order;
}

/// The mesh's runs in the order of their cells. A cell may have several (join_meshes), which then follow one another.
std::vector<std::uint32_t> runs_in_sequence(const IntervalMesh& mesh, const CellSequence& sequence) {
  constexpr std::uint32_t kNone = 0xffffffffu;
  const std::size_t cells = sequence.cells.size();
  std::vector<std::uint64_t> active((cells + 63) / 64, 0);
  Buffer<std::uint32_t> run_of_cell(cells);  // written where active
  std::vector<std::uint32_t> next;           // [runs] another run of the same cell; empty if there is none
  for (std::uint32_t r = 0; r < mesh.cell_runs.size(); ++r) {
    const auto cell = static_cast<std::size_t>(mesh.cell_runs[r].cell);
    std::uint64_t& word = active[cell / 64];
    const std::uint64_t bit = std::uint64_t{1} << (cell % 64);
    if (word & bit) {
      if (next.empty()) next.assign(mesh.cell_runs.size(), kNone);
      next[r] = run_of_cell[cell];
    }
    word |= bit;
    run_of_cell[cell] = r;
  }
  std::vector<std::uint32_t> runs;
  runs.reserve(mesh.cell_runs.size());
  for (const std::uint32_t cell : sequence.cells) {
    if (!(active[cell / 64] >> (cell % 64) & 1)) continue;
    for (std::uint32_t r = run_of_cell[cell]; r != kNone; r = next.empty() ? kNone : next[r]) runs.push_back(r);
  }
  return runs;
}

std::string mpvo_name(const CellSequence& sequence, std::int64_t unresolved) {
  std::string name = sequence.convex ? "MPVO" : "MPVONC";
  if (sequence.exact && unresolved == 0) return name + " (exact)";
  name += " (" + std::to_string(sequence.cycles) + (sequence.cycles == 1 ? " cycle" : " cycles");
  if (unresolved > 0) name += ", " + std::to_string(unresolved) + " pairs inside cells";
  return name + ")";
}

}  // namespace

VisibilityOrder index_distance_order(const Grid& grid, const IntervalMesh& mesh, const OrderRequest& request,
                                     const Camera& camera) {
  std::int64_t unresolved = 0;
  VisibilityOrder order = order_in_cells(mesh, request, ordering_eye(camera), sort_runs(grid, mesh, camera), unresolved);
  order.exact = unresolved == 0;
  order.method = order.exact ? "index distance (exact)"
                             : "index distance (exact but for " + std::to_string(unresolved) + " pairs inside cells)";
  return order;
}

VisibilityOrder mpvo_order(const Grid& grid, const std::shared_ptr<const FaceGraph>& graph, const IntervalMesh& mesh,
                           const OrderRequest& request, const Camera& camera, int width, int height) {
  const auto sequence = cell_sequence(grid, graph, camera, width, height);
  std::int64_t unresolved = 0;
  VisibilityOrder order = order_in_cells(mesh, request, ordering_eye(camera), runs_in_sequence(mesh, *sequence), unresolved);
  order.exact = sequence->exact && unresolved == 0;
  order.method = mpvo_name(*sequence, unresolved);
  return order;
}

VisibilityOrder visibility_order(const Grid* grid, const IntervalMesh& mesh, const OrderRequest& request, const Camera& camera,
                                 int width, int height) {
  if (!grid || mesh.cell_runs.empty()) return centroid_order(mesh, request, camera);
  if (grid->rectilinear()) return index_distance_order(*grid, mesh, request, camera);
  if (const auto graph = face_graph(*grid)) return mpvo_order(*grid, graph, mesh, request, camera, width, height);
  return centroid_order(mesh, request, camera);
}

}  // namespace isostrata
