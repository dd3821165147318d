// The colour maps that are built in, as splines fitted to the published tables of 256 colours (the greatest error made small), so
// that they bend smoothly: steps of a table's last digit would be kinks, which exact integrals have to stop at. Within 1.1/255 of
// the published entries (tested against the published tables if they are at hand).
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
// coolwarm: fitted to colours computed after Kenneth Moreland, "Diverging Color Maps for Scientific Visualization", 2009.
#include "scene/log_map.h"
#include "scene/style.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>

#include "base/error.h"
#include "base/nearest_name.h"

namespace isostrata {
namespace {
constexpr std::size_t kMaxRampColors = 16;

/// Weights of a uniform cubic B-spline on kPieces equal pieces of [0, 1], of red, green and blue.
constexpr int kPieces = 16;
using Spline = std::array<std::array<float, kPieces + 3>, 3>;

// clang-format off
constexpr Spline kViridis{{
    {0.2316f, 0.2711f, 0.2849f, 0.2823f, 0.2604f, 0.2308f, 0.1987f, 0.1732f, 0.1492f, 0.1272f, 0.1121f, 0.1457f, 0.2364f, 0.3585f, 0.5058f, 0.6678f, 0.8382f, 0.9957f, 1.1395f},
    {-0.0716f, -0.0010f, 0.0998f, 0.1727f, 0.2541f, 0.3198f, 0.3895f, 0.4453f, 0.5089f, 0.5626f, 0.6263f, 0.6795f, 0.7399f, 0.7855f, 0.8334f, 0.8613f, 0.8899f, 0.9001f, 0.9516f},
    {0.1918f, 0.3403f, 0.4159f, 0.4914f, 0.5240f, 0.5513f, 0.5515f, 0.5622f, 0.5544f, 0.5564f, 0.5329f, 0.5101f, 0.4540f, 0.3938f, 0.2982f, 0.2013f, 0.0762f, 0.1104f, 0.3535f},
}};

constexpr Spline kPlasma{{
    {-0.2051f, 0.0794f, 0.1933f, 0.3020f, 0.3969f, 0.4962f, 0.5825f, 0.6667f, 0.7340f, 0.7992f, 0.8509f, 0.9026f, 0.9423f, 0.9740f, 0.9941f, 0.9959f, 0.9812f, 0.9372f, 0.9084f},
    {0.0798f, 0.0203f, 0.0212f, 0.0083f, 0.0001f, 0.0003f, 0.0654f, 0.1384f, 0.2059f, 0.2797f, 0.3469f, 0.4232f, 0.4965f, 0.5824f, 0.6677f, 0.7671f, 0.8652f, 0.9797f, 1.0635f},
    {0.3670f, 0.5509f, 0.5843f, 0.6409f, 0.6532f, 0.6692f, 0.6310f, 0.5950f, 0.5230f, 0.4773f, 0.4089f, 0.3683f, 0.3018f, 0.2605f, 0.1935f, 0.1586f, 0.1246f, 0.1934f, -0.0972f},
}};

constexpr Spline kInferno{{
    {-0.0010f, -0.0072f, 0.0325f, 0.1269f, 0.2366f, 0.3432f, 0.4362f, 0.5415f, 0.6350f, 0.7372f, 0.8190f, 0.8981f, 0.9457f, 0.9841f, 0.9886f, 0.9834f, 0.9387f, 0.9543f, 1.1802f},
    {0.0231f, -0.0122f, 0.0315f, 0.0572f, 0.0243f, 0.0629f, 0.0977f, 0.1352f, 0.1677f, 0.2132f, 0.2683f, 0.3476f, 0.4429f, 0.5504f, 0.6693f, 0.7894f, 0.9168f, 1.0087f, 1.0367f},
    {-0.0296f, -0.0089f, 0.1439f, 0.2888f, 0.4211f, 0.4214f, 0.4462f, 0.4071f, 0.3968f, 0.3226f, 0.2818f, 0.1848f, 0.1343f, 0.0131f, 0.0315f, 0.2032f, 0.3632f, 0.6990f, 0.6878f},
}};

constexpr Spline kMagma{{
    {0.0371f, -0.0150f, 0.0365f, 0.1076f, 0.2083f, 0.3191f, 0.4102f, 0.5124f, 0.6081f, 0.7157f, 0.8129f, 0.9092f, 0.9628f, 0.9907f, 0.9949f, 1.0004f, 0.9902f, 0.9915f, 0.9614f},
    {-0.0284f, -0.0005f, 0.0253f, 0.0793f, 0.0575f, 0.0621f, 0.1149f, 0.1440f, 0.1852f, 0.2088f, 0.2547f, 0.3054f, 0.4143f, 0.5264f, 0.6522f, 0.7592f, 0.8828f, 0.9825f, 1.1438f},
    {-0.0424f, -0.0039f, 0.1346f, 0.2685f, 0.4382f, 0.4888f, 0.5096f, 0.5064f, 0.5046f, 0.4756f, 0.4438f, 0.3841f, 0.3530f, 0.3697f, 0.4418f, 0.5234f, 0.6357f, 0.7414f, 0.9024f},
}};

constexpr Spline kBatlow{{
    {-0.0798f, 0.0139f, 0.0539f, 0.0654f, 0.0844f, 0.1257f, 0.2054f, 0.2985f, 0.3998f, 0.5047f, 0.6262f, 0.7523f, 0.8635f, 0.9573f, 0.9942f, 0.9930f, 0.9902f, 0.9818f, 0.9720f},
    {-0.0007f, 0.0989f, 0.1954f, 0.2648f, 0.3216f, 0.3771f, 0.4180f, 0.4503f, 0.4791f, 0.5102f, 0.5406f, 0.5655f, 0.5830f, 0.6116f, 0.6593f, 0.7055f, 0.7502f, 0.8004f, 0.8505f},
    {0.3218f, 0.3525f, 0.3653f, 0.3791f, 0.3854f, 0.3854f, 0.3531f, 0.3031f, 0.2450f, 0.1923f, 0.1558f, 0.2017f, 0.2921f, 0.4165f, 0.5721f, 0.7049f, 0.8373f, 0.9783f, 1.1392f},
}};

constexpr Spline kVik{{
    {0.0090f, -0.0022f, 0.0145f, 0.0052f, 0.0231f, 0.1820f, 0.3709f, 0.5775f, 0.7694f, 0.9675f, 0.9110f, 0.8649f, 0.8090f, 0.7674f, 0.7163f, 0.5773f, 0.4488f, 0.3574f, 0.2173f},
    {0.0128f, 0.0605f, 0.1763f, 0.2577f, 0.3716f, 0.4804f, 0.6242f, 0.7349f, 0.8718f, 0.9342f, 0.7868f, 0.6761f, 0.5477f, 0.4519f, 0.3278f, 0.1737f, 0.0793f, 0.0006f, -0.0934f},
    {0.3979f, 0.3607f, 0.4537f, 0.4945f, 0.5777f, 0.6410f, 0.7486f, 0.8138f, 0.9203f, 0.9177f, 0.7141f, 0.5684f, 0.3955f, 0.2703f, 0.1088f, -0.0014f, 0.0389f, 0.0109f, 0.1170f},
}};

constexpr Spline kCoolwarm{{
    {0.1456f, 0.2326f, 0.3014f, 0.3841f, 0.4650f, 0.5546f, 0.6386f, 0.7244f, 0.8003f, 0.8662f, 0.9301f, 0.9614f, 0.9755f, 0.9605f, 0.9292f, 0.8711f, 0.8006f, 0.7050f, 0.6182f},
    {0.0952f, 0.3211f, 0.3951f, 0.5214f, 0.5965f, 0.7012f, 0.7525f, 0.8273f, 0.8418f, 0.8852f, 0.8193f, 0.7831f, 0.6871f, 0.6153f, 0.4896f, 0.3919f, 0.2333f, 0.1091f, -0.5534f},
    {0.6634f, 0.7533f, 0.8502f, 0.9196f, 0.9737f, 0.9981f, 1.0036f, 0.9796f, 0.9351f, 0.8702f, 0.7737f, 0.6801f, 0.5779f, 0.4828f, 0.3856f, 0.3005f, 0.2170f, 0.1514f, 0.0744f},
}};
// clang-format on

ColorMap sampled(std::string_view name, const Spline& spline) {
  constexpr int kSteps = 8 * kPieces;
  ColorMap map{std::string(name), {}};
  for (int i = 0; i <= kSteps; ++i) {
    const auto piece = static_cast<std::size_t>(std::min(i * kPieces / kSteps, kPieces - 1));
    const float x = static_cast<float>(i) * kPieces / kSteps - static_cast<float>(piece), y = 1 - x;
    const float weight[4] = {y * y * y / 6, (3 * x * x * x - 6 * x * x + 4) / 6, (3 * y * y * y - 6 * y * y + 4) / 6,
                             x * x * x / 6};
    Rgb rgb{};
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < 4; ++k) rgb[c] += weight[k] * spline[c][piece + k];
      rgb[c] = std::clamp(rgb[c], 0.0f, 1.0f);
    }
    map.rgb.push_back(rgb);
  }
  return map;
}

/// Each also the other way round, named as Matplotlib names it.
const std::vector<ColorMap>& all_maps() {
  static const std::vector<ColorMap> maps = [] {
    std::vector<ColorMap> all{sampled("viridis", kViridis), sampled("plasma", kPlasma),     sampled("inferno", kInferno),
                              sampled("magma", kMagma),     sampled("batlow", kBatlow),     sampled("vik", kVik),
                              sampled("coolwarm", kCoolwarm), ColorMap{"gray", {{0, 0, 0}, {1, 1, 1}}}};
    for (std::size_t i = 0, count = all.size(); i < count; ++i) all.push_back({all[i].name + "_r", {all[i].rgb.rbegin(), all[i].rgb.rend()}});
    return all;
  }();
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

constexpr std::string_view kLog = "log ";

// Of log_map: "log FROM TO GROWTH NAME".
ColorMap logarithmic(std::string_view name) {
  constexpr int kFewest = 256, kMost = 65536;
  double number[3] = {};
  std::string_view rest = name.substr(kLog.size());
  for (double& value : number) {
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (error != std::errc{} || end == rest.data() + rest.size() || *end != ' ' || !std::isfinite(value))
      throw Error(ErrorCode::invalid_argument, "colour map '" + std::string(name.substr(0, 80)) + "' is not known");
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()) + 1);
  }
  const auto [from, to, growth] = number;
  const ColorMap base = rest.starts_with('#') ? ramp(rest) : color_map(rest);
  ColorMap map{std::string(name), {}};
  // Where the value has grown least, each step is a sixty-fourth of it.
  const int steps = static_cast<int>(std::clamp(std::ceil(64 * growth), double{kFewest}, double{kMost}));
  const double whole = std::log(growth);
  map.rgb.reserve(static_cast<std::size_t>(steps) + 1);
  for (int i = 0; i <= steps; ++i) {
    const double share = whole > 0 ? std::log1p((growth - 1) * i / steps) / whole : 0.0;
    map.rgb.push_back(sample(base, static_cast<float>(std::lerp(from, to, share))));
  }
  return map;
}

}  // namespace

std::string log_map(std::string_view name, double from, double to, double growth) {
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(), "%s%.17g %.17g %.17g ", kLog.data(), from, to, growth);
  return text.data() + std::string(name);
}

ColorMap color_map(std::string_view name) {
  if (name.starts_with('#')) return ramp(name);
  if (name.starts_with(kLog)) return logarithmic(name);
  for (const ColorMap& map : all_maps())
    if (map.name == name) return map;
  std::string known;
  std::vector<std::string> names;
  for (const ColorMap& map : all_maps()) {
    known += (known.empty() ? "" : ", ") + map.name;
    names.push_back(map.name);
  }
  const std::string meant = did_you_mean(name, names);
  throw Error(ErrorCode::not_found, "colour map '" + std::string(name) + "' is not built in; there are " + known + " and ramps as #0000ff-#ffffff" + (meant.empty() ? "" : "." + meant));
}

bool is_color_map(std::string_view name) {
  try {
    if (name.starts_with(kLog)) return false;  // made by log_map, and not for people
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
