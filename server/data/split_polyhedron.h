// Polyhedra as cells of the four types, split without breaking faces.
//
// A polyhedron that is a tetrahedron, pyramid, wedge or hexahedron becomes that cell. Any other is joined face by face to a point
// inside it: triangles make tetrahedra, quadrilaterals make pyramids on the whole quadrilateral, larger polygons are cut into
// triangles first, and so are triangles that have a fourth point on an edge. How a face is cut depends on its points and their global
// ids only, so two cells that share a face agree on it whatever kinds they are.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
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
  std::vector<CellType> types;             // [pieces], right-handed
  std::vector<std::int64_t> connectivity;  // [sum of the pieces' vertices] global ids or kAddedPoint
  std::vector<std::int64_t> points;        // [n] the polyhedron's distinct points, increasing
  /// [n] what each point counts for in any array's value at the added point; sums to 1. All equal where the mean of the points
  /// sees all faces, else what the least-squares linear fit gives (some may be negative): a linear field stays linear.
  std::vector<double> weights;
  Vec3d added;  // the sum of weights times positions
};

/// Replaces what is in `out`. Degenerate faces (fewer than three distinct points) hold no volume and are left out. O(F log F) for
/// F face corners, with a search for the added point of at most a few hundred passes where the mean of the points does not see
/// every face.
void split_polyhedron(const PolyhedronFaces& faces, const std::function<Vec3d(std::int64_t)>& position, PolyhedronSplit& out);

/// Cuts a polygon into triangles, three ids each, the same for every cell that has it: a fan from its smallest id where that
/// covers the polygon with triangles that have an area, else a fan from another point, else one with triangles without area, else
/// cut ears, begun at the smallest id towards its smaller neighbour. A corner in line with its neighbours, or nearly (the middle of
/// an edge, beside refined cells), makes no triangle with them where there is another way: the face beyond that edge would have it, too.
/// Each triangle goes round as the polygon does.
void cut_polygon(std::span<const std::int64_t> cycle, const std::function<Vec3d(std::int64_t)>& position,
                 std::vector<std::int64_t>& triangles);

}  // namespace isostrata
