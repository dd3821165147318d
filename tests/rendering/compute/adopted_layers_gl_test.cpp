// Layers whose mesh renderer compute makes on the device, against the same layers from the CPU's mesh.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "data/dataset/analytic.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/bricks/layer_bricks.h"
#include "extraction/intervals/extract_intervals.h"
#include "rendering/compute/compute_renderer.h"
#include "support/oracle.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using namespace testing;
using ::testing::HasSubstr;

using Field = std::shared_ptr<const Dataset>;

Field torus(const char* name = "torus:12") { return make_analytic(name, {}, Task{}); }

/// The same values on planes that are not evenly spaced, the first axis turned round.
Field uneven_torus() {
  auto dataset = std::make_shared<Dataset>(*torus());
  RectilinearGrid grid{dataset->grid.dims(), {}};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::int64_t i = 0; i < dataset->grid.dims()[axis]; ++i) {
      const double t = static_cast<double>(i) / static_cast<double>(dataset->grid.dims()[axis] - 1);
      grid.axes[axis].push_back((axis == 0 ? -1 : 1) * (t + 0.3 * t * t) + 1000.0);
    }
  dataset->grid.shape = grid;
  dataset->bounds = dataset->grid.bounds();
  return dataset;
}

std::vector<Interval> two_intervals(const Field& field, double shift = 0) {
  const PointArray& array = field->arrays[0];
  const auto at = [&](double t) { return array.lower + (t + shift) * (array.upper - array.lower); };
  return {{at(0.15), at(0.4)}, {at(0.4), at(0.7)}};
}

/// Beside the axes: an edge that lies in the ray of a pixel is met or missed by a rounding.
Camera beside(const Box3d& bounds, const char* side) {
  Camera camera = view_of(bounds, side);
  camera.eye = camera.eye + Vec3d{0.131, 0.077, 0.053} * bounds.diagonal();
  return camera;
}

void style(DrawInput& input, const Field& field, const std::vector<Interval>& intervals) {
  input.grid = &field->grid;
  input.bounds = field->grid.bounds();
  for (const Interval& interval : intervals) {
    IntervalStyle& style = input.styles.emplace_back();
    style.opacity = 0.5;
    style.color_map = "viridis";
    style.color_lower = interval.lower;
    style.color_upper = interval.upper;
  }
  input.camera = beside(input.bounds, "reset");
  input.width = 48;
  input.height = 36;
}

DrawInput meshed(const Field& field, const std::vector<Interval>& intervals) {
  ExtractOptions options;
  options.values = true;
  IntervalMesh mesh = extract_intervals(field->grid, field->arrays[0], intervals, options, Task{});
  DrawInput input;
  input.color_values = std::make_shared<const std::vector<float>>(mesh.values.begin(), mesh.values.end());
  input.mesh = std::make_shared<const IntervalMesh>(std::move(mesh));
  style(input, field, intervals);
  return input;
}

DrawInput unmeshed(const Field& field, const std::vector<Interval>& intervals) {
  BrickMemory memory;
  auto found = find_layer_bricks(field, field->arrays[0], intervals, memory, 0, std::uint64_t{1} << 32, Task{});
  DrawInput input;
  if (!found) {
    ADD_FAILURE() << "no bricks";
    return input;
  }
  input.mesh = std::make_shared<const IntervalMesh>(std::move(found->mesh));
  input.bricks = std::move(found->bricks);
  style(input, field, intervals);
  return input;
}

class AdoptedLayers : public ::testing::Test {
 protected:
  /// The picture of the first is what the oracle makes of the second, in the same order.
  void expect_same(const DrawInput& there, const DrawInput& here, const std::string& what) {
    DrawInput floats = there;
    floats.float_image = true;
    const DrawResult drawn = there_->draw(floats);
    const DrawResult expected = here_->draw(here);
    const OracleError error = compare_with_oracle(here, std::get<FloatImage>(drawn.image));
    EXPECT_GT(error.covered, 0.1) << what;
    EXPECT_LT(error.mean, 5e-5) << what;
    EXPECT_LE(error.above_a_percent, 2e-3) << what;
    EXPECT_EQ(drawn.facts.tetrahedra, expected.facts.tetrahedra) << what;
    EXPECT_EQ(drawn.facts.order, expected.facts.order) << what;
  }

  const std::unique_ptr<Renderer> there_ = make_renderer({"compute", test_device()}), here_ = make_renderer({"compute", test_device()});
};

TEST_F(AdoptedLayers, AreThoseOfTheCpusMesh) {
  for (const Field& field : {torus(), uneven_torus()}) {
    const auto intervals = two_intervals(field);
    DrawInput there = unmeshed(field, intervals), here = meshed(field, intervals);
    for (const char* side : {"reset", "-z"})
      for (const bool orthographic : {false, true}) {
        there.camera = here.camera = beside(here.bounds, side);
        there.camera.orthographic = here.camera.orthographic = orthographic;
        expect_same(there, here, field->name + ", " + side);
      }
    there.camera.eye = here.camera.eye = here.bounds.center() + (here.bounds.upper - here.bounds.lower) * 0.1;  // inside
    expect_same(there, here, field->name + ", inside");
    there.mode = here.mode = RenderMode::prioritized;
    there.styles[1].priority = here.styles[1].priority = 3;
    there.styles[0].opacity_upper = here.styles[0].opacity_upper = 0.9;
    expect_same(there, here, field->name + ", by priority");
  }
}

TEST_F(AdoptedLayers, FollowMovedEndsOtherFieldsAndMeshes) {
  const Field a = torus(), b = torus("torus:13");
  for (const double shift : {0.0, 0.05, -0.1}) expect_same(unmeshed(a, two_intervals(a, shift)), meshed(a, two_intervals(a, shift)), "moved");
  expect_same(unmeshed(b, two_intervals(b)), meshed(b, two_intervals(b)), "another field");
  expect_same(meshed(a, two_intervals(a)), meshed(a, two_intervals(a)), "a mesh");
  expect_same(unmeshed(a, two_intervals(a)), meshed(a, two_intervals(a)), "the first field again");
}

TEST_F(AdoptedLayers, AreKnownByTheirBricks) {
  const Field field = torus();
  const DrawInput input = unmeshed(field, two_intervals(field));
  const auto mesh_ms = [&](const DrawResult& drawn) { return drawn.facts.stages.front(); };
  EXPECT_EQ(mesh_ms(there_->draw(input)).name, "mesh");
  const auto before = draw_bytes(input, *there_);
  DrawInput turned = input;
  turned.camera = beside(input.bounds, "+y");
  EXPECT_NE(draw_bytes(turned, *there_).rgba, before.rgba);
  EXPECT_EQ(draw_bytes(input, *there_).rgba, before.rgba);
}

TEST_F(AdoptedLayers, OthersSayThatTheyCannot) {
  const Field field = torus();
  const DrawInput input = unmeshed(field, two_intervals(field));
  EXPECT_TRUE(there_->extracts());
  for (const char* name : {"native", "raster"}) {
    const auto other = make_renderer({name, name == std::string("native") ? "native" : test_device()});
    EXPECT_FALSE(other->extracts()) << name;
    try {
      other->draw(input);
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("layers without a mesh")) << name;
    }
  }
}

}  // namespace
}  // namespace isostrata
