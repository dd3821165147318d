#include "camera_path.h"

#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>
#include <cmath>

#include "isostrata/client.h"
#include "quaternion.h"

namespace isostrata::client {
namespace {

namespace json = boost::json;

constexpr std::size_t kMaxKeyframes = 10000;

[[noreturn]] void refuse(const std::string& message) { throw ClientError("bad_argument", message); }

Vec3 array_of(const v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }
Vec3 difference(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Vec3& a) { return std::hypot(a[0], a[1], a[2]); }
Vec3 unit(const Vec3& a) {
  const double l = length(a);
  return {a[0] / l, a[1] / l, a[2] / l};
}

struct Frame {
  double log_distance = 0;
  Quaternion world_from_camera;
};

Frame frame_of(const v1::Camera& camera) {
  const Vec3 back = difference(array_of(camera.eye()), array_of(camera.at()));
  const Vec3 z = unit(back);
  const Vec3 x = unit(cross(array_of(camera.up()), z));
  return {std::log(length(back)), from_axes(x, cross(z, x), z)};
}

double number_of(const json::value& value, const std::string& where) {
  double number = NAN;
  if (value.is_double()) number = value.get_double();
  if (value.is_int64()) number = static_cast<double>(value.get_int64());
  if (value.is_uint64()) number = static_cast<double>(value.get_uint64());
  if (!std::isfinite(number) || std::abs(number) > 1e30) refuse(where + ": expected a number");
  return number;
}

v1::Vec3 vector_of(const json::value& value, const std::string& where) {
  Vec3 xyz{};
  if (value.is_array() && value.get_array().size() == 3) {
    for (std::size_t i = 0; i < 3; ++i) xyz[i] = number_of(value.get_array()[i], where);
  } else if (value.is_object()) {
    for (const auto& [key, part] : value.get_object()) {
      if (key != "x" && key != "y" && key != "z") refuse(where + ": unknown member '" + std::string(key) + "'; expected x, y, z");
      xyz[static_cast<std::size_t>(key[0] - 'x')] = number_of(part, where + "." + std::string(key));
    }
  } else {
    refuse(where + ": expected [x, y, z]");
  }
  return vec3(xyz);
}

void read_camera(const json::value& value, const std::string& where, v1::Camera& camera) {
  if (!value.is_object()) refuse(where + ": expected an object with eye, at, up, fov");
  for (const auto& [key, part] : value.get_object()) {
    const std::string at = where + "." + std::string(key);
    if (key == "eye")
      *camera.mutable_eye() = vector_of(part, at);
    else if (key == "at")
      *camera.mutable_at() = vector_of(part, at);
    else if (key == "up")
      *camera.mutable_up() = vector_of(part, at);
    else if (key == "fov" || key == "fovDeg" || key == "fov_deg")
      camera.set_fov_deg(number_of(part, at));
    else if (key == "orthographic" && part.is_bool())
      camera.set_orthographic(part.get_bool());
    else
      refuse(at + ": expected eye, at, up, fov or orthographic");
  }
}

// The slope at keyframe i of a quantity's curve, per second.
template <class Value>
double slope(const std::vector<Keyframe>& keys, std::size_t i, const Value& value) {
  const auto between = [&](std::size_t a, std::size_t b) { return (value(b) - value(a)) / (keys[b].time_s - keys[a].time_s); };
  if (i == 0) return between(0, 1);
  if (i + 1 == keys.size()) return between(i - 1, i);
  const double before = keys[i].time_s - keys[i - 1].time_s, after = keys[i + 1].time_s - keys[i].time_s;
  return (between(i - 1, i) * after + between(i, i + 1) * before) / (before + after);
}

// Hermite's cubic over the segment from keyframe i on.
template <class Value>
double curve(const std::vector<Keyframe>& keys, std::size_t i, double u, const Value& value) {
  const double span = keys[i + 1].time_s - keys[i].time_s;
  const double a = value(i), b = value(i + 1), ma = slope(keys, i, value) * span, mb = slope(keys, i + 1, value) * span;
  const double u2 = u * u, u3 = u2 * u;
  return a * (2 * u3 - 3 * u2 + 1) + ma * (u3 - 2 * u2 + u) + b * (3 * u2 - 2 * u3) + mb * (u3 - u2);
}

}  // namespace

CameraPath::CameraPath(std::vector<Keyframe> keyframes, std::optional<double> fps) : keyframes_(std::move(keyframes)), fps_(fps) {
  if (keyframes_.size() < 2) refuse("a camera path has " + std::to_string(keyframes_.size()) + " keyframes; expected at least 2");
  for (std::size_t i = 0; i < keyframes_.size(); ++i) {
    const std::string which = "keyframes[" + std::to_string(i) + "]";
    if (i > 0 && !(keyframes_[i].time_s > keyframes_[i - 1].time_s))
      refuse(which + ".time: expected more than the keyframe's before it");
    const v1::Camera& camera = keyframes_[i].camera;
    const Vec3 back = difference(array_of(camera.eye()), array_of(camera.at()));
    if (!(length(back) > 0)) refuse(which + ".camera: eye and at are the same point");
    if (!(length(cross(unit(array_of(camera.up())), unit(back))) > 1e-9))
      refuse(which + ".camera: up is along the line of sight, or 0");
  }
}

CameraPath CameraPath::from_json(const std::string& text, const std::string& name, const v1::Camera& start) {
  boost::system::error_code error;
  const json::value document = json::parse(text, error);
  if (error || !document.is_object()) refuse(name + " is not a JSON object" + (error ? ": " + error.message() : ""));
  std::optional<double> fps;
  std::vector<Keyframe> keyframes;
  try {
    for (const auto& [key, value] : document.get_object()) {
      if (key == "fps") {
        fps = number_of(value, "fps");
        continue;
      }
      if (key != "keyframes" || !value.is_array()) refuse("'" + std::string(key) + "': expected keyframes, an array, and fps");
      if (value.get_array().size() > kMaxKeyframes) refuse("keyframes: expected at most " + std::to_string(kMaxKeyframes));
      for (const json::value& given : value.get_array()) {
        const std::string which = "keyframes[" + std::to_string(keyframes.size()) + "]";
        if (!given.is_object()) refuse(which + ": expected an object");
        Keyframe next = keyframes.empty() ? Keyframe{0, start, {}} : keyframes.back();
        bool timed = false;
        for (const auto& [member, part] : given.get_object()) {
          if (member == "time") {
            next.time_s = number_of(part, which + ".time");
            timed = true;
          } else if (member == "camera") {
            read_camera(part, which + ".camera", next.camera);
          } else if (member == "data_time") {
            next.data_time = number_of(part, which + ".data_time");
          } else {
            refuse(which + "." + std::string(member) + ": expected time, camera or data_time");
          }
        }
        if (!timed) refuse(which + ": it has no time");
        keyframes.push_back(std::move(next));
      }
    }
    return CameraPath(std::move(keyframes), fps);
  } catch (const ClientError& wrong) {
    refuse(name + ": " + wrong.what());
  }
}

std::size_t CameraPath::segment_of(double time_s, double& u) const {
  const double t = keyframes_.front().time_s + time_s;
  std::size_t i = 0;
  while (i + 2 < keyframes_.size() && t >= keyframes_[i + 1].time_s) ++i;
  u = std::clamp((t - keyframes_[i].time_s) / (keyframes_[i + 1].time_s - keyframes_[i].time_s), 0.0, 1.0);
  return i;
}

v1::Camera CameraPath::camera_at(double time_s) const {
  double u = 0;
  const std::size_t i = segment_of(time_s, u);
  const auto camera = [&](std::size_t k) -> const v1::Camera& { return keyframes_[k].camera; };
  const Vec3 at{curve(keyframes_, i, u, [&](std::size_t k) { return camera(k).at().x(); }),
                curve(keyframes_, i, u, [&](std::size_t k) { return camera(k).at().y(); }),
                curve(keyframes_, i, u, [&](std::size_t k) { return camera(k).at().z(); })};
  const double distance = std::exp(curve(keyframes_, i, u, [&](std::size_t k) { return frame_of(camera(k)).log_distance; }));

  // Shoemake's inner quadrangle points, of the keyframes on both sides; at the ends the keyframe itself.
  const Quaternion a = frame_of(camera(i)).world_from_camera;
  const Quaternion b = nearer(frame_of(camera(i + 1)).world_from_camera, a);
  const auto inner = [](const Quaternion& before, const Quaternion& here, const Quaternion& after) {
    const auto to = log(inverse(here) * nearer(after, here)), from = log(inverse(here) * nearer(before, here));
    return here * exp({-(to[0] + from[0]) / 4, -(to[1] + from[1]) / 4, -(to[2] + from[2]) / 4});
  };
  const Quaternion sa = i > 0 ? inner(frame_of(camera(i - 1)).world_from_camera, a, b) : a;
  const Quaternion sb = i + 2 < keyframes_.size() ? inner(a, b, frame_of(camera(i + 2)).world_from_camera) : b;
  const Quaternion q = slerp(slerp(a, b, u), slerp(sa, sb, u), 2 * u * (1 - u));

  const Vec3 back = rotated(q, {0, 0, 1});
  v1::Camera out = camera(u < 1 ? i : i + 1);
  *out.mutable_at() = vec3(at);
  *out.mutable_eye() = vec3({at[0] + back[0] * distance, at[1] + back[1] * distance, at[2] + back[2] * distance});
  *out.mutable_up() = vec3(rotated(q, {0, 1, 0}));
  out.set_fov_deg(camera(i).fov_deg() + u * (camera(i + 1).fov_deg() - camera(i).fov_deg()));
  return out;
}

std::optional<double> CameraPath::data_time_at(double time_s) const {
  double u = 0;
  const std::size_t i = segment_of(time_s, u);
  const auto &a = keyframes_[i].data_time, &b = keyframes_[i + 1].data_time;
  if (!a || !b) return u < 1 ? a : b;
  return *a + u * (*b - *a);
}

}  // namespace isostrata::client
