// What is shown of a dataset when nobody has chosen anything: new sessions of a server, and so the page and scripts, `isostrata render`
// and the gallery ask here, so that they show the same, to the last bit.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/task.h"
#include "data/dataset/dataset.h"
#include "engine/first/choose_camera.h"
#include "extraction/mesh/interval_mesh.h"
#include "scene/axis_scale.h"
#include "scene/camera.h"
#include "scene/field_values.h"
#include "scene/style.h"

namespace isostrata {

struct FirstLayer {
  double lower = 0, upper = 1;
  Rgb color{1, 1, 1};
  double opacity = 0.5;  // of a layer one unit distance thick
  SurfaceStyle surface;
  std::string name;  // only where the data say what it is: "skin"; else empty
  std::string reason;

  Interval interval() const { return {lower, upper}; }
  bool operator==(const FirstLayer&) const = default;
};

/// Plain data that can cross a process boundary.
struct FirstView {
  std::string array;  // empty: nothing to show, and array_reason says why
  std::string array_reason;
  FieldValues values = FieldValues::interpolated;  // whole: of an array of labels
  int step = 0;
  std::string step_reason;
  std::string kind;  // of field: to_string(FieldKind)
  std::string kind_reason;
  double lower = 0, upper = 0;     // of the array, over the steps that were looked at: the ends of what reaches to an end
  std::vector<FirstLayer> layers;  // by their lower ends
  std::string light_reason;
  Vec3d direction{0, 0, 1}, up{0, 1, 0};
  std::vector<Vec3d> outline;  // [at most 1024] world: what the camera sees all of
  Vec3d axis_scale = kUnscaled;  // Scene::axis_scale
  std::string scale_reason;      // empty: none is scaled
  std::string up_reason, camera_reason;

  /// For a picture `aspect` times as wide as high.
  Camera camera(double aspect) const;
  bool operator==(const FirstView&) const = default;
};

/// Opens a step. It may be asked for the same one several times.
using FirstViewSteps = std::function<std::shared_ptr<const Dataset>(int step, const Task& task)>;

/// Chosen from the wishes and the dataset alone: the same for any order of cells and any number of threads.
struct FirstViewWishes {
  std::string array;  // empty: the best
  int step = -1;      // -1: the best
};

/// `first` is a step of the dataset, whichever. Of a series five steps are looked at, of one whose steps take more than
/// kFirstViewBytes the middle one alone. Without wishes it is kept beside the import of `first`, if that is cached, and not made again
/// (kept_first_view.h). About 20 ms for 256^3 points, 50 ms a million cells of other grids, on one core. Throws
/// not_found (no such array), cancelled, and what `steps` throws.
FirstView first_view(const Dataset& first, const FirstViewSteps& steps, const FirstViewWishes& wishes, const Task& task);
inline constexpr std::uint64_t kFirstViewBytes = 64ull << 20;

/// Of one step, as it is.
FirstView first_view(const Dataset& dataset, const FirstViewWishes& wishes, const Task& task);

}  // namespace isostrata
