// Polyhedra as cells of the four types, split without breaking faces.
//
// A polyhedron that is a tetrahedron, pyramid, wedge or hexahedron becomes that cell. Any other is joined face by face to a point
// inside it: triangles make tetrahedra, quadrilaterals make pyramids on the whole quadrilateral, larger polygons are cut into
// triangles first, and so are triangles that have a fourth point on an edge. How a face is cut depends on its points and their global
// ids only, so two cells that share a face agree on it whatever kinds they are.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <unordered_set>
#include <vector>

#include "base/vec.h"
#include "tables/cell_type.h"

namespace isostrata {

/// Faces as cycles of global point ids, in either direction.
struct PolyhedronFaces {
  std::vector<std::int64_t> ids;
  std::vector<std::size_t> first{0};  // [faces + 1] into ids

  std::size_t size() const { return first.size() - 1; }
  std::span<const std::int64_t> face(std::size_t f) const { return {ids.data() + first[f], first[f + 1] - first[f]}; }
  void add(std::span<const std::int64_t> cycle) {
    ids.insert(ids.end(), cycle.begin(), cycle.end());
    first.push_back(ids.size());
  }
  void clear() {
    ids.clear();
    first.assign(1, 0);
  }
};

/// The points in the middle of edges (beside refined cells) of all polyhedra of a mesh. A triangle of such a point and its neighbours
/// would be one of both faces at the edge, or as thin as rounding or smoothing made it, in whatever plane. In some cell most belong to
/// two faces only; where there are refined cells, corners at which a face's outline turns by less than 27 degrees count as well.
/// Meshes without any are cut by their numbers alone, so that they are cut alike at every step when their points move. To be told
/// of every polyhedron before any is split; where a piece is turned then (PolyhedronSplit::turned), all are to be split again with
/// nearly_in_line().
class EdgePoints {
 public:
  void add(const PolyhedronFaces& cell);  // O(corners log corners)
  /// From now on corners that are nearly in line count, whatever cells there are.
  void nearly_in_line() { nearly_ = true; }
  bool contains(std::int64_t id) const { return points_.contains(id); }
  bool contains(std::int64_t id, const Vec3d& before, const Vec3d& at, const Vec3d& after) const;
  /// Whether a face of four corners is a triangle with a point on an edge, as one of its cells has it.
  bool is_triangle_of_four(std::span<const std::int64_t> face) const;

 private:
  bool nearly_ = false;
  std::unordered_set<std::int64_t> points_;
  std::set<std::array<std::int64_t, 4>> triangles_of_four_;  // increasing
};

enum class SplitKind {
  whole,        // it is one of the four cells
  star,         // split about an added point that sees all of its faces
  overlapping,  // no point sees all of its faces: split about the mean of its points, pieces overlap
  open          // not a closed surface: an edge does not have two faces. No pieces
};

/// Stands for the added point in PolyhedronSplit::connectivity.
inline constexpr std::int64_t kAddedPoint = -1;

struct PolyhedronSplit {
  SplitKind kind = SplitKind::open;
  bool turned = false;                     // the added point does not see all triangles from inside, be it for rounding
  std::vector<CellType> types;             // [pieces], right-handed
  std::vector<std::int64_t> connectivity;  // [sum of the pieces' vertices] global ids or kAddedPoint
  std::vector<std::int64_t> points;        // [n] the polyhedron's distinct points, increasing
  /// [n] what each point counts for in any array's value at the added point; sums to 1. All equal where the mean of the points
  /// sees all faces, else what the least-squares linear fit gives (some may be negative): a linear field stays linear.
  std::vector<double> weights;
  Vec3d added;  // the sum of weights times positions
};

/// Replaces what is in `out`. Degenerate faces (fewer than three distinct points) hold no volume and are left out. O(F log F) for
/// F face corners, with a search for the added point of a few dozen passes where the mean of the points does not see every face.
void split_polyhedron(const PolyhedronFaces& faces, const std::function<Vec3d(std::int64_t)>& position,
                      const EdgePoints& edge_points, PolyhedronSplit& out);

/// Cuts a polygon into triangles, three ids each, the same for every cell that has it: a fan from the smallest id that has no edge
/// point beside it and whose fan covers the polygon; else ears, not those of edge points if there are others, begun at the smallest
/// id towards its smaller neighbour. Each triangle goes round as the polygon does.
void cut_polygon(std::span<const std::int64_t> cycle, const std::function<Vec3d(std::int64_t)>& position,
                 const EdgePoints& edge_points, std::vector<std::int64_t>& triangles);

}  // namespace isostrata
