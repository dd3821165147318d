#include "rendering/annotations/glyphs.h"

#include <ft2build.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "base/error.h"
#include "rendering/annotations/other_fonts.h"
#include FT_FREETYPE_H
#include FT_GLYPH_H
#include FT_OUTLINE_H
#include FT_STROKER_H

// The font's file, taken in by the assembler (CMakeLists.txt names it).
asm(".pushsection .rodata\n"
    ".balign 16\n"
    ".global isostrata_font_begin\n"
    "isostrata_font_begin:\n"
    ".incbin \"" ISOSTRATA_FONT
    "\"\n"
    ".global isostrata_font_end\n"
    "isostrata_font_end:\n"
    ".byte 0\n"
    ".popsection\n");
extern "C" const unsigned char isostrata_font_begin[];
extern "C" const unsigned char isostrata_font_end[];

namespace isostrata {
namespace {

/// The next code point of UTF-8; '?' for a byte that begins none.
char32_t next_code_point(std::string_view& text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  const std::size_t length = lead < 0x80 ? 1 : lead >= 0xf0 && lead < 0xf8 ? 4 : lead >= 0xe0 ? 3 : lead >= 0xc2 ? 2 : 0;
  char32_t code = lead < 0x80 ? lead : length == 4 ? lead & 7u : length == 3 ? lead & 15u : lead & 31u;
  bool good = length > 0 && length <= text.size() && lead < 0xf8;
  for (std::size_t i = 1; good && i < length; ++i) {
    good = (byte(i) & 0xc0) == 0x80;
    code = code << 6 | (byte(i) & 0x3fu);
  }
  text.remove_prefix(good ? length : 1);
  return good && code >= 32 ? code : U'?';
}

constexpr int kSteps = 4;  // places of a glyph between two pixels

}  // namespace

struct Font::State {
  FT_Library library = nullptr;
  FT_Face face = nullptr;
  FT_Stroker stroker = nullptr;
  mutable std::map<std::string, FT_Face> others;  // by their files; null: one that does not open

  ~State() {
    if (stroker) FT_Stroker_Done(stroker);
    for (const auto& [file, other] : others)
      if (other) FT_Done_Face(other);
    if (face) FT_Done_Face(face);
    if (library) FT_Done_FreeType(library);
  }

  static void set_size(FT_Face face, double size) {
    const auto fixed = static_cast<FT_F26Dot6>(std::lround(std::clamp(size, 1.0, 2000.0) * 64));
    FT_Size_RequestRec request{FT_SIZE_REQUEST_TYPE_NOMINAL, fixed, fixed, 0, 0};
    FT_Request_Size(face, &request);
  }

  /// The program's own font if it has the character or nobody has.
  FT_Face face_with(char32_t character, double size) const {
    if (FT_Get_Char_Index(face, character) != 0) return face;
    const std::string file = font_with(character);
    if (file.empty()) return face;
    const auto [at, added] = others.emplace(file, nullptr);
    if (added && FT_New_Face(library, file.c_str(), 0, &at->second) != 0) at->second = nullptr;
    if (!at->second) return face;
    set_size(at->second, size);
    return at->second;
  }

  /// Calls each(x in pixels from the text's origin, glyph); returns the end of the last advance.
  template <class Each>
  double walk(std::string_view text, double size, const Each& each) const {
    set_size(face, size);
    double x = 0;
    FT_UInt before = 0;
    FT_Face face_before = nullptr;
    while (!text.empty()) {
      const char32_t character = next_code_point(text);
      const FT_Face of = face_with(character, size);
      const FT_UInt index = FT_Get_Char_Index(of, character);
      if (FT_Load_Glyph(of, index, FT_LOAD_NO_BITMAP | FT_LOAD_NO_HINTING) != 0) continue;
      FT_Vector kerning{0, 0};
      if (before && of == face_before) FT_Get_Kerning(of, before, index, FT_KERNING_UNFITTED, &kerning);
      x += static_cast<double>(kerning.x) / 64;
      const double advance = static_cast<double>(of->glyph->linearHoriAdvance) / 65536;
      each(x, of->glyph);
      x += advance;
      before = index;
      face_before = of;
    }
    return x;
  }
};

Font::Font() : state_(std::make_unique<State>()) {
  const auto size = static_cast<FT_Long>(isostrata_font_end - isostrata_font_begin);
  if (FT_Init_FreeType(&state_->library) != 0 ||
      FT_New_Memory_Face(state_->library, isostrata_font_begin, size, 0, &state_->face) != 0 ||
      FT_Stroker_New(state_->library, &state_->stroker) != 0)
    throw Error(ErrorCode::unavailable, "text: FreeType does not open the font");
}
Font::~Font() = default;

double Font::width(std::string_view text, double size) const {
  return state_->walk(text, size, [](double, FT_GlyphSlot) {});
}

double Font::cap_height(double size) const { return 0.729 * size; }  // of DejaVu Sans: 1493 of 2048 units

void Font::draw(std::string_view text, double size, double x, double y, double outline, const Put& put) const {
  const double baseline = std::round(y);
  state_->walk(text, size, [&](double offset, FT_GlyphSlot slot) {
    const double at = std::round((x + offset) * kSteps) / kSteps, whole = std::floor(at);
    FT_Glyph glyph = nullptr;
    if (FT_Get_Glyph(slot, &glyph) != 0) return;
    if (outline > 0) {
      FT_Stroker_Set(state_->stroker, static_cast<FT_Fixed>(outline * 64), FT_STROKER_LINECAP_ROUND, FT_STROKER_LINEJOIN_ROUND,
                     0);
      FT_Glyph_StrokeBorder(&glyph, state_->stroker, 0, 1);
    }
    FT_Vector shift{static_cast<FT_Pos>(std::lround((at - whole) * 64)), 0};
    if (FT_Glyph_To_Bitmap(&glyph, FT_RENDER_MODE_NORMAL, &shift, 1) == 0) {
      const auto* bitmap = reinterpret_cast<FT_BitmapGlyph>(glyph);
      const FT_Bitmap& mask = bitmap->bitmap;
      if (mask.width > 0 && mask.rows > 0 && mask.pitch > 0)
        put({static_cast<int>(whole) + bitmap->left, static_cast<int>(baseline) - bitmap->top, static_cast<int>(mask.width),
             static_cast<int>(mask.rows), mask.buffer, static_cast<std::size_t>(mask.pitch)});
    }
    FT_Done_Glyph(glyph);
  });
}

}  // namespace isostrata
