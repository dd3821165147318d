#include "engine/picture/draw_still.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>

#include "base/parallel.h"
#include "engine/picture/draw_lit.h"
#include "rendering/light/light_rows.h"
#include "rendering/picture/check_draw_input.h"
#include "rendering/tiles/resolve_simd.h"

namespace isostrata {
namespace {

static_assert(kPartSamples * 24 * 3 <= static_cast<std::int64_t>(kStillBytes));

/// The mean of samples x samples pixels of `part` each, put into `band` from column x on.
void average(const FloatImage& part, int samples, int x, FloatImage& band) {
  const int columns = part.width / samples, rows = part.height / samples;
  const float weight = 1.0f / static_cast<float>(samples * samples);
  const bool depth = !part.depth.empty() && !band.depth.empty(), mean_depth = !part.mean_depth.empty();
  parallel_for(rows, 4, [&](std::int64_t begin, std::int64_t end) {
    for (auto row = static_cast<int>(begin); row < static_cast<int>(end); ++row)
      for (int column = 0; column < columns; ++column) {
        std::array<float, 4> sum{};
        float nearest = std::numeric_limits<float>::infinity(), depth_sum = 0;
        for (int j = 0; j < samples; ++j) {
          const std::size_t from = static_cast<std::size_t>(row * samples + j) * static_cast<std::size_t>(part.width) +
                                   static_cast<std::size_t>(column * samples);
          for (std::size_t i = from; i < from + static_cast<std::size_t>(samples); ++i) {
            for (std::size_t c = 0; c < 4; ++c) sum[c] += part.rgba[4 * i + c];
            if (depth) nearest = std::min(nearest, part.depth[i]);
            if (mean_depth) depth_sum += part.mean_depth[i];
          }
        }
        const std::size_t to =
            static_cast<std::size_t>(row) * static_cast<std::size_t>(band.width) + static_cast<std::size_t>(x + column);
        for (std::size_t c = 0; c < 4; ++c) band.rgba[4 * to + c] = sum[c] * weight;
        if (depth) band.depth[to] = nearest;
        if (mean_depth) band.mean_depth[to] = depth_sum * weight;
      }
  });
}

AnyImage finished(FloatImage&& band, const DrawInput& input) {
  if (input.float_image) return std::move(band);
  return resolved(band, input.background, input.transparent);
}

}  // namespace

void add_part(DrawFacts& sum, const DrawFacts& part) {
  const double order_ms = sum.order_ms + part.order_ms, draw_ms = sum.draw_ms + part.draw_ms,
               readback_ms = sum.readback_ms + part.readback_ms;
  const std::int64_t fragments = sum.fragments + part.fragments, tetrahedra = std::max(sum.tetrahedra, part.tetrahedra);
  sum = part;
  sum.order_ms = order_ms;
  sum.draw_ms = draw_ms;
  sum.readback_ms = readback_ms;
  sum.fragments = fragments;
  sum.tetrahedra = tetrahedra;
}

DrawFacts draw_still(Renderer& renderer, const Still& still, const Task& task, const StillRows& put) {
  const DrawInput& input = still.input;
  const int samples = still.samples;
  if (samples < 1 || samples > kMaxSamples)
    throw Error(ErrorCode::invalid_argument,
                "samples: " + std::to_string(samples) + ", expected 1 to " + std::to_string(kMaxSamples) + " each way");
  DrawInput part = input;
  part.window = {};
  check(part);
  if (std::max(input.width, input.height) * samples > kMaxWholeSize)
    throw Error(ErrorCode::too_large, "picture of " + std::to_string(input.width) + "x" + std::to_string(input.height) +
                                          " with " + std::to_string(samples) + " samples each way: expected at most " +
                                          std::to_string(kMaxWholeSize) + " samples across");
  const std::int64_t row_samples = static_cast<std::int64_t>(input.width) * samples * samples;
  const bool lit = still.light.any();
  bool plain = samples == 1 && still.annotations.empty();
  if (plain && row_samples * input.height <= still.part_samples) {
    task.check();
    DrawResult result = draw_lit(renderer, part, still.light);
    put(result.image);
    return result.facts;
  }
  plain = plain && !lit;

  // Whole rows, as many as may be; a row that is too wide or too large is drawn in pieces.
  const int rows_per_band =
      static_cast<int>(std::clamp<std::int64_t>(still.part_samples / row_samples, 1, std::min(input.height, kMaxImageSize / samples)));
  const int columns_per_part = std::min(input.width, kMaxImageSize / samples);
  part.float_image = input.float_image || !plain;
  part.mean_depth = lit;
  std::optional<LightRows> light;
  if (lit) light.emplace(still.light, input);
  part.window.width = input.width * samples;
  part.window.height = input.height * samples;
  DrawFacts facts;
  int finished_rows = 0;
  for (int y = 0; y < input.height; y += rows_per_band) {
    const int rows = std::min(rows_per_band, input.height - y);
    FloatImage band;
    for (int x = 0; x < input.width; x += columns_per_part) {
      task.check();
      task.report(static_cast<double>(y) / input.height + static_cast<double>(x) / input.width * rows / input.height, "drawing");
      const int columns = std::min(columns_per_part, input.width - x);
      part.window.x = x * samples;
      part.window.y = y * samples;
      part.width = columns * samples;
      part.height = rows * samples;
      DrawResult result = renderer.draw(part);
      add_part(facts, result.facts);
      if (plain) {  // columns is the whole width
        put(result.image);
        continue;
      }
      FloatImage& floats = std::get<FloatImage>(result.image);
      if (samples == 1 && columns == input.width) {
        band = std::move(floats);
        continue;
      }
      if (x == 0) {
        const std::size_t pixels = static_cast<std::size_t>(input.width) * static_cast<std::size_t>(rows);
        band = {input.width, rows, std::vector<float>(4 * pixels), {}};
        if (input.float_image) band.depth.resize(pixels);
        if (lit) band.mean_depth.resize(pixels);
      }
      average(floats, samples, x, band);
    }
    if (plain) continue;
    if (light) band = light->add(std::move(band));
    if (band.height == 0) continue;
    paint(still.annotations, band, finished_rows);
    finished_rows += band.height;
    put(finished(std::move(band), input));
  }
  task.report(1, "drawing");
  return facts;
}

void ask_for_annotated(DrawInput& input, bool exact) {
  input.float_image = exact;
  input.transparent = true;
}

Image finish_annotated(AnyImage drawn, const Drawing& annotations, const Rgb& background, bool transparent) {
  FloatImage picture;
  if (auto* floats = std::get_if<FloatImage>(&drawn)) {
    picture = std::move(*floats);
  } else {
    const Image& bytes = std::get<Image>(drawn);
    picture = {bytes.width, bytes.height, std::vector<float>(bytes.rgba.size()), {}};
    parallel_for(static_cast<std::int64_t>(bytes.rgba.size() / 4), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
      for (auto i = static_cast<std::size_t>(4 * begin); i < static_cast<std::size_t>(4 * end); i += 4) {
        const float alpha = static_cast<float>(bytes.rgba[i + 3]) / 255;
        for (std::size_t c = 0; c < 3; ++c) picture.rgba[i + c] = static_cast<float>(bytes.rgba[i + c]) / 255 * alpha;
        picture.rgba[i + 3] = alpha;
      }
    });
  }
  paint(annotations, picture);
  return resolved(picture, background, transparent);
}

}  // namespace isostrata
