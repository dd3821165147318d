#include <turbojpeg.h>

#include <memory>
#include <string>

#include "base/error.h"
#include "encoding/check_image.h"
#include "encoding/encode_image.h"

namespace isostrata {

Bytes encode_jpeg(const Image& image, int quality) {
  check_image(image);
  if (quality < 1 || quality > 100)
    throw Error(ErrorCode::invalid_argument, "JPEG quality " + std::to_string(quality) + ": expected 1 to 100");
  const std::unique_ptr<void, int (*)(tjhandle)> compressor(tjInitCompress(), tjDestroy);
  if (!compressor) throw Error(ErrorCode::unavailable, std::string("JPEG: ") + tjGetErrorStr());
  // The buffer is ours and large enough for the worst case, so the library never allocates one (TJFLAG_NOREALLOC).
  Bytes out(tjBufSize(image.width, image.height, TJSAMP_444));
  unsigned char* data = out.data();
  unsigned long size = static_cast<unsigned long>(out.size());
  if (tjCompress2(compressor.get(), image.rgba.data(), image.width, 0, image.height, TJPF_RGBX, &data, &size, TJSAMP_444, quality,
                  TJFLAG_NOREALLOC) != 0)
    throw Error(ErrorCode::internal, std::string("JPEG: ") + tjGetErrorStr2(compressor.get()));
  out.resize(size);
  return out;
}

}  // namespace isostrata
