#include "camera_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "isostrata/client.h"

namespace isostrata::client {
namespace {

Vec3 of(const v1::Vec3& v) { return {v.x(), v.y(), v.z()}; }
double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double length(const Vec3& a) { return std::sqrt(dot(a, a)); }

std::vector<Keyframe> random_keyframes(std::uint64_t seed, int count) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> anywhere(-3, 3), later(0.1, 2);
  std::vector<Keyframe> keys;
  double time = 1;
  for (int i = 0; i < count; ++i, time += later(random)) {
    const auto vector = [&] { return Vec3{anywhere(random), anywhere(random), anywhere(random)}; };
    keys.push_back({time, camera(vector(), vector(), vector(), 20 + 5 * anywhere(random)), time * 10});
  }
  return keys;
}

TEST(CameraPath, GoesThroughItsKeyframes) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto keys = random_keyframes(seed, 2 + static_cast<int>(seed % 4));
    const CameraPath path(keys);
    for (const Keyframe& key : keys) {
      const v1::Camera at = path.camera_at(key.time_s - keys[0].time_s);
      const double scale = length(minus(of(key.camera.eye()), of(key.camera.at())));
      EXPECT_LT(length(minus(of(at.eye()), of(key.camera.eye()))), 1e-9 * (1 + scale)) << "seed " << seed;
      EXPECT_LT(length(minus(of(at.at()), of(key.camera.at()))), 1e-9) << "seed " << seed;
      // Up may be any in the plane of the line of sight: the right direction is that of the keyframe.
      const Vec3 back = minus(of(at.eye()), of(at.at())), up = of(key.camera.up()), given = of(at.up());
      const Vec3 right{given[1] * back[2] - given[2] * back[1], given[2] * back[0] - given[0] * back[2],
                       given[0] * back[1] - given[1] * back[0]};
      EXPECT_NEAR(dot(right, up) / length(right) / length(up), 0, 1e-6) << "seed " << seed;
      EXPECT_GT(dot(given, up), 0) << "seed " << seed;
      EXPECT_NEAR(*path.data_time_at(key.time_s - keys[0].time_s), key.time_s * 10, 1e-9);
    }
  }
}

TEST(CameraPath, IsContinuous) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const CameraPath path(random_keyframes(seed, 5));
    const int steps = 4000;
    Vec3 before = of(path.camera_at(0).eye());
    for (int i = 1; i <= steps; ++i) {
      const Vec3 eye = of(path.camera_at(path.duration_s() * i / steps).eye());
      ASSERT_LT(length(minus(eye, before)), 0.5) << "seed " << seed << ", step " << i;
      before = eye;
    }
  }
}

TEST(CameraPath, KeepsItsDistanceBetweenCamerasOfOneDistance) {
  const auto start = camera({3, 0, 0}, {0, 0, 0}, {0, 0, 1});
  const CameraPath path({{0, start, {}}, {1, turned(start, 90, 0), {}}, {2, turned(start, 180, 0), {}}});
  for (int i = 0; i <= 20; ++i) {
    const auto at = path.camera_at(0.1 * i);
    EXPECT_NEAR(length(of(at.eye())), 3, 1e-9) << i;
    EXPECT_NEAR(at.eye().z(), 0, 1e-9) << i;
  }
  // And the way from one to the other is the short one.
  EXPECT_NEAR(path.camera_at(0.5).eye().x(), 3 * std::sqrt(0.5), 0.1);
}

TEST(CameraPath, FilesSayWhatIsWrongAndWhere) {
  const auto start = camera({3, 0, 0}, {0, 0, 0}, {0, 0, 1});
  const auto two = [](const std::string& second) { return R"({"keyframes":[{"time":0},)" + second + "]}"; };
  for (const auto& [text, part] : std::vector<std::pair<std::string, std::string>>{
           {"[]", "a.json is not a JSON object"},
           {"{\"keyframes\":", "a.json is not a JSON object"},
           {"{}", "0 keyframes"},
           {R"({"keyframes":[{"time":0}]})", "1 keyframes"},
           {R"({"key":[]})", "'key'"},
           {two(R"({"time":0})"), "keyframes[1].time"},
           {two(R"({"camera":{}})"), "keyframes[1]: it has no time"},
           {two(R"({"time":1,"camera":{"eye":[1,2]}})"), "keyframes[1].camera.eye"},
           {two(R"({"time":1,"camera":{"eye":[1,2,"x"]}})"), "keyframes[1].camera.eye"},
           {two(R"({"time":1,"camera":{"eye":[0,0,0]}})"), "keyframes[1].camera: eye and at"},
           {two(R"({"time":1,"camera":{"up":[1,0,0]}})"), "keyframes[1].camera: up"},
           {two(R"({"time":1,"zoom":2})"), "keyframes[1].zoom"},
           {two(R"({"time":1e999})"), "a.json"},
       }) {
    try {
      CameraPath::from_json(text, "a.json", start);
      ADD_FAILURE() << text;
    } catch (const ClientError& error) {
      EXPECT_EQ(error.code(), "bad_argument");
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << text << ": " << error.what();
    }
  }
}

TEST(CameraPath, ReadsCamerasAsSavedStatesHaveThem) {
  const auto start = camera({3, 0, 0}, {0, 0, 0}, {0, 0, 1}, 25);
  const auto path = CameraPath::from_json(
      R"({"fps":12,"keyframes":[{"time":0},{"time":2,"camera":{"eye":{"x":0,"y":2,"z":0},"fovDeg":45,"orthographic":true},"data_time":7}]})",
      "a.json", start);
  EXPECT_EQ(*path.fps(), 12);
  EXPECT_EQ(path.duration_s(), 2);
  EXPECT_EQ(path.camera_at(0).fov_deg(), 25);
  EXPECT_NEAR(path.camera_at(2).eye().y(), 2, 1e-9);
  EXPECT_EQ(path.camera_at(2).fov_deg(), 45);
  EXPECT_TRUE(path.camera_at(9).orthographic());
  EXPECT_FALSE(path.data_time_at(1));
  EXPECT_EQ(*path.data_time_at(2), 7);
}

}  // namespace
}  // namespace isostrata::client
