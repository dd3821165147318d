// Text as coverage masks. The font (DejaVu Sans) is part of the program, so no machine needs one; what it has not is drawn by a font of the machine
// (other_fonts.h), or as a box. FreeType fills the outlines.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

namespace isostrata {

/// Coverage of one glyph: [height][width] of 0..255, its upper left pixel at (x, y) of the picture.
struct GlyphMask {
  int x = 0, y = 0, width = 0, height = 0;
  const std::uint8_t* coverage = nullptr;
  std::size_t stride = 0;
};

/// One thread at a time; making one takes a tenth of a millisecond.
class Font {
 public:
  /// Throws unavailable if FreeType refuses.
  Font();
  ~Font();

  /// Pixels from the first glyph's origin to the end of the last one's advance. UTF-8; bytes that are none count as "?".
  double width(std::string_view text, double size) const;
  /// Of a capital letter, above the baseline.
  double cap_height(double size) const;

  using Put = std::function<void(const GlyphMask&)>;
  /// Masks of the glyphs with the baseline's beginning at (x, y), y down; outline > 0: of the letters grown by so many pixels.
  void draw(std::string_view text, double size, double x, double y, double outline, const Put& put) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isostrata
