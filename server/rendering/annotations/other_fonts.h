// The fonts of this machine, for letters that the program's own has not: Chinese, Japanese, Korean and others.
#pragma once

#include <string>

namespace isostrata {

/// A font file with a glyph of this character, in the folders where systems keep their fonts; empty: there is none. Upright, regular faces without serifs come
/// first. What was found is remembered. So that names which somebody else makes up cost little, the folders are searched for a few dozen characters alone: after
/// that, what was found serves as far as it goes. Any thread.
std::string font_with(char32_t character);

}  // namespace isostrata
