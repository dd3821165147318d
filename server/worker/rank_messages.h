// What the first rank of a parallel job tells the others, and what they answer. Every order goes to all ranks, in one sequence.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "base/error.h"
#include "data/grids/region_tree.h"
#include "data/parts/region.h"
#include "data/values/moments.h"
#include "engine/picture/scene_ranks.h"
#include "extraction/layers/extract_layers.h"
#include "extraction/mesh/interval_mesh.h"
#include "scene/scene.h"

namespace isostrata {

/// RankSettings.
struct RankSetup {
  std::string importer, sandbox;
  std::uint64_t max_bytes = 0;
  double import_timeout_s = 0;
  std::string renderer, device;
  int threads = 0;
  Region region;
};

/// What is extracted has this number from then on. Answered by RankReply.
struct RankExtract {
  std::uint64_t number = 0;
  std::uint64_t previous = 0;  // whose parts may be used again; 0: none
  std::string source, version;
  RegionTree regions;
  Scene scene;
  std::uint64_t max_bytes = 0;
  std::int64_t least_in_bricks = 0;  // as SceneAids, of one rank
};

/// DrawInput, without what each rank has of its own. All ranks composite; a rank that cannot answers RankReply.
struct RankDraw {
  std::uint64_t number = 0;  // of the extraction
  std::uint64_t picture = 0;
  Box3d bounds;
  std::vector<IntervalStyle> styles;
  RenderMode mode = RenderMode::sorted;
  Integral integral = Integral::exact;
  std::vector<ClipPlane> clip_planes;
  bool with_normals = false;
  double body_shading = 0;
  Camera camera;
  int width = 0, height = 0;
  PictureWindow window;
  double unit_distance = 0;
  bool with_depth = false, with_mean_depth = false;
};

/// Extracts and writes what the rank owns. Answered by RankReply.
struct RankWrite {
  std::uint64_t number = 0;
  std::string source, version;
  RegionTree regions;
  LayerRequest request;
  std::string path;  // of the .pvtu; empty: nothing is written
  int compression = 1;
};

/// Looks at the values that the rank owns. Answered by RankReply.
struct RankMeasure {
  std::uint64_t number = 0;
  std::string source, version;
  RegionTree regions;
  int step = 0;
  std::string array;            // empty: the ranges of all arrays
  double lower = 0, upper = 0;  // of the histogram, or the range of the whole
  int bins = 0;                 // of the histogram; 0: moments
};

struct RankCancel {
  std::uint64_t number = 0;
};
/// These extractions are not drawn any more.
struct RankForget {
  std::vector<std::uint64_t> numbers;
};
struct RankEnd {};

using RankOrder = std::variant<RankSetup, RankExtract, RankDraw, RankWrite, RankMeasure, RankCancel, RankForget, RankEnd>;

/// What RankMeasure asks for.
struct RankMeasured {
  struct Range {
    double lower = 0, upper = 0;  // lower > upper: no finite value
    std::int64_t nan_count = 0;
  };
  std::vector<Range> ranges;
  std::vector<std::uint64_t> counts;
  Moments moments;
};

struct RankReply {
  std::uint64_t number = 0;  // of the extraction or of the picture that it is about
  int rank = 0;
  bool beat = false;  // nothing but a sign that the extraction goes on
  bool failed = false;
  ErrorCode code = ErrorCode::internal;
  std::string message;
  RankedExtraction made;
  RankMeasured measured;
};

}  // namespace isostrata
