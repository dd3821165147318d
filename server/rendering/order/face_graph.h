// Which cells of a curvilinear or unstructured grid touch, and in which plane: what of a visibility order does not depend on the
// camera.
//
// Source: P. Williams, "Visibility Ordering Meshed Polyhedra", 1992: the adjacency graph of a mesh, whose edges a viewpoint turns
// into a relation "is behind". What is added here: faces of cells that touch without sharing points (the seam of an O-grid) are
// joined by place, and exterior faces are kept for the gaps that a ray may cross outside the mesh (boundary_gaps.h).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/buffer.h"
#include "data/grids/grid.h"

namespace isostrata {

/// dot(normal, x - FaceGraph::center) = offset; the normal points out of the cell and has length 1, or 0 if the face has no
/// area and so orders nothing.
struct FacePlane {
  float normal[3];
  float offset;
};

/// A face with no cell on its other side.
struct ExteriorFace {
  std::array<std::uint32_t, 4> points;  // counter-clockwise seen from outside; a triangle repeats its last
  std::uint32_t cell;
};

/// Two cells that touch in a face whose points they do not share.
struct JoinedFace {
  std::uint32_t from, to;
  FacePlane plane;  // from `from` to `to`
};

inline constexpr std::uint32_t kNoCell = 0xffffffffu;

struct FaceGraph {
  std::uint32_t cells = 0;
  Vec3d center;         // of the grid's bounds
  double diagonal = 0;  // of the grid's bounds

  // Unstructured grids. Slot s of cell c is the s-th face of its type.
  int slots = 0;                   // per cell: 4 where all cells are tetrahedra, else 6; 0: curvilinear
  Buffer<std::uint32_t> neighbor;  // [cells * slots] kNoCell if there is none or it is hidden
  Buffer<FacePlane> planes;        // [cells * slots]

  // Curvilinear grids. The planes are made of the points as they are needed, which takes no longer than reading them would. Bit
  // a: the face to the cell before it along axis a is turned against the index; bit 3 + a: there is no such cell, or it or this
  // one is hidden, or the face has no area.
  std::array<std::int64_t, 3> cell_dims{};
  Buffer<std::uint8_t> faces;  // [cells]

  std::vector<ExteriorFace> exterior;
  std::vector<JoinedFace> joined;
  bool convex = false;  // no ray that leaves the mesh comes back
  bool plane_faces =
      false;  // all faces are plane, so that one side of each is behind the other; not looked for in curvilinear grids
  std::uint64_t bytes = 0;  // of memory
};

/// Null for rectilinear grids and where the grid has 2^32 / 6 cells, 2^32 points or more. Parallel.
std::shared_ptr<const FaceGraph> build_face_graph(const Grid& grid);

/// The same, kept for the grids asked for last (by identity, while their storage lives). Any thread.
std::shared_ptr<const FaceGraph> face_graph(const Grid& grid);

/// Parts of building, by file. Joins exterior faces that lie at the same place, within 2e-7 of the grid's size; removes those of
/// no area; finds out whether the rest is convex.
void close_exterior(const Grid& grid, FaceGraph& graph);
void build_unstructured(const Grid& grid, FaceGraph& graph);
void build_curvilinear(const Grid& grid, FaceGraph& graph);

/// The middle of the cell's points.
Vec3d cell_middle(const Grid& grid, std::int64_t cell);

}  // namespace isostrata
