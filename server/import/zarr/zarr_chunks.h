// Reading values out of a Zarr array, one chunk after the other.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "import/zarr/zarr_array.h"
#include "import/zarr/zarr_store.h"

namespace isostrata {

/// Part of an array, as a grid of points with several arrays: which axis of the array is which of the box.
struct ZarrBox {
  static constexpr std::size_t kNone = ~std::size_t{0};
  std::array<std::size_t, 4> axes{kNone, kNone, kNone, kNone};  // x, y, z, channel; kNone: of one place
  std::array<std::int64_t, 4> size{1, 1, 1, 1};
  std::vector<std::int64_t> at;  // [axes of the array] the place on every other axis
};

struct ZarrCount {
  std::int64_t chunks = 0;
  std::int64_t missing = 0;  // they hold the fill value
};

/// Takes the next values of a channel, x running fastest, in the machine's byte order.
using AddValues = std::function<void(std::size_t channel, std::span<const std::byte> values)>;

/// Gives each channel's values to `add`, from its first to its last, a layer of chunks at a time. Takes the memory of such a layer, of as many channels as a chunk spans, and
/// of one chunk, unpacked and as it is stored. Throws what ZarrChunkPlaces::read and decode_chunk throw, and too_large above 10 million chunks and if far more would be filled
/// than the chunks that are there could unpack to.
ZarrCount read_zarr_box(ZarrStore& store, const ZarrArray& array, const ZarrBox& box, const AddValues& add, const std::function<void(double fraction)>& progress);

}  // namespace isostrata
