// Pictures that are more than one frame of a renderer: supersampled, larger than memory, with axes and legends.
#pragma once

#include <functional>
#include <variant>

#include "base/task.h"
#include "rendering/annotations/canvas.h"
#include "rendering/picture/renderer.h"
#include "scene/depth_light.h"

namespace isostrata {

inline constexpr int kMaxSamples = 16;  // each way
// A part is drawn as floats with both depths (24 bytes a sample), which the renderer may hold twice, and is averaged into a band.
inline constexpr std::int64_t kPartSamples = std::int64_t{14} << 20;

using AnyImage = std::variant<Image, FloatImage>;

struct Still {
  DrawInput input;      // of the finished picture's size; its window is not looked at
  Drawing annotations;  // of the same size
  int samples = 1;      // each way: a pixel is the mean of samples x samples rays, their depth the nearest
  std::int64_t part_samples = kPartSamples;  // that are drawn at once, at most
  DepthLight light = {};                     // of the finished picture's pixels, under the annotations
};

/// Takes finished rows from the top, of Image, or of FloatImage where input.float_image.
using StillRows = std::function<void(const AnyImage& rows)>;

/// The picture goes to `put` band by band; beside the mesh there are at most about 60 bytes for each of part_samples in memory. A picture of one sample
/// and no annotations that is small enough is one plain frame. Times in the facts are sums over all bands; tetrahedra are those
/// of the picture. Of a lit one rows wait for those below, at most a tenth of its height in all. Throws what the renderer throws,
/// invalid_argument for `samples` and light, and cancelled between bands.
DrawFacts draw_still(Renderer& renderer, const Still& still, const Task& task, const StillRows& put);
/// The facts of a picture whose parts are drawn one after another: times and fragments are sums.
void add_part(DrawFacts& sum, const DrawFacts& part);
inline constexpr std::size_t kStillBytes = std::size_t{1} << 30;

/// How a frame must be asked for so that annotations can be painted under it too: floats where every bit counts (frames at
/// rest), else transparent bytes, which devices hand over faster.
void ask_for_annotated(DrawInput& input, bool exact);

/// What such a frame becomes: painted, over the background unless `transparent`.
Image finish_annotated(AnyImage drawn, const Drawing& annotations, const Rgb& background, bool transparent);

}  // namespace isostrata
