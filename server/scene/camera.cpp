#include "scene/camera.h"

#include <charconv>
#include <cmath>
#include <numbers>
#include <string>

#include "base/error.h"
#include "base/finite.h"

namespace isostrata {
namespace {

[[noreturn]] void refuse(std::string_view text, const std::string& why) {
  throw Error(ErrorCode::invalid_argument,
              "camera '" + std::string(text) + "': " + why +
                  "; expected eye=x,y,z;at=x,y,z;up=x,y,z;fov=degrees;projection=perspective|orthographic (any of them) or "
                  "reset, +x, -x, +y, -y, +z, -z");
}

double parse_number(std::string_view part, std::string_view whole) {
  double value = 0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
  if (error != std::errc{} || end != part.data() + part.size()) refuse(whole, "'" + std::string(part) + "' is not a number");
  return value;
}

Vec3d parse_vector(std::string_view part, std::string_view whole) {
  Vec3d v;
  for (int axis = 0; axis < 3; ++axis) {
    const auto comma = part.find(',');
    if ((comma == std::string_view::npos) != (axis == 2)) refuse(whole, "expected three numbers x,y,z");
    v[axis] = parse_number(part.substr(0, comma), whole);
    part.remove_prefix(comma == std::string_view::npos ? part.size() : comma + 1);
  }
  return v;
}

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// The direction from `at` to the eye, and what is up.
bool named_direction(std::string_view side, Vec3d& direction, Vec3d& up) {
  up = side == "reset" || side.ends_with('z') ? Vec3d{0, 1, 0} : Vec3d{0, 0, 1};
  if (side == "reset")
    direction = normalized(Vec3d{0.55, 0.45, 1.0});
  else if (side == "+x")
    direction = {1, 0, 0};
  else if (side == "-x")
    direction = {-1, 0, 0};
  else if (side == "+y")
    direction = {0, 1, 0};
  else if (side == "-y")
    direction = {0, -1, 0};
  else if (side == "+z")
    direction = {0, 0, 1};
  else if (side == "-z")
    direction = {0, 0, -1};
  else
    return false;
  return true;
}

/// Of a long box from its end, which in the sphere about it would be a dot: the middle of the box, or of its near end if parallel rays need no more distance than that,
/// and the eye, so far away that the box fits with a margin. Whether it is so long.
bool stand_before_end(Camera& camera, const Box3d& bounds, Vec3d direction, double aspect) {
  constexpr double kMargin = 1.05, kDot = 0.3;
  const Vec3d size = bounds.upper - bounds.lower, right = cross(camera.up, direction);
  const auto along = [&](Vec3d axis) { return std::abs(axis.x) * size.x + std::abs(axis.y) * size.y + std::abs(axis.z) * size.z; };
  if (std::max(along(camera.up), along(right)) > kDot * bounds.diagonal()) return false;
  const double half = std::max(along(camera.up), along(right) / std::max(aspect, 1e-3)) / 2 * kMargin, depth = along(direction) / 2;
  const double fit = std::max(half, 0.01 * depth) / std::tan(radians(camera.fov_deg / 2));
  if (camera.orthographic && fit < 2 * depth) camera.at = camera.at + direction * depth;
  camera.eye = camera.at + direction * (camera.orthographic ? fit : fit + depth);
  return true;
}

}  // namespace

double half_height(const Camera& camera) { return length(camera.eye - camera.at) * std::tan(radians(camera.fov_deg / 2)); }

void check(const Camera& camera) {
  const auto fail = [](const std::string& why) { throw Error(ErrorCode::invalid_argument, "camera: " + why); };
  if (!is_finite(camera.eye) || !is_finite(camera.at) || !is_finite(camera.up)) fail("eye, at and up must be finite numbers");
  if (!(camera.fov_deg > 0 && camera.fov_deg < 180))
    fail("fov must be above 0 and below 180 degrees, not " + std::to_string(camera.fov_deg));
  const Vec3d forward = camera.at - camera.eye;
  const double distance = length(forward), up_length = length(camera.up);
  if (!(distance > 0) || !std::isfinite(distance)) fail("eye and at must be apart, by a distance that is a finite number");
  if (!(up_length > 0) || !std::isfinite(up_length)) fail("up must not be zero");
  if (length(cross(forward / distance, camera.up / up_length)) < 1e-9) fail("up must not be parallel to the direction of view");
}

Camera view_of(const Box3d& bounds, std::string_view side, double aspect, bool orthographic) {
  Camera camera;
  Vec3d direction;
  if (!named_direction(side, direction, camera.up)) refuse(side, "unknown view");
  if (side == "reset" && !bounds.empty()) {  // a box without depth is seen from its broad side
    const Vec3d size = bounds.upper - bounds.lower;
    const double thin = 1e-9 * bounds.diagonal();
    const bool flat_x = size.x <= thin, flat_y = size.y <= thin, flat_z = size.z <= thin;
    if (flat_x + flat_y + flat_z == 1) named_direction(flat_x ? "+x" : flat_y ? "-y" : "+z", direction, camera.up);
  }
  const double radius = bounds.diagonal() > 0 ? bounds.diagonal() / 2 : 1.0;
  camera.at = bounds.empty() ? Vec3d{} : bounds.center();
  camera.orthographic = orthographic;
  if (side != "reset" && bounds.diagonal() > 0 && stand_before_end(camera, bounds, direction, aspect)) return camera;
  // The sphere about the box touches the narrower pair of sides of the pyramid of view.
  const double half_height_angle = radians(camera.fov_deg / 2);
  const double half_angle = aspect < 1 ? std::atan(std::tan(half_height_angle) * std::max(aspect, 1e-3)) : half_height_angle;
  camera.eye = camera.at + direction * (radius / std::sin(half_angle));
  return camera;
}

Mat4d view_from_world(const Camera& camera) {
  const Vec3d back = normalized(camera.eye - camera.at);
  const Vec3d right = normalized(cross(normalized(camera.up), back));
  const Vec3d up = cross(back, right);
  Mat4d m = Mat4d::identity();
  const Vec3d rows[3] = {right, up, back};
  for (int row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis) m.m[axis][row] = rows[row][axis];
    m.m[3][row] = -dot(rows[row], camera.eye);
  }
  return m;
}

Camera parse_camera(std::string_view text, const Camera& base, const Box3d& bounds, double aspect) {
  Vec3d direction, up;
  Camera camera = base;
  std::string_view rest = text;
  if (rest.empty()) refuse(text, "empty");
  if (const std::string_view first = rest.substr(0, rest.find(';')); named_direction(first, direction, up)) {
    camera = view_of(bounds, first, aspect, rest.find("projection=orthographic") != std::string_view::npos);
    rest.remove_prefix(std::min(rest.size(), first.size() + 1));
  }
  while (!rest.empty()) {
    const auto end = rest.find(';');
    const std::string_view part = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    const auto equals = part.find('=');
    const std::string_view key = part.substr(0, equals);
    if (equals == std::string_view::npos) refuse(text, "unknown part '" + std::string(part) + "'");
    const std::string_view value = part.substr(equals + 1);
    if (key == "eye")
      camera.eye = parse_vector(value, text);
    else if (key == "at")
      camera.at = parse_vector(value, text);
    else if (key == "up")
      camera.up = parse_vector(value, text);
    else if (key == "fov")
      camera.fov_deg = parse_number(value, text);
    else if (key == "projection" && (value == "perspective" || value == "orthographic"))
      camera.orthographic = value == "orthographic";
    else
      refuse(text, "unknown part '" + std::string(part) + "'");
  }
  check(camera);
  return camera;
}

}  // namespace isostrata
