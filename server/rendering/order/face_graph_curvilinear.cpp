// Curvilinear grids need no matching: the neighbours are those of the indices. What is found out once is which faces there are
// and which way they look.
#include <algorithm>

#include "base/parallel.h"
#include "rendering/order/face_graph.h"

namespace isostrata {
namespace {

using Index = std::array<std::int64_t, 3>;

class Scan {
 public:
  Scan(const Grid& grid, FaceGraph& graph) : grid_(grid), graph_(graph), points_(grid.dims()) {
    for (std::size_t a = 0; a < 3; ++a) graph.cell_dims[a] = points_[a] - 1;
  }

  void run() {
    graph_.faces.resize(graph_.cells);
    const auto& n = graph_.cell_dims;
    std::vector<std::vector<ExteriorFace>> exterior(static_cast<std::size_t>(n[2]));
    parallel_for(n[2], 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t k = begin; k < end; ++k)
        for (std::int64_t j = 0; j < n[1]; ++j)
          for (std::int64_t i = 0; i < n[0]; ++i) scan_cell({i, j, k}, exterior[static_cast<std::size_t>(k)]);
    });
    for (const auto& slab : exterior) graph_.exterior.insert(graph_.exterior.end(), slab.begin(), slab.end());
  }

 private:
  std::int64_t cell_id(const Index& at) const { return at[0] + graph_.cell_dims[0] * (at[1] + graph_.cell_dims[1] * at[2]); }
  std::int64_t point_id(const Index& at) const { return at[0] + points_[0] * (at[1] + points_[1] * at[2]); }
  bool present(const Index& at) const {
    for (std::size_t a = 0; a < 3; ++a)
      if (at[a] < 0 || at[a] >= graph_.cell_dims[a]) return false;
    return !grid_.hidden(cell_id(at));
  }

  /// The face between the cell and the one before it along the axis, counter-clockwise seen from the cell where the grid is
  /// right-handed.
  std::array<std::int64_t, 4> face(Index at, std::size_t axis) const {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::array<std::int64_t, 4> ids{};
    ids[0] = point_id(at);
    ++at[u];
    ids[1] = point_id(at);
    ++at[v];
    ids[2] = point_id(at);
    --at[u];
    ids[3] = point_id(at);
    return ids;
  }

  void scan_cell(const Index& at, std::vector<ExteriorFace>& exterior) {
    std::uint8_t bits = 0;
    const bool here = present(at);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Index before = at, after = at;
      --before[axis];
      ++after[axis];
      if (here && present(before)) {
        const auto ids = face(at, axis);
        const Vec3d a = grid_.point(ids[2]) - grid_.point(ids[0]), b = grid_.point(ids[3]) - grid_.point(ids[1]);
        const Vec3d n = cross(a, b);
        // Across: the sum of the edges from the points before the face to those behind it.
        Vec3d across;
        const std::int64_t step = axis == 0 ? 1 : axis == 1 ? points_[0] : points_[0] * points_[1];
        for (const std::int64_t id : ids) across = across + (grid_.point(id + step) - grid_.point(id - step));
        if (dot(n, across) < 0) bits |= static_cast<std::uint8_t>(1 << axis);
        if (!(dot(n, n) > 1e-20 * dot(a, a) * dot(b, b))) bits |= static_cast<std::uint8_t>(8 << axis);
      } else {
        bits |= static_cast<std::uint8_t>(8 << axis);
        if (here) add_exterior(at, face(at, axis), exterior);
      }
      if (here && !present(after)) add_exterior(at, face(after, axis), exterior);
    }
    graph_.faces[static_cast<std::size_t>(cell_id(at))] = bits;
  }

  void add_exterior(const Index& at, std::array<std::int64_t, 4> ids, std::vector<ExteriorFace>& exterior) const {
    Vec3d p[4];
    for (std::size_t v = 0; v < 4; ++v) p[v] = grid_.point(ids[v]);
    const Vec3d n = cross(p[2] - p[0], p[3] - p[1]), middle = (p[0] + p[1] + p[2] + p[3]) * 0.25;
    if (dot(n, middle - cell_middle(grid_, cell_id(at))) < 0) std::reverse(ids.begin(), ids.end());
    ExteriorFace& out = exterior.emplace_back();
    for (std::size_t v = 0; v < 4; ++v) out.points[v] = static_cast<std::uint32_t>(ids[v]);
    out.cell = static_cast<std::uint32_t>(cell_id(at));
  }

  const Grid& grid_;
  FaceGraph& graph_;
  Index points_;
};

}  // namespace

void build_curvilinear(const Grid& grid, FaceGraph& graph) { Scan(grid, graph).run(); }

}  // namespace isostrata
