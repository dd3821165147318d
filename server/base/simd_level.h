// Which vector instructions our kernels use: the best that the machine has, or what somebody asks for.
//
// Every level gives the same mesh bit by bit, and pictures that differ by rounding. What other libraries choose for themselves
// (libvpx, libjpeg, VTK) is not touched.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace isostrata {

/// The levels of this machine, best first: of "avx512", "avx2", "sse4" and "emulated" (what every processor has); on other
/// processors the name of their own instead ("neon").
std::vector<std::string> simd_levels();

/// The level in use.
std::string simd_level();

/// "auto", or a level's name. Before threads run kernels. Programs that this one starts are given it by ISOSTRATA_SIMD. Throws
/// invalid_argument for what is not a level, unavailable for what the machine does not have.
void use_simd_level(std::string_view name);

/// use_simd_level of $ISOSTRATA_SIMD, if it is there and not empty. The error names the variable.
void use_simd_level_of_environment();

}  // namespace isostrata
