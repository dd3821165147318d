// The module with OpenImageIO.
#pragma once

#include "encoding/oiio/picture_writer.h"

namespace isostrata {

/// Loaded by the first call: beside the program, in lib/isostrata/ beside the program's folder, or where $ISOSTRATA_OIIO says. Throws
/// unavailable if it cannot be. Any thread.
const PictureModule& picture_module();

}  // namespace isostrata
