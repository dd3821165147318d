// The renderer as a device: sizes, errors, backgrounds, depth, tiles, contexts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <thread>

#include "base/error.h"
#include "support/oracle.h"
#include "support/osmesa.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using namespace testing;
using ::testing::HasSubstr;

DrawInput cube(double opacity = 0.5) {
  IntervalMesh mesh;
  add_box(mesh, {-1, -1, -1}, {1, 1, 1}, 0, 0);
  return input_of(std::move(mesh), opacity);
}

TEST(GlRenderer, RefusesBadSizesAndGoesOn) {
  DrawInput input = cube();
  for (const auto& [width, height] : {std::pair{0, 10}, {10, 0}, {-5, 10}, {16385, 10}, {10, 16385}, {2147483647, 2147483647}}) {
    input.width = width;
    input.height = height;
    try {
      test_renderer().draw(input);
      FAIL() << width << "x" << height;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::invalid_argument);
      EXPECT_THAT(error.what(), HasSubstr(std::to_string(width) + "x" + std::to_string(height)));
    }
  }
  EXPECT_EQ(draw_bytes(cube()).rgba.size(), 64u * 48 * 4);
}

TEST(GlRenderer, RefusesWhatIsNotANumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](auto change) {
    DrawInput input = cube();
    change(input);
    EXPECT_THROW(test_renderer().draw(input), Error);
  };
  refused([&](DrawInput& i) { i.camera.eye.x = nan; });
  refused([&](DrawInput& i) { i.camera.at = i.camera.eye; });
  refused([&](DrawInput& i) { i.unit_distance = nan; });
  refused([&](DrawInput& i) { i.unit_distance = -1; });
  refused([&](DrawInput& i) { i.background[1] = static_cast<float>(nan); });
  refused([&](DrawInput& i) { i.styles[0].opacity = nan; });
  refused([&](DrawInput& i) { i.styles[0].opacity = 1.5; });
  refused([&](DrawInput& i) { i.styles[0].color[2] = static_cast<float>(nan); });
  refused([&](DrawInput& i) { i.styles.clear(); });
  refused([&](DrawInput& i) { i.styles[0].color_map = "viridis"; });  // without colour values
  refused([&](DrawInput& i) { i.styles[0].color_map = "nosuch"; });
  refused([&](DrawInput& i) { i.mesh = nullptr; });
}

TEST(GlRenderer, AnEmptyMeshIsTheBackground) {
  DrawInput input;
  input.mesh = std::make_shared<const IntervalMesh>();
  input.bounds = Box3d{{-1, -1, -1}, {1, 1, 1}};
  input.camera = view_of(input.bounds, "reset");
  input.width = 3;
  input.height = 2;
  input.background = {1.0f, 0.4f, 0.0f};
  const Image image = draw_bytes(input);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 3; ++x) EXPECT_EQ(pixel(image, x, y), (std::array<int, 4>{255, 102, 0, 255}));
}

TEST(GlRenderer, EightBitsAreTheFloatsOverTheBackground) { expect_bytes_of_floats(cube(0.3), test_renderer(), for_triangles(0.51, 1.1), for_triangles(0.51, 1.1)); }

TEST(GlRenderer, AnOpaqueIntervalShowsExactlyItsColour) {
  DrawInput input = cube(1.0);
  input.styles[0].color = parse_rgb("#12ab9f");
  input.unit_distance = 1e-3;
  EXPECT_EQ(pixel(draw_bytes(input), 32, 24), (std::array<int, 4>{0x12, 0xab, 0x9f, 255}));
}

TEST(GlRenderer, ManyThinLayersAddUpBelowOneStepOfEightBits) {
  IntervalMesh mesh;
  for (int i = 0; i < 400; ++i) add_box(mesh, {-1, -1, i / 400.0}, {1, 1, (i + 1) / 400.0}, 0, i);
  DrawInput input = input_of(std::move(mesh), 0.25);
  input.camera = {{0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 10};
  input.unit_distance = 1;  // each layer's alpha is 7e-4, a fifth of 1/255
  EXPECT_NEAR(pixel(draw_floats(input), 32, 24)[3], 0.25, 1e-4);
}

TEST(GlRenderer, InvisibleAndTransparentIntervalsAreNotDrawn) {
  DrawInput input = cube();
  input.styles[0].visible = false;
  DrawResult result = test_renderer().draw(input);
  EXPECT_EQ(result.facts.tetrahedra, 0);
  input.styles[0].visible = true;
  input.styles[0].opacity = 0;
  EXPECT_EQ(test_renderer().draw(input).facts.tetrahedra, 0);
}

TEST(GlRenderer, DepthIsTheDistanceAlongTheViewToTheNearestPoint) {
  DrawInput input = cube();
  input.camera = {{0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 30};
  const FloatImage image = draw_floats(input);
  ASSERT_EQ(image.depth.size(), 64u * 48);
  EXPECT_NEAR(image.depth[24 * 64 + 32], 4.0, 1e-4);
  EXPECT_NEAR(image.depth[20 * 64 + 30], 4.0, 1e-4);  // along the view, not along the ray
  EXPECT_TRUE(std::isinf(image.depth[0]));
}

TEST(GlRenderer, UpIsUpAndRightIsRight) {
  IntervalMesh mesh;
  add_box(mesh, {0.5, 0.5, -0.1}, {0.9, 0.9, 0.1}, 0, 0);
  DrawInput input = input_of(std::move(mesh), 1.0);
  input.unit_distance = 0.01;
  input.camera = {{0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 25};
  const FloatImage image = draw_floats(input);
  double x_sum = 0, y_sum = 0, count = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (pixel(image, x, y)[3] > 0.5f) x_sum += x, y_sum += y, ++count;
  ASSERT_GT(count, 10);
  EXPECT_GT(x_sum / count, 40);
  EXPECT_LT(y_sum / count, 20);
}

TEST(GlRenderer, PicturesLargerThanATileHaveNoSeams) {
  DrawInput input = cube(0.6);
  input.camera = {{1.5, 1, 4}, {0, 0, 0}, {0, 1, 0}, 0.5};  // a narrow view: the cube is everywhere
  input.width = 4100;                                       // one tile and four pixels
  input.height = 3;
  const FloatImage image = draw_floats(input);
  for (const int x : {0, 1, 2049, 4094, 4095, 4096, 4097, 4099})
    for (int y = 0; y < 3; ++y) {
      const auto expected = oracle_pixel(input, x, y);
      for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(pixel(image, x, y)[c], expected[c], 1e-4) << x << "," << y;
    }
}

TEST(GlRenderer, OddSizesMeetTheOracleToo) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 37}, {53, 1}, {31, 17}}) {
    DrawInput input = cube(0.6);
    input.width = width;
    input.height = height;
    EXPECT_LT(compare_with_oracle(input, draw_floats(input)).max, for_triangles(2e-3, 3)) << width << "x" << height;
  }
}

TEST(GlRenderer, UnitsOfTheDataDoNotMatter) {
  const FloatImage reference = draw_floats(cube());
  for (const double scale : {1e-12, 1e-3, 1e6, 1e15}) {
    IntervalMesh mesh;
    add_box(mesh, Vec3d{-1, -1, -1} * scale, Vec3d{1, 1, 1} * scale, 0, 0);
    const FloatImage image = draw_floats(input_of(std::move(mesh)));
    for (std::size_t i = 0; i < image.rgba.size(); ++i) ASSERT_NEAR(image.rgba[i], reference.rgba[i], 1e-3) << scale;
  }
}

TEST(GlRenderer, CountsFragments) {
  DrawInput input = cube();
  EXPECT_EQ(test_renderer().draw(input).facts.fragments, 0);
  input.count_fragments = true;
  const std::int64_t fragments = test_renderer().draw(input).facts.fragments;
  input.transparent = true;
  const Image image = draw_bytes(input);
  std::int64_t covered = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) covered += image.rgba[i] > 0;
  EXPECT_GE(fragments, covered);  // every covered pixel at least once
  EXPECT_LE(fragments, 6 * covered + 200);
}

TEST(GlRenderer, OsmesaDrawsTheSamePictureInTheSameThread) {
  if (!osmesa_is_installed()) {
    try {
      make_renderer({"raster", "osmesa"});
      FAIL();
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("libOSMesa.so.8 and libOSMesa.so.6 cannot be loaded"));
    }
    return;
  }
  const std::unique_ptr<Renderer> osmesa = make_renderer({"raster", "osmesa"});
  EXPECT_THAT(osmesa->device(), HasSubstr("OSMesa"));
  EXPECT_THAT(osmesa->device(), HasSubstr("SOFTWARE"));
  for (int turn = 0; turn < 3; ++turn) {  // the two contexts take turns
    const Image a = draw_bytes(cube(0.4)), b = draw_bytes(cube(0.4), *osmesa);
    EXPECT_EQ(a.rgba, b.rgba);
  }
}

TEST(GlRenderer, RenderersLiveOnTheirOwnThreads) {
  const Image expected = draw_bytes(cube());
  std::vector<std::thread> threads;
  std::vector<Image> images(3);
  for (Image& image : images)
    threads.emplace_back([&image] {
      const std::unique_ptr<Renderer> renderer = make_renderer({"raster", test_device()});
      for (int i = 0; i < 3; ++i) image = draw_bytes(cube(), *renderer);
    });
  for (std::thread& thread : threads) thread.join();
  for (const Image& image : images) EXPECT_EQ(image.rgba, expected.rgba);
}

TEST(GlContext, SaysWhichDeviceIsNotThere) {
  const auto message = [](const char* device) -> std::string {
    try {
      make_renderer({"raster", device});
      return "";
    } catch (const Error& error) {
      return error.what();
    }
  };
  EXPECT_THAT(message("vulkan"), HasSubstr("expected auto, egl:INDEX, egl:UUID, surfaceless or osmesa"));
  EXPECT_THAT(message("egl:1000"), HasSubstr("no such EGL device"));
  EXPECT_THAT(message("egl:"), HasSubstr("expected egl:INDEX or egl:UUID"));
  EXPECT_THAT(message("egl:12ab"), HasSubstr("32 hexadecimal digits"));
  EXPECT_THAT(message("egl:00112233-4455-6677-8899-aabbccddeeff"), HasSubstr("no OpenGL 4.5 device for"));
}

TEST(GlContext, ADeviceIsFoundByItsUuid) {
  std::string uuid;
  for (const DeviceAttempt& attempt : probe_devices())
    if (attempt.ok && attempt.name.starts_with("EGL device"))
      if (const auto at = attempt.detail.find("UUID "); at != std::string::npos) uuid = attempt.detail.substr(at + 5);
  if (uuid.empty()) GTEST_SKIP() << "no EGL device tells its UUID";
  EXPECT_THAT(make_renderer({"raster", "egl:" + uuid})->device(), HasSubstr("EGL device"));
}

}  // namespace
}  // namespace isostrata
