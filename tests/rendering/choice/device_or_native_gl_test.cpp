#include "rendering/choice/device_or_native.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "data/dataset/analytic.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/bricks/layer_bricks.h"
#include "extraction/intervals/extract_intervals.h"
#include "rendering/choice/native_renderer.h"
#include "rendering/compute/compute_renderer.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using namespace testing;
using ::testing::HasSubstr;

GlFunctions real;

void APIENTRY at_most_64_kib(GLenum name, GLint64* value) {
  real.GetInteger64v(name, value);
  if (name == GL_MAX_SHADER_STORAGE_BLOCK_SIZE) *value = 1 << 16;
}

std::unique_ptr<Renderer> cramped() {
  auto context = open_context(test_device());
  real = context->gl();
  context->gl_to_break().GetInteger64v = at_most_64_kib;
  return make_device_or_native(make_compute_renderer(std::move(context), test_device()));
}

TEST(DeviceOrNative, LayersThatTheDeviceCannotExtractAreThoseOfTheCpusMesh) {
  const auto field = make_analytic("torus:40", {}, Task{});  // 256,000 bytes
  const std::vector<Interval> intervals{{0.1, 0.25}, {0.25, 0.5}};
  BrickMemory memory;
  auto found = find_layer_bricks(field, field->arrays[0], intervals, memory, 0, std::uint64_t{1} << 32, Task{});
  ASSERT_TRUE(found);
  ExtractOptions options;
  options.values = true;
  IntervalMesh mesh = extract_intervals(field->grid, field->arrays[0], intervals, options, Task{});
  const auto values = std::make_shared<const std::vector<float>>(mesh.values.begin(), mesh.values.end());
  DrawInput here = input_of(std::move(mesh), 0.5), there = here;
  here.color_values = values;
  there.mesh = std::make_shared<const IntervalMesh>(std::move(found->mesh));
  there.bricks = std::move(found->bricks);
  for (DrawInput* input : {&here, &there}) {
    input->grid = &field->grid;
    for (IntervalStyle& style : input->styles) style.color_map = "viridis";
  }

  const auto device = cramped(), native = make_native_renderer();
  for (const char* side : {"reset", "-x"}) {
    here.camera = there.camera = view_of(here.bounds, side);
    const DrawResult drawn = device->draw(there);
    EXPECT_THAT(drawn.facts.device, HasSubstr("in place of"));
    EXPECT_EQ(std::get<Image>(drawn.image).rgba, draw_bytes(here, *native).rgba) << side;
  }
  for (IntervalStyle& style : there.styles) style.color_map.clear();  // the native renderer needs no mesh of these
  here.styles = there.styles;
  here.color_values = nullptr;
  const Image with_mesh = draw_bytes(here, *native), without = draw_bytes(there, *device);
  int worst = 0;
  for (std::size_t i = 0; i < without.rgba.size(); ++i) worst = std::max(worst, std::abs(without.rgba[i] - with_mesh.rgba[i]));
  EXPECT_LE(worst, 1);
}

}  // namespace
}  // namespace isostrata
