#include "import/images/geo_tiff.h"

#include <cmath>
#include <cstddef>
#include <string_view>

#include "import/bytes/parsed_number.h"
#include "import/bytes/trimmed.h"

namespace isostrata {
namespace {

/// Whether a key that is a number by itself has this one.
bool says(const TiffDirectory& directory, int wanted, int number) {
  for (std::size_t key = 4; key + 3 < directory.geo_keys.size(); key += 4)
    if (directory.geo_keys[key] == wanted && directory.geo_keys[key + 1] == 0) return directory.geo_keys[key + 3] == number;
  return false;
}

}  // namespace

std::optional<GeoPlace> geo_place(const TiffDirectory& directory) {
  GeoPlace out;
  const auto &t = directory.transformation, &scale = directory.pixel_scale, &tie = directory.tie_points;
  if (t.size() == 16)
    out = {{t[3], t[7]}, {t[0], t[4]}, {t[1], t[5]}};
  else if (scale.size() >= 2 && tie.size() == 6)
    out = {{tie[3] - tie[0] * scale[0], tie[4] + tie[1] * scale[1]}, {scale[0], 0}, {0, -scale[1]}};
  else
    return std::nullopt;
  constexpr int kModelType = 1024, kGeographic = 2, kRasterType = 1025, kIsPoint = 2;
  out.degrees = says(directory, kModelType, kGeographic);
  const double middle = says(directory, kRasterType, kIsPoint) ? 0 : 0.5;  // places are those of the pixels' middles, not of their corners
  for (std::size_t a = 0; a < 2; ++a) out.first[a] += middle * (out.column[a] + out.row[a]);
  const double area = out.column[0] * out.row[1] - out.column[1] * out.row[0];
  return std::isfinite(area) && area != 0 && std::isfinite(out.first[0]) && std::isfinite(out.first[1]) ? std::optional(out) : std::nullopt;
}

std::optional<double> geo_no_data(const TiffDirectory& directory) {
  const std::string_view text = directory.no_data;
  return parsed_number<double>(trimmed(text.substr(0, text.find('\0'))));
}

}  // namespace isostrata
