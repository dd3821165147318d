// The edges of tetrahedra and the faces that only one of them has, numbered once for whatever is cut out of them later.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/buffer.h"
#include "base/task.h"

namespace isostrata {

struct NumberedEdges {
  Buffer<std::uint32_t> first;                 // [points + 1] of the edges that run from a point
  Buffer<std::uint32_t> ends;                  // [edges] the point that it runs to; of one point increasing
  Buffer<std::array<std::uint32_t, 6>> edges;  // [nt] between vertices 01, 02, 03, 12, 13, 23
  Buffer<std::uint8_t> open;                   // [nt] bit i: no other tetrahedron has the face without vertex i
};

/// vertices: [nt] of each tetrahedron four different points of [0, points), each edge the same way round in all; nt < 2^32 / 6.
/// 12 bytes a tetrahedron and 12 a point beside the result. O(nt), on the pool; the result does not depend on threads. Throws
/// cancelled.
NumberedEdges number_edges(std::span<const std::array<std::uint32_t, 4>> vertices, std::size_t points, const Task& task);

}  // namespace isostrata
