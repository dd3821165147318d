#include "rendering/tiles/tile_sink.h"

#include <algorithm>

#include "rendering/picture/blank_picture.h"
#include "rendering/tiles/resolve_simd.h"

namespace isostrata {

TileSink::TileSink(const DrawInput& input)
    : background_(input.background),
      transparent_(input.transparent),
      wants_depth_(input.float_image && !input.rounded),
      wants_mean_depth_(input.float_image && input.mean_depth),
      rounded_(!input.float_image || input.rounded),
      image_(blank_picture(input)) {}

void TileSink::put(const FinishedTile& tile) {
  for (int row = 0; row < tile.height; ++row) {
    const std::size_t from = static_cast<std::size_t>(row) * tile.stride;
    if (auto* floats = std::get_if<FloatImage>(&image_)) {
      const std::size_t to =
          static_cast<std::size_t>(tile.y + row) * static_cast<std::size_t>(floats->width) + static_cast<std::size_t>(tile.x);
      for (std::size_t x = 0; x < static_cast<std::size_t>(tile.width); ++x) {
        for (std::size_t c = 0; c < 4; ++c) floats->rgba[4 * (to + x) + c] = tile.rgba[c][from + x];
      }
      if (tile.depth) std::copy_n(tile.depth + from, tile.width, &floats->depth[to]);
      if (tile.mean_depth) std::copy_n(tile.mean_depth + from, tile.width, &floats->mean_depth[to]);
      continue;
    }
    Image& bytes = std::get<Image>(image_);
    const std::size_t to =
        static_cast<std::size_t>(tile.y + row) * static_cast<std::size_t>(bytes.width) + static_cast<std::size_t>(tile.x);
    resolve_row({{tile.rgba[0] + from, tile.rgba[1] + from, tile.rgba[2] + from, tile.rgba[3] + from},
                 static_cast<std::size_t>(tile.width),
                 background_,
                 transparent_,
                 &bytes.rgba[4 * to]});
  }
}

}  // namespace isostrata
