// Scene in, picture out: dataset, extraction, style, renderer, in this order, each reused where nothing that it depends on
// changed.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "base/known_later.h"
#include "base/task.h"
#include "data/coarse_error.h"
#include "data/dataset.h"
#include "engine/messages/messages.h"
#include "engine/picture/base_meshes.h"
#include "extraction/layers/extract_layers.h"
#include "extraction/mesh/interval_mesh.h"
#include "rendering/annotations/annotations.h"
#include "rendering/picture/renderer.h"
#include "scene/scene.h"

namespace isostrata {

/// What the scene asks of extraction: its intervals, visible or not, with the terms, the time and the triangulation; the array
/// that colours run over where an interval or a term has a colour map or an opacity that runs, then the array of the textures
/// where a surface has one and it is another; facets where a surface is drawn or all colours are constant (drawing needs them,
/// and extraction finds them for next to nothing). Arrays that the scene leaves open are empty here too. Of a smear: what is
/// asked of its first step or time.
LayerRequest layer_request(const Scene& scene);

/// Whether any boundary surface of the scene's intervals or terms is drawn.
bool draws_surfaces(const Scene& scene);

/// Whether its surfaces may be lit along the field's gradient, which takes a pass over the mesh: true wherever lit_along_gradient is of what is drawn.
bool lights_along_gradient(const Scene& scene);

/// What one part of a smear shows: a step, or a time.
struct SmearMoment {
  int step = 0;
  std::optional<double> time;

  bool operator==(const SmearMoment&) const = default;
};
/// Of SceneMode::smear; empty in any other mode.
std::vector<SmearMoment> smear_moments(const Scene& scene);

/// Whether the extraction made for one scene serves the other: same dataset, layer_request and moments of a smear, and lit alike.
bool same_extraction(const Scene& a, const Scene& b);

/// How many pictures a cycle has: intervals, and terms that bring something in, that are not hidden.
std::size_t cycle_length(const Scene& scene);

/// One step or time in the mesh of a smear.
struct SmearPart {
  SmearMoment moment;
  std::size_t first_summary = 0;  // of the mesh's
};

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
  std::uint64_t max_bytes = 16ull << 30;            // throws too_large, with the numbers, where the scene would need more
};

/// A mesh and what it was made from. Immutable, shared between threads.
struct ExtractedScene {
  LayerRequest request;                               // without what it carries; the array's name as it was found
  std::vector<std::shared_ptr<const Dataset>> steps;  // that were opened for it
  std::shared_ptr<const Dataset> dataset;             // whose grid the mesh lies in, see Layers
  LayerTime time;
  std::shared_ptr<KeptSpaceTime> kept;  // for the next slice; null but in space-time mode
  std::string array, color_by;          // the arrays' names, as they were found
  std::shared_ptr<const IntervalMesh> mesh;
  std::shared_ptr<const std::vector<float>> color_values;    // null where there is no colour map and no opacity that runs
  double color_lower = 0, color_upper = 1;                   // range of the color-by array in the first of `steps`
  std::string texture;                                       // the array's name, as it was found
  std::shared_ptr<const std::vector<float>> texture_values;  // null where no surface has a texture
  double texture_lower = 0, texture_upper = 1;               // its range in the first of `steps`
  std::shared_ptr<const std::vector<Vec3f>> normals;         // null where none are known
  bool normals_wanted = false;                               // whether they were looked for
  Box3d bounds;                                              // of the grids
  bool same_grid = true;                                     // of all parts: the one that a visibility order may be taken from
  std::vector<SmearPart> parts;                              // of a smear, one a moment, in their order
  // Not null: nothing was extracted; mesh and color_values are its, and draw_input has the intervals cut by the renderer.
  std::shared_ptr<const BaseTetrahedra> base;
  std::vector<IntervalSummary> cut_summaries;  // of those intervals
  std::shared_ptr<const LayerBricks> bricks;   // not null: the mesh has summaries and no points, and the renderer draws these
  // Not empty: the mesh is one rank's part (scene_ranks.h), and these are of the whole.
  std::vector<IntervalSummary> whole_summaries;
  int point_stride = 1;   // more: of every n-th point of the grid, for a first look (coarse_scene.h)
  std::shared_ptr<const KnownLater<CoarseError>> coarse_error;  // of `array` at those points; null: nobody will find it
  double extract_ms = 0;  // 0 where `previous` was reused

  /// Of the request's intervals and of the terms that bring something in; of a smear, of each step.
  const std::vector<IntervalSummary>& summaries() const {
    return base ? cut_summaries : !whole_summaries.empty() ? whole_summaries : mesh->summaries;
  }
};

/// Whether the intervals can be cut out of a grid of tetrahedra where they are drawn, and the picture is that of the split mesh:
/// one field at one step, colours that run along it or are constant (those where a surface is drawn, without textures), no overlaps.
/// `array` is the scene's.
bool cuts_exactly(const Scene& scene, const std::string& array);

/// Whether a renderer needs no mesh for the layers of a structured grid: constant colours of plain ranges at one step, by the table, without
/// textures.
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

/// What it takes in memory beside its datasets, and what a renderer makes of it.
std::uint64_t scene_bytes(const ExtractedScene& extracted);

/// The tetrahedra and cells of each of the scene's intervals; of a smear, added over its steps.
std::vector<IntervalSummary> interval_summaries(const ExtractedScene& extracted, const Scene& scene);

/// The same by the intervals' ids, as clients know them; those of a transfer function are one. With `errors` how far the volumes
/// are from those of the interpolated field, where that is defined: a mesh of plain ranges of one array. That takes a fraction of a
/// second on one thread. Throws cancelled.
std::vector<IntervalFacts> interval_facts(const ExtractedScene& extracted, const Scene& scene, bool errors, const Task& task);

/// Extracts what layer_request says; `previous` is reused as far as that and the dataset are the same, and its mesh also where
/// only colours are wanted that can be carried to it. A scene without intervals gives an empty mesh. Scene::array empty: the
/// dataset's first. A smear is extracted step by step and joined; before the second step its memory is foreseen from the first
/// one's (too_large). Where the aids say so, a grid of tetrahedra is not extracted at all: see ExtractedScene::base. Throws
/// not_found (no such array) and what extract_layers throws. Any thread.
std::shared_ptr<const ExtractedScene> extract_scene(const StepSource& source, const Scene& scene,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task,
                                                    const SceneAids& aids = {});

/// The same for one step that is at hand. Throws not_found where the scene's time needs another one.
std::shared_ptr<const ExtractedScene> extract_scene(std::shared_ptr<const Dataset> dataset, const Scene& scene,
                                                    const std::shared_ptr<const ExtractedScene>& previous, const Task& task);

/// What the renderer needs for the scene at this size. `extracted` must belong to the scene's ends, terms and arrays.
DrawInput draw_input(const ExtractedScene& extracted, const Scene& scene, int width, int height);

/// What the scene wants beside that picture. `input` is of draw_input for the same scene.
AnnotationInput annotation_input(const ExtractedScene& extracted, const Scene& scene, const DrawInput& input);

}  // namespace isostrata
