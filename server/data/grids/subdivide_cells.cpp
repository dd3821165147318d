#include "data/grids/subdivide_cells.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>

#include "base/error.h"

namespace isostrata {
namespace {

using Edge = std::array<std::int64_t, 2>;
using Face = std::array<std::int64_t, 4>;  // rising; -1 first in a triangle

Edge edge_of(std::int64_t a, std::int64_t b) { return {std::min(a, b), std::max(a, b)}; }

Face face_of(const CellFace& face, std::span<const std::int64_t> ids) {
  Face out{-1, -1, -1, -1};
  for (int v = 0; v < face.size; ++v) out[static_cast<std::size_t>(v)] = ids[static_cast<std::size_t>(face.vertex[static_cast<std::size_t>(v)])];
  std::sort(out.begin(), out.end());
  return out;
}

template <class Key>
void make_unique(std::vector<Key>& keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

template <class Key>
std::int64_t place(const std::vector<Key>& keys, const Key& key) {
  return std::lower_bound(keys.begin(), keys.end(), key) - keys.begin();
}

struct Made {
  std::vector<Vec3d> points;
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> offsets{0}, connectivity;
};

class Subdivision {
 public:
  Subdivision(const Grid& whole, const std::string& name, std::uint64_t max_bytes, const Task& task) : whole_(whole), name_(name), task_(task) {
    std::array<std::int64_t, kMaxCellVertices> ids{};
    std::uint64_t pieces = 0, corners = 0;
    for (std::int64_t cell = 0; cell < whole.cell_count(); ++cell) {
      if (cell % 4096 == 0) task.check();
      if (whole.hidden(cell)) continue;
      ++cells_;
      const auto n = static_cast<std::uint64_t>(whole.cell_points(cell, ids));
      pieces += n + 3;
      corners += n;
    }
    const std::uint64_t bytes = 3 * corners * (sizeof(Edge) + sizeof(Face)) + pieces * (8 * 8 + 8 + 8 + 1) +
                                (2 * corners + static_cast<std::uint64_t>(whole.point_count())) * sizeof(Vec3d);
    if (bytes > max_bytes)
      throw Error(ErrorCode::too_large, name + ": cutting " + std::to_string(cells_) + " cells about their middles needs " + std::to_string(bytes) +
                                            " bytes; the limit is " + std::to_string(max_bytes));
  }

  SubdividedCells run() {
    collect();
    place_points();
    for_cells([&](std::int64_t number, const CellTopology& cell, std::span<const std::int64_t> ids) { cut(number, cell, ids); });
    SubdividedCells out;
    UnstructuredGrid grid;
    grid.points = std::span<const Vec3d>(made_->points);
    grid.types = made_->types;
    grid.offsets = made_->offsets;
    grid.connectivity = made_->connectivity;
    out.grid.shape = grid;
    out.grid.storage = made_;
    out.point_of = std::move(point_of_);
    return out;
  }

 private:
  template <class Visit>
  void for_cells(const Visit& visit) const {
    std::array<std::int64_t, kMaxCellVertices> ids{};
    std::int64_t number = 0;
    for (std::int64_t cell = 0; cell < whole_.cell_count(); ++cell) {
      if (cell % 1024 == 0) task_.check();
      if (whole_.hidden(cell)) continue;
      const int n = whole_.cell_points(cell, ids);
      visit(number++, topology(whole_.cell_type(cell)), std::span<const std::int64_t>(ids).first(static_cast<std::size_t>(n)));
    }
  }

  void collect() {
    for_cells([&](std::int64_t, const CellTopology& cell, std::span<const std::int64_t> ids) {
      for (std::size_t v = 1; v < ids.size(); ++v)
        if (std::find(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(v), ids[v]) != ids.begin() + static_cast<std::ptrdiff_t>(v))
          throw Error(ErrorCode::unsupported, name_ + ": a " + std::string(cell.name) + " repeats point " + std::to_string(ids[v]) +
                                                  "; values of points are taken whole only in cells with distinct points");
      for (const auto& edge : cell.edges) edges_.push_back(edge_of(ids[static_cast<std::size_t>(edge[0])], ids[static_cast<std::size_t>(edge[1])]));
      for (const CellFace& face : cell.faces) faces_.push_back(face_of(face, ids));
    });
    make_unique(edges_);
    task_.check();
    make_unique(faces_);
  }

  /// Middles of cells first: a face of four points is halved from its smallest one, and the tips of pyramids need that to be the middle.
  void place_points() {
    const auto n = static_cast<std::size_t>(whole_.point_count());
    made_->points.reserve(static_cast<std::size_t>(cells_) + faces_.size() + edges_.size() + n);
    const auto add_middle = [&](std::span<const std::int64_t> ids) {
      Vec3d sum{};
      for (const std::int64_t id : ids) sum = sum + whole_.point(id);
      made_->points.push_back(sum * (1.0 / static_cast<double>(ids.size())));
    };
    for_cells([&](std::int64_t, const CellTopology&, std::span<const std::int64_t> ids) { add_middle(ids); });
    for (const Face& face : faces_) add_middle(std::span<const std::int64_t>(face).subspan(face[0] < 0 ? 1 : 0));
    for (const Edge& edge : edges_) add_middle(edge);
    for (std::size_t p = 0; p < n; ++p) made_->points.push_back(whole_.point(static_cast<std::int64_t>(p)));
  }

  std::int64_t middle(const Face& face) const { return cells_ + place(faces_, face); }
  std::int64_t middle(std::int64_t a, std::int64_t b) const { return cells_ + static_cast<std::int64_t>(faces_.size()) + place(edges_, edge_of(a, b)); }
  std::int64_t corner(std::int64_t point) const { return cells_ + static_cast<std::int64_t>(faces_.size() + edges_.size()) + point; }

  void add(CellType type, std::int64_t point, std::initializer_list<std::int64_t> ids) {
    made_->types.push_back(static_cast<std::uint8_t>(type));
    made_->connectivity.insert(made_->connectivity.end(), ids);
    made_->offsets.push_back(static_cast<std::int64_t>(made_->connectivity.size()));
    point_of_.push_back(point);
  }

  void cut(std::int64_t number, const CellTopology& cell, std::span<const std::int64_t> ids) {
    if (is_flat(cell.type)) {
      for (std::size_t v = 0; v < ids.size(); ++v) {
        const std::int64_t p = ids[v], next = ids[(v + 1) % ids.size()], last = ids[(v + ids.size() - 1) % ids.size()];
        add(CellType::quadrilateral, p, {corner(p), middle(p, next), number, middle(last, p)});
      }
      return;
    }
    for (std::size_t v = 0; v < ids.size(); ++v) cut_at(number, cell, ids, static_cast<int>(v));
  }

  /// The faces at the vertex are met in turn: each has an edge that leads out of the vertex and one that leads back.
  void cut_at(std::int64_t number, const CellTopology& cell, std::span<const std::int64_t> ids, int v) {
    struct Turn {
      int out, back;      // the face goes from `back` through the vertex to `out`, seen from outside
      std::int64_t face;  // its middle
    };
    std::array<Turn, 4> turns{};
    int count = 0;
    for (const CellFace& face : cell.faces)
      for (int i = 0; i < face.size; ++i)
        if (face.vertex[static_cast<std::size_t>(i)] == v)
          turns[static_cast<std::size_t>(count++)] = {face.vertex[static_cast<std::size_t>((i + 1) % face.size)],
                                                      face.vertex[static_cast<std::size_t>((i + face.size - 1) % face.size)], middle(face_of(face, ids))};
    // Seen from outside the faces follow one another: where one leads back another one leads out.
    for (int i = 0; i + 1 < count; ++i)
      for (int j = i + 1; j < count; ++j)
        if (turns[static_cast<std::size_t>(j)].out == turns[static_cast<std::size_t>(i)].back) {
          std::swap(turns[static_cast<std::size_t>(i + 1)], turns[static_cast<std::size_t>(j)]);
          break;
        }
    const std::int64_t p = ids[static_cast<std::size_t>(v)];
    const auto edge = [&](int to) { return middle(p, ids[static_cast<std::size_t>(to)]); };
    if (count == 3) {
      const auto& [a, b, c] = std::array{turns[0], turns[1], turns[2]};
      // The bottom is face a, counter-clockwise seen from inside; above it lie what b and c have, and the middle of the cell.
      add(CellType::hexahedron, p,
          {corner(p), edge(a.back), a.face, edge(a.out), edge(b.back), b.face, number, c.face});
      return;
    }
    for (int i = 0; i < count; ++i) {  // the tip of a pyramid
      const Turn& turn = turns[static_cast<std::size_t>(i)];
      add(CellType::pyramid, p, {corner(p), edge(turn.back), turn.face, edge(turn.out), number});
    }
  }

  const Grid& whole_;
  const std::string& name_;
  const Task& task_;
  std::int64_t cells_ = 0;
  std::vector<Edge> edges_;  // sorted, each once
  std::vector<Face> faces_;
  std::shared_ptr<Made> made_ = std::make_shared<Made>();
  std::vector<std::int64_t> point_of_;
};

}  // namespace

SubdividedCells subdivide_cells(const Grid& whole, const std::string& name, std::uint64_t max_bytes, const Task& task) {
  return Subdivision(whole, name, max_bytes, task).run();
}

}  // namespace isostrata
