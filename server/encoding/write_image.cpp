// Pictures as files, through OpenImageIO. It only writes here: reading foreign pictures is not this process's business.
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <string>

#include "base/error.h"
#include "encoding/check_image.h"
#include "encoding/encode_image.h"

namespace isostrata {
namespace {

constexpr int kStillQuality = 95;

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

[[noreturn]] void unknown_extension(const std::filesystem::path& path) {
  throw Error(ErrorCode::invalid_argument, path.string() + ": extension '" + extension_of(path) +
                                               "' is not a picture; expected .png, .jpg, .webp, .tif or .exr");
}

[[noreturn]] void cannot_write(const std::filesystem::path& path, const std::string& why) {
  throw Error(ErrorCode::unavailable, path.string() + ": cannot be written: " + why);
}

void write_bytes(const std::filesystem::path& path, const Bytes& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) cannot_write(path, "the folder is missing, not writable or full");
}

void write_by_oiio(const std::filesystem::path& path, const OIIO::ImageSpec& spec, OIIO::TypeDesc type, const void* pixels) {
  const auto output = OIIO::ImageOutput::create(path.string());
  if (!output) cannot_write(path, OIIO::geterror());
  if (!output->open(path.string(), spec) || !output->write_image(type, pixels) || !output->close())
    cannot_write(path, output->geterror());
}

float linear_from_srgb(float v) { return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f); }

}  // namespace

bool is_float_format(const std::filesystem::path& path) { return extension_of(path) == ".exr"; }

void check_image_path(const std::filesystem::path& path) {
  for (const char* known : {".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".exr"})
    if (extension_of(path) == known) return;
  unknown_extension(path);
}

void write_animation(const std::filesystem::path& path, const std::vector<Image>& images, double seconds) {
  if (extension_of(path) != ".png")
    throw Error(ErrorCode::invalid_argument,
                path.string() + ": only .png can hold several pictures; expected .png, or %02d in the name for one file each");
  write_bytes(path, encode_animated_png(images, seconds));
}

void write_image(const std::filesystem::path& path, const Image& image) {
  check_image_path(path);
  check_image(image);
  const std::string extension = extension_of(path);
  if (extension == ".png") return write_bytes(path, encode_png(image));
  if (extension == ".jpg" || extension == ".jpeg") return write_bytes(path, encode_jpeg(image, kStillQuality));
  if (extension == ".exr") {
    FloatImage floats{image.width, image.height, std::vector<float>(image.rgba.size()), {}};
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
      const float alpha = static_cast<float>(image.rgba[i + 3]) / 255.0f;
      for (std::size_t c = 0; c < 3; ++c) floats.rgba[i + c] = static_cast<float>(image.rgba[i + c]) / 255.0f * alpha;
      floats.rgba[i + 3] = alpha;
    }
    return write_image(path, floats);
  }
  OIIO::ImageSpec spec(image.width, image.height, 4, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute("oiio:UnassociatedAlpha", 1);
  spec.attribute("compression", extension == ".webp" ? "webp:100" : "zip");
  write_by_oiio(path, spec, OIIO::TypeDesc::UINT8, image.rgba.data());
}

void write_image(const std::filesystem::path& path, const FloatImage& image) {
  check_image(image);
  if (!is_float_format(path)) return write_image(path, to_8_bit(image));
  const std::size_t pixels = image.rgba.size() / 4;
  const bool depth = image.depth.size() == pixels;
  const std::size_t channels = depth ? 5 : 4;
  std::vector<float> linear(pixels * channels);
  for (std::size_t p = 0; p < pixels; ++p) {
    const float alpha = image.rgba[4 * p + 3];
    for (std::size_t c = 0; c < 3; ++c)
      linear[p * channels + c] = alpha > 0 ? alpha * linear_from_srgb(std::max(image.rgba[4 * p + c] / alpha, 0.0f)) : 0.0f;
    linear[p * channels + 3] = alpha;
    if (depth) linear[p * channels + 4] = image.depth[p];
  }
  OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(channels), OIIO::TypeDesc::FLOAT);
  spec.channelnames = depth ? std::vector<std::string>{"R", "G", "B", "A", "Z"} : std::vector<std::string>{"R", "G", "B", "A"};
  spec.alpha_channel = 3;
  if (depth) spec.z_channel = 4;
  spec.attribute("oiio:ColorSpace", "Linear");
  spec.attribute("compression", "zip");
  write_by_oiio(path, spec, OIIO::TypeDesc::FLOAT, linear.data());
}

}  // namespace isostrata
