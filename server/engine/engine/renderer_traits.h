// What a renderer draws that is not a mesh, and so what need not be extracted for it.
#pragma once

#include "engine/picture/extraction_plan.h"
#include "engine/picture/without_mesh.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

struct RendererTraits {
  bool cuts_intervals = false, draws_bricks = false, extracts = false;  // as Renderer has them
};

inline RendererTraits traits_of(const Renderer& renderer) { return {renderer.cuts_intervals(), renderer.draws_bricks(), renderer.extracts()}; }

/// What extraction for frame after frame may leave to such a renderer.
inline void leave_to(const RendererTraits& renderer, SceneAids& aids) {
  aids.tetrahedra = renderer.cuts_intervals ? TetrahedraWay::automatic : TetrahedraWay::split;
  if (renderer.draws_bricks) aids.least_in_bricks = kLeastInBricksOfFrames;
  aids.facets_alone = renderer.draws_bricks;
  aids.extracts_there = renderer.extracts;
}

/// Whether such a renderer can draw what was extracted for another one.
inline bool can_draw(const RendererTraits& renderer, const ExtractedScene& extracted, const Scene& scene) {
  if (extracted.base && !renderer.cuts_intervals) return false;
  if (!extracted.request.tetrahedra && !renderer.draws_bricks) return false;
  return !extracted.bricks || (renderer.draws_bricks && draws_from_bricks(scene));
}

}  // namespace isostrata
