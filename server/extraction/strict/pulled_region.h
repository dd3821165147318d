// Other triangulations of a region with the same boundary, from a single point.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "base/vec.h"

namespace isostrata {

using TetrahedronPoints = std::array<std::uint32_t, 4>;  // positive

struct PulledRegion {
  std::vector<TetrahedronPoints> tetrahedra;
  std::vector<Vec3d> inner;  // new points: number first_inner + i
};

/// Tetrahedra with the same boundary as the given ones, facet by facet, and without one that is turned (volume < -tolerance).
/// Each connected part that has one is triangulated anew: one of its points is joined to all boundary facets that it is not in,
/// of the points that see them all the one with the fewest flat tetrahedra, then the fewest tetrahedra; and where none does, a
/// point inside the part that sees all (kernel_point.h). Empty if a part has no such point either. positions: of all points
/// that the tetrahedra name. faces: of each of these points the cell faces that it lies in, a bit each; no tetrahedron is laid
/// into a face, where its facets would meet the neighbour's. Any thread.
std::optional<PulledRegion> pull_region(std::span<const TetrahedronPoints> tetrahedra, const Vec3d* positions,
                                        const std::map<std::uint32_t, unsigned>& faces, double tolerance,
                                        std::uint32_t first_inner);

}  // namespace isostrata
