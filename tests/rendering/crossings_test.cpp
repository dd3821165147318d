// The native renderer for constant colours, against the oracle and against itself.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/parallel.h"
#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "rendering/choice/native_renderer.h"
#include "support/box_mesh.h"
#include "support/oracle.h"
#include "support/pictures.h"
#include "support/simd_levels.h"

namespace isostrata {
namespace {

using namespace testing;

Renderer& native() {
  static const std::unique_ptr<Renderer> renderer = make_native_renderer();
  return *renderer;
}

/// Intervals are given as shares of the array's range.
DrawInput extracted(const char* data, const std::vector<Interval>& shares, double opacity, bool facets = true) {
  static std::vector<std::shared_ptr<const Dataset>> alive;
  alive.push_back(make_analytic(data, {}, Task{}));
  const Dataset& dataset = *alive.back();
  const PointArray& array = dataset.arrays[0];
  std::vector<Interval> intervals;
  for (const Interval& share : shares)
    intervals.push_back({std::lerp(array.lower, array.upper, share.lower), std::lerp(array.lower, array.upper, share.upper)});
  ExtractOptions options;
  options.facets = facets;
  options.strict = true;  // inverted tetrahedra count with their sign here and without it in the oracle
  DrawInput input = input_of(extract_intervals(dataset.grid, array, intervals, options, Task{}), opacity);
  input.grid = &dataset.grid;
  return input;
}

void expect_like_oracle(const DrawInput& input, const OracleImage& expected, const std::string& what, double limit) {
  const FloatImage drawn = draw_floats(input, native());
  const OracleError error = compare_images(expected, drawn);
  EXPECT_LT(error.max, limit) << what << " at " << error.max_x << "," << error.max_y << ", mean " << error.mean;
  std::size_t wrong_depths = 0;
  for (std::size_t i = 0; i < expected.depth.size(); ++i) {
    if (std::abs(drawn.rgba[4 * i + 3] - expected.rgba[i][3]) < 1e-4 && expected.rgba[i][3] < 1e-4) continue;
    const double off = std::abs(expected.depth[i] - double{drawn.depth[i]});
    wrong_depths += !(off < 1e-3 * input.bounds.diagonal());
  }
  EXPECT_LE(wrong_depths, expected.depth.size() / 500) << what;
}

/// With every level of vector instructions.
void expect_like_oracle(const DrawInput& input, const std::string& what, double limit = kHalfStep) {
  const OracleImage expected = oracle_image(input);
  with_each_simd_level([&](const std::string&) { expect_like_oracle(input, expected, what, limit); });
}

struct Dataset3 {
  const char* name;
  double limit;  // where cells are bent, the strict triangulation leaves some tetrahedra turned
};
constexpr Dataset3 kData[] = {{"torus:13", kHalfStep},
                              {"marschner-lobb:11", kHalfStep},
                              {"tets:8", kHalfStep},
                              {"mixed:7", kHalfStep},
                              {"cylinder:12x10x6", 0.02}};

std::vector<Camera> cameras(const Box3d& bounds, unsigned seed) {
  std::vector<Camera> all{view_of(bounds, "reset")};
  std::mt19937 random(seed);
  std::normal_distribution<double> number;
  const double size = bounds.diagonal();
  for (int i = 0; i < 2; ++i) {
    Camera camera;
    camera.at = bounds.center() + Vec3d{number(random), number(random), number(random)} * (0.05 * size);
    camera.eye = camera.at + normalized(Vec3d{number(random), number(random), number(random)}) * size * (i ? 0.9 : 0.12);
    camera.up = {number(random), number(random), number(random)};
    camera.fov_deg = i ? 50 : 80;
    all.push_back(camera);  // from outside, and with the eye inside
    camera.orthographic = true;
    all.push_back(camera);
  }
  return all;
}

TEST(Crossings, OneIntervalMeetsTheOracle) {
  for (const auto& [name, limit] : kData) {
    DrawInput input = extracted(name, {{0.25, 0.5}}, 0.6);
    int which = 0;
    for (const Camera& camera : cameras(input.bounds, 7)) {
      input.camera = camera;
      expect_like_oracle(input, std::string(name) + ", camera " + std::to_string(which++), limit);
    }
  }
}

TEST(Crossings, SeveralIntervalsMeetTheOracle) {
  for (const auto& [name, limit] : kData) {
    DrawInput input = extracted(name, {{0.1, 0.3}, {0.3, 0.45}, {0.6, 0.9}}, 0.6);
    input.styles[1].opacity = 0.9;
    int which = 0;
    for (const Camera& camera : cameras(input.bounds, 8)) {
      input.camera = camera;
      expect_like_oracle(input, std::string(name) + ", camera " + std::to_string(which++), limit);
    }
  }
}

TEST(Crossings, PrioritiesMeetTheOracle) {
  DrawInput input = extracted("torus:13", {{0.1, 0.2}, {0.3, 0.45}, {0.5, 0.6}}, 0.7);
  input.mode = RenderMode::prioritized;
  input.styles[0].priority = -3;
  input.styles[2].priority = 5;
  expect_like_oracle(input, "three groups of one colour");
  input.styles[0].priority = input.styles[1].priority;
  expect_like_oracle(input, "a group of two colours");
  EXPECT_EQ(native().draw(input).facts.order, "priority, then per pixel (exact)");
  input.styles[0].visible = false;
  expect_like_oracle(input, "one interval hidden");
  EXPECT_EQ(native().draw(input).facts.order, "priority (none needed)");
}

TEST(Crossings, ClipPlanesCutExactly) {
  for (const int intervals : {1, 2}) {
    std::vector<Interval> shares{{0.1, 0.4}, {0.4, 0.6}};
    shares.resize(static_cast<std::size_t>(intervals));
    DrawInput input = extracted("torus:13", shares, 0.8);
    for (const Camera& camera : cameras(input.bounds, 9)) {
      input.camera = camera;
      input.clip_planes = {{{0.3, 1, -0.2}, 0.1}};
      expect_like_oracle(input, "one plane");
      // Bytes take the sums where floats with depth take the lists.
      const Image bytes = draw_bytes(input, native());
      const FloatImage floats = draw_floats(input, native());
      for (std::size_t i = 0; i < floats.rgba.size(); i += 4) ASSERT_NEAR(bytes.rgba[i] / 255.0, floats.rgba[i], 0.6 / 255) << i;
      input.clip_planes.push_back({{-1, 0.2, 0.1}, -0.3});
      input.clip_planes.push_back({{0, 0, 2}, -0.8});
      expect_like_oracle(input, "three planes");
      input.clip_planes.push_back({{0, 0, -1}, 0.9});
      EXPECT_EQ(draw_bytes(input, native()).rgba[0], 0) << "nothing is left";
    }
  }
}

/// Unit vectors that turn slowly from point to point.
std::shared_ptr<const std::vector<Vec3f>> smooth_normals(const IntervalMesh& mesh) {
  std::vector<Vec3f> normals;
  for (const Vec3d& p : mesh.positions) {
    const Vec3d n = normalized(p + Vec3d{0.1, 0.01, -0.2});
    normals.push_back({static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)});
  }
  return std::make_shared<const std::vector<Vec3f>>(std::move(normals));
}

TEST(Crossings, SurfacesMeetTheOracle) {
  for (const char* name : {"torus:13", "tets:8", "mixed:7"}) {
    DrawInput input = extracted(name, {{0.1, 0.3}, {0.3, 0.45}}, 0.6);
    input.styles[0].surface.lower = input.styles[0].surface.upper = true;
    input.styles[0].surface.opacity = 0.4;
    input.styles[1].surface.upper = input.styles[1].surface.domain = true;
    input.styles[1].surface.own_color = true;
    input.styles[1].surface.color = {0.2f, 0.9f, 0.7f};
    input.styles[1].surface.opacity = 0.7;
    input.styles[1].surface.silhouette = 0.6;
    input.styles[1].surface.texture = "stripes";
    input.styles[1].surface.texture_repeat = 3;
    std::vector<float> texture;
    for (const Vec3d& p : input.mesh->positions) texture.push_back(static_cast<float>(p.z));
    input.texture_values = std::make_shared<const std::vector<float>>(texture);
    for (const Camera& camera : cameras(input.bounds, 10)) {
      input.camera = camera;
      input.normals = nullptr;
      expect_like_oracle(input, std::string(name) + " with the facets' normals", 0.01);
      input.normals = smooth_normals(*input.mesh);
      expect_like_oracle(input, std::string(name) + " with given normals", 0.01);
    }
  }
}

/// More of them than a vector has lanes.
TEST(Crossings, ADozenLitIntervalsMeetTheOracle) {
  std::vector<Interval> shares;
  for (int i = 0; i < 12; ++i) shares.push_back({0.07 * i + 0.02, 0.07 * i + (i % 3 ? 0.09 : 0.07)});
  DrawInput input = extracted("tets:8", shares, 0.3);
  input.normals = smooth_normals(*input.mesh);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    SurfaceStyle& surface = input.styles[i].surface;
    surface.lower = i % 2, surface.upper = i % 3 == 0, surface.domain = i % 5 == 0;
    surface.opacity = 0.1 + 0.07 * static_cast<double>(i);
    surface.specular = i % 4 ? 0.4 : 0;
    surface.silhouette = i % 7 ? 0 : 0.8;
  }
  for (const Camera& camera : cameras(input.bounds, 12)) {
    input.camera = camera;
    expect_like_oracle(input, "twelve", 0.01);
  }
}

/// Where a ray has become opaque it ends, and what light can hardly change is not lit: in pictures of 8 bits, not in those of
/// floats.
TEST(Crossings, WhatIsLeftOutForEightBitsIsLessThanHalfAStep) {
  std::vector<Interval> shares;
  for (int i = 0; i < 15; ++i) shares.push_back({0.06 * i, 0.06 * (i + 1)});
  DrawInput input = extracted("marschner-lobb:21", shares, 0.01);
  input.normals = smooth_normals(*input.mesh);
  input.width = 200;
  input.height = 150;
  std::mt19937 random(13);
  std::uniform_real_distribution<float> unit(0, 1);
  double largest = 0;
  for (int trial = 0; trial < 12; ++trial) {
    const double faint = trial % 3 == 0 ? 0.0005 : trial % 3 == 1 ? 0.003 : 0.05;
    for (IntervalStyle& style : input.styles) {
      style.color = {unit(random), unit(random), unit(random)};
      style.surface.lower = true, style.surface.upper = trial % 2;
      style.surface.opacity = unit(random) < 0.2 ? 0.9 + 0.1 * static_cast<double>(unit(random)) : faint;
      style.surface.ambient = 0, style.surface.diffuse = 1;  // all that light can do
      style.surface.specular = static_cast<double>(unit(random));
    }
    const FloatImage exact = draw_floats(input, native());
    with_each_simd_level([&](const std::string& level) {
      const Image drawn = draw_bytes(input, native());
      for (std::size_t i = 0; i < exact.rgba.size(); i += 4)
        for (std::size_t c = 0; c < 3; ++c) {
          const double off = std::abs(drawn.rgba[i + c] / 255.0 - exact.rgba[i + c]);
          largest = std::max(largest, off);
          ASSERT_LT(off, 2 * kHalfStep + 1e-5)
              << level << ", seed 13, trial " << trial << ", pixel " << i / 4;  // with the rounding
        }
    });
  }
  EXPECT_GT(largest, 1.05 * kHalfStep) << "nothing was left out";
}

/// Rays through points, edges and faces of the tetrahedra: every pixel shows the box's whole thickness or nothing.
TEST(Crossings, StraightViewsOfARegularGridHaveNoHoles) {
  const RectilinearGrid shape = even_grid(9, 9, 9, {-1, -1, -1}, {1, 1, 1});
  DrawInput input = input_of(box_mesh(shape, [](auto...) { return 0; }), 0.5);
  input.unit_distance = 0.05;
  for (const char* side : {"+x", "-y", "+z"})
    for (const int size : {32, 33, 64}) {
      input.camera = view_of(input.bounds, side);
      input.camera.orthographic = true;
      input.camera.fov_deg = 2 * std::atan(1.0 / length(input.camera.eye)) * 180 / std::numbers::pi;  // sees just the box
      input.width = input.height = size;
      const FloatImage image = draw_floats(input, native());
      const double expected = 1 - std::pow(0.5, 2 / 0.05);
      int covered = 0;
      for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
        if (image.rgba[i] == 0) continue;
        ++covered;
        ASSERT_NEAR(image.rgba[i], expected, 1e-5) << side << " " << size << " " << i / 4;
      }
      EXPECT_GT(covered, (size - 2) * (size - 2)) << side << " " << size;
    }
}

TEST(Crossings, SumsAndListsAreTheSamePicture) {
  DrawInput input = extracted("marschner-lobb:11", {{0.1, 0.3}, {0.5, 0.7}}, 0.7);
  input.styles[1].color = input.styles[0].color;
  input.styles[1].opacity = 0.3;
  for (const Camera& camera : cameras(input.bounds, 11)) {
    input.camera = camera;
    input.styles[1].color[2] = input.styles[0].color[2];
    EXPECT_EQ(native().draw(input).facts.order, "none needed");
    const FloatImage sums = draw_floats(input, native());
    input.styles[1].color[2] += 1e-6f;
    EXPECT_EQ(native().draw(input).facts.order, "per pixel (exact)");
    const FloatImage lists = draw_floats(input, native());
    for (std::size_t i = 0; i < sums.rgba.size(); ++i) ASSERT_NEAR(sums.rgba[i], lists.rgba[i], 2e-5) << i;
    for (std::size_t i = 0; i < sums.depth.size(); ++i)
      if (sums.rgba[4 * i + 3] > 1e-4) {
        ASSERT_NEAR(sums.depth[i], lists.depth[i], 1e-4) << i;
      }
  }
}

TEST(Crossings, AMeshWithoutFacetsIsTheSamePicture) {
  for (const auto& [name, limit] : kData) {
    const DrawInput with = extracted(name, {{0.1, 0.3}, {0.3, 0.45}}, 0.6, true);
    const DrawInput without = extracted(name, {{0.1, 0.3}, {0.3, 0.45}}, 0.6, false);
    ASSERT_TRUE(without.mesh->facets.empty());
    EXPECT_EQ(draw_bytes(with, native()).rgba, draw_bytes(without, native()).rgba) << name;
  }
}

TEST(Crossings, ThreadsChangeNothing) {
  DrawInput input = extracted("torus:30", {{0.1, 0.3}, {0.3, 0.45}}, 0.6);
  input.width = 400;
  input.height = 300;
  const Image two = draw_bytes(input, native());
  set_thread_count(1);
  const Image one = draw_bytes(input, native());
  set_thread_count(0);
  EXPECT_EQ(one.rgba, two.rgba);
}

TEST(Crossings, MirroredMeshesAreNotInsideOut) {
  DrawInput input = extracted("torus:13", {{0.1, 0.3}}, 0.6);
  auto mirrored = std::make_shared<IntervalMesh>(*input.mesh);
  for (Vec3d& p : mirrored->positions) p.x = -p.x;
  input.mesh = mirrored;
  expect_like_oracle(input, "mirrored");
}

TEST(Crossings, FragmentsAreThoseOfTetrahedra) {
  DrawInput input = extracted("torus:13", {{0.1, 0.3}}, 0.6);
  input.count_fragments = true;
  const DrawFacts facts = native().draw(input).facts;
  EXPECT_EQ(facts.tetrahedra, static_cast<std::int64_t>(input.mesh->tetrahedra.size()));
  std::int64_t expected = 0;
  for (int y = 0; y < input.height; ++y)
    for (int x = 0; x < input.width; ++x)
      for (std::size_t t = 0; t < input.mesh->tetrahedra.size(); ++t) {
        OracleSegment segment{};
        expected += oracle_segment(*input.mesh, nullptr, t, oracle_ray(input, x, y), segment);
      }
  EXPECT_NEAR(static_cast<double>(facts.fragments), static_cast<double>(expected), 0.002 * static_cast<double>(expected));
}

TEST(Crossings, EmptyMeshesAndSmallPicturesAreDrawn) {
  DrawInput input = extracted("torus:13", {{0.1, 0.3}}, 0.6);
  for (const int size : {1, 2, 127, 129}) {
    input.width = size;
    input.height = 1;
    EXPECT_EQ(draw_bytes(input, native()).rgba.size(), static_cast<std::size_t>(4 * size));
  }
  input.mesh = std::make_shared<const IntervalMesh>();
  input.styles.clear();
  input.background = {1, 0, 0};
  EXPECT_EQ(pixel(draw_bytes(input, native()), 0, 0), (std::array<int, 4>{255, 0, 0, 255}));
}

TEST(Crossings, ThousandsOfCrossingsInAPixelAreSorted) {
  IntervalMesh mesh;
  constexpr int kSlabs = 3000;
  for (int i = 0; i < kSlabs; ++i)
    add_box(mesh, {-1, -1, -1e-3 * (i + 1)}, {1, 1, -1e-3 * i}, static_cast<std::uint16_t>(i % 2), i);
  DrawInput input = input_of(std::move(mesh), 0.4);
  input.camera = {{0.3, 0.2, 5}, {0, 0, 0}, {0, 1, 0}, 30};
  input.width = input.height = 3;
  input.unit_distance = 0.5;
  expect_like_oracle(input, "slabs");
  input.width = input.height = 30;  // more than a part may have
  const FloatImage large = draw_floats(input, native());
  const auto middle = pixel(large, 15, 15);
  EXPECT_NEAR(middle[3], 1 - std::pow(0.6, 3 / 0.5), 0.01);
}

}  // namespace
}  // namespace isostrata
