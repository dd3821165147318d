#include <OpenImageIO/imageio.h>
#include <zlib.h>

#include <functional>

#include "base/error.h"
#include "encoding/encode_image.h"

namespace isostrata {
namespace {

CodecProbe probe(const std::string& name, const std::string& library, const std::function<std::size_t()>& encode) {
  try {
    return {name, true, library + ", " + std::to_string(encode()) + " bytes for a picture of 16x16"};
  } catch (const Error& error) {
    return {name, false, error.what()};
  }
}

}  // namespace

std::vector<CodecProbe> probe_codecs() {
  Image image{16, 16, std::vector<std::uint8_t>(16 * 16 * 4, 200)};
  std::vector<CodecProbe> probes{probe("jpeg", "libjpeg-turbo", [&] { return encode_jpeg(image, 90).size(); }),
                                 probe("png", std::string("zlib ") + zlibVersion(), [&] { return encode_png(image).size(); })};
  const int version = OIIO::openimageio_version();  // 20413 is 2.4.13
  const std::string library = "OpenImageIO " + std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
                              std::to_string(version % 100);
  for (const char* format : {"webp", "tiff", "openexr"}) {  // to files only, so that it is asked for, not run
    const auto output = OIIO::ImageOutput::create(format);
    probes.push_back({format, output != nullptr, output ? library : library + ": " + OIIO::geterror()});
  }
  return probes;
}

}  // namespace isostrata
