// What the axes of a Zarr array mean: OME-Zarr's "multiscales", or the names of the axes alone.
//
// "Next-generation file formats (NGFF)", 0.1 to 0.5, ngff.openmicroscopy.org.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "import/zarr/zarr_array.h"
#include "import/zarr/zarr_store.h"

namespace isostrata {

enum class ZarrRole : std::uint8_t { time, channel, space, other };

struct ZarrAxis {
  std::string name;
  ZarrRole role = ZarrRole::space;
  std::string unit;
  double scale = 1, translation = 0;  // place = translation + scale * index
};

struct ZarrImage {
  std::string level;            // the folder of its array below the store's; empty: the store's own
  std::vector<ZarrAxis> axes;   // empty: not said, as in versions 0.1 and 0.2, if they are t, c, z, y, x
  std::vector<std::string> channels;
  std::vector<std::string> notes;
};

/// The image of a folder at its finest level, or at that whose array lies in the folder `level` of it. Nothing if the folder is not an image, or has no such level.
/// Throws bad_data for metadata that makes no sense or that leads out of the folder, unsupported for what is not read.
std::optional<ZarrImage> read_zarr_image(ZarrStore& store, const std::string& level);

/// Of an array by itself: by the names "t", "time", "c", "channel"; all others are space.
std::vector<ZarrAxis> axes_by_name(const ZarrArray& array);

/// Throws bad_data or unsupported, saying what the folder is and what to do, if neither an array nor an image is in it.
[[noreturn]] void refuse_zarr_group(ZarrStore& store);

}  // namespace isostrata
