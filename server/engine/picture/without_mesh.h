// Which scenes a renderer can draw without a mesh of their layers: pure functions of the scene.
#pragma once

#include <cstdint>
#include <string>

#include "scene/scene.h"

namespace isostrata {

/// Whether the intervals can be cut out of a grid of tetrahedra if they are drawn, and the picture is that of the split mesh:
/// one field at one step, colours that run along it or are constant (those where a surface is drawn, without textures), no overlaps, interiors unshaded.
/// `array` is the scene's.
bool cuts_exactly(const Scene& scene, const std::string& array);

/// Whether a renderer needs no mesh for the layers of a structured grid: constant colours of plain ranges at one step, by the table, without
/// textures and unshaded.
bool draws_from_bricks(const Scene& scene);
/// Whether a renderer that extracts() needs no mesh for layers of `array` on a grid of boxes: plain ranges at one step, by the table, whose colours or
/// opacities run with that array, without surfaces and textures, of few enough ends.
bool draws_where_extracted(const Scene& scene, const std::string& array);
inline constexpr std::int64_t kLeastExtractedThere = 100'000;  // tetrahedra; a smaller mesh is sent sooner
/// Of a field that is sent for the first picture; a larger one is sent when ends are moved.
inline constexpr std::uint64_t kMostSentAtOnce = std::uint64_t{256} << 20;
inline constexpr std::int64_t kLeastInBricks = 4'000'000;  // for one picture
/// For frame after frame: a frame from bricks takes some 2.7 times one from a mesh, whose 100 bytes a tetrahedron must then have room.
inline constexpr std::int64_t kLeastInBricksOfFrames = 64'000'000;

}  // namespace isostrata
