// How a tetrahedron falls apart at both ends of a range: the part inside and the parts outside, which tile it.
// Method: the tetrahedron's interval table (P. Bhaniramka, C. Zhang, D. Xue, R. Crawfis, R. Wenger, "Volume Interval Segmentation
// and Rendering", 2004, section 3) for the range itself, for what lies below it and for what lies above it, all three pulled in
// one order of points, so that the parts share whole facets with each other and with those of the next tetrahedron.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace isostrata {

/// Where a point of a mesh lies with regard to a range, as a set of bits. Just one of the first four is set: a range holds both
/// its ends, and a value that is not finite is absent, outside every range.
enum PointSide : std::uint8_t {
  kBelowRange = 1,
  kInRange = 2,
  kAboveRange = 4,
  kAbsentValue = 8,
  kPastLower = 16,   // in the range and not on its lower end
  kBeforeUpper = 32  // in the range and not on its upper end
};

PointSide side_of_range(double value, double lower, double upper);

/// Of the OR over a tetrahedron's points: whether an edge passes through an end between its points. Where none does, the whole
/// tetrahedron is inside (all_in_range) or has nothing inside but a part of its boundary.
inline bool is_cut(unsigned any) {
  const bool at_lower = (any & kBelowRange) && (any & (kAboveRange | kPastLower));
  const bool at_upper = (any & kAboveRange) && (any & (kBelowRange | kBeforeUpper));
  return at_lower || at_upper;
}
inline bool all_in_range(unsigned any) { return !(any & (kBelowRange | kAboveRange | kAbsentValue)); }

/// A point of a cut tetrahedron: its vertex v (0..3), or where edge e crosses the lower (4 + e) or the upper (10 + e) end.
using CutPoint = std::uint8_t;
inline constexpr std::array<std::array<std::uint8_t, 2>, 6> kCutEdges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
inline constexpr CutPoint kFirstLowerCut = 4, kFirstUpperCut = 10;
inline constexpr int kCutPoints = 16;

/// Bit k: the point lies in the facet opposite vertex k.
std::uint8_t cut_point_facets(CutPoint point);

struct CutPiece {
  std::array<CutPoint, 4> points{};  // oriented as the tetrahedron is
  bool inside = false;               // of the range
};

/// The pieces of a tetrahedron whose vertices are in the order of their numbers in the mesh. Where a vertex lies on an end,
/// crossings of its edges with that end are the vertex itself: the pieces name it, and those that have no extent then are left
/// out. A vertex without value makes the whole tetrahedron outside; it is divided as its neighbours divide the facets that have
/// values, so that it still conforms. Valid for ever. Any thread.
std::span<const CutPiece> cut_pieces(std::array<PointSide, 4> sides);

}  // namespace isostrata
