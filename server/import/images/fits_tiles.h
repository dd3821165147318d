// Images of FITS that are packed in tiles, as fpack does: a binary table with a row for each tile.
//
// "Definition of the Flexible Image Transport System (FITS)", version 4.0, IAU 2016, section 10 and appendix I: RICE_1, GZIP_1, GZIP_2 and NOCOMPRESS; whole numbers for real ones, with and without
// subtractive dithering.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "import/images/fits_header.h"
#include "import/imported/imported.h"

namespace isostrata {

struct FitsData {
  std::span<const std::byte> bytes;  // as FITS has them, the highest byte first
  std::shared_ptr<const void> storage;
};

/// `table` is the header of the packed image, `image` what it says of the image (FitsHeader::unpacked). Throws bad_data, unsupported, too_large.
FitsData unpack_fits_tiles(std::span<const std::byte> file, const FitsHeader& table, const FitsHeader& image, const ReadRequest& request);

}  // namespace isostrata
