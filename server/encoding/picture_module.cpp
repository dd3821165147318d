#include "encoding/picture_module.h"

#include "base/error.h"
#include "base/load_module.h"

namespace isostrata {

const PictureModule& picture_module() {
  static const LoadedModule found =
      load_module("libisostrata_oiio.so", "ISOSTRATA_OIIO", "isostrata_picture_module", kPictureWriterAbi);
  const auto* module = static_cast<const PictureModule*>(found.entry);
  if (!module)
    throw Error(ErrorCode::unavailable, "OpenImageIO, which writes .tif, .exr and .jpg, cannot be loaded: " + found.problem);
  return *module;
}

}  // namespace isostrata
