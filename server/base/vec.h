// Small vectors, boxes and 4x4 matrices. Matrices are column-major and act on column vectors: clip = clip_from_world * world.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace isostrata {

template <class T>
struct Vec3 {
  T x{}, y{}, z{};

  constexpr T& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  constexpr const T& operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  constexpr bool operator==(const Vec3&) const = default;
};
using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;

template <class T>
constexpr Vec3<T> operator+(Vec3<T> a, Vec3<T> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
constexpr Vec3<T> operator-(Vec3<T> a, Vec3<T> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
constexpr Vec3<T> operator*(Vec3<T> a, T s) {
  return {a.x * s, a.y * s, a.z * s};
}
template <class T>
constexpr Vec3<T> operator*(T s, Vec3<T> a) {
  return a * s;
}
template <class T>
constexpr Vec3<T> operator/(Vec3<T> a, T s) {
  return {a.x / s, a.y / s, a.z / s};
}
template <class T>
constexpr T dot(Vec3<T> a, Vec3<T> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
constexpr Vec3<T> cross(Vec3<T> a, Vec3<T> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T length(Vec3<T> a) {
  return std::sqrt(dot(a, a));
}
template <class T>
Vec3<T> normalized(Vec3<T> a) {
  return a / length(a);
}
template <class T>
constexpr Vec3<T> lerp(Vec3<T> a, Vec3<T> b, T t) {
  return a + (b - a) * t;
}

/// Six times the signed volume of the tetrahedron abcd: positive if (b-a, c-a, d-a) is right-handed.
template <class T>
constexpr T orient3d(Vec3<T> a, Vec3<T> b, Vec3<T> c, Vec3<T> d) {
  return dot(cross(b - a, c - a), d - a);
}

/// An axis-aligned box; empty until it includes a point.
struct Box3d {
  Vec3d lower{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
              std::numeric_limits<double>::infinity()};
  Vec3d upper{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
              -std::numeric_limits<double>::infinity()};

  bool empty() const { return !(lower.x <= upper.x); }
  void include(Vec3d p) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  Vec3d center() const { return (lower + upper) * 0.5; }
  double diagonal() const { return empty() ? 0.0 : length(upper - lower); }
};

/// Axis by axis.
constexpr Vec3d scaled(Vec3d place, Vec3d factors) { return {place.x * factors.x, place.y * factors.y, place.z * factors.z}; }
inline Box3d scaled(const Box3d& box, Vec3d factors) { return box.empty() ? box : Box3d{scaled(box.lower, factors), scaled(box.upper, factors)}; }

/// m[column][row].
struct Mat4d {
  std::array<std::array<double, 4>, 4> m{};

  static constexpr Mat4d identity() {
    Mat4d r;
    for (int i = 0; i < 4; ++i) r.m[i][i] = 1.0;
    return r;
  }
};

inline Mat4d operator*(const Mat4d& a, const Mat4d& b) {
  Mat4d r;
  for (int c = 0; c < 4; ++c)
    for (int k = 0; k < 4; ++k)
      for (int i = 0; i < 4; ++i) r.m[c][i] += a.m[k][i] * b.m[c][k];
  return r;
}

inline std::array<double, 4> operator*(const Mat4d& a, const std::array<double, 4>& v) {
  std::array<double, 4> r{};
  for (int c = 0; c < 4; ++c)
    for (int i = 0; i < 4; ++i) r[i] += a.m[c][i] * v[c];
  return r;
}

}  // namespace isostrata
