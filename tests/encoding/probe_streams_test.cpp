// The streams that the page decodes at start, from the page's own source.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <regex>

#include "encoding/decoder.h"
#include "encoding/encoder.h"
#include "support/places.h"

namespace isostrata {
namespace {

constexpr int kSide = 64, kBlock = kSide / 4;  // edges at 17, 33 and 49

std::string source() {
  std::ifstream file(isostrata::places::source() + "/web/src/lib/probe-streams.ts");
  return {std::istreambuf_iterator<char>(file), {}};
}

Bytes from_base64(const std::string& text) {
  static const std::string kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  Bytes out;
  unsigned bits = 0, count = 0;
  for (const char c : text) {
    const auto value = kAlphabet.find(c);
    if (value == std::string::npos) break;
    bits = bits << 6 | static_cast<unsigned>(value);
    if (++count % 4 != 1) out.push_back(static_cast<std::uint8_t>(bits >> (count % 4 == 2 ? 4 : count % 4 == 3 ? 2 : 0)));
  }
  return out;
}

std::vector<std::array<int, 3>> colors(const std::string& text) {
  std::vector<std::array<int, 3>> out;
  const std::regex color(R"(\n  \[(\d+), (\d+), (\d+)\],)");
  for (std::sregex_iterator at(text.begin(), text.end(), color), end; at != end; ++at)
    out.push_back({std::stoi((*at)[1]), std::stoi((*at)[2]), std::stoi((*at)[3])});
  return out;
}

void expect_known_picture(const Bytes& stream, Codec codec, const std::vector<std::array<int, 3>>& known) {
  const Image image = make_decoder(codec)->decode(stream);
  ASSERT_EQ(image.width, kSide);
  ASSERT_EQ(image.height, kSide);
  for (int block = 0; block < 16; ++block) {
    const int x = block % 4 * kBlock + kBlock / 2, y = block / 4 * kBlock + kBlock / 2;
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(image.rgba[static_cast<std::size_t>(4 * (y * kSide + x)) + c], known[static_cast<std::size_t>(block)][c], 4)
          << name_of(codec) << ", block " << block;
  }
  int worst = 0;  // over every pixel: small only with full chroma
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        const int block = std::max(0, (y - 1) / kBlock) * 4 + std::max(0, (x - 1) / kBlock);
        worst = std::max(worst, std::abs(image.rgba[static_cast<std::size_t>(4 * (y * kSide + x)) + c] -
                                         known[static_cast<std::size_t>(block)][c]));
      }
  if (codec == Codec::vp9_444)
    EXPECT_LT(worst, 20);
  else
    EXPECT_GT(worst, 60);
}

TEST(ProbeStreams, DecodeToTheKnownPictureAndNameTheirFormats) {
  const std::string text = source();
  const auto known = colors(text);
  ASSERT_EQ(known.size(), 16u);
  const std::regex stream(R"(format: '([^']*)',\s*codec: '([^']*)',\s*fullChroma: (\w+),\s*base64:\s*'([^']*)')");
  std::vector<std::string> formats;
  for (std::sregex_iterator at(text.begin(), text.end(), stream), end; at != end; ++at) {
    formats.push_back((*at)[1]);
    const auto codec = codec_named(formats.back());
    ASSERT_TRUE(codec) << formats.back();
    EXPECT_EQ((*at)[3] == "true", *codec == Codec::vp9_444);
    const auto& have = moving_codecs();
    if (std::find(have.begin(), have.end(), *codec) != have.end()) expect_known_picture(from_base64((*at)[4]), *codec, known);
  }
  EXPECT_EQ(formats, (std::vector<std::string>{"vp9-444", "h264-420"}));
}

}  // namespace
}  // namespace isostrata
