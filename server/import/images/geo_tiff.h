// Where the pixels of a GeoTIFF lie, and which value stands for none.
//
// "OGC GeoTIFF Standard", version 1.1, OGC 19-008r4; no-data as GDAL writes it.
#pragma once

#include <array>
#include <optional>

#include "import/images/tiff_directory.h"

namespace isostrata {

/// In the units of the file's own coordinates: degrees or metres to the east and north.
struct GeoPlace {
  std::array<double, 2> first{};               // the middle of the first pixel of the file
  std::array<double, 2> column{}, row{};       // from a pixel to the next of its row, and to the one in the next row
  bool degrees = false;                        // longitudes and latitudes
};

/// Nothing if the file does not say it, or says it by more points than one alone.
std::optional<GeoPlace> geo_place(const TiffDirectory& directory);

/// The value that stands for none; nothing if none does.
std::optional<double> geo_no_data(const TiffDirectory& directory);

}  // namespace isostrata
