// How far a decoded picture is from what was encoded.
#pragma once

#include "base/image.h"

namespace isostrata {

struct PictureDistance {
  double ssim = 1;    // of luma, in [-1, 1]
  double psnr = 100;  // over R, G and B, in dB; 100: equal
  int max = 0;        // of R, G and B
};

/// SSIM: Wang, Bovik, Sheikh and Simoncelli, "Image Quality Assessment: From Error Visibility to Structural Similarity", IEEE TIP
/// 2004, over windows of 8x8 pixels, four apart, unweighted, as x264 and libvpx count it. Windows where both pictures are of one
/// and the same colour are left out: an empty background must not make every codec good. Pictures of one size, which
/// invalid_argument says.
PictureDistance picture_distance(const Image& a, const Image& b);

}  // namespace isostrata
