#include "film.h"

#include <cmath>

#include "isostrata/image.h"
#include "isostrata/options.h"
#include "webm_file.h"
#include "whole_file.h"
#include "yuv444.h"

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
      : options_(options), file_(path, options.width, options.height, options.fps, options.quality) {}
  void add(const std::string& png) override {
    const Picture picture = decode(png);
    check_size(picture, options_);
    file_.add(picture);
  }
  void finish() override { file_.finish(); }

 private:
  FilmOptions options_;
  WebmFile file_;
};

}  // namespace

std::unique_ptr<Film> open_film(const std::string& path, const FilmOptions& options) {
  if (path.ends_with(".png")) return std::make_unique<Pictures>(path);
  if (path.ends_with(".y4m")) return std::make_unique<Y4m>(path, options);
  if (path.ends_with(".webm")) return std::make_unique<WebM>(path, options);
  throw ClientError("bad_argument", "--out '" + path + "': expected a name that ends in .png, .y4m or .webm");
}

}  // namespace isostrata::client
