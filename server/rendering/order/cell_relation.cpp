#include "rendering/order/cell_relation.h"

#include <bit>

#include "base/parallel.h"

namespace isostrata {
namespace {

/// Of each face to the cell before: bit a: that cell is in front; bit 3 + a: behind.
template <class Point>
class CurvilinearSides {
 public:
  CurvilinearSides(std::span<const Point> points, const FaceGraph& graph, const OrderView& view)
      : points_(points), graph_(graph), view_(view) {}

  void row(std::int64_t j, std::int64_t k, std::uint8_t* out) const {
    const std::int64_t nx = graph_.cell_dims[0] + 1, ny = graph_.cell_dims[1] + 1;
    const Point* r00 = points_.data() + nx * (j + ny * k);
    const Point *r10 = r00 + nx, *r01 = r00 + nx * ny, *r11 = r01 + nx;
    const std::uint8_t* faces = graph_.faces.data() + graph_.cell_dims[0] * (j + graph_.cell_dims[1] * k);
    for (std::int64_t i = 0; i < graph_.cell_dims[0]; ++i) {
      const Vec3d a = at(r00[i]), b = at(r10[i]), c = at(r11[i]), d = at(r01[i]);  // the face to i - 1: (j, k), (j+1, k), ...
      const Vec3d e = at(r00[i + 1]), f = at(r01[i + 1]), g = at(r10[i + 1]);
      const double x = side(a, b, c, d);  // along i
      const double y = side(a, d, f, e);  // along j: (k, i), (k+1, i), (k+1, i+1), (k, i+1)
      const double z = side(a, e, g, b);  // along k: (i, j), (i+1, j), ...
      const unsigned bits = faces[i];
      const auto relation = [bits](double value, unsigned axis) -> unsigned {
        if (bits >> (3 + axis) & 1 || value == 0) return 0;
        const bool turned = bits >> axis & 1;
        // The normal points towards this cell: with the eye on that side the cell before is behind.
        return (value > 0) != turned ? 8u << axis : 1u << axis;
      };
      out[i] = static_cast<std::uint8_t>(relation(x, 0) | relation(y, 1) | relation(z, 2));
    }
  }

 private:
  static Vec3d at(const Point& p) { return {p.x, p.y, p.z}; }
  double side(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) const {
    const Vec3d n = cross(c - a, d - b), middle = (a + b + c + d) * (0.25 * view_.weight);
    return dot(n, view_.x - middle);
  }

  std::span<const Point> points_;
  const FaceGraph& graph_;
  OrderView view_;
};

void relate_curvilinear(const Grid& grid, const FaceGraph& graph, const OrderView& view, CellRelation& relation) {
  const auto& n = graph.cell_dims;
  const std::int64_t layer = n[0] * n[1];
  Buffer<std::uint8_t> sides(graph.cells + static_cast<std::size_t>(layer));  // a layer of nothing behind the last
  std::fill(sides.end() - static_cast<std::ptrdiff_t>(layer), sides.end(), std::uint8_t{0});
  std::visit(
      [&](auto points) {
        const CurvilinearSides<std::remove_const_t<typename decltype(points)::element_type>> rows(points, graph, view);
        parallel_for(n[1] * n[2], 16, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t r = begin; r < end; ++r) rows.row(r % n[1], r / n[1], sides.data() + r * n[0]);
        });
      },
      std::get_if<CurvilinearGrid>(&grid.shape)->points);
  parallel_for(graph.cells, 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t c = begin; c < end; ++c) {
      // Cells at the end of a row look at the next row's first, whose face to the cell before does not exist.
      const unsigned own = sides[static_cast<std::size_t>(c)], x = sides[static_cast<std::size_t>(c + 1)],
                     y = sides[static_cast<std::size_t>(c + n[0])], z = sides[static_cast<std::size_t>(c + layer)];
      const unsigned front =
          (own & 1) | (x >> 3 & 1) << 1 | (own >> 1 & 1) << 2 | (y >> 4 & 1) << 3 | (own >> 2 & 1) << 4 | (z >> 5 & 1) << 5;
      relation.front[static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(front);
      relation.behind[static_cast<std::size_t>(c)] =
          static_cast<std::uint16_t>(std::popcount(own >> 3) + (x & 1) + (y >> 1 & 1) + (z >> 2 & 1));
    }
  });
}

template <int kSlots>
void relate_unstructured(const FaceGraph& graph, const OrderView& view, CellRelation& relation) {
  const double margin = side_margin(view, graph);
  parallel_for(graph.cells, 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
      unsigned front = 0, behind = 0;
      for (std::size_t s = 0; s < kSlots; ++s) {
        if (graph.neighbor[c * kSlots + s] == kNoCell) continue;
        const int side = side_of(graph.planes[c * kSlots + s], view, graph.center, margin);
        front |= static_cast<unsigned>(side > 0) << s;
        behind += side < 0;
      }
      relation.front[c] = static_cast<std::uint8_t>(front);
      relation.behind[c] = static_cast<std::uint16_t>(behind);
    }
  });
}

}  // namespace

OrderView order_view(const Camera& camera) {
  if (camera.orthographic) return {normalized(camera.eye - camera.at), 0};
  return {camera.eye, 1};
}

double side_margin(const OrderView& view, const FaceGraph& graph) {
  return view.weight == 0 ? 2e-7 : 2e-7 * std::max(length(view.x - graph.center), graph.diagonal);
}

CellRelation relate_cells(const Grid& grid, const FaceGraph& graph, const Camera& camera) {
  CellRelation relation;
  relation.front.resize(graph.cells);
  relation.behind.resize(graph.cells);
  const OrderView view = order_view(camera);
  if (graph.slots == 0)
    relate_curvilinear(grid, graph, view, relation);
  else if (graph.slots == 4)
    relate_unstructured<4>(graph, view, relation);
  else
    relate_unstructured<6>(graph, view, relation);
  return relation;
}

}  // namespace isostrata
