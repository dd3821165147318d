// The order of the few tetrahedra inside one convex cell.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Orders small sets of tetrahedra with disjoint interiors by separating planes. Keeps its scratch memory; one per thread.
class CellOrder {
 public:
  /// one_color[interval] != 0: the interval has one colour and one opacity everywhere, so that its tetrahedra commute with each
  /// other and only pairs of different intervals are ordered.
  explicit CellOrder(std::span<const std::uint8_t> one_color) : one_color_(one_color) {}

  /// Permutes `tetrahedra` (indices into mesh.tetrahedra) back to front as seen from the eye. Returns how many pairs could not be
  /// ordered exactly: their interiors meet (inverted tetrahedra), or they hide each other in a cycle. 0 means the order is exact.
  /// O(n^2).
  int sort(const IntervalMesh& mesh, Vec3d eye, std::span<std::uint32_t> tetrahedra);

 private:
  enum class Relation { none, a_behind, b_behind, unknown };
  struct Plane {
    Vec3d normal;   // unit length, outwards
    double offset;  // dot(normal, x) <= offset inside
    double eye;     // the eye's distance from it
  };
  struct Item {
    std::uint32_t id;
    std::array<std::uint32_t, 4> points;
    std::uint16_t interval;
    bool flat;  // of no volume: hides nothing
    // Of the picture on a plane through the middle of the cell, and of the depth behind that plane; only where in_front_.
    double lower[3], upper[3];
    Vec3d p[4];  // seen from the middle of the cell
    Plane plane[4];
  };

  void prepare(const IntervalMesh& mesh, Vec3d eye, std::span<const std::uint32_t> tetrahedra);
  Relation relate(const Item& a, const Item& b) const;
  Relation relate_neighbors(const Item& a, const Item& b) const;
  Relation relate_by_edges(const Item& a, const Item& b) const;
  bool silhouettes_meet(const Item& a, const Item& b) const;
  int emit(std::span<std::uint32_t> tetrahedra);

  std::span<const std::uint8_t> one_color_;
  std::vector<Item> items_;                                    // far ones first
  std::vector<std::pair<double, std::uint32_t>> by_distance_;  // minus the squared distance of the centroid, id
  std::vector<std::uint64_t> behind_;                          // [items][words] bit j of row i: j must be drawn before i
  std::vector<std::uint64_t> left_;                            // [words] not drawn yet
  std::size_t words_ = 0;
  Vec3d eye_;              // seen from the middle of the cell
  double tolerance_ = 0;   // lengths below it do not count
  bool in_front_ = false;  // the whole cell is in front of the eye, so that it has a projection
};

}  // namespace isostrata
