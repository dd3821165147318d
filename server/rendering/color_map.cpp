// The colour maps that are built in: every third entry of the published 256 (of plasma, which bends more, every one), as packed
// sRGB bytes. Linear interpolation between them stays within 1/255 of the published entries (tested against the published tables
// where they are at hand).
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
    "440154450559460a5d470e61471365481769481b6d481f70482374482677472a7a472e7c46327e453581443983433d844240864144873f47883e4a89"
    "3d4e8a3b518b3a548c38588c375b8d355e8d34618d32648e31678e306a8e2e6d8e2d708e2c728e2b758e2a788e297b8e277e8e26818e25838e24868e"
    "23898e228c8d218f8d20928c1f948c1f978b1f9a8a1e9d891fa0881fa28721a58522a88425ab8227ad812ab07f2eb37c32b67a37b8783bbb7540bd72"
    "46c06f4cc26c52c56958c7655ec96265cb5e6ccd5a73d0567ad15181d34d89d54890d74398d83ea0da39a8db34b0dd2fb8de29c0df25c8e020d0e11c"
    "d8e219dfe318e7e419efe51cf6e620fde725";

constexpr std::string_view kPlasma =
    "0d088710078813078916078a19068c1b068d1d068e20068f2206902406912605912805922a05932c05942e05952f0596310597330597350498370499"
    "38049a3a049a3c049b3e049c3f049c41049d43039e44039e46039f48039f4903a04b03a14c02a14e02a25002a25102a35302a35502a45601a45801a4"
    "5901a55b01a55c01a65e01a66001a66100a76300a76400a76600a76700a86900a86a00a86c00a86e00a86f00a87100a87201a87401a87501a87701a8"
    "7801a87a02a87b02a87d03a87e03a88004a88104a78305a78405a78606a68707a68808a68a09a58b0aa58d0ba58e0ca48f0da4910ea3920fa39410a2"
    "9511a19613a19814a099159f9a169f9c179e9d189d9e199da01a9ca11b9ba21d9aa31e9aa51f99a62098a72197a82296aa2395ab2494ac2694ad2793"
    "ae2892b02991b12a90b22b8fb32c8eb42e8db52f8cb6308bb7318ab83289ba3388bb3488bc3587bd3786be3885bf3984c03a83c13b82c23c81c33d80"
    "c43e7fc5407ec6417dc7427cc8437bc9447aca457acb4679cc4778cc4977cd4a76ce4b75cf4c74d04d73d14e72d24f71d35171d45270d5536fd5546e"
    "d6556dd7566cd8576bd9586ada5a6ada5b69db5c68dc5d67dd5e66de5f65de6164df6263e06363e16462e26561e26660e3685fe4695ee56a5de56b5d"
    "e66c5ce76e5be76f5ae87059e97158e97257ea7457eb7556eb7655ec7754ed7953ed7a52ee7b51ef7c51ef7e50f07f4ff0804ef1814df1834cf2844b"
    "f3854bf3874af48849f48948f58b47f58c46f68d45f68f44f79044f79143f79342f89441f89540f9973ff9983ef99a3efa9b3dfa9c3cfa9e3bfb9f3a"
    "fba139fba238fca338fca537fca636fca835fca934fdab33fdac33fdae32fdaf31fdb130fdb22ffdb42ffdb52efeb72dfeb82cfeba2cfebb2bfebd2a"
    "febe2afec029fdc229fdc328fdc527fdc627fdc827fdca26fdcb26fccd25fcce25fcd025fcd225fbd324fbd524fbd724fad824fada24f9dc24f9dd25"
    "f8df25f8e125f7e225f7e425f6e626f6e826f5e926f5eb27f4ed27f3ee27f3f027f2f227f1f426f1f525f0f724f0f921";

constexpr std::string_view kInferno =
    "00000401010802020e04031407051b0a07220d0829110a30150b37190c3e1e0c45230c4c280b532d0b59320a5e3809623d0965420a68470b6a4c0c6b"
    "510e6c550f6d5a116e5f136e64156e69166e6d186e721a6e771c6d7c1d6d801f6c85216b8a226a8f24699326679827669d2964a22b62a62d60ab2f5e"
    "b0315bb43359b93556bd3853c13a50c63d4dca404ace4347d24644d54a41d94d3ddd513ae05536e35933e65d2fe9612beb6628ee6a24f06f20f2741c"
    "f47918f67e14f78410f8890cf98e09fa9407fb9906fc9f07fca50afcaa0ffcb014fbb61afbbc21fac228f9c72ff8cd37f7d340f5d949f4df53f3e55d"
    "f2ea69f1ef75f2f482f4f88ef8fb9afcffa4";

constexpr std::string_view kMagma =
    "00000401010802020d04041406051a0907200c0926100b2d130d34160f3b1a10421e11492211502712582c115f31116536106b3b0f70400f74451077"
    "4a10794f127b54137d59157e5d177f621980671b806b1d81701f817521817922827e24828326818827818c2981912b81962c809b2e7fa02f7fa5317e"
    "aa337dae347bb3367ab83779bd3977c23b75c73d73cc3f71d0416fd5446dd9466bde4968e24d66e55064e95462ec5860ef5d5ef2625df4675cf66c5c"
    "f7725cf9785dfa7d5efb835ffc8961fc8e64fd9467fd9a6afe9f6dfea571feaa74feb078feb67cfebb81fec185fec68afecc8ffed194fed799fddc9e"
    "fde2a3fde7a9fcecaefcf2b4fcf7b9fcfdbf";

constexpr std::string_view kBatlow =
    "011959041e5a07225b09275c0b2b5c0c2f5d0d335e0e375e0f3b5f103e5f114160114460124761134a61144d62154f621752621855621a57621c5a62"
    "1e5d62215f6124616027635f2b655e2f675c33695a376b583b6d563f6e5444705248714f4d734d52744a5776475b7745607942657a3f6a7b3d6f7d3a"
    "747e387980357f81338483318a842f8f862d95872c9b892ba18a2ba78b2cad8c2db38e2fb98f32be9035c49138ca923ccf9340d49445d9954ade964f"
    "e39754e7985aeb9a60ef9b67f29d6df59f74f8a17bf9a382fba689fca890fdaa97fdac9efdafa5fdb1abfdb3b1fdb5b8fdb7befdbac4fdbccbfcbed1"
    "fcc0d8fcc3dffcc5e5fbc7ecfbcaf3faccfa";

constexpr std::string_view kVik =
    "001261011764021c6702206a02256d022a70022e73023376023779033c7c03417f034582034a85044f8806548b08598f0c5e921164961769991e6f9d"
    "2575a12d7ba53681a93f87ad488db25194b65a9aba64a0be6da6c277acc680b2ca8ab8ce94bed29dc4d6a7c9dab0cfdebad5e2c3dae5ccdfe8d5e3e9"
    "dee6e9e5e7e8eae6e4ede4deeee0d8eedbd0edd5c8ebd0c0e9cab8e6c4b0e4bea8e1b8a0dfb298dcac90daa688d7a081d59b79d39572d0906bce8b64"
    "cc855dc98056c77b4fc57548c27041c06b3abe6533bb602db75a26b3531faf4c18a94512a33e0d9c37099631078f2b068926068321067e1d06781806"
    "7314066d1007680c076307075e0308590008";

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
