#include "encoding/picture_distance.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"

namespace isostrata {
namespace {

constexpr int kWindow = 8, kStep = 4;

std::vector<float> luma_of(const Image& image) {
  std::vector<float> luma(image.rgba.size() / 4);
  for (std::size_t i = 0; i < luma.size(); ++i) {
    const std::uint8_t* p = &image.rgba[4 * i];
    luma[i] = 0.299f * p[0] + 0.587f * p[1] + 0.114f * p[2];
  }
  return luma;
}

struct Sums {
  double ssim = 0, squares = 0;
  std::int64_t windows = 0;
  int max = 0;
};

void add_window(const float* a, const float* b, int stride, Sums& to) {
  float sum_a = 0, sum_b = 0, aa = 0, bb = 0, ab = 0;
  for (int y = 0; y < kWindow; ++y)
    for (int x = 0; x < kWindow; ++x) {
      const float u = a[y * stride + x] - a[0], v = b[y * stride + x] - a[0];  // about a value near both means: floats suffice
      sum_a += u, sum_b += v, aa += u * u, bb += v * v, ab += u * v;
    }
  if (aa == 0 && bb == 0) return;
  constexpr double n = kWindow * kWindow, c1 = 0.01 * 255 * 0.01 * 255, c2 = 0.03 * 255 * 0.03 * 255;
  const double mean_a = sum_a / n + a[0], mean_b = sum_b / n + a[0];
  const double var_a = (aa - sum_a * sum_a / n) / (n - 1), var_b = (bb - sum_b * sum_b / n) / (n - 1);
  const double covariance = (ab - sum_a * sum_b / n) / (n - 1);
  to.ssim +=
      (2 * mean_a * mean_b + c1) * (2 * covariance + c2) / ((mean_a * mean_a + mean_b * mean_b + c1) * (var_a + var_b + c2));
  ++to.windows;
}

}  // namespace

PictureDistance picture_distance(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height || a.rgba.size() != b.rgba.size())
    throw Error(ErrorCode::invalid_argument, "pictures of " + std::to_string(a.width) + "x" + std::to_string(a.height) + " and " +
                                                 std::to_string(b.width) + "x" + std::to_string(b.height) +
                                                 " cannot be compared");
  const std::vector<float> luma_a = luma_of(a), luma_b = luma_of(b);
  Sums sums;
  std::mutex adding;
  parallel_for((a.height + kStep - 1) / kStep, 8, [&](std::int64_t begin, std::int64_t end) {
    Sums own;
    for (auto row = static_cast<int>(begin) * kStep; row < static_cast<int>(end) * kStep && row < a.height; ++row) {
      const auto first = static_cast<std::size_t>(row) * static_cast<std::size_t>(a.width);
      for (std::size_t i = 4 * first; i < 4 * (first + static_cast<std::size_t>(a.width)); ++i) {
        if (i % 4 == 3) continue;
        const int apart = std::abs(a.rgba[i] - b.rgba[i]);
        own.max = std::max(own.max, apart);
        own.squares += static_cast<double>(apart * apart);
      }
      if (row % kStep != 0 || row + kWindow > a.height) continue;
      for (int x = 0; x + kWindow <= a.width; x += kStep)
        add_window(&luma_a[first + static_cast<std::size_t>(x)], &luma_b[first + static_cast<std::size_t>(x)], a.width, own);
    }
    const std::lock_guard lock(adding);
    sums.ssim += own.ssim, sums.squares += own.squares, sums.windows += own.windows;
    sums.max = std::max(sums.max, own.max);
  });
  PictureDistance out;
  out.max = sums.max;
  if (sums.windows > 0) out.ssim = sums.ssim / static_cast<double>(sums.windows);
  if (sums.squares > 0)
    out.psnr = std::min(100.0, 10 * std::log10(255.0 * 255 * 0.75 * static_cast<double>(a.rgba.size()) / sums.squares));
  return out;
}

}  // namespace isostrata
