#include <turbojpeg.h>

#include <memory>

#include "isostrata/client.h"

namespace isostrata::client {

DecodedImage decode_jpeg(std::string_view bytes) {
  const std::unique_ptr<void, int (*)(void*)> turbo(tjInitDecompress(), tjDestroy);
  const auto fail = [&] { throw Error("malformed", std::string("a JPEG frame cannot be decoded: ") + tjGetErrorStr2(turbo.get())); };
  DecodedImage image;
  int subsampling = 0, colorspace = 0;
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  if (tjDecompressHeader3(turbo.get(), data, bytes.size(), &image.width, &image.height, &subsampling, &colorspace) != 0) fail();
  image.rgb.resize(static_cast<std::size_t>(image.width) * image.height * 3);
  if (tjDecompress2(turbo.get(), data, bytes.size(), image.rgb.data(), image.width, 0, image.height, TJPF_RGB, 0) != 0) fail();
  return image;
}

}  // namespace isostrata::client
