// What is to be extracted for a scene, and what of the last extraction serves it: pure decisions.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/task.h"
#include "engine/picture/base_meshes.h"
#include "engine/picture/extracted_scene.h"
#include "engine/picture/layer_request.h"
#include "extraction/layers/extract_layers.h"
#include "scene/scene.h"

namespace isostrata {

/// How grids of nothing but tetrahedra are drawn.
enum class TetrahedraWay {
  automatic,  // cut where only ends of intervals were moved and the base mesh is at hand, split else
  split,      // as any grid: extraction splits tetrahedra
  cut         // where cuts_exactly(), the intervals are cut in the rays and no mesh is extracted; split else
};

/// What makes an extraction cheaper or spares it.
struct SceneAids : LayerAids {
  TetrahedraWay tetrahedra = TetrahedraWay::split;  // another one only where the renderer cuts_intervals()
  BaseMeshes* bases = nullptr;                      // null: split
  // Layers on a structured grid that would have this many tetrahedra are drawn from their bricks (ExtractedScene::bricks) where the scene draws
  // draws_from_bricks(); needs `bricks`, and a renderer that draws_bricks(). A smaller mesh is drawn sooner the second time.
  std::int64_t least_in_bricks = std::numeric_limits<std::int64_t>::max();
  // Layers on grids of boxes whose colours run with their own array are left to the renderer as bricks, too (draws_where_extracted()); needs `bricks`,
  // and a renderer that extracts().
  bool extracts_there = false;
  bool facets_alone = false;  // constant colours of structured grids get no tetrahedra: the renderer draws them by facets
  std::uint64_t max_bytes = 16ull << 30;            // throws too_large, with the numbers, if the scene would need more
};

/// What a scene asks for, with the names of its arrays.
struct ExtractionPlan {
  LayerRequest layers;               // without what they carry; array: as it is named in the dataset
  std::vector<std::string> carry;    // arrays for colours and textures, as in LayerRequest
  std::vector<SmearMoment> moments;  // of a smear; else none
  ArrayNames names;
  bool colored = false, textured = false;  // values of these arrays are wanted
  bool lit = false;                        // surfaces, along the field's gradient
  bool shaded = false;                     // interiors, along the same
  bool cuts = false;                       // a renderer can cut the intervals out of a grid of tetrahedra, and may
  // From how many tetrahedra on the layers are left to the renderer as bricks, on a grid of boxes and on any structured grid; nothing: never.
  std::optional<std::int64_t> least_of_boxes, least_of_any;
};
/// array: the scene's, or what stands for it. Of the aids it looks only at what they allow, not at what they hold.
ExtractionPlan plan_extraction(const Scene& scene, const std::string& array, const SceneAids& aids);

/// From how many tetrahedra on layers on this grid are left to the renderer as bricks; nothing: never.
std::optional<std::int64_t> least_in_bricks(const ExtractionPlan& plan, const Grid& grid);

/// What of the last extraction serves the next one.
enum class Reuse {
  nothing,    // its layers are other ones
  as_mesh,    // its layers are the same, and a mesh, to which the arrays cannot be brought: a mesh is extracted anew
  mesh,       // its mesh, to which those arrays are brought that it does not have
  everything  // as it is
};
/// last: may be null. steps: gives the very dataset that it gave for `last` as long as that is what would be extracted from; it is asked only if
/// everything else is the same. Throws what it throws.
Reuse reuse_of(const ExtractedScene* last, const ExtractionPlan& plan, const StepSource& steps, const Task& task);

/// Whether only the ends of the intervals were moved since `last`, as in a drag. last: may be null.
bool ends_moved(const ExtractedScene* last, const ExtractionPlan& plan);

/// The values for colours that `last` has; null if they are of another array.
std::shared_ptr<const std::vector<float>> kept_colors(const ExtractedScene& last, const ExtractionPlan& plan);
std::shared_ptr<const std::vector<float>> kept_texture(const ExtractedScene& last, const ExtractionPlan& plan);

}  // namespace isostrata
