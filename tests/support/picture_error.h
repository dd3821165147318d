// How far a picture is from the oracle's, in the figures that pictures are judged by.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/oracle.h"

namespace isostrata::testing {

struct PictureError {
  double max = 0, mean = 0;    // over pixels and channels, premultiplied
  double above_half_step = 0;  // share of channel values that are off by more than half an 8-bit step
  double ssim = 1;             // of the luminance over black
  double covered = 0;          // share of pixels with some opacity
  double max_depth = 0;        // of the bounds' diagonal, over pixels where both have a depth
  double depth_missing = 0;    // share of pixels where one has a depth and the other has none
  double mean_depth = 0;       // of the bounds' diagonal, premultiplied, the mean of all pixels
};

/// Mean structural similarity of two pictures in [0, 1] over all 8x8 windows (Z. Wang, A. Bovik, H. Sheikh, E. Simoncelli, "Image
/// Quality Assessment: From Error Visibility to Structural Similarity", 2004, with even weights).
inline double structural_similarity(const std::vector<double>& a, const std::vector<double>& b, int width, int height) {
  constexpr int kSide = 8;
  constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
  double sum = 0;
  std::int64_t windows = 0;
  for (int y = 0; y + kSide <= height; ++y)
    for (int x = 0; x + kSide <= width; ++x) {
      double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
      for (int v = y; v < y + kSide; ++v)
        for (int u = x; u < x + kSide; ++u) {
          const auto i = static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
          sa += a[i], sb += b[i], saa += a[i] * a[i], sbb += b[i] * b[i], sab += a[i] * b[i];
        }
      constexpr double n = kSide * kSide;
      const double ma = sa / n, mb = sb / n, va = saa / n - ma * ma, vb = sbb / n - mb * mb, cov = sab / n - ma * mb;
      sum += (2 * ma * mb + kC1) * (2 * cov + kC2) / ((ma * ma + mb * mb + kC1) * (va + vb + kC2));
      ++windows;
    }
  return windows > 0 ? sum / static_cast<double>(windows) : 1;
}

/// A channel that is not a number counts as 1e9.
inline PictureError picture_error(const OracleImage& expected, const FloatImage& image, double diagonal) {
  PictureError error;
  const std::size_t pixels = expected.rgba.size();
  std::vector<double> luminance[2];
  for (std::size_t i = 0; i < pixels; ++i) {
    error.covered += expected.rgba[i][3] > 0;
    for (std::size_t c = 0; c < 4; ++c) {
      const double d = std::abs(double{image.rgba[4 * i + c]} - expected.rgba[i][c]), e = std::isnan(d) ? 1e9 : d;
      error.max = std::max(error.max, e);
      error.mean += e;
      error.above_half_step += e > 0.5 / 255;
    }
    const auto brightness = [](auto r, auto g, auto b) { return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
    luminance[0].push_back(brightness(expected.rgba[i][0], expected.rgba[i][1], expected.rgba[i][2]));
    luminance[1].push_back(brightness(image.rgba[4 * i], image.rgba[4 * i + 1], image.rgba[4 * i + 2]));
    if (!image.mean_depth.empty()) error.mean_depth += std::abs(double{image.mean_depth[i]} - expected.mean_depth[i]) / diagonal;
    if (image.depth.empty()) continue;
    const bool here = std::isfinite(expected.depth[i]), there = std::isfinite(image.depth[i]);
    error.depth_missing += here != there;
    if (here && there)
      error.max_depth = std::max(error.max_depth, std::abs(double{image.depth[i]} - expected.depth[i]) / diagonal);
  }
  const auto count = static_cast<double>(pixels);
  error.mean /= 4 * count;
  error.mean_depth /= count;
  error.above_half_step /= 4 * count;
  error.covered /= count;
  error.depth_missing /= count;
  error.ssim = structural_similarity(luminance[0], luminance[1], expected.width, expected.height);
  return error;
}

}  // namespace isostrata::testing
