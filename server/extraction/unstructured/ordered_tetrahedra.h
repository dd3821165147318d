// A grid of tetrahedra and an array on it, laid out for being cut again and again: what lies near in space lies near in memory,
// and edges have numbers, so that nothing is hashed, searched for or locked while intervals move.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <variant>

#include "base/buffer.h"
#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"

namespace isostrata {

/// How a tetrahedron whose vertices are in the order of their global ids is turned.
struct TetrahedronTurn {
  static constexpr std::uint16_t kSwapped = 1 << 8;    // its vertices in the order of their ids make a left-handed cell
  static constexpr std::uint16_t kFlat = 1 << 9;       // it has no volume; kSwapped takes it for positive
  static constexpr std::uint16_t kNegative = 1 << 10;  // of the cell's volume, in the order of the grid
  // Bits 2 i, 2 i + 1: the vertex of the grid's cell that is the i-th by id.
};

/// Of 64 tetrahedra, all first vertices, then all second ones ... Behind the last tetrahedron 0.
struct BlockCorners {
  std::array<std::array<std::uint8_t, 64>, 4> of{};
};

/// The tetrahedra that take part (not hidden, of finite positions) in the order of CellClusters, the points they use in the order
/// of their first use. An edge runs from the end with the lower global id; edges are in the order of that end. Holds nothing of
/// the grid. 38 bytes a tetrahedron, 5 an edge, 20 or 32 a point. Used by any number of threads.
class OrderedTetrahedra {
 public:
  static constexpr std::size_t kBlock = 64, kPointBlock = 16;  // tetrahedra, and points, whose values' range is known

  /// Null if the grid has other cells than tetrahedra, one that has a point twice, or more than 2^32 of anything.
  /// O(cells log cells), on the pool; the result does not depend on threads. Throws too_large (more than max_bytes while it is
  /// made), cancelled.
  static std::shared_ptr<const OrderedTetrahedra> make(const Grid& grid, std::uint64_t max_bytes, const Task& task);
  /// What making one takes, about.
  static std::uint64_t foreseen_bytes(const Grid& grid);

  std::size_t count() const { return cells.size(); }
  std::size_t point_count() const { return ids.size(); }
  std::size_t edge_count() const { return ends.size(); }
  Vec3d position(std::uint32_t point) const {
    if (const auto* single = std::get_if<Buffer<Vec3f>>(&positions)) {
      const Vec3f& p = (*single)[point];
      return {p.x, p.y, p.z};
    }
    return (*std::get_if<Buffer<Vec3d>>(&positions))[point];
  }
  /// Of a tetrahedron, in the order of their global ids.
  std::array<std::uint32_t, 4> vertices(std::size_t tetrahedron) const {
    const std::size_t block = tetrahedron / kBlock, at = tetrahedron % kBlock;
    const std::uint32_t* const points = block_points.data() + first_in_block[block];
    const auto& of = corners[block].of;
    return {points[of[0][at]], points[of[1][at]], points[of[2][at]], points[of[3][at]]};
  }
  std::span<const std::uint32_t> points_of_block(std::size_t block) const {
    return {block_points.data() + first_in_block[block], block_points.data() + first_in_block[block + 1]};
  }
  std::size_t blocks() const { return corners.size(); }
  std::uint64_t bytes() const;

  // Written by make() alone.
  Buffer<std::uint32_t> first_in_block;                  // [blocks + 1] into block_points
  Buffer<std::uint32_t> block_points;                    // the points of each block, each once
  Buffer<BlockCorners> corners;                          // [blocks] the vertices by global id, as places in their block's points
  Buffer<std::array<std::uint32_t, 6>> edges;            // [nt] between vertices 01, 02, 03, 12, 13, 23
  Buffer<std::uint32_t> cells;                           // [nt] of the grid
  Buffer<std::uint16_t> turns;                           // [nt] TetrahedronTurn
  Buffer<std::uint8_t> open_faces;                       // [nt] bit k: nobody shares face k of the grid's cell
  Buffer<std::uint32_t> ids;                             // [np] of the grid
  std::variant<Buffer<Vec3f>, Buffer<Vec3d>> positions;  // [np]
  Buffer<std::uint32_t> first_edge;                      // [np + 1] of the edges that run from a point
  Buffer<std::uint32_t> ends;                            // [edges] the point that it runs to
  Buffer<std::uint8_t> begins;                           // [edges] the place in its block of the point that it runs from
  bool some_are_flat = false;
};

/// The values of an array in that order. 1 to 8 bytes a point and a sixteenth as much a tetrahedron.
template <class T>
struct OrderedValues {
  Buffer<T> of_points;                // [np]
  Buffer<T> least, most;              // [blocks of tetrahedra]
  Buffer<T> least_about, most_about;  // [blocks of points] of their points and those to which edges run from them
};
using OrderedArray =
    std::variant<OrderedValues<std::int8_t>, OrderedValues<std::uint8_t>, OrderedValues<std::int16_t>,
                 OrderedValues<std::uint16_t>, OrderedValues<std::int32_t>, OrderedValues<std::uint32_t>,
                 OrderedValues<std::int64_t>, OrderedValues<std::uint64_t>, OrderedValues<float>, OrderedValues<double>>;

/// One look at each tetrahedron and edge. Null if a value is not finite: which cells are absent then depends on the array.
/// Throws cancelled.
std::shared_ptr<const OrderedArray> order_values(const OrderedTetrahedra& tetrahedra, const PointArray& array, const Task& task);
std::uint64_t bytes_of(const OrderedArray& array);

}  // namespace isostrata
