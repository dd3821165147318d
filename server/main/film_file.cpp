#include "main/film_file.h"

namespace isostrata {

FilmFile::FilmFile(const std::string& path, int width, int height, bool alpha, PngAnimation animation) : height_(height), picture_{width, 0, {}} {
  if (path.ends_with(".webm")) webm_.emplace(path, width, height, 1 / animation.seconds, client::kFilmQuality);
  else png_.emplace(path, width, height, ImageChannels{alpha, false}, animation);
}

void FilmFile::add(const Image& rows) {
  if (png_) return png_->put(rows);
  for (std::size_t i = 0; i < rows.rgba.size(); i += 4) picture_.rgb.insert(picture_.rgb.end(), {rows.rgba[i], rows.rgba[i + 1], rows.rgba[i + 2]});
  picture_.height += rows.height;
  if (picture_.height < height_) return;
  webm_->add(picture_);
  picture_.height = 0;
  picture_.rgb.clear();
}

void FilmFile::finish() {
  if (png_) png_->finish();
  if (webm_) webm_->finish();
}

}  // namespace isostrata
