// Unit quaternions as orientations, as far as a camera's path needs them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace isostrata::client {

struct Quaternion {
  double w = 1, x = 0, y = 0, z = 0;
};

inline Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
inline Quaternion operator-(const Quaternion& q) { return {-q.w, -q.x, -q.y, -q.z}; }
inline Quaternion inverse(const Quaternion& q) { return {q.w, -q.x, -q.y, -q.z}; }
inline double dot(const Quaternion& a, const Quaternion& b) { return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z; }

/// The one of q and -q, the same orientation, that is nearer to `to`.
inline Quaternion nearer(const Quaternion& q, const Quaternion& to) { return dot(q, to) < 0 ? -q : q; }

/// Of a unit quaternion: half its angle times its axis.
inline std::array<double, 3> log(const Quaternion& q) {
  const double s = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z);
  const double scale = s < 1e-12 ? 1 : std::atan2(s, q.w) / s;
  return {q.x * scale, q.y * scale, q.z * scale};
}
inline Quaternion exp(const std::array<double, 3>& v) {
  const double angle = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  const double scale = angle < 1e-12 ? 1 : std::sin(angle) / angle;
  return {std::cos(angle), v[0] * scale, v[1] * scale, v[2] * scale};
}

/// On the great circle from a to b.
inline Quaternion slerp(const Quaternion& a, const Quaternion& b, double u) {
  auto step = log(inverse(a) * b);
  for (double& c : step) c *= u;
  return a * exp(step);
}

/// From the axes of a right-handed orthonormal frame, the columns of its matrix (K. Shoemake, 1985).
inline Quaternion from_axes(const std::array<double, 3>& x, const std::array<double, 3>& y, const std::array<double, 3>& z) {
  const double trace = x[0] + y[1] + z[2];
  Quaternion q;
  if (trace > 0) {
    const double s = 2 * std::sqrt(trace + 1);
    q = {s / 4, (y[2] - z[1]) / s, (z[0] - x[2]) / s, (x[1] - y[0]) / s};
  } else if (x[0] >= y[1] && x[0] >= z[2]) {
    const double s = 2 * std::sqrt(1 + x[0] - y[1] - z[2]);
    q = {(y[2] - z[1]) / s, s / 4, (y[0] + x[1]) / s, (z[0] + x[2]) / s};
  } else if (y[1] >= z[2]) {
    const double s = 2 * std::sqrt(1 + y[1] - x[0] - z[2]);
    q = {(z[0] - x[2]) / s, (y[0] + x[1]) / s, s / 4, (z[1] + y[2]) / s};
  } else {
    const double s = 2 * std::sqrt(1 + z[2] - x[0] - y[1]);
    q = {(x[1] - y[0]) / s, (z[0] + x[2]) / s, (z[1] + y[2]) / s, s / 4};
  }
  const double length = std::sqrt(dot(q, q));
  return {q.w / length, q.x / length, q.y / length, q.z / length};
}

inline std::array<double, 3> rotated(const Quaternion& q, const std::array<double, 3>& v) {
  const Quaternion r = q * Quaternion{0, v[0], v[1], v[2]} * inverse(q);
  return {r.x, r.y, r.z};
}

}  // namespace isostrata::client
