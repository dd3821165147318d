// Everything that a picture may ask for, drawn by projected tetrahedra and compared with the oracle.
#include <gtest/gtest.h>

#include <random>

#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/surfaces/gradient_normals.h"
#include "rendering/raster/gl_renderer.h"
#include "support/oracle.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using namespace testing;

struct Extracted {
  std::shared_ptr<const Dataset> dataset;
  DrawInput input;
};

/// Intervals in the middle of the array's range, with facets.
Extracted extracted(const char* data, int intervals, double opacity) {
  Extracted out{make_analytic(data, {}, Task{}), {}};
  const PointArray& array = out.dataset->arrays[0];
  const double low = array.lower, span = array.upper - array.lower;
  std::vector<Interval> wanted;
  for (int i = 0; i < intervals; ++i) wanted.push_back({low + (0.1 + 0.2 * i) * span, low + (0.25 + 0.2 * i) * span});
  ExtractOptions options;
  options.facets = true;
  IntervalMesh mesh = extract_intervals(out.dataset->grid, array, wanted, options, Task{});
  std::vector<float> values(mesh.values.begin(), mesh.values.end());
  out.input = input_of(std::move(mesh), opacity);
  out.input.grid = &out.dataset->grid;
  out.input.color_values = std::make_shared<const std::vector<float>>(std::move(values));
  out.input.width = 48;
  out.input.height = 36;
  return out;
}

class RasterPictures : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    renderer_ = make_gl_renderer(open_context(test_device()), "surfaceless",
                                 GetParam() == std::string("cpu") ? ProjectOn::cpu : ProjectOn::device);
  }
  void meets(const DrawInput& input, double mean, double max, const std::string& what) {
    const OracleError error = compare_with_oracle(input, draw_floats(input, *renderer_));
    RecordProperty(what + " mean", std::to_string(error.mean * 1e6) + "e-6");
    RecordProperty(what + " max", std::to_string(error.max));
    EXPECT_GT(error.covered, 0.05) << what;
    EXPECT_LT(error.mean, for_triangles(mean, 2)) << what << " max " << error.max << " at " << error.max_x << "," << error.max_y;
    EXPECT_LT(error.max, max) << what << " at " << error.max_x << "," << error.max_y << " mean " << error.mean;
  }
  std::unique_ptr<Renderer> renderer_;
};

// Where the rasterizer's grid of 1/256 pixel decides otherwise than the oracle a pixel on an edge of a big tetrahedron may show
// what a sliver lets through; these pictures have few.
constexpr double kMean = 6e-5, kMax = 0.03;

TEST_P(RasterPictures, ParallelRaysMeetTheOracle) {
  Extracted e = extracted("torus:9", 3, 0.6);
  e.input.camera.orthographic = true;
  for (const Vec3d eye : {Vec3d{3, 2.2, 4}, Vec3d{-4, 0.3, 0.2}, Vec3d{0.1, 0.2, 0.3}}) {  // the last is inside
    e.input.camera.eye = eye;
    e.input.camera.fov_deg = length(eye) < 1 ? 140 : 30;
    meets(e.input, kMean, kMax, "seen from " + std::to_string(eye.x));
  }
}

TEST_P(RasterPictures, ShadedBodiesMeetTheOracle) {
  Extracted e = extracted("torus:9", 3, 0.6);
  e.input.body_shading = 0.9;
  e.input.body_normals = std::make_shared<const std::vector<Vec3f>>(
      gradient_normals(*e.input.grid, e.dataset->arrays[0], *e.input.mesh, Task{}, NormalsAt::all_points));
  for (const bool mapped : {false, true}) {
    if (mapped)
      for (IntervalStyle& style : e.input.styles) style.color_map = "viridis";
    for (const bool orthographic : {false, true}) {
      e.input.camera.orthographic = orthographic;
      e.input.camera.eye = {3, 2.2, 4};
      meets(e.input, kMean, kMax, std::string(mapped ? "viridis" : "constant") + (orthographic ? ", orthographic" : ""));
    }
  }
  e.input.camera.orthographic = false;
  e.input.camera.eye = {0.6, 0.2, 0.1};  // among the tetrahedra: some are clipped
  meets(e.input, 1e-3, 0.3, "from inside");
  e.input.camera.eye = {3, 2.2, 4};
  e.input.clip_planes = {{{1, 0, 0}, 0.1}};
  meets(e.input, kMean, kMax, "clipped");
}

TEST_P(RasterPictures, ParallelRaysZoomedInMeetTheOracle) {  // tetrahedra reach far beyond the picture
  Extracted e = extracted("torus:6", 3, 0.6);
  e.input.camera.orthographic = true;
  e.input.camera.at = {0.5, 0.3, 0.1};
  e.input.camera.fov_deg = 0.2;
  meets(e.input, 1e-4, kMax, "zoomed in");
}

TEST_P(RasterPictures, ClipPlanesCutToThePixel) {
  Extracted e = extracted("torus:9", 3, 0.6);
  for (IntervalStyle& style : e.input.styles) {
    style.color_map = "viridis";
    style.color_lower = 0.1;
    style.color_upper = 1;
  }
  e.input.clip_planes = {{{0.3, 0.2, -1}, -0.4}, {{-2, 1, 0.1}, -0.9}, {{0, 0, 0}, -1}};
  meets(e.input, kMean, kMax, "two planes");
  e.input.camera.orthographic = true;
  meets(e.input, kMean, kMax, "two planes, parallel rays");
  e.input.camera = {{0.013, 0.007, 4}, {0, 0, 0}, {0, 1, 0}, 30};  // not along the walls of cells
  e.input.clip_planes = {{{0, 0, 1}, 0.123}};
  meets(e.input, kMean, kMax, "a plane across the rays");
  e.input.clip_planes.push_back({{0, 0, -1}, 0});
  const FloatImage nothing = draw_floats(e.input, *renderer_);
  for (const float v : nothing.rgba) ASSERT_EQ(v, 0.0f);
}

TEST_P(RasterPictures, LinearExtinctionMeetsTheOracle) {
  for (const char* map : {"", "viridis"})
    for (const double unit : {0.03, 0.3, 3.0}) {
      Extracted e = extracted("marschner-lobb:7", 3, 0.1);
      for (IntervalStyle& style : e.input.styles) {
        style.color_map = map;
        style.color_lower = 0.2;
        style.color_upper = 0.5;  // values beyond stay at its end
        style.opacity_upper = 0.9;
      }
      std::swap(e.input.styles[1].opacity, *e.input.styles[1].opacity_upper);
      e.input.unit_distance = unit;
      e.input.camera.orthographic = unit == 0.3;
      meets(e.input, *map ? 2e-4 : 5e-5, 0.03, std::string(map) + " unit distance " + std::to_string(unit));
    }
}

TEST_P(RasterPictures, TheTableIsNearItself) {
  Extracted e = extracted("torus:9", 3, 0.3);
  for (IntervalStyle& style : e.input.styles) {
    style.color_map = "viridis";
    style.color_lower = 0.1;
    style.color_upper = 1;
    style.opacity_upper = 0.7;
  }
  e.input.styles[2] = constant_style({0, 0, 1}, 0.4);
  e.input.integral = Integral::table2d;
  meets(e.input, 3e-4, 1e-2, "the table");
}

TEST_P(RasterPictures, SurfacesLieInOrderWithTheVolume) {
  for (const char* data : {"torus:8", "tets:5", "mixed:5", "cylinder:10x8x6"}) {
    Extracted e = extracted(data, 3, 0.5);
    const bool grid = std::string(data).starts_with("torus");
    for (std::size_t i = 0; i < 3; ++i) {
      SurfaceStyle& surface = e.input.styles[i].surface;
      surface.lower = i != 1;
      surface.upper = i != 0;
      surface.domain = i == 2;
      surface.opacity = 0.3 + 0.2 * static_cast<double>(i);
      surface.silhouette = i == 0 ? 0.8 : 0;
      surface.own_color = i == 1;
    }
    e.input.styles[2].color_map = "plasma";
    e.input.styles[2].opacity = 0;  // only its surface
    // A pixel on the edge of a facet may get its neighbour: another facet normal, not another normal of the field. Off
    // rectilinear grids the order by centroids has errors of its own.
    meets(e.input, grid ? 1e-4 : 4e-3, 1.0, std::string(data) + ", facet normals");
    e.input.normals = std::make_shared<const std::vector<Vec3f>>(
        gradient_normals(e.dataset->grid, e.dataset->arrays[0], *e.input.mesh, Task{}));
    meets(e.input, grid ? 1e-4 : 4e-3, 1.0, std::string(data) + ", gradients");
    e.input.texture_values = e.input.color_values;
    e.input.styles[0].surface.texture = "stripes";
    e.input.styles[1].surface.texture = "gray";
    e.input.styles[0].surface.texture_repeat = 5;
    e.input.camera.orthographic = true;
    e.input.clip_planes = {{{0.3, 0.2, -1}, -0.3}};
    meets(e.input, grid ? 1e-4 : 4e-3, 1.0, std::string(data) + ", textures, cut");
  }
}

TEST_P(RasterPictures, AnEyeInsideSeesSurfacesAndVolume) {
  Extracted e = extracted("torus:8", 3, 0.4);
  for (IntervalStyle& style : e.input.styles) style.surface.upper = true, style.surface.opacity = 0.5;
  std::mt19937 random(61);
  std::uniform_real_distribution<double> number(-0.8, 0.8);
  for (int trial = 0; trial < 6; ++trial) {
    e.input.camera = {
        {number(random), number(random), number(random)}, {number(random), number(random), number(random)}, {0.1, 1, 0.3}, 70};
    if (trial == 0) e.input.camera.eye = e.input.mesh->positions[e.input.mesh->tetrahedra[17][2]];  // on a vertex
    meets(e.input, 2e-3, 1.0, "trial " + std::to_string(trial) + ", seed 61");
  }
}

TEST_P(RasterPictures, PrioritiesArePaintedWithTheirSurfaces) {
  Extracted e = extracted("torus:8", 3, 0.4);
  e.input.mode = RenderMode::prioritized;
  for (std::size_t i = 0; i < 3; ++i) {
    e.input.styles[i].priority = i == 0 ? 2 : 1;
    e.input.styles[i].surface.lower = i == 0;
    e.input.styles[i].surface.opacity = 0.5;
  }
  meets(e.input, 1e-3, 1.0, "priorities");
}

INSTANTIATE_TEST_SUITE_P(Projection, RasterPictures, ::testing::Values("cpu", "device"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace isostrata
