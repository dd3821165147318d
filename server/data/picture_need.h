// Whether a file is a picture by its first bytes, whatever its name. What reads pictures takes as long to load as many small files to read, and must be loaded before the reader is
// confined, which looks at no file until then: so whoever starts a reader tells it.
#pragma once

#include <filesystem>

namespace isostrata {

/// Of the reader: any value says that its file is a picture.
inline constexpr const char* kPictureVariable = "ISOSTRATA_PICTURE";

/// Of a pattern (file_series.h) its first file counts. False of what cannot be told, and of what is named as a picture, which the reader sees itself.
bool is_picture_under_another_name(const std::filesystem::path& file);

}  // namespace isostrata
