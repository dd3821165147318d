// What a picture shows of the facets of layers that have no mesh: most facets of a large grid lie between pixels' centres and are never kept.
#pragma once

#include <cstdint>
#include <span>

#include "extraction/bricks/layer_bricks.h"
#include "rendering/crossings/screen_transform.h"

namespace isostrata {

/// Positions, origins and facets, slab by slab: the facets of `drawn` intervals whose bounds on the screen hold a pixel's centre (all others
/// change no pixel), and those that are to be clipped. `summaries` are put into it. The same whatever the threads. Parallel. Throws too_large.
IntervalMesh seen_facets(const LayerBricks& bricks, std::span<const IntervalSummary> summaries, const ScreenTransform& transform,
                         std::span<const std::uint8_t> drawn);

}  // namespace isostrata
