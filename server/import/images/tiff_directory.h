// What the first directory of a TIFF says of the whole file, beyond what OpenImageIO tells: where its values lie and who describes them.
//
// "TIFF, revision 6.0", Adobe 1992; BigTIFF by libtiff's design, 64-bit offsets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace isostrata {

struct TiffDirectory {
  std::string description;  // at most 64 MiB of it
  double x_resolution = 0, y_resolution = 0;
  int resolution_unit = 2;  // 1: the description's, 2: inches, 3: centimetres
  int compression = 1;      // 1: none
  int layout = 1;           // 1: the components of a pixel beside each other, 2: a plane for each
  bool big_endian = false;
  bool last = false;              // no other follows it
  std::uint64_t strips = 0;       // pieces of the picture; 0: tiles
  std::uint64_t first_strip = 0;  // where the first begins
  // GeoTIFF 1.1 (OGC 19-008r4), and GDAL's own:
  std::vector<double> pixel_scale, tie_points, transformation;  // as in the file; empty if they are not there
  std::vector<std::uint16_t> geo_keys;                          // four a key
  std::string no_data;                                          // a number as text
};

/// Nothing for what is not a TIFF file or has a damaged directory: why, OpenImageIO says.
std::optional<TiffDirectory> first_tiff_directory(std::span<const std::byte> file);

/// Whether what follows the first `read` directories lies beyond the end of the file, of which the rest is missing.
bool leads_beyond_end(std::span<const std::byte> file, std::size_t read);

}  // namespace isostrata
