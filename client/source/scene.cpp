#include "isostrata/scene.h"

#include <charconv>
#include <cmath>

#include "isostrata/options.h"

namespace isostrata::client {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180;

Vec3 array_of(const v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }
Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 scaled(const Vec3& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
Vec3 sum(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec3 unit(const Vec3& a) { return scaled(a, 1 / std::sqrt(dot(a, a))); }

// O. Rodrigues' formula; the axis has unit length.
Vec3 rotated(const Vec3& v, const Vec3& axis, double radians) {
  const double c = std::cos(radians), s = std::sin(radians);
  return sum(sum(scaled(v, c), scaled(cross(axis, v), s)), scaled(axis, dot(axis, v) * (1 - c)));
}

}  // namespace

v1::Rgb rgb(const std::string& text) {
  unsigned value = 0;
  const bool hash = text.size() == 7 && text[0] == '#';
  const char* end = text.data() + text.size();
  if (!hash) throw ClientError("bad_argument", "colour '" + text + "': expected #rrggbb");
  if (const auto [at, error] = std::from_chars(text.data() + 1, end, value, 16); error != std::errc{} || at != end)
    throw ClientError("bad_argument", "colour '" + text + "': expected #rrggbb");
  v1::Rgb color;
  color.set_r(static_cast<float>(value >> 16 & 255) / 255);
  color.set_g(static_cast<float>(value >> 8 & 255) / 255);
  color.set_b(static_cast<float>(value & 255) / 255);
  return color;
}

v1::Vec3 vec3(const Vec3& xyz) {
  v1::Vec3 out;
  out.set_x(xyz[0]);
  out.set_y(xyz[1]);
  out.set_z(xyz[2]);
  return out;
}

v1::Surface surface(const SurfaceLook& look) {
  v1::Surface out;
  out.set_lower(look.lower);
  out.set_upper(look.upper);
  out.set_domain(look.domain);
  if (!look.color.empty()) *out.mutable_color() = rgb(look.color);
  if (look.opacity) out.set_opacity(*look.opacity);
  if (look.ambient) out.set_ambient(*look.ambient);
  if (look.diffuse) out.set_diffuse(*look.diffuse);
  if (look.specular) out.set_specular(*look.specular);
  if (look.shininess) out.set_shininess(*look.shininess);
  out.set_silhouette(look.silhouette);
  out.set_texture(look.texture);
  if (look.texture_repeat) out.set_texture_repeat(*look.texture_repeat);
  return out;
}

v1::Interval interval(double lower, double upper, const IntervalLook& look) {
  v1::Interval out;
  out.set_lower(lower);
  out.set_upper(upper);
  if (!look.color.empty()) *out.mutable_color() = rgb(look.color);
  out.set_color_map(look.color_map);
  out.set_opacity(look.opacity);
  if (look.opacity_upper) out.set_opacity_upper(*look.opacity_upper);
  out.set_own_range(look.own_range);
  out.set_priority(look.priority);
  out.set_visible(look.visible);
  out.set_name(look.name);
  if (look.surface) *out.mutable_surface() = surface(*look.surface);
  return out;
}

v1::RangeTerm range_term(v1::RangeOperator op, const std::string& array, double lower, double upper) {
  v1::RangeTerm out;
  out.set_op(op);
  out.set_array(array);
  out.set_lower(lower);
  out.set_upper(upper);
  return out;
}

v1::TransferPoint transfer_point(double value, const std::string& color, double opacity) {
  v1::TransferPoint out;
  out.set_value(value);
  *out.mutable_color() = rgb(color);
  out.set_opacity(opacity);
  return out;
}

v1::ClipPlane clip_plane(const Vec3& normal, double offset) {
  v1::ClipPlane out;
  *out.mutable_normal() = vec3(normal);
  out.set_offset(offset);
  return out;
}

v1::Camera camera(const Vec3& eye, const Vec3& at, const Vec3& up, double fov_deg, bool orthographic) {
  v1::Camera out;
  *out.mutable_eye() = vec3(eye);
  *out.mutable_at() = vec3(at);
  *out.mutable_up() = vec3(up);
  out.set_fov_deg(fov_deg);
  out.set_orthographic(orthographic);
  return out;
}

v1::Camera turned(const v1::Camera& camera, double azimuth_deg, double elevation_deg) {
  const Vec3 at = array_of(camera.at());
  Vec3 back = sum(array_of(camera.eye()), scaled(at, -1));
  Vec3 up = unit(array_of(camera.up()));
  back = rotated(back, up, azimuth_deg * kRadians);
  const Vec3 right = unit(cross(up, back));
  back = rotated(back, right, -elevation_deg * kRadians);
  up = rotated(up, right, -elevation_deg * kRadians);
  v1::Camera out = camera;
  *out.mutable_eye() = vec3(sum(at, back));
  *out.mutable_up() = vec3(up);
  return out;
}

v1::Camera zoomed(const v1::Camera& camera, double factor) {
  const Vec3 at = array_of(camera.at());
  v1::Camera out = camera;
  *out.mutable_eye() = vec3(sum(at, scaled(sum(array_of(camera.eye()), scaled(at, -1)), 1 / factor)));
  return out;
}

}  // namespace isostrata::client
