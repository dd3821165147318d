#include "encoding/image_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "encoding/check_image.h"
#include "encoding/encode_image.h"
#include "encoding/picture_module.h"
#include "encoding/png_stream.h"

namespace isostrata {
namespace {

constexpr int kStillQuality = 95;
constexpr int kMaxWebp = 16383;  // a side, by the format

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_jpeg(const std::string& extension) { return extension == ".jpg" || extension == ".jpeg"; }

[[noreturn]] void cannot_write(const std::filesystem::path& path, const std::string& why) {
  throw Error(ErrorCode::unavailable, path.string() + ": cannot be written: " + why);
}

float linear_from_srgb(float v) { return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f); }

}  // namespace

bool is_float_format(const std::filesystem::path& path) { return extension_of(path) == ".exr"; }

void check_image_path(const std::filesystem::path& path) {
  for (const char* known : {".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".exr"})
    if (extension_of(path) == known) return;
  throw Error(ErrorCode::invalid_argument, path.string() + ": extension '" + extension_of(path) +
                                               "' is not a picture; expected .png, .jpg, .webp, .tif or .exr");
}

void check_image_file(const std::filesystem::path& path, int width, int height, bool alpha) {
  check_image_path(path);
  const std::string extension = extension_of(path);
  if (alpha && is_jpeg(extension))
    throw Error(ErrorCode::invalid_argument, path.string() + ": JPEG has no transparency; expected .png, .webp, .tif or .exr");
  if (extension == ".webp" && std::max(width, height) > kMaxWebp)
    throw Error(ErrorCode::invalid_argument, path.string() + ": WebP takes at most " + std::to_string(kMaxWebp) +
                                                 " pixels each way, not " + std::to_string(width) + "x" + std::to_string(height) +
                                                 "; expected .png, .jpg, .tif or .exr");
}

struct ImageFile::Writer {
  std::filesystem::path path, part;  // what it is called at the end and until then
  std::string extension;
  int width = 0;
  std::int64_t height = 0, rows = 0;  // of all pictures, one below the other
  int channels = 4;
  bool floats = false, done = false, keep_alpha = true;
  std::optional<PngStream> png;
  std::optional<Image> webp;  // the rows so far: its encoder wants them all
  std::ofstream file;
  std::unique_ptr<PictureWriter> output;

  Writer(const std::filesystem::path& name, int w, int h, ImageChannels wanted, PngAnimation animation)
      : path(name), part(name.string() + ".part"), extension(extension_of(name)), width(w), height(std::int64_t{h} * animation.pictures) {
    check_image_file(name, w, h, false);
    if (animation.pictures != 1 && extension != ".png")
      throw Error(ErrorCode::invalid_argument,
                  path.string() + ": only .png can hold several pictures; expected .png, or %02d in the name for one file each");
    floats = is_float_format(name);
    if (extension == ".png") {
      png.emplace(w, h, wanted.alpha, animation);
      file.open(part, std::ios::binary | std::ios::trunc);
      if (!file) cannot_write(path, "the folder is missing, not writable or full");
      return;
    }
    if (extension == ".webp") {
      webp.emplace(Image{w, 0, {}});
      keep_alpha = wanted.alpha;
      file.open(part, std::ios::binary | std::ios::trunc);
      if (!file) cannot_write(path, "the folder is missing, not writable or full");
      return;
    }
    channels = floats ? (wanted.depth ? 5 : 4) : is_jpeg(extension) ? 3 : 4;
    const char* format = floats ? "openexr" : is_jpeg(extension) ? "jpeg" : "tiff";
    by_module([&] { output = picture_module().open({part.string(), format, w, h, channels, floats, kStillQuality}); });
  }

  ~Writer() {
    if (done) return;
    output.reset();
    file.close();
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
  }

  template <class AnyImage>
  void check_rows(const AnyImage& image) {
    check_image(image);
    if (image.width != width || image.height > height - rows)
      throw Error(ErrorCode::internal, path.string() + ": " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                                           " pixels came; " + std::to_string(width) + "x" + std::to_string(height - rows) +
                                           " were left");
  }

  void put_bytes(const Image& image) {
    check_rows(image);
    if (png) {
      const Bytes bytes = png->put(image);
      file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
      if (!file) cannot_write(path, "the folder is missing, not writable or full");
    } else if (webp) {
      webp->rgba.insert(webp->rgba.end(), image.rgba.begin(), image.rgba.end());
      webp->height += image.height;
    } else {
      by_module([&] { output->write(image.height, image.rgba.data(), 4); });  // JPEG takes three bytes of each four
    }
    rows += image.height;
  }

  void put_floats(const FloatImage& image) {
    check_rows(image);
    const auto n = static_cast<std::size_t>(channels);
    const std::size_t pixels = image.rgba.size() / 4;
    std::vector<float> linear(pixels * n);
    parallel_for(static_cast<std::int64_t>(pixels), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
      for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end); ++p) {
        const float alpha = image.rgba[4 * p + 3];
        for (std::size_t c = 0; c < 3; ++c)
          linear[p * n + c] = alpha > 0 ? alpha * linear_from_srgb(std::max(image.rgba[4 * p + c] / alpha, 0.0f)) : 0.0f;
        linear[p * n + 3] = alpha;
        if (n == 5) linear[p * n + 4] = image.depth.empty() ? std::numeric_limits<float>::infinity() : image.depth[p];
      }
    });
    by_module([&] { output->write(image.height, linear.data(), n * sizeof(float)); });
    rows += image.height;
  }

  template <class Act>
  void by_module(const Act& act) const try {
    act();
  } catch (const std::runtime_error& error) {
    cannot_write(path, error.what());
  }

  void finish() {
    if (rows != height)
      throw Error(ErrorCode::internal,
                  path.string() + ": " + std::to_string(rows) + " of " + std::to_string(height) + " rows were written");
    if (webp) {
      if (!keep_alpha)
        for (std::size_t i = 3; i < webp->rgba.size(); i += 4) webp->rgba[i] = 255;
      const Bytes bytes = encode_webp(*webp);
      file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    }
    if (png || webp) {
      file.close();
      if (!file) cannot_write(path, "the folder is missing, not writable or full");
    } else {
      by_module([&] { output->finish(); });
    }
    std::error_code failed;
    std::filesystem::rename(part, path, failed);
    if (failed) cannot_write(path, failed.message());
    done = true;
  }
};

ImageFile::ImageFile(const std::filesystem::path& path, int width, int height, ImageChannels channels, PngAnimation animation)
    : writer_(std::make_unique<Writer>(path, width, height, channels, animation)) {}
ImageFile::~ImageFile() = default;

void ImageFile::put(const Image& rows) {
  if (!writer_->floats) return writer_->put_bytes(rows);
  check_image(rows);
  FloatImage floats{rows.width, rows.height, std::vector<float>(rows.rgba.size()), {}};
  for (std::size_t i = 0; i < rows.rgba.size(); i += 4) {
    const float alpha = static_cast<float>(rows.rgba[i + 3]) / 255.0f;
    for (std::size_t c = 0; c < 3; ++c) floats.rgba[i + c] = static_cast<float>(rows.rgba[i + c]) / 255.0f * alpha;
    floats.rgba[i + 3] = alpha;
  }
  writer_->put_floats(floats);
}

void ImageFile::put(const FloatImage& rows) {
  if (writer_->floats) return writer_->put_floats(rows);
  check_image(rows);
  writer_->put_bytes(to_8_bit(rows));
}

void ImageFile::finish() { writer_->finish(); }

void write_image(const std::filesystem::path& path, const Image& image) {
  check_image_path(path);
  check_image(image);
  bool alpha = false;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) alpha = alpha || image.rgba[i] != 255;
  ImageFile file(path, image.width, image.height, {alpha, false});
  file.put(image);
  file.finish();
}

void write_image(const std::filesystem::path& path, const FloatImage& image) {
  check_image_path(path);
  check_image(image);
  if (!is_float_format(path)) return write_image(path, to_8_bit(image));
  ImageFile file(path, image.width, image.height, {true, image.depth.size() == image.rgba.size() / 4});
  file.put(image);
  file.finish();
}

}  // namespace isostrata
