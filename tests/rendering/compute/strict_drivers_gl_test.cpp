// What a driver may do that software does not: leave garbage in new buffers, round two programs differently, take long.
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "rendering/compute/compute_renderer.h"
#include "rendering/raster/gl_renderer.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using namespace testing;

// Functions of the device that a test has put something before; one test at a time.
PFNGLNAMEDBUFFERSTORAGEPROC real_storage = nullptr;
PFNGLSHADERSOURCEPROC real_source = nullptr;
PFNGLDISPATCHCOMPUTEINDIRECTPROC real_dispatch = nullptr;
int dispatches = 0, perturbed = 0;

void APIENTRY garbage_storage(GLuint buffer, GLsizeiptr bytes, const void* data, GLbitfield flags) {
  const std::vector<unsigned char> garbage(data ? 0 : static_cast<std::size_t>(bytes), 0xff);
  real_storage(buffer, bytes, data ? data : garbage.data(), flags);
}

/// The program that fills in what another has counted sees all of it a little larger.
void APIENTRY perturbed_source(GLuint shader, GLsizei count, const GLchar* const* text, const GLint* lengths) {
  std::string whole;
  for (GLsizei i = 0; i < count; ++i) whole += lengths && lengths[i] >= 0 ? std::string(text[i], static_cast<std::size_t>(lengths[i])) : std::string(text[i]);
  const std::string from = "frame.lens.x";
  if (whole.find("#define FILL\n") != std::string::npos) {
    for (std::size_t at = 0; (at = whole.find(from, at)) != std::string::npos; at += 30, ++perturbed) whole.replace(at, from.size(), "(frame.lens.x * 1.0000005)");
  }
  const GLchar* one = whole.c_str();
  real_source(shader, 1, &one, nullptr);
}

void APIENTRY counted_dispatch(GLintptr at) {
  ++dispatches;
  real_dispatch(at);
}

DrawInput mapped(const char* data) {
  static std::vector<std::shared_ptr<const Dataset>> alive;
  const Dataset& dataset = *alive.emplace_back(make_analytic(data, {}, Task{}));
  const PointArray& array = dataset.arrays[0];
  const auto at = [&](double t) { return array.lower + t * (array.upper - array.lower); };
  ExtractOptions options;
  options.values = true;
  IntervalMesh mesh = extract_intervals(dataset.grid, array, {{{at(0.15), at(0.4)}, {at(0.4), at(0.7)}}}, options, Task{});
  auto values = std::make_shared<const std::vector<float>>(mesh.values.begin(), mesh.values.end());
  DrawInput input = input_of(std::move(mesh), 0.5);
  input.grid = &dataset.grid;
  input.color_values = std::move(values);
  for (std::size_t i = 0; i < input.styles.size(); ++i) {
    input.styles[i].color_map = "viridis";
    input.styles[i].color_lower = array.lower;
    input.styles[i].color_upper = array.upper;
  }
  input.camera = view_of(input.bounds, "reset");
  input.camera.eye = input.camera.eye + Vec3d{0.131, 0.077, 0.053} * input.bounds.diagonal();
  input.width = 64;
  input.height = 48;
  return input;
}

/// Pictures of a renderer whose device has been changed by `change`.
template <class Make, class Change>
std::vector<std::uint8_t> bytes_with(Make make, Change change, const DrawInput& input) {
  auto context = open_context(test_device());
  change(context->gl_to_break());
  return draw_bytes(input, *make(std::move(context), test_device())).rgba;
}

TEST(StrictDrivers, GarbageInNewBuffersIsNotDrawn) {
  const auto compute = [](auto context, const std::string& name) { return make_compute_renderer(std::move(context), name); };
  const auto raster = [](auto context, const std::string& name) { return make_gl_renderer(std::move(context), name); };
  const auto as_it_is = [](GlFunctions&) {};
  const auto dirty = [](GlFunctions& gl) {
    real_storage = gl.NamedBufferStorage;
    gl.NamedBufferStorage = garbage_storage;
  };
  for (const char* data : {"torus:10", "tets:6"}) {
    const DrawInput input = mapped(data);
    EXPECT_EQ(bytes_with(compute, dirty, input), bytes_with(compute, as_it_is, input)) << data;
    EXPECT_EQ(bytes_with(raster, dirty, input), bytes_with(raster, as_it_is, input)) << data;
  }
}

TEST(StrictDrivers, WhatIsFilledInNeedNotBeJustWhatWasCounted) {
  const DrawInput input = mapped("torus:10");
  const auto compute = [](auto context, const std::string& name) { return make_compute_renderer(std::move(context), name); };
  const auto expected = bytes_with(compute, [](GlFunctions&) {}, input);
  perturbed = 0;
  const auto drawn = bytes_with(compute, [](GlFunctions& gl) {
    real_source = gl.ShaderSource;
    gl.ShaderSource = perturbed_source;
  }, input);
  EXPECT_GT(perturbed, 0);
  int apart = 0;
  for (std::size_t i = 0; i < drawn.size(); ++i) apart += std::abs(int{drawn[i]} - int{expected[i]}) > 1;
  EXPECT_LE(apart, 8);  // a tile's edge
}

TEST(StrictDrivers, SlicesOfAPictureMakeTheSamePicture) {
  DrawInput input = mapped("torus:24");
  input.width = 640;
  input.height = 480;
  auto context = open_context(test_device());
  real_dispatch = context->gl().DispatchComputeIndirect;
  context->gl_to_break().DispatchComputeIndirect = counted_dispatch;
  const auto renderer = make_compute_renderer(std::move(context), test_device());
  draw_bytes(input, *renderer);  // finds out how much room it needs
  std::vector<int> counts;
  std::vector<std::vector<std::uint8_t>> pictures;
  std::vector<double> blend_ms;
  for (int i = 0; i < 3; ++i) {
    dispatches = 0;
    const DrawResult drawn = renderer->draw(input);
    counts.push_back(dispatches);
    for (const StageTime& stage : drawn.facts.stages)
      if (stage.name == "blend") blend_ms.push_back(stage.ms);
    pictures.push_back(std::get<Image>(drawn.image).rgba);
    EXPECT_EQ(pictures[static_cast<std::size_t>(i)], pictures[0]);
    input.width = i == 0 ? 16 : 640;  // a small picture takes one slice after it
    input.height = i == 0 ? 16 : 480;
    if (i == 0) {
      renderer->draw(input);
      renderer->draw(input);
      input.width = 640;
      input.height = 480;
    }
  }
  ASSERT_EQ(blend_ms.size(), 3u);
  if (blend_ms[1] < 30) GTEST_SKIP() << "this device blends all of it in " << blend_ms[1] << " ms";
  EXPECT_GT(counts[2], counts[1]) << "the third in slices, the second after a small one";
}

}  // namespace
}  // namespace isostrata
