// The colour maps that are built in: every fifth entry of the published 256, as packed sRGB bytes. Linear interpolation between
// them stays within 2.1/255 of the published entries (tested against the published tables where they are at hand).
//
// viridis, plasma, inferno, magma: Nathaniel Smith and Stefan van der Walt, mpl-colormaps, CC0 1.0 (public domain).
//
// batlow, vik: Fabio Crameri, "Scientific colour maps", 2018 (and "The misuse of colour in science communication", 2020).
//   MIT License. Copyright (c) 2020 Fabio Crameri
//   Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated documentation
//   files (the "Software"), to deal in the Software without restriction, including without limitation the rights to use, copy,
//   modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit persons to whom the
//   Software is furnished to do so, subject to the following conditions: The above copyright notice and this permission notice
//   shall be included in all copies or substantial portions of the Software. THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY
//   OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR
//   PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER
//   LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR
//   THE USE OR OTHER DEALINGS IN THE SOFTWARE.
//
// coolwarm: computed, after Kenneth Moreland, "Diverging Color Maps for Scientific Visualization", 2009. gray: computed.
#include "rendering/style.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "base/error.h"

namespace isostrata {
namespace {
constexpr std::size_t kMaxRampColors = 16;

constexpr std::string_view kViridis =
    "44015446085c471063481769481d6f482475472a7a46307e453781433d844142873f48893d4e8a3a538b38598c355e8d33638d31688e2e6d8e2c718e"
    "2a768e297b8e27808e25848e23898e218e8d20928c1f978b1e9c891fa18821a58524aa8328ae802eb37c35b7793dbc7446c06f50c46a5ac86465cb5e"
    "70cf577cd25089d54895d840a2da37b0dd2fbddf26cae11fd8e219e5e419f1e51dfde725";

constexpr std::string_view kPlasma =
    "0d08871b068d2605912f059638049a41049d4903a05102a35901a56100a76900a87100a87801a88004a88707a68e0ca49511a19c179ea21d9aa82296"
    "ae2892b42e8dba3388bf3984c43e7fc9447acd4a76d24f71d6556dda5b69de6164e26660e66c5ce97257ed7953f07f4ff3854bf58c46f79342f99a3e"
    "fba139fca835fdaf31feb72dfebe2afdc627fcce25fbd724f8df25f6e826f3f027f0f921";

constexpr std::string_view kInferno =
    "00000402020c0504170a072210092d160b391e0c45260c512f0a5b380962400a67490b6a510e6c59106e61136e69166e71196e781c6d801f6c88226a"
    "902568982766a02a63a82e5fb0315bb73557bf3952c63d4dcc4248d34743d94d3ddf5337e45a31e9612bed6925f1711ff47918f78212f98b0bfa9407"
    "fb9d07fca60cfcb014fbba1ffac42af8cd37f6d746f4e156f2ea69f2f27df5f992fcffa4";

constexpr std::string_view kMagma =
    "00000402020b0504160907200e0b2b140e361a104221114e29115a311165390f6e420f754a107952137c5a167e6219806a1c81721f81792282812581"
    "892881912b81992d80a1307eaa337db2357bba3878c23b75ca3e72d2426fd9466be04c67e75263ec5860f1605df4695cf7725cf97b5dfb8560fc8e64"
    "fd9869fea16efeaa74feb47bfebd82fec68afecf92fed89afde2a3fdebacfcf4b6fcfdbf";

constexpr std::string_view kBatlow =
    "01195906215b0a285c0c2f5d0e365e0f3c5f114160124661134b61154f621854621b58621e5d6223606028645f2f675c356a593c6d564470524c724d"
    "5375495b7745637a406c7c3c747e387d81348683308f862d99882ca38a2cad8c2db78e31c09036ca923cd29343db954be39754ea995ef09c69f59f74"
    "f9a380fba68cfdaa97fdaea2fdb2adfdb5b8fdb9c2fdbccdfcc0d8fcc4e3fbc8effaccfa";

constexpr std::string_view kVik =
    "001261011a6602226b022a7002317502397a03417f03498405518908598f106294196b9a2575a1337fa84289af5194b6619ebd71a8c480b2ca90bcd1"
    "a0c5d8b0cfdec0d8e4cfe0e8dee6e9e8e7e5eee3dceedbd0ecd1c3e8c8b5e4bea8dfb49adbaa8dd7a081d39774cf8e68cc855dc87c51c47445c06b3a"
    "bc622fb65824af4c18a5400f9a35088f2b068522067c1b067314066a0d07620607590008";

int hex_digit(char c) { return c <= '9' ? c - '0' : c - 'a' + 10; }

ColorMap unpack(std::string_view name, std::string_view hex) {
  ColorMap map{std::string(name), {}};
  for (std::size_t i = 0; i + 5 < hex.size(); i += 6) {
    Rgb rgb{};
    for (std::size_t c = 0; c < 3; ++c)
      rgb[c] = static_cast<float>(16 * hex_digit(hex[i + 2 * c]) + hex_digit(hex[i + 2 * c + 1])) / 255.0f;
    map.rgb.push_back(rgb);
  }
  return map;
}

// ---- coolwarm -------------------------------------------------------------------------------------------------------------

constexpr std::array<double, 3> kWhite{0.9505, 1.0, 1.089};  // D65

double linear_from_srgb(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }
double srgb_from_linear(double v) { return v <= 0.0031308 ? v * 12.92 : 1.055 * std::pow(v, 1 / 2.4) - 0.055; }
double lab_curve(double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; }
double lab_curve_inverse(double t) { return t > 0.206893 ? t * t * t : (t - 16.0 / 116) / 7.787; }

struct Msh {
  double magnitude, saturation, hue;  // CIELAB in polar coordinates (Moreland 2009, section 5.2)
};

Msh msh_from_rgb(const Rgb& rgb) {
  const double r = linear_from_srgb(rgb[0]), g = linear_from_srgb(rgb[1]), b = linear_from_srgb(rgb[2]);
  const double x = lab_curve((0.4124 * r + 0.3576 * g + 0.1805 * b) / kWhite[0]);
  const double y = lab_curve((0.2126 * r + 0.7152 * g + 0.0722 * b) / kWhite[1]);
  const double z = lab_curve((0.0193 * r + 0.1192 * g + 0.9505 * b) / kWhite[2]);
  const double l = 116 * y - 16, a = 500 * (x - y), b2 = 200 * (y - z);
  const double m = std::sqrt(l * l + a * a + b2 * b2);
  return {m, std::acos(l / m), std::atan2(b2, a)};
}

Rgb rgb_from_msh(const Msh& msh) {
  const double l = msh.magnitude * std::cos(msh.saturation);
  const double a = msh.magnitude * std::sin(msh.saturation) * std::cos(msh.hue);
  const double b = msh.magnitude * std::sin(msh.saturation) * std::sin(msh.hue);
  const double fy = (l + 16) / 116;
  const double x = kWhite[0] * lab_curve_inverse(fy + a / 500), y = kWhite[1] * lab_curve_inverse(fy);
  const double z = kWhite[2] * lab_curve_inverse(fy - b / 200);
  const std::array<double, 3> linear{3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z,
                                     0.0557 * x - 0.2040 * y + 1.0570 * z};
  Rgb rgb{};
  for (std::size_t c = 0; c < 3; ++c) rgb[c] = static_cast<float>(std::clamp(srgb_from_linear(linear[c]), 0.0, 1.0));
  return rgb;
}

// Hue turns away from the unsaturated middle so that its change is not seen as a band (Moreland 2009, figure 7).
double turned_hue(const Msh& end, double middle_magnitude) {
  const double turn = end.saturation * std::sqrt(middle_magnitude * middle_magnitude - end.magnitude * end.magnitude) /
                      (end.magnitude * std::sin(end.saturation));
  return end.hue > -1.0471975511965976 ? end.hue + turn : end.hue - turn;
}

ColorMap make_coolwarm() {
  const Msh cool = msh_from_rgb({0.230f, 0.299f, 0.754f}), warm = msh_from_rgb({0.706f, 0.016f, 0.150f});
  const double middle = std::max({cool.magnitude, warm.magnitude, 88.0});
  ColorMap map{"coolwarm", {}};
  for (int i = 0; i <= 64; ++i) {
    const double t = i / 64.0;
    const Msh& end = t < 0.5 ? cool : warm;
    const double to_end = std::abs(2 * t - 1);
    const double hue = turned_hue(end, middle);
    map.rgb.push_back(
        rgb_from_msh({middle + (end.magnitude - middle) * to_end, end.saturation * to_end, hue + (end.hue - hue) * to_end}));
  }
  return map;
}

const std::vector<ColorMap>& all_maps() {
  static const std::vector<ColorMap> maps{unpack("viridis", kViridis),
                                          unpack("plasma", kPlasma),
                                          unpack("inferno", kInferno),
                                          unpack("magma", kMagma),
                                          unpack("batlow", kBatlow),
                                          unpack("vik", kVik),
                                          make_coolwarm(),
                                          ColorMap{"gray", {{0, 0, 0}, {1, 1, 1}}}};
  return maps;
}

// "#rrggbb-#rrggbb-...": straight between colours at equal distances.
ColorMap ramp(std::string_view name) {
  ColorMap map{std::string(name), {}};
  for (std::string_view rest = name;;) {
    const auto end = rest.find('-');
    map.rgb.push_back(parse_rgb(rest.substr(0, end)));
    if (end == std::string_view::npos) break;
    rest.remove_prefix(end + 1);
    if (map.rgb.size() == kMaxRampColors) break;
  }
  if (map.rgb.size() < 2 || std::count(name.begin(), name.end(), '-') + 1 > static_cast<std::ptrdiff_t>(kMaxRampColors))
    throw Error(ErrorCode::invalid_argument,
                "colour ramp '" + std::string(name.substr(0, 80)) + "': expected 2 to 16 colours, as #0000ff-#ffffff");
  return map;
}

}  // namespace

ColorMap color_map(std::string_view name) {
  if (name.starts_with('#')) return ramp(name);
  for (const ColorMap& map : all_maps())
    if (map.name == name) return map;
  std::string known;
  for (const ColorMap& map : all_maps()) known += (known.empty() ? "" : ", ") + std::string(map.name);
  throw Error(ErrorCode::not_found,
              "colour map '" + std::string(name) + "' is not built in; there are " + known + " and ramps as #0000ff-#ffffff");
}

bool is_color_map(std::string_view name) {
  try {
    color_map(name);
    return true;
  } catch (const Error&) {
    return false;
  }
}

Rgb sample(const ColorMap& map, float t) {
  const float at = (t > 0 ? std::min(t, 1.0f) : 0.0f) * static_cast<float>(map.rgb.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), map.rgb.size() - 2);
  Rgb rgb{};
  for (std::size_t c = 0; c < 3; ++c) rgb[c] = map.rgb[i][c] + (map.rgb[i + 1][c] - map.rgb[i][c]) * (at - static_cast<float>(i));
  return rgb;
}

std::vector<std::string_view> color_map_names() {
  std::vector<std::string_view> names;
  for (const ColorMap& map : all_maps()) names.push_back(map.name);
  return names;
}

}  // namespace isostrata
