#include "import/images/geo_tiff.h"

#include <cmath>
#include <cstddef>
#include <string_view>

#include "import/bytes/parsed_number.h"
#include "import/bytes/trimmed.h"

namespace isostrata {
namespace {

/// Whether places are those of the pixels' middles (GTRasterTypeGeoKey is RasterPixelIsPoint), not of their corners.
bool of_middles(const TiffDirectory& directory) {
  constexpr int kRasterType = 1025, kIsPoint = 2;
  for (std::size_t key = 4; key + 3 < directory.geo_keys.size(); key += 4)
    if (directory.geo_keys[key] == kRasterType && directory.geo_keys[key + 1] == 0) return directory.geo_keys[key + 3] == kIsPoint;
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
  const double middle = of_middles(directory) ? 0 : 0.5;
  for (std::size_t a = 0; a < 2; ++a) out.first[a] += middle * (out.column[a] + out.row[a]);
  const double area = out.column[0] * out.row[1] - out.column[1] * out.row[0];
  return std::isfinite(area) && area != 0 && std::isfinite(out.first[0]) && std::isfinite(out.first[1]) ? std::optional(out) : std::nullopt;
}

std::optional<double> geo_no_data(const TiffDirectory& directory) {
  const std::string_view text = directory.no_data;
  return parsed_number<double>(trimmed(text.substr(0, text.find('\0'))));
}

}  // namespace isostrata
