// Pictures one after the other, as files: numbered PNGs, or one film.
#pragma once

#include <memory>
#include <string>

#include "webm_file.h"

namespace isostrata::client {

/// A film that is being written. Nothing has the film's name before finish(); without it nothing of a film is left behind, and of
/// numbered pictures those that are complete.
class Film {
 public:
  virtual ~Film() = default;
  /// The next picture, a PNG file's bytes. Throws ClientError.
  virtual void add(const std::string& png) = 0;
  virtual void finish() = 0;
};

struct FilmOptions {
  int width = 0, height = 0;
  double fps = 30;
  int quality = kFilmQuality;
};

/// By the name's end: ".png" with a place for the number ("frame-%04d.png"), ".y4m" (uncompressed 4:4:4, BT.601), ".webm" (VP9
/// 4:4:4, BT.709). Throws ClientError "bad_argument".
std::unique_ptr<Film> open_film(const std::string& path, const FilmOptions& options);

}  // namespace isostrata::client
