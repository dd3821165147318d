// What a renderer asks of its input before it draws, whichever renderer it is.
#pragma once

#include "rendering/picture/renderer.h"

namespace isostrata {

inline constexpr int kMaxImageSize = 16384;
inline constexpr int kMaxWholeSize = 4 * kMaxImageSize;  // of a picture that is drawn in parts

/// Throws invalid_argument, naming what is wrong.
void check(const DrawInput& input);

/// Whether nothing that is drawn has a colour or an opacity that runs.
bool all_constant(const DrawInput& input);
/// And nothing is shaded inside: what a ray sees of an interior depends on where it enters and leaves, and on nothing between.
bool drawn_by_facets(const DrawInput& input);

}  // namespace isostrata
