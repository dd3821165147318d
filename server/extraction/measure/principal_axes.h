// The axes of a symmetric 3 x 3 matrix.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/vec.h"

namespace isostrata {

/// Of a matrix of second moments about the centre, xx, yy, zz, xy, xz, yz: its eigenvectors, that of the largest value first, each as long as the root of its
/// value (negative ones, which are rounding, count as 0) and turned so that its largest coordinate is positive. By Jacobi's rotations.
inline std::array<Vec3d, 3> principal_axes(const std::array<double, 6>& moments) {
  constexpr int kSweeps = 50;
  double a[3][3] = {{moments[0], moments[3], moments[4]}, {moments[3], moments[1], moments[5]}, {moments[4], moments[5], moments[2]}};
  Vec3d vectors[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int sweep = 0; sweep < kSweeps && std::abs(a[0][1]) + std::abs(a[0][2]) + std::abs(a[1][2]) > 0; ++sweep)
    for (const auto& [p, q] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
      if (a[p][q] == 0) continue;
      const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
      const double t = (theta < 0 ? -1 : 1) / (std::abs(theta) + std::hypot(theta, 1.0)), c = 1 / std::hypot(t, 1.0), s = t * c;
      const int r = 3 - p - q;
      const double pq = a[p][q], rp = a[r][p], rq = a[r][q];
      a[p][p] -= t * pq;
      a[q][q] += t * pq;
      a[p][q] = a[q][p] = 0;
      a[r][p] = a[p][r] = c * rp - s * rq;
      a[r][q] = a[q][r] = s * rp + c * rq;
      const Vec3d vp = vectors[p], vq = vectors[q];
      vectors[p] = vp * c - vq * s;
      vectors[q] = vp * s + vq * c;
    }
  std::array<int, 3> order{0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return a[i][i] > a[j][j]; });
  std::array<Vec3d, 3> axes;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d v = vectors[order[i]];
    const double largest = std::abs(v.x) >= std::abs(v.y) && std::abs(v.x) >= std::abs(v.z) ? v.x : std::abs(v.y) >= std::abs(v.z) ? v.y : v.z;
    axes[i] = v * ((largest < 0 ? -1 : 1) * std::sqrt(std::max(0.0, a[order[i]][order[i]])));
  }
  return axes;
}

}  // namespace isostrata
