// The frame that the page decodes at start, from the page's own source.
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
  std::ifstream file(isostrata::places::source() + "/web/src/lib/probe-stream.ts");
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

void expect_known_picture(const Bytes& stream, const std::vector<std::array<int, 3>>& known) {
  const Image image = make_decoder(Codec::vp9_444)->decode(stream);
  ASSERT_EQ(image.width, kSide);
  ASSERT_EQ(image.height, kSide);
  for (int block = 0; block < 16; ++block) {
    const int x = block % 4 * kBlock + kBlock / 2, y = block / 4 * kBlock + kBlock / 2;
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(image.rgba[static_cast<std::size_t>(4 * (y * kSide + x)) + c], known[static_cast<std::size_t>(block)][c], 4)
          << "block " << block;
  }
  int worst = 0;  // over every pixel: small only with full chroma
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        const int block = std::max(0, (y - 1) / kBlock) * 4 + std::max(0, (x - 1) / kBlock);
        worst = std::max(worst, std::abs(image.rgba[static_cast<std::size_t>(4 * (y * kSide + x)) + c] -
                                         known[static_cast<std::size_t>(block)][c]));
      }
  EXPECT_LT(worst, 20);
}

TEST(ProbeStream, DecodesToTheKnownPictureAndNamesItsFormat) {
  const std::string text = source();
  const auto known = colors(text);
  ASSERT_EQ(known.size(), 16u);
  std::smatch stream;
  ASSERT_TRUE(std::regex_search(text, stream, std::regex(R"(format: '([^']*)',\s*codec: '([^']*)',\s*base64:\s*'([^']*)')")));
  EXPECT_EQ(stream[1].str(), name_of(Codec::vp9_444));
  EXPECT_EQ(stream[2].str(), "vp09.01.10.08.03.01.13.06.00");
  expect_known_picture(from_base64(stream[3].str()), known);
}

}  // namespace
}  // namespace isostrata
