// The closed surfaces of a mesh's intervals, in small bundles that are near one another: what the crossings renderer draws.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/buffer.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Whose facet it is: the interval, and 1 << its label below it, as vectors look it up.
using FacetPart = std::int32_t;
inline constexpr int kFacetLabelBits = 3;
constexpr FacetPart facet_part(std::uint16_t interval, FacetLabel label) {
  return FacetPart{interval} << kFacetLabelBits | 1 << static_cast<int>(label);
}
constexpr std::uint16_t interval_of(FacetPart part) { return static_cast<std::uint16_t>(part >> kFacetLabelBits); }

struct FacetChunk {
  std::uint32_t first = 0, end = 0;  // of FacetSet::points
  std::uint16_t interval = 0;
  Box3d bounds;
};

/// Facets by interval, within an interval in the order of the mesh.
struct FacetSet {
  // Counter-clockwise seen from outside the interval, the smallest first: facets on the same points then have the same depths to
  // the last bit.
  Buffer<std::array<std::uint32_t, 3>> points;
  Buffer<FacetPart> parts;  // as points; labels are meaningless where the mesh has no facets
  std::vector<FacetChunk> chunks;
  std::vector<std::uint32_t> first_chunk;  // [intervals + 1]
  Box3d bounds;                            // of all facets
};

/// From mesh.facets, or, if it has none, from the tetrahedra. An interval whose facets enclose a negative volume (a mesh of
/// mirrored cells) is turned inside out, unless they are a part of its facets only, which are right as they are. Parallel.
enum class FacetsAre { whole, part };
FacetSet make_facet_set(const IntervalMesh& mesh, FacetsAre are = FacetsAre::whole);

/// Of unit length, or nothing if the facet has no area.
inline Vec3f facet_normal(const std::array<std::uint32_t, 3>& points, const IntervalMesh& mesh) {
  const Vec3d a = mesh.positions[points[0]], b = mesh.positions[points[1]], c = mesh.positions[points[2]];
  const Vec3d across = cross(b - a, c - a);
  const double size2 = dot(across, across), inverse = size2 > 0 ? 1 / std::sqrt(size2) : 0;
  return {static_cast<float>(across.x * inverse), static_cast<float>(across.y * inverse), static_cast<float>(across.z * inverse)};
}
/// [facets]. Parallel.
void facet_normals(const FacetSet& set, const IntervalMesh& mesh, Buffer<Vec3f>& normals);

}  // namespace isostrata
