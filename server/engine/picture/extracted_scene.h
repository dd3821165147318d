// What has been extracted for a scene: a mesh, or what a renderer draws in place of one.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/known_later.h"
#include "data/dataset/dataset.h"
#include "data/derived/coarse_error.h"
#include "engine/picture/layer_request.h"
#include "extraction/bricks/layer_bricks.h"
#include "extraction/layers/extract_layers.h"
#include "extraction/mesh/interval_mesh.h"
#include "extraction/surfaces/base_tetrahedra.h"

namespace isostrata {

/// One step or time in the mesh of a smear.
struct SmearPart {
  SmearMoment moment;
  std::size_t first_summary = 0;  // of the mesh's
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
  std::shared_ptr<const std::vector<float>> color_values;    // null if there is no colour map and no opacity that runs
  double color_lower = 0, color_upper = 1;                   // range of the color-by array in the first of `steps`
  std::string texture;                                       // the array's name, as it was found
  std::shared_ptr<const std::vector<float>> texture_values;  // null if no surface has a texture
  double texture_lower = 0, texture_upper = 1;               // its range in the first of `steps`
  std::shared_ptr<const std::vector<Vec3f>> normals;         // null if none are known
  bool normals_wanted = false;                               // whether they were looked for
  std::shared_ptr<const std::vector<Vec3f>> body_normals;    // along the gradient of `array` at each point; null if none are known or wanted
  bool body_normals_wanted = false;
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
  double extract_ms = 0;  // 0 if `previous` was reused

  /// Of the request's intervals and of the terms that bring something in; of a smear, of each step.
  const std::vector<IntervalSummary>& summaries() const {
    return base ? cut_summaries : !whole_summaries.empty() ? whole_summaries : mesh->summaries;
  }
};

/// Of all its intervals.
std::int64_t tetrahedra_of(const ExtractedScene& extracted);

/// What it takes in memory beside its datasets, and what a renderer makes of it.
std::uint64_t scene_bytes(const ExtractedScene& extracted);

/// The range of an array as `values` are drawn: of whole cells theirs, which points' means do not reach. lower and upper stay if there is none.
void set_range(const PointArray& array, FieldValues values, double& lower, double& upper);

}  // namespace isostrata
