#include "film.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <thread>

#include "isostrata/options.h"
#include "vp9_encoder.h"
#include "webm_writer.h"
#include "whole_file.h"

namespace isostrata::client {
namespace {

void check_size(const Picture& picture, const FilmOptions& options) {
  if (picture.width != options.width || picture.height != options.height)
    throw ClientError("protocol", "a picture of " + std::to_string(picture.width) + "x" + std::to_string(picture.height) +
                                      " pixels came; expected " + std::to_string(options.width) + "x" +
                                      std::to_string(options.height));
}

// "%d" or "%04d", once; everything else stays as it is.
class Pictures : public Film {
 public:
  explicit Pictures(const std::string& pattern) {
    const auto at = pattern.find('%');
    auto end = at == std::string::npos ? at : pattern.find_first_not_of("0123456789", at + 1);
    if (end == std::string::npos || pattern[end] != 'd' || pattern.find('%', end) != std::string::npos || end - at > 4)
      throw ClientError("bad_argument", "--out '" + pattern + "': expected one place for the number, such as frame-%04d.png");
    before_ = pattern.substr(0, at);
    after_ = pattern.substr(end + 1);
    digits_ = end - at > 1 ? static_cast<std::size_t>(std::stoi(pattern.substr(at + 1, end - at - 1))) : 1;
  }
  void add(const std::string& png) override {
    std::string number = std::to_string(next_++);
    if (number.size() < digits_) number.insert(0, digits_ - number.size(), '0');
    WholeFile file(before_ + number + after_);
    file.write(png);
    file.finish();
  }
  void finish() override {}

 private:
  std::string before_, after_;
  std::size_t digits_ = 1;
  int next_ = 0;
};

// YUV4MPEG2, as mjpegtools describe it (yuv4mpeg(5)).
class Y4m : public Film {
 public:
  Y4m(const std::string& path, const FilmOptions& options) : options_(options), file_(path) {
    const long rate = std::lround(options.fps * 1000);
    file_.write("YUV4MPEG2 W" + std::to_string(options.width) + " H" + std::to_string(options.height) + " F" +
                std::to_string(rate) + ":1000 Ip A1:1 C444 XCOLORRANGE=LIMITED\n");
  }
  void add(const std::string& png) override {
    const Picture picture = decode(png);
    check_size(picture, options_);
    const auto planes = to_yuv444(picture, Matrix::bt601);
    file_.write("FRAME\n");
    file_.write({reinterpret_cast<const char*>(planes.data()), planes.size()});
  }
  void finish() override { file_.finish(); }

 private:
  FilmOptions options_;
  WholeFile file_;
};

class WebM : public Film {
 public:
  WebM(const std::string& path, const FilmOptions& options)
      : options_(options),
        file_(path),
        writer_(file_, options.width, options.height, options.fps),
        encoder_(options.width, options.height, options.quality) {}
  void add(const std::string& png) override {
    const Picture picture = decode(png);
    check_size(picture, options_);
    const auto time_ms = static_cast<std::int64_t>(std::llround(static_cast<double>(next_++) * 1000 / options_.fps));
    const auto after_ms = static_cast<std::int64_t>(std::llround(static_cast<double>(next_) * 1000 / options_.fps));
    encoder_.encode(to_yuv444(picture, Matrix::bt709), time_ms, after_ms - time_ms, packets());
    end_ms_ = after_ms;
  }
  void finish() override {
    encoder_.flush(packets());
    writer_.finish(end_ms_);
    file_.finish();
  }

 private:
  Vp9Encoder::Packets packets() {
    return [this](std::string_view bytes, std::int64_t time_ms, bool key) { writer_.add(bytes, time_ms, key); };
  }

  FilmOptions options_;
  WholeFile file_;
  WebmWriter writer_;
  Vp9Encoder encoder_;
  std::int64_t next_ = 0, end_ms_ = 0;
};

}  // namespace

std::unique_ptr<Film> open_film(const std::string& path, const FilmOptions& options) {
  if (path.ends_with(".png")) return std::make_unique<Pictures>(path);
  if (path.ends_with(".y4m")) return std::make_unique<Y4m>(path, options);
  if (path.ends_with(".webm")) return std::make_unique<WebM>(path, options);
  throw ClientError("bad_argument", "--out '" + path + "': expected a name that ends in .png, .y4m or .webm");
}

// Recommendations ITU-R BT.601 and BT.709, 8 bits.
std::vector<std::uint8_t> to_yuv444(const Picture& picture, Matrix matrix) {
  const float kr = matrix == Matrix::bt601 ? 0.299f : 0.2126f, kb = matrix == Matrix::bt601 ? 0.114f : 0.0722f;
  const std::size_t pixels = picture.rgb.size() / 3;
  std::vector<std::uint8_t> planes(pixels * 3);  // [3][height][width]
  for (std::size_t p = 0; p < pixels; ++p) {
    const float r = picture.rgb[p * 3], g = picture.rgb[p * 3 + 1], b = picture.rgb[p * 3 + 2];
    const float y = kr * r + (1 - kr - kb) * g + kb * b;
    planes[p] = static_cast<std::uint8_t>(16.5f + y * (219.f / 255));
    planes[pixels + p] = static_cast<std::uint8_t>(128.5f + (b - y) / (2 * (1 - kb)) * (224.f / 255));
    planes[2 * pixels + p] = static_cast<std::uint8_t>(128.5f + (r - y) / (2 * (1 - kr)) * (224.f / 255));
  }
  return planes;
}

}  // namespace isostrata::client
