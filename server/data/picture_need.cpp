#include "data/picture_need.h"

#include "base/error.h"
#include "data/file_series.h"
#include "data/recognise.h"

namespace isostrata {

bool is_picture_under_another_name(const std::filesystem::path& file) {
  if (names_pictures(file)) return false;
  try {
    return recognise(is_series_pattern(file) ? series_files(file).front().path : file).kind == FileKind::tiff;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace isostrata
