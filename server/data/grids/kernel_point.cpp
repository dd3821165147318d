#include "data/grids/kernel_point.h"

#include <cmath>
#include <utility>
#include <vector>

namespace isostrata {
namespace {

using Row = std::array<double, 4>;
using Matrix = std::array<Row, 4>;

/// Solves a x = b by elimination; false if a is singular.
bool solve(Matrix a, Row b, Row& x) {
  for (int c = 0; c < 4; ++c) {
    int pivot = c;
    for (int r = c + 1; r < 4; ++r)
      if (std::abs(a[r][c]) > std::abs(a[pivot][c])) pivot = r;
    if (std::abs(a[pivot][c]) < 1e-14) return false;
    std::swap(a[c], a[pivot]);
    std::swap(b[c], b[pivot]);
    for (int r = c + 1; r < 4; ++r) {
      const double factor = a[r][c] / a[c][c];
      for (int k = c; k < 4; ++k) a[r][k] -= factor * a[c][k];
      b[r] -= factor * b[c];
    }
  }
  for (int r = 3; r >= 0; --r) {
    x[r] = b[r];
    for (int k = r + 1; k < 4; ++k) x[r] -= a[r][k] * x[k];
    x[r] /= a[r][r];
  }
  return true;
}

Matrix transposed(const Matrix& a) {
  Matrix t;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) t[r][c] = a[c][r];
  return t;
}

struct Plane {
  Row row{};  // the outward unit normal, and 1 for t
  double offset = 0;
};

/// Positions in which the points are as wide in all directions: y = L^-1 (x - mean) with L L^T their covariance.
struct Scaling {
  Vec3d mean;
  std::array<Vec3d, 3> l;  // rows, lower triangular

  Vec3d apply(Vec3d x) const {
    const Vec3d d = x - mean;
    Vec3d y;
    y.x = d.x / l[0].x;
    y.y = (d.y - l[1].x * y.x) / l[1].y;
    y.z = (d.z - l[2].x * y.x - l[2].y * y.y) / l[2].z;
    return y;
  }
  Vec3d undo(Vec3d y) const { return mean + Vec3d{dot(l[0], y), dot(l[1], y), dot(l[2], y)}; }
};

std::optional<Scaling> scaling_of(std::span<const std::array<Vec3d, 3>> triangles) {
  Scaling s;
  const double n = 3.0 * static_cast<double>(triangles.size());
  for (const auto& t : triangles) s.mean = s.mean + (t[0] + t[1] + t[2]) / n;
  std::array<Vec3d, 3> c{};
  for (const auto& t : triangles)
    for (const Vec3d& p : t) {
      const Vec3d d = p - s.mean;
      for (int r = 0; r < 3; ++r) c[r] = c[r] + d * (d[r] / n);
    }
  for (int r = 0; r < 3; ++r)
    for (int k = 0; k <= r; ++k) {
      double sum = c[r][k];
      for (int i = 0; i < k; ++i) sum -= s.l[r][i] * s.l[k][i];
      if (k < r)
        s.l[r][k] = sum / s.l[k][k];
      else if (sum > 0)
        s.l[r][r] = std::sqrt(sum);
      else
        return std::nullopt;  // all in one plane
    }
  return s;
}

}  // namespace

std::optional<Vec3d> kernel_point(std::span<const std::array<Vec3d, 3>> triangles) {
  if (triangles.empty()) return std::nullopt;
  const auto scaling = scaling_of(triangles);
  if (!scaling) return std::nullopt;
  // First the far tetrahedron; its normals add up to nothing, which is what a first solution of the dual needs.
  constexpr double kFar = 1e3;
  const double s = 1 / std::sqrt(3.0);
  std::vector<Plane> planes{{{s, s, s, 1}, kFar}, {{s, -s, -s, 1}, kFar}, {{-s, s, -s, 1}, kFar}, {{-s, -s, s, 1}, kFar}};
  for (const auto& t : triangles) {
    const Vec3d a = scaling->apply(t[0]), b = scaling->apply(t[1]), c = scaling->apply(t[2]);
    const Vec3d normal = cross(b - a, c - a);
    const double size = length(normal);
    if (!(size > 1e-12)) continue;
    const Vec3d n = normal / size;
    planes.push_back({{n.x, n.y, n.z, 1}, dot(n, a)});
  }

  std::array<std::size_t, 4> basis{0, 1, 2, 3};
  for (int step = 0; step < 500; ++step) {
    Matrix rows;
    Row offsets, x, y, lambda;
    for (int i = 0; i < 4; ++i) {
      rows[i] = planes[basis[i]].row;
      offsets[i] = planes[basis[i]].offset;
    }
    if (!solve(rows, offsets, x)) return std::nullopt;
    std::size_t entering = 0;
    double worst = 1e-12;
    for (std::size_t k = 0; k < planes.size(); ++k) {
      const Row& r = planes[k].row;
      const double excess = r[0] * x[0] + r[1] * x[1] + r[2] * x[2] + x[3] - planes[k].offset;
      if (excess > worst) {
        worst = excess;
        entering = k;
      }
    }
    if (worst == 1e-12) {
      if (!(x[3] > 0)) return std::nullopt;
      return scaling->undo({x[0], x[1], x[2]});
    }
    const Matrix columns = transposed(rows);
    if (!solve(columns, {0, 0, 0, 1}, y) || !solve(columns, planes[entering].row, lambda)) return std::nullopt;
    int leaving = -1;
    for (int i = 0; i < 4; ++i)
      if (lambda[i] > 1e-12 && (leaving < 0 || y[i] * lambda[leaving] < y[leaving] * lambda[i])) leaving = i;
    if (leaving < 0) return std::nullopt;
    basis[leaving] = entering;
  }
  return std::nullopt;
}

}  // namespace isostrata
