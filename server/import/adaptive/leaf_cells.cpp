#include "import/adaptive/leaf_cells.h"

#include <algorithm>
#include <array>
#include <span>
#include <string>

#include <boost/container_hash/hash.hpp>
#include <boost/unordered/unordered_flat_map.hpp>

#include "tables/cell_type.h"

namespace isostrata {
namespace {

constexpr std::int64_t kTile = 64;  // cells along an edge of what is looked at together
constexpr std::uint8_t kCovered = 1, kNearFiner = 2;

using PlaceMap = boost::unordered_flat_map<LatticePlace, std::int64_t, boost::hash<LatticePlace>>;

/// Levels from the finest to the coarsest: the points that hang at a cell are there before it is looked at.
class LeafMaker {
 public:
  LeafMaker(const LevelLattice& lattice, const ReadRequest& request) : lattice_(lattice), request_(request) {
    for (int axis = 0; axis < 3; ++axis)
      if (axis != lattice.flat_axis) along_.push_back(static_cast<std::size_t>(axis));
  }

  LeafCells run() {
    const std::uint64_t corners = flat() ? 4 : 8;
    check_bytes(request_, static_cast<std::uint64_t>(lattice_.leaves) * (corners * 8 + 50), request_.file.filename().string() + ": " + std::to_string(lattice_.leaves) + " leaves as one unstructured grid");
    out_.connectivity.reserve(static_cast<std::size_t>(lattice_.leaves) * corners);
    for (auto* of_cells : {&out_.offsets, &out_.source, &out_.in_file}) of_cells->reserve(static_cast<std::size_t>(lattice_.leaves) + 1);
    out_.points.reserve(static_cast<std::size_t>(lattice_.leaves));
    for (level_ = lattice_.levels.size(); level_-- > 0;)
      for (const std::size_t box : lattice_.levels[level_].boxes) add_box(box);
    return std::move(out_);
  }

 private:
  bool flat() const { return lattice_.flat_axis >= 0; }
  const LevelLattice::Level& level(std::size_t number) const { return lattice_.levels[number]; }

  void add_box(std::size_t box) {
    const CellRange& range = lattice_.cells[box];
    CellRange tile;
    for (tile.lower[2] = range.lower[2]; tile.lower[2] < range.upper[2]; tile.lower[2] += kTile)
      for (tile.lower[1] = range.lower[1]; tile.lower[1] < range.upper[1]; tile.lower[1] += kTile)
        for (tile.lower[0] = range.lower[0]; tile.lower[0] < range.upper[0]; tile.lower[0] += kTile) {
          for (std::size_t a = 0; a < 3; ++a) tile.upper[a] = std::min(tile.lower[a] + kTile, range.upper[a]);
          tile_ = tile;
          mark_cells();
          add_tile(box);
        }
  }

  // ---- which cells are leaves, and which of them need a look --------------------------------------------------------------------

  std::size_t in_tile(const LatticePlace& cell) const {
    return static_cast<std::size_t>(cell[0] - tile_.lower[0] + tile_.extent(0) * (cell[1] - tile_.lower[1] + tile_.extent(1) * (cell[2] - tile_.lower[2])));
  }

  template <class Use>
  static void for_each_in(const CellRange& range, const Use& use) {
    for (std::int64_t k = range.lower[2]; k < range.upper[2]; ++k)
      for (std::int64_t j = range.lower[1]; j < range.upper[1]; ++j)
        for (std::int64_t i = range.lower[0]; i < range.upper[0]; ++i) use(LatticePlace{i, j, k});
  }

  CellRange grown(CellRange range) const {
    for (const std::size_t a : along_) --range.lower[a], ++range.upper[a];
    return range;
  }

  void mark_cells() {
    marks_.assign(static_cast<std::size_t>(tile_.count()), 0);
    for (std::size_t finer = level_ + 1; finer < lattice_.levels.size(); ++finer) {
      const std::int64_t ratio = level(level_).unit / level(finer).unit;
      CellRange wanted = grown(tile_);
      for (const std::size_t a : along_) wanted.lower[a] *= ratio, wanted.upper[a] *= ratio;
      level(finer).tree.for_each_meeting(wanted, [&](std::size_t, CellRange box) {
        for (const std::size_t a : along_) box.lower[a] = divided_down(box.lower[a], ratio), box.upper[a] = divided_down(box.upper[a] - 1, ratio) + 1;
        for_each_in(intersection(grown(box), tile_), [&](const LatticePlace& cell) { marks_[in_tile(cell)] |= kNearFiner; });
        for_each_in(intersection(box, tile_), [&](const LatticePlace& cell) { marks_[in_tile(cell)] |= kCovered; });
      });
    }
  }

  // ---- points -------------------------------------------------------------------------------------------------------------------

  std::int64_t add_point(const LatticePlace& place) {
    out_.points.push_back(lattice_.position(place));
    return static_cast<std::int64_t>(out_.points.size()) - 1;
  }

  static std::int64_t number_in(PlaceMap& map, const LatticePlace& place, const auto& make) {
    const auto [entry, fresh] = map.try_emplace(place, 0);
    if (fresh) entry->second = make();
    return entry->second;
  }

  std::int64_t point_at(const LatticePlace& place) {
    return number_in(points_, place, [&] { return add_point(place); });
  }

  bool is_point(const LatticePlace& place) const { return points_.contains(place); }

  LatticePlace corner_of(const LatticePlace& cell) const {
    LatticePlace place{};
    for (const std::size_t a : along_) place[a] = cell[a] * level(level_).unit;
    return place;
  }

  /// Only the eight leaves around it have it, all of them are in this tile, and none of them is cut.
  bool is_inside(const LatticePlace& corner) const {
    CellRange around{corner, corner};
    for (std::size_t a = 0; a < 3; ++a) ++around.upper[a];
    for (const std::size_t a : along_) --around.lower[a];
    for (std::size_t a = 0; a < 3; ++a)
      if (around.lower[a] < tile_.lower[a] || around.upper[a] > tile_.upper[a]) return false;
    bool leaves = true;
    for_each_in(around, [&](const LatticePlace& cell) { leaves = leaves && marks_[in_tile(cell)] == 0; });
    return leaves;
  }

  /// The number of a corner of cells of the tile.
  std::int64_t corner_point(const LatticePlace& corner) {
    std::int64_t& known = ids_[static_cast<std::size_t>(corner[0] - tile_.lower[0] + (tile_.extent(0) + 1) * (corner[1] - tile_.lower[1] + (tile_.extent(1) + 1) * (corner[2] - tile_.lower[2])))];
    if (known < 0) known = is_inside(corner) ? add_point(corner_of(corner)) : point_at(corner_of(corner));
    return known;
  }

  // ---- cells --------------------------------------------------------------------------------------------------------------------

  void add_tile(std::size_t box) {
    ids_.assign(static_cast<std::size_t>((tile_.extent(0) + 1) * (tile_.extent(1) + 1) * (tile_.extent(2) + 1)), -1);
    const CellRange& range = lattice_.cells[box];
    for_each_in(tile_, [&](const LatticePlace& cell) {
      const std::uint8_t mark = marks_[in_tile(cell)];
      if (mark & kCovered) return;
      const std::int64_t in_box = cell[0] - range.lower[0] + range.extent(0) * (cell[1] - range.lower[1] + range.extent(1) * (cell[2] - range.lower[2]));
      out_.in_file.push_back(lattice_.first_cell[box] + in_box);
      out_.level.push_back(static_cast<std::uint8_t>(level_));
      if (!(mark & kNearFiner) || !add_pieces(cell)) add_whole(cell);
    });
    check_bytes(request_, out_.points.size() * 24 + out_.connectivity.size() * 8 + out_.types.size() * 17 + out_.in_file.size() * 9, request_.file.filename().string());
  }

  void end_cell(CellType type) {
    out_.types.push_back(static_cast<std::uint8_t>(type));
    out_.offsets.push_back(static_cast<std::int64_t>(out_.connectivity.size()));
    out_.source.push_back(static_cast<std::int64_t>(out_.in_file.size()) - 1);
  }

  void add_whole(const LatticePlace& cell) {
    if (flat()) {
      for (const auto& [u, v] : {std::array{0, 0}, std::array{1, 0}, std::array{1, 1}, std::array{0, 1}}) {
        LatticePlace corner = cell;
        corner[along_[0]] += u;
        corner[along_[1]] += v;
        out_.connectivity.push_back(corner_point(corner));
      }
      return end_cell(CellType::quadrilateral);
    }
    for (const auto& of : kHexahedronCorners) out_.connectivity.push_back(corner_point({cell[0] + of[0], cell[1] + of[1], cell[2] + of[2]}));
    end_cell(CellType::hexahedron);
  }

  // ---- leaves beside finer ones -------------------------------------------------------------------------------------------------

  static LatticePlace moved(LatticePlace place, std::size_t axis, std::int64_t by) {
    place[axis] += by;
    return place;
  }

  /// The points of the edge from `from` to one unit of `level` further along the axis, without its last; of `backwards` from there to `from`.
  void add_edge(std::size_t of_level, const LatticePlace& from, std::size_t axis, bool backwards) {
    const std::int64_t unit = level(of_level).unit;
    if (of_level + 1 < lattice_.levels.size() && is_point(moved(from, axis, level(of_level + 1).unit))) {
      const std::int64_t step = level(of_level + 1).unit;
      for (std::int64_t at = 0; at < unit; at += step) add_edge(of_level + 1, moved(from, axis, backwards ? unit - step - at : at), axis, backwards);
      return;
    }
    cycle_.push_back(point_at(backwards ? moved(from, axis, unit) : from));
  }

  /// The outline of a square of the level, seen from where axis u turns into axis v counter-clockwise, or from its other side.
  void outline(std::size_t of_level, const LatticePlace& from, std::size_t u, std::size_t v, bool other_side) {
    const std::int64_t unit = level(of_level).unit;
    if (other_side) std::swap(u, v);
    cycle_.clear();
    add_edge(of_level, from, u, false);
    add_edge(of_level, moved(from, u, unit), v, false);
    add_edge(of_level, moved(from, v, unit), u, true);
    add_edge(of_level, from, v, true);
  }

  /// Notes a face as cycles, counter-clockwise seen from outside: of its finer neighbours, or one.
  void add_face(std::size_t of_level, const LatticePlace& from, std::size_t axis, bool upper) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const std::int64_t unit = level(of_level).unit;
    if (of_level + 1 < lattice_.levels.size()) {
      const std::int64_t step = level(of_level + 1).unit;
      if (is_point(moved(moved(from, u, step), v, step))) {
        for (std::int64_t at_v = 0; at_v < unit; at_v += step)
          for (std::int64_t at_u = 0; at_u < unit; at_u += step) add_face(of_level + 1, moved(moved(from, u, at_u), v, at_v), axis, upper);
        return;
      }
    }
    outline(of_level, from, u, v, !upper);
    if (cycle_.size() == 4) {
      quadrilaterals_.insert(quadrilaterals_.end(), cycle_.begin(), cycle_.end());
      return;
    }
    const LatticePlace middle = moved(moved(from, u, unit / 2), v, unit / 2);
    add_fan(number_in(middles_, middle, [&] {
      const std::int64_t point = add_point(middle);
      out_.middles.push_back({point, point_at(from), point_at(moved(from, u, unit)), point_at(moved(from, v, unit)), point_at(moved(moved(from, u, unit), v, unit))});
      return point;
    }));
  }

  /// The triangles of the cycle about a point.
  void add_fan(std::int64_t middle) {
    for (std::size_t i = 0; i < cycle_.size(); ++i) triangles_.insert(triangles_.end(), {middle, cycle_[i], cycle_[(i + 1) % cycle_.size()]});
  }

  /// False if no finer cell is at a face or an edge of it.
  bool add_pieces(const LatticePlace& cell) {
    const LatticePlace from = corner_of(cell);
    const std::int64_t unit = level(level_).unit;
    LatticePlace middle = from;
    for (const std::size_t a : along_) middle[a] += unit / 2;
    quadrilaterals_.clear();
    triangles_.clear();
    if (flat()) {
      outline(level_, from, along_[0], along_[1], false);
      if (cycle_.size() == 4) return false;
      add_fan(add_point(middle));
      end_pieces(CellType::triangle, triangles_, 3, -1);
    } else {
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (const bool upper : {false, true}) add_face(level_, upper ? moved(from, axis, unit) : from, axis, upper);
      if (triangles_.empty() && quadrilaterals_.size() == 6 * 4) return false;
      const std::int64_t apex = add_point(middle);
      end_pieces(CellType::pyramid, quadrilaterals_, 4, apex);
      end_pieces(CellType::tetrahedron, triangles_, 3, apex);
    }
    ++out_.split;
    return true;
  }

  /// Cells on these faces, `corners` each; with an apex, faces are turned inwards, as VTK has the base of a cell first.
  void end_pieces(CellType type, std::vector<std::int64_t>& faces, std::size_t corners, std::int64_t apex) {
    for (std::size_t first = 0; first < faces.size(); first += corners) {
      const std::span<std::int64_t> face(&faces[first], corners);
      if (apex >= 0) std::reverse(face.begin(), face.end());
      out_.connectivity.insert(out_.connectivity.end(), face.begin(), face.end());
      if (apex >= 0) out_.connectivity.push_back(apex);
      end_cell(type);
      ++out_.pieces;
    }
  }

  const LevelLattice& lattice_;
  const ReadRequest& request_;
  std::vector<std::size_t> along_;  // the axes in which cells have an extent
  std::size_t level_ = 0;
  CellRange tile_;
  std::vector<std::uint8_t> marks_;  // [cells of the tile]
  std::vector<std::int64_t> ids_;    // [points of the tile]; -1: not yet
  PlaceMap points_;                  // that more than one tile may have
  PlaceMap middles_;                 // of faces that are cut
  std::vector<std::int64_t> cycle_, quadrilaterals_, triangles_;
  LeafCells out_;
};

}  // namespace

LeafCells leaf_cells(const LevelLattice& lattice, const ReadRequest& request) { return LeafMaker(lattice, request).run(); }

}  // namespace isostrata
