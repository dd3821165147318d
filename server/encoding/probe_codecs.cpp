#include <libdeflate.h>
#include <zlib.h>

#include <functional>

#include "base/error.h"
#include "encoding/decoder.h"
#include "encoding/encode_image.h"
#include "encoding/encoder.h"
#include "encoding/picture_distance.h"
#include "encoding/picture_module.h"

namespace isostrata {
namespace {

CodecProbe probe(const std::string& name, const std::string& library, const std::function<std::size_t()>& encode) {
  try {
    return {name, true, library + ", " + std::to_string(encode()) + " bytes for a picture of 16x16"};
  } catch (const Error& error) {
    return {name, false, error.what()};
  }
}

constexpr double kLeastPsnr = 30;  // in dB; another matrix, range or stride would be far below

/// Colours that run across the picture: a plain one would hide a wrong row or a swapped channel.
Image slope() {
  Image image{320, 240, std::vector<std::uint8_t>(320 * 240 * 4, 255)};
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      std::uint8_t* pixel = &image.rgba[static_cast<std::size_t>(4 * (y * 320 + x))];
      pixel[0] = static_cast<std::uint8_t>(255 * x / 320);
      pixel[1] = static_cast<std::uint8_t>(255 * y / 240);
      pixel[2] = static_cast<std::uint8_t>(128 + 60 * x / 320);
    }
  return image;
}

/// A key frame and one that follows it, decoded again.
CodecProbe probe_video(Codec codec) {
  const std::string name(name_of(codec));
  try {
    const auto encoder = make_encoder(codec);
    const auto decoder = make_decoder(codec);
    const Image image = slope();
    const Bytes first = encoder->encode(image, {}).bytes, second = encoder->encode(image, {}).bytes;
    const std::string detail = encoder->implementation() + ", " + std::to_string(first.size()) + " and " +
                         std::to_string(second.size()) + " bytes for two frames of 320x240";
    for (const Bytes* frame : {&first, &second}) {
      const PictureDistance distance = picture_distance(image, decoder->decode(*frame));
      if (distance.psnr < kLeastPsnr)
        return {name, false,
                detail + "; decoded, a picture is " + std::to_string(distance.max) + " steps of 255 from the one encoded"};
    }
    return {name, true, detail + ", decoded as they were"};
  } catch (const Error& error) {
    return {name, false, error.what()};
  }
}

}  // namespace

std::vector<CodecProbe> probe_codecs() {
  Image image{16, 16, std::vector<std::uint8_t>(16 * 16 * 4, 200)};
  std::vector<CodecProbe> probes{probe_video(Codec::vp9_444),
                                 probe("jpeg", "libjpeg-turbo", [&] { return encode_jpeg(image, 90).size(); }),
                                 probe("png", std::string("zlib ") + zlibVersion(), [&] { return encode_png(image).size(); }),
                                 probe("png-bands", std::string("libdeflate ") + LIBDEFLATE_VERSION_STRING,
                                       [&] { return encode_png_bands(image, 65536).at(0).bytes.size(); }),
                                 probe("webp", "libwebp, lossless", [&] { return encode_webp(image).size(); })};
  for (const char* format : {"tiff", "openexr"}) {  // to files only, so that it is asked for, not run
    try {
      const PictureModule& module = picture_module();
      const std::string missing = module.missing(format);
      probes.push_back({format, missing.empty(), missing.empty() ? module.library() : module.library() + ": " + missing});
    } catch (const Error& error) {
      probes.push_back({format, false, error.what()});
    }
  }
  return probes;
}

}  // namespace isostrata
