#include "rendering/annotations/glyphs.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "rendering/annotations/other_fonts.h"

namespace isostrata {
namespace {

/// All that is drawn of a text, as bytes.
std::vector<std::uint8_t> drawn(const std::string& text) {
  std::vector<std::uint8_t> bytes;
  Font().draw(text, 40, 0, 50, 0, [&](const GlyphMask& mask) {
    for (int row = 0; row < mask.height; ++row)
      bytes.insert(bytes.end(), mask.coverage + static_cast<std::size_t>(row) * mask.stride, mask.coverage + static_cast<std::size_t>(row) * mask.stride + mask.width);
  });
  return bytes;
}

TEST(Glyphs, LettersOfManyScriptsAreNoBoxes) {
  const auto box = drawn("\U0010fffd");  // nobody's letter
  for (const char* letter : {"a", "\u00e9", "\u03bc", "\u03a9", "\u0416", "\u0448", "\u05d0", "\u00b0"}) EXPECT_NE(drawn(letter), box) << letter;
}

TEST(Glyphs, ALetterThatTheOwnFontLacksIsDrawnByAnotherFontOfTheMachine) {
  // Two that DejaVu Sans Mono has, of the package that DejaVu Sans is in, and DejaVu Sans has not.
  const auto first = drawn("\u2336"), second = drawn("\u2339");
  EXPECT_FALSE(font_with(U'\u2336').empty());
  EXPECT_NE(first, second);
  EXPECT_EQ(drawn("\U0010fffd"), drawn("\U0010fffc")) << "boxes are alike";
  EXPECT_NE(first, drawn("\U0010fffd"));
  const Font font;
  EXPECT_GT(font.width("a\u2336b", 40), font.width("ab", 40) + 10) << "it has its own width between letters of the other font";
}

}  // namespace
}  // namespace isostrata
