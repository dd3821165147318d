// The tile algorithm in compute shaders, by llvmpipe, against the oracle and against raster.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <random>

#include "base/error.h"
#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "rendering/choice/renderer_trial.h"
#include "rendering/compute/compute_renderer.h"
#include "rendering/compute/tile_layout.h"
#include "rendering/gl/gl_objects.h"
#include "support/oracle.h"
#include "support/pictures.h"
#include "support/places.h"

namespace isostrata {
namespace {

using namespace testing;
using ::testing::HasSubstr;

Renderer& compute() {
  static const std::unique_ptr<Renderer> renderer = make_renderer({"compute", test_device()});
  return *renderer;
}

/// Two intervals, touching, in the middle of the array's range, with facets.
DrawInput extracted_input(const char* data, double opacity = 0.6) {
  static std::vector<std::shared_ptr<const Dataset>> alive;
  alive.push_back(make_analytic(data, {}, Task{}));
  const Dataset& dataset = *alive.back();
  const PointArray& array = dataset.arrays[0];
  const double span = array.upper - array.lower;
  const auto at = [&](double t) { return array.lower + t * span; };
  ExtractOptions options;
  options.facets = true;
  options.values = true;
  IntervalMesh mesh = extract_intervals(dataset.grid, array, {{{at(0.15), at(0.4)}, {at(0.4), at(0.7)}}}, options, Task{});
  std::vector<float> values(mesh.values.begin(), mesh.values.end());
  DrawInput input = input_of(std::move(mesh), opacity);
  input.grid = &dataset.grid;
  input.color_values = std::make_shared<const std::vector<float>>(std::move(values));
  input.width = 40;
  input.height = 30;
  return input;
}

void use_map(DrawInput& input, const char* map) {
  const auto [low, high] = std::minmax_element(input.color_values->begin(), input.color_values->end());
  for (IntervalStyle& style : input.styles) {
    style.color_map = map;
    style.color_lower = *low;
    style.color_upper = *high;
  }
}

// Pixels are sampled 1/2048 of their width beside their middles, so where an edge runs through one it may be on the other side.
OracleError expect_oracle(const DrawInput& input, const std::string& what, double mean = 1e-5, double share = 1e-3) {
  const OracleError error = compare_with_oracle(input, draw_floats(input, compute()));
  EXPECT_GT(error.covered, 0.1) << what;
  EXPECT_LT(error.mean, mean) << what << ", largest " << error.max << " at " << error.max_x << "," << error.max_y;
  EXPECT_LE(error.above_a_percent, share) << what << ", largest " << error.max << " at " << error.max_x << "," << error.max_y;
  return error;
}

constexpr const char* kGrids[] = {"torus:10", "cylinder:10x8x6", "tets:6", "mixed:6"};

Camera random_camera(const Box3d& bounds, std::mt19937& random, double distance) {
  std::uniform_real_distribution<double> number(-1, 1);
  Vec3d direction;
  do direction = {number(random), number(random), number(random)};
  while (!(length(direction) > 0.2));
  Camera camera;
  camera.at = bounds.center();
  camera.eye = camera.at + normalized(direction) * (distance * bounds.diagonal());
  camera.up = {number(random), number(random), 2.0};
  camera.fov_deg = 40;
  return camera;
}

TEST(Compute, TheFramesUniformBlockIsTheSameInBothLanguages) {
  const auto context = open_context(test_device());
  context->make_current();
  const GlFunctions& gl = context->gl();
  std::ifstream file(isostrata::places::source() + "/server/rendering/compute/tile_layout.h");
  const std::string layout{std::istreambuf_iterator<char>(file), {}};
  const GlObject program = make_compute_program(gl, layout.c_str(),
                                                "layout(local_size_x = 1) in;\n"
                                                "layout(std140, binding = 0) uniform FrameBlock { TileFrame frame; };\n"
                                                "layout(std430, binding = 1) buffer Out { TileFrame copied; };\n"
                                                "void main() { copied = frame; }\n",
                                                "");
#define MEMBER(name) \
  { #name, offsetof(shaders::TileFrame, name) }
  const std::pair<const char*, std::size_t> members[] = {MEMBER(right),    MEMBER(down),       MEMBER(forward), MEMBER(lens),
                                                         MEMBER(limits),   MEMBER(background), MEMBER(part),    MEMBER(keys),
                                                         MEMBER(eye_cell), MEMBER(room)};
#undef MEMBER
  EXPECT_EQ(std::size(members) * 16, sizeof(shaders::TileFrame)) << "a member is not named here";
  for (const auto& [name, offset] : members) {
    GLuint index = gl.GetProgramResourceIndex(program.name(), GL_UNIFORM, ("FrameBlock.frame." + std::string(name)).c_str());
    if (index == GL_INVALID_INDEX)
      index = gl.GetProgramResourceIndex(program.name(), GL_UNIFORM, ("frame." + std::string(name)).c_str());
    ASSERT_NE(index, GL_INVALID_INDEX) << name;
    const GLenum property = GL_OFFSET;
    GLint value = -1;
    gl.GetProgramResourceiv(program.name(), GL_UNIFORM, index, 1, &property, 1, nullptr, &value);
    EXPECT_EQ(static_cast<std::size_t>(value), offset) << name;
  }
}

TEST(Compute, ConstantColoursMeetTheOracleOnAllGrids) {
  std::mt19937 random(1);
  for (const char* data : kGrids) {
    DrawInput input = extracted_input(data);
    for (const double distance : {1.3, 0.6}) {
      input.camera = random_camera(input.bounds, random, distance);
      expect_oracle(input, std::string(data) + ", seed 1, distance " + std::to_string(distance));
    }
  }
}

TEST(Compute, ColourMapsMeetTheOracleOnAllGrids) {
  std::mt19937 random(2);
  for (const char* data : kGrids) {
    DrawInput input = extracted_input(data);
    use_map(input, "viridis");
    input.camera = random_camera(input.bounds, random, 1.3);
    expect_oracle(input, std::string(data) + ", seed 2", 2e-5);
  }
}

TEST(Compute, LinearExtinctionMeetsTheOracleHoweverThick) {
  DrawInput input = extracted_input("torus:10", 0.05);
  use_map(input, "coolwarm");
  for (IntervalStyle& style : input.styles) style.opacity_upper = 0.95;
  for (const double unit : {0.01, 0.3, 5.0}) {
    input.unit_distance = unit;
    expect_oracle(input, "unit distance " + std::to_string(unit), 2e-5);
  }
}

TEST(Compute, Table2dMeetsTheOracle) {
  DrawInput input = extracted_input("torus:10");
  use_map(input, "viridis");
  input.integral = Integral::table2d;
  expect_oracle(input, "table2d", 2e-5);
}

TEST(Compute, ParallelRaysMeetTheOracleFromAllSides) {
  DrawInput input = extracted_input("torus:10");
  std::mt19937 random(3);
  for (const char* side : {"+x", "-y", "+z", "reset"}) {
    input.camera = view_of(input.bounds, side);
    const Vec3d aside =
        Vec3d{0.0137, 0.0071, 0.0093} * input.bounds.diagonal();  // no ray lies in a face: the oracle has no rule then
    input.camera.eye = input.camera.eye + aside;
    input.camera.at = input.camera.at + aside;
    input.camera.orthographic = true;
    expect_oracle(input, side);
  }
  for (int trial = 0; trial < 2; ++trial) {
    input.camera = random_camera(input.bounds, random, 0.3);
    input.camera.fov_deg = 90;
    input.camera.orthographic = true;
    expect_oracle(input, "seed 3, trial " + std::to_string(trial));
  }
}

TEST(Compute, StraightViewsOfARegularGridHaveNoSeams) {
  const RectilinearGrid shape = even_grid(4, 4, 4, {-1, -1, -1}, {1, 1, 1});
  const Grid grid{shape, {}, {}};
  DrawInput input = input_of(box_mesh(shape, [](auto i, auto j, auto k) { return static_cast<int>((i + j + k) % 2); }), 0.5);
  input.grid = &grid;
  input.styles[1] = input.styles[0];  // one solid, cut along the rays
  input.styles[1].color = {0, 0, 1};
  input.width = input.height = 48;
  input.unit_distance = 1;
  for (const char* side : {"+x", "-x", "+y", "-y", "+z", "-z"}) {
    input.camera = view_of(input.bounds, side);
    input.camera.orthographic = true;
    input.camera.fov_deg =
        2 * 180 / 3.14159265358979 * std::atan(1.2 / length(input.camera.eye));  // 20 pixels a unit: cells of 40/3
    const FloatImage image = draw_floats(input, compute());
    int covered = 0;
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 48; ++x) {
        const float alpha = pixel(image, x, y)[3];
        if (x > 4 && x < 43 && y > 4 && y < 43) {
          EXPECT_NEAR(alpha, 0.75, 1e-5) << side << " " << x << "," << y;
        }
        covered += alpha > 0;
      }
    EXPECT_EQ(covered, 1600) << side;
  }
}

TEST(Compute, AnEyeInsideMeetsTheOracle) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-0.6, 0.6);
  DrawInput input = extracted_input("torus:10", 0.4);
  for (int trial = 0; trial < 4; ++trial) {
    input.camera = {{number(random), number(random), 0.2 * number(random)},
                    {number(random), number(random), number(random)},
                    {0.1, 1, 0.3},
                    80};
    expect_oracle(input, "seed 4, trial " + std::to_string(trial), 2e-5);
  }
  input.camera.eye = input.mesh->positions[input.mesh->tetrahedra[7][2]];  // on a vertex
  expect_oracle(input, "on a vertex", 1e-4, 5e-3);
}

TEST(Compute, ClipPlanesCutEachRayExactly) {
  DrawInput input = extracted_input("torus:10");
  input.clip_planes = {{{1, 0.3, -0.2}, -0.1}, {{0, -2, 0.5}, -1.1}};
  expect_oracle(input, "perspective");
  input.camera.orthographic = true;
  expect_oracle(input, "orthographic");
}

TEST(Compute, SurfacesMeetTheOracleInTheirPlaceAmongTheVolume) {
  for (const char* data : {"torus:10", "mixed:6"}) {
    DrawInput input = extracted_input(data, 0.3);
    input.styles[0].surface.lower = input.styles[0].surface.domain = true;
    input.styles[0].surface.opacity = 0.5;
    input.styles[0].surface.silhouette = 0.8;
    input.styles[1].surface.upper = true;
    input.styles[1].surface.own_color = true;
    input.styles[1].surface.color = {0.2f, 0.9f, 0.4f};
    expect_oracle(input, data, 1e-4, 4e-3);
  }
}

TEST(Compute, TexturesAndNormalsOfThePointsMeetTheOracle) {
  DrawInput input = extracted_input("torus:10", 0.2);
  std::vector<Vec3f> normals;
  std::vector<float> texture;
  for (const Vec3d& p : input.mesh->positions) {
    const Vec3d n = length(p) > 0 ? normalized(p) : Vec3d{0, 0, 1};
    normals.push_back({static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)});
    texture.push_back(static_cast<float>(p.x));
  }
  input.normals = std::make_shared<const std::vector<Vec3f>>(std::move(normals));
  input.texture_values = std::make_shared<const std::vector<float>>(std::move(texture));
  for (IntervalStyle& style : input.styles) {
    style.surface.lower = style.surface.upper = true;
    style.surface.opacity = 0.7;
    style.surface.texture_repeat = 2;
  }
  input.styles[0].surface.texture = "stripes";
  input.styles[1].surface.texture = "plasma";
  use_map(input, "viridis");
  expect_oracle(input, "textures", 2e-4, 4e-3);
}

TEST(Compute, PrioritiesMeetTheOracle) {
  DrawInput input = extracted_input("mixed:6", 0.7);
  input.mode = RenderMode::prioritized;
  input.styles[1].priority = 3;
  expect_oracle(input, "constant");
  EXPECT_EQ(compute().draw(input).facts.order, "priority (none needed)");
  input = extracted_input("torus:10", 0.7);
  input.mode = RenderMode::prioritized;
  use_map(input, "viridis");
  input.styles[0].priority = 3;
  expect_oracle(input, "mapped", 2e-5);
  EXPECT_THAT(compute().draw(input).facts.order, HasSubstr("priority, then index distance"));
}

TEST(Compute, OneColourNeedsNoOrder) {
  DrawInput input = extracted_input("mixed:6");
  input.styles[1].color = input.styles[0].color;
  input.styles[1].opacity = 0.1;
  expect_oracle(input, "one colour");
  const DrawFacts facts = compute().draw(input).facts;
  EXPECT_EQ(facts.order, "none needed");
  EXPECT_TRUE(facts.order_exact);
}

TEST(Compute, ManyBatchesOfATileAreOnePicture) {
  DrawInput input = extracted_input("torus:22", 0.2);
  input.width = input.height = 14;  // one tile for all tetrahedra
  EXPECT_GT(input.mesh->tetrahedra.size(), 5000u);
  const OracleError error = expect_oracle(input, "one tile", 3e-5, 5e-3);
  EXPECT_LT(error.max, 0.05);
  EXPECT_TRUE(compute().draw(input).facts.order_exact) << compute().draw(input).facts.order;
}

TEST(Compute, DepthIsThatOfTheNearestLight) {
  DrawInput input = extracted_input("torus:10");
  for (const bool orthographic : {false, true}) {
    input.camera.orthographic = orthographic;
    const OracleImage expected = oracle_image(input);
    const FloatImage image = draw_floats(input, compute());
    int wrong = 0;
    for (std::size_t i = 0; i < image.depth.size(); ++i)
      wrong +=
          std::isinf(expected.depth[i]) ? !std::isinf(image.depth[i]) : !(std::abs(expected.depth[i] - image.depth[i]) < 2e-3);
    EXPECT_LE(wrong, 2) << "orthographic " << orthographic;
  }
}

TEST(Compute, CountsTheFragmentsThatRasterCounts) {
  DrawInput input = extracted_input("torus:10");
  input.count_fragments = true;
  const auto by_raster = static_cast<double>(test_renderer().draw(input).facts.fragments);
  const DrawFacts facts = compute().draw(input).facts;
  EXPECT_NEAR(static_cast<double>(facts.fragments), by_raster, 0.01 * by_raster);
  EXPECT_EQ(facts.renderer, "compute");
  ASSERT_EQ(facts.stages.size(), 6u);
  EXPECT_EQ(facts.stages[2].name, "sort");
}

TEST(Compute, EightBitsAreTheFloatsOverTheBackground) {
  expect_bytes_of_floats(extracted_input("torus:10", 0.3), compute(), 0.53, 0.6);
}

TEST(Compute, AWidePictureInPartsIsRastersPicture) {
  DrawInput input = extracted_input("torus:10");
  input.width = 4200;
  input.height = 5;
  input.camera.fov_deg = 0.3;
  const Image parts = draw_bytes(input, compute()), whole = draw_bytes(input);
  int different = 0, covered = 0;
  for (std::size_t i = 0; i < parts.rgba.size(); ++i) {
    different += std::abs(parts.rgba[i] - whole.rgba[i]) > 2;
    covered += i % 4 < 3 && whole.rgba[i] > 0;
  }
  EXPECT_GT(covered, 1000);
  EXPECT_LE(different, 40);
}

TEST(Compute, AWindowOfALargerPictureIsThatPartOfIt) {
  DrawInput input = extracted_input("torus:10");
  use_map(input, "viridis");
  for (const bool orthographic : {false, true}) {
    input.camera.orthographic = orthographic;
    const FloatImage whole = draw_floats(input, compute());
    DrawInput part = input;
    part.window = {11, 7, input.width, input.height};
    part.width = 20;
    part.height = 15;
    const FloatImage image = draw_floats(part, compute());
    for (int y = 0; y < 15; ++y)
      for (int x = 0; x < 20; ++x) {
        EXPECT_NEAR(pixel(image, x, y)[0], pixel(whole, x + 11, y + 7)[0], 1e-4) << x << "," << y;
        EXPECT_NEAR(pixel(image, x, y)[3], pixel(whole, x + 11, y + 7)[3], 1e-4) << x << "," << y;
      }
  }
}

TEST(Compute, RoomForPairsGrowsWithThePictures) {
  DrawInput small = extracted_input("torus:6"), large = extracted_input("torus:10");
  const auto renderer = make_renderer({"compute", test_device()});  // knows no need yet
  draw_bytes(small, *renderer);
  large.width = 400;
  large.height = 300;  // many tiles a tetrahedron
  EXPECT_EQ(draw_bytes(large, *renderer).rgba, draw_bytes(large, compute()).rgba);
}

TEST(Compute, AnEmptyMeshAndHiddenIntervalsAreTheBackground) {
  DrawInput input;
  input.mesh = std::make_shared<const IntervalMesh>();
  input.bounds = Box3d{{-1, -1, -1}, {1, 1, 1}};
  input.camera = view_of(input.bounds, "reset");
  input.width = 3;
  input.height = 2;
  input.background = {1.0f, 0.5f, 0.0f};
  EXPECT_EQ(pixel(draw_bytes(input, compute()), 2, 1), (std::array<int, 4>{255, 128, 0, 255}));
  DrawInput hidden = extracted_input("torus:10");
  for (IntervalStyle& style : hidden.styles) style.visible = false;
  EXPECT_EQ(pixel(draw_bytes(hidden, compute()), 20, 15), (std::array<int, 4>{0, 0, 0, 255}));
}

TEST(Compute, SliversAndFlatTetrahedraGiveNoMoreThanTheirLength) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int trial = 0; trial < 8; ++trial) {
    const double thickness = trial % 4 == 0 ? 0.0 : std::pow(10, -4.0 * (trial % 4));
    IntervalMesh mesh;
    for (int i = 0; i < 3; ++i) add_point(mesh, {number(random), number(random), number(random)});
    const Vec3d in_plane = mesh.positions[0] * 0.3 + mesh.positions[1] * 0.4 + mesh.positions[2] * 0.3;
    add_point(mesh, in_plane + Vec3d{number(random), number(random), number(random)} * thickness);
    add_tetrahedron(mesh, {0, 1, 2, 3}, 0);
    double longest = 0;
    for (const Vec3d& a : mesh.positions)
      for (const Vec3d& b : mesh.positions) longest = std::max(longest, length(a - b));
    DrawInput input = input_of(mesh, 0.5);
    input.bounds = Box3d{{-2, -2, -2}, {2, 2, 2}};
    input.unit_distance = 1;
    input.camera = {{number(random) * 2, number(random) * 2, 5}, mesh.positions[0], {0, 1, 0}, 30};
    const FloatImage image = draw_floats(input, compute());
    const double most = 1 - std::exp(-extinction(0.5, 1) * longest) + 1e-5;
    for (const float v : image.rgba)
      ASSERT_TRUE(v >= 0 && v <= most) << v << " above " << most << ", trial " << trial << ", seed 5";
    EXPECT_LT(compare_with_oracle(input, image).mean, 1e-5) << "trial " << trial << ", seed 5";
  }
}

// As a driver does after it has reset a device: llvmpipe never does, so its function is replaced.
TEST(Compute, ALostContextIsAClearErrorAndTheNextPictureWorks) {
  auto context = open_context(test_device());
  auto& functions = const_cast<GlFunctions&>(context->gl());
  const auto renderer = make_compute_renderer(std::move(context), test_device());
  const DrawInput input = extracted_input("torus:6");
  const Image before = draw_bytes(input, *renderer);
  functions.GetGraphicsResetStatus = [] { return static_cast<GLenum>(GL_INNOCENT_CONTEXT_RESET); };
  try {
    renderer->draw(input);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::unavailable);
    EXPECT_THAT(error.what(), HasSubstr("reset"));
  }
  EXPECT_EQ(draw_bytes(input, *renderer).rgba, before.rgba);
}

// On a software device only if it is asked for.
TEST(RendererTrial, TheFasterOfRasterAndComputeIsKept) {
  const auto renderer = make_renderer({"auto", test_device(), true});
  const std::string report = renderer_trial_report();
  const std::string kept = renderer->draw(extracted_input("torus:6")).facts.renderer;
  EXPECT_TRUE(kept == "raster" || kept == "compute") << kept;
  EXPECT_TRUE(report.starts_with(kept + ": ")) << report;
  EXPECT_THAT(report, HasSubstr(" ms a frame in the trial; " + std::string(kept == "raster" ? "compute " : "raster ")));
  EXPECT_THAT(report, HasSubstr(renderer->device()));
  const auto again = make_renderer({"auto", test_device(), true});
  EXPECT_EQ(renderer_trial_report(), report);  // remembered: a second trial would have other times
  EXPECT_EQ(again->draw(extracted_input("torus:6")).facts.renderer, kept);
}

TEST(RendererTrial, ANamedSoftwareDeviceIsDrawnOnByRasterWithoutOne) {
  if (!open_context("surfaceless")->software()) GTEST_SKIP() << "no software device is at hand";
  EXPECT_EQ(make_renderer({"auto", "surfaceless"})->draw(extracted_input("torus:6")).facts.renderer, "raster");
}

TEST(RendererTrial, WhatDoesNotWorkIsNotTheFaster) {
  RendererTrial trial{"a device", 2.5, 0, "", "too few buffers"};
  EXPECT_FALSE(trial.compute_is_faster());
  EXPECT_EQ(trial.report(), "raster: 2.50 ms a frame in the trial; compute does not work: too few buffers (a device)");
  trial = {"a device", 2.5, 1.25, "", ""};
  EXPECT_EQ(trial.report(), "compute: 1.25 ms a frame in the trial; raster 2.50 ms (a device)");
  trial = {"a device", 0, 1.25, "no blending", ""};
  EXPECT_TRUE(trial.compute_is_faster());
}

}  // namespace
}  // namespace isostrata
