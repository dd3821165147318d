// How many fragments a renderer of tetrahedra would blend.
#pragma once

#include <cstdint>
#include <span>

#include "extraction/mesh/interval_mesh.h"
#include "rendering/crossings/screen_transform.h"

namespace isostrata {

/// Pixels of the picture that the tetrahedra of the drawn intervals cover, each for itself: half of what their facets cover.
/// Those that are cut by the near depth or the guard are left out. A pass of its own, as slow as drawing each tetrahedron.
/// Parallel.
std::int64_t count_fragments(const IntervalMesh& mesh, std::span<const ScreenVertex> vertices, const ScreenTransform& transform,
                             std::span<const std::uint8_t> drawn);

}  // namespace isostrata
