// Devices that fail: contexts lost in the middle of a frame, memory that is not there. The functions of a real context are
// replaced by some that fail as a driver's would; the frame ends with a clear error or with the right picture, and the next one
// works.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "base/error.h"
#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "rendering/raster/gl_renderer.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using namespace testing;
using ::testing::HasSubstr;

// What the replaced functions do; contexts and tests live on one thread.
thread_local bool lost = false;
thread_local int calls = 0;
thread_local GLsizeiptr largest = 0;  // of a buffer that there is room for
thread_local GLenum pending_error = GL_NO_ERROR;
thread_local GlFunctions real;

GLenum APIENTRY reset_status() { return lost ? GL_UNKNOWN_CONTEXT_RESET : GL_NO_ERROR; }
GLenum APIENTRY lost_error() { return lost ? GL_CONTEXT_LOST : real.GetError(); }
void APIENTRY draw_and_lose(GLenum mode, GLint first, GLsizei count) {
  if (++calls == 2) lost = true;
  if (!lost) real.DrawArrays(mode, first, count);
}
void APIENTRY dispatch_and_lose(GLuint, GLuint, GLuint) { lost = true; }
GLenum APIENTRY wait_failed(GLsync, GLbitfield, GLuint64) { return lost ? GL_WAIT_FAILED : GL_ALREADY_SIGNALED; }
void APIENTRY storage_up_to(GLuint buffer, GLsizeiptr size, const void* data, GLbitfield flags) {
  if (size > largest)
    pending_error = GL_OUT_OF_MEMORY;
  else
    real.NamedBufferStorage(buffer, size, data, flags);
}
void APIENTRY no_texture(GLuint, GLsizei, GLenum, GLsizei, GLsizei) { pending_error = GL_OUT_OF_MEMORY; }
GLenum APIENTRY take_error() {
  return pending_error != GL_NO_ERROR ? std::exchange(pending_error, GL_NO_ERROR) : real.GetError();
}

DrawInput torus(const char* data = "torus:10") {
  static std::vector<std::shared_ptr<const Dataset>> alive;
  alive.push_back(make_analytic(data, {}, Task{}));
  const Dataset& dataset = *alive.back();
  ExtractOptions options;
  options.facets = true;
  DrawInput input = input_of(
      extract_intervals(dataset.grid, dataset.arrays[0], std::vector<Interval>{{0.1, 0.3}, {0.3, 0.5}}, options, Task{}), 0.5);
  input.grid = &dataset.grid;
  return input;
}

class Trouble : public ::testing::Test {
 protected:
  Trouble() : context_(open_context(test_device())) {
    lost = false;
    calls = 0;
    largest = 0;
    pending_error = GL_NO_ERROR;
    real = context_->gl();
    expected_ = draw_bytes(torus());
    context_->make_current();
  }
  GlFunctions& gl() { return context_->gl_to_break(); }
  std::unique_ptr<Renderer> renderer(ProjectOn project_on) {
    its_functions_ = &context_->gl_to_break();  // valid until the renderer opens another context
    return make_gl_renderer(std::move(context_), test_device(), project_on);
  }
  static std::string failure(Renderer& renderer, const DrawInput& input, ErrorCode code) {
    try {
      renderer.draw(input);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      return error.what();
    }
    ADD_FAILURE() << "no failure";
    return "";
  }
  std::unique_ptr<GlContext> context_;
  GlFunctions* its_functions_ = nullptr;
  Image expected_;
};

TEST_F(Trouble, AContextLostInTheMiddleOfAFrameFailsThatFrameOnly) {
  gl().GetGraphicsResetStatus = reset_status;
  gl().DrawArrays = draw_and_lose;  // the tetrahedra are drawn, the resolve finds the context gone
  const auto lossy = renderer(ProjectOn::cpu);
  EXPECT_THAT(failure(*lossy, torus(), ErrorCode::unavailable), HasSubstr("reset the device"));
  EXPECT_EQ(draw_bytes(torus(), *lossy).rgba, expected_.rgba);
}

TEST_F(Trouble, ADriverThatOnlySaysSoByAnErrorIsUnderstoodToo) {
  gl().GetGraphicsResetStatus = nullptr;
  gl().GetError = lost_error;
  gl().DrawArrays = draw_and_lose;
  const auto lossy = renderer(ProjectOn::cpu);
  EXPECT_THAT(failure(*lossy, torus(), ErrorCode::unavailable), HasSubstr("context was lost"));
  EXPECT_EQ(draw_bytes(torus(), *lossy).rgba, expected_.rgba);
}

TEST_F(Trouble, AContextLostWhileVerticesAreOnTheirWay) {
  gl().GetGraphicsResetStatus = reset_status;
  gl().ClientWaitSync = wait_failed;
  gl().DrawArrays = [](GLenum, GLint, GLsizei) APIENTRY { lost = true; };
  const auto lossy = renderer(ProjectOn::cpu);
  DrawInput much = torus("torus:60");  // more vertices than the stream's regions hold
  much.width = much.height = 1000;
  EXPECT_THAT(failure(*lossy, much, ErrorCode::unavailable), HasSubstr("lost"));
  EXPECT_EQ(draw_bytes(torus(), *lossy).rgba, expected_.rgba);
}

TEST_F(Trouble, AContextLostDuringProjection) {
  gl().GetGraphicsResetStatus = reset_status;
  gl().DispatchCompute = dispatch_and_lose;
  const auto lossy = renderer(ProjectOn::device);
  EXPECT_THAT(failure(*lossy, torus(), ErrorCode::unavailable), HasSubstr("reset the device"));
  const Image next = draw_bytes(torus(), *lossy);  // projected on the device, in single precision
  int worst = 0;
  for (std::size_t i = 0; i < next.rgba.size(); ++i) worst = std::max(worst, std::abs(next.rgba[i] - expected_.rgba[i]));
  EXPECT_LE(worst, 1);
}

TEST_F(Trouble, AMeshThatTheDeviceHasNoRoomForIsProjectedHere) {
  const auto cramped = renderer(ProjectOn::device);
  DrawInput input = torus();
  largest = 4096;  // from now on; what a context begins with is there
  const auto device_of = [&] { return cramped->draw(input).facts.device; };
  EXPECT_EQ(device_of(), cramped->device());
  input = torus();
  its_functions_->NamedBufferStorage = storage_up_to;
  its_functions_->GetError = take_error;
  for (const char* when : {"the mesh is new", "the mesh is known"}) {
    EXPECT_EQ(draw_bytes(input, *cramped).rgba, expected_.rgba) << when;
    EXPECT_THAT(device_of(), HasSubstr("projected by the CPU")) << when;
  }
}

TEST_F(Trouble, FacetsThatTheDeviceHasNoRoomForAreAClearError) {
  const auto cramped = renderer(ProjectOn::cpu);
  DrawInput input = torus();
  for (IntervalStyle& style : input.styles) style.surface.upper = true;
  largest = 4096;
  its_functions_->NamedBufferStorage = storage_up_to;
  its_functions_->GetError = take_error;
  EXPECT_THAT(failure(*cramped, input, ErrorCode::too_large), HasSubstr("boundary facets"));
  EXPECT_EQ(draw_bytes(torus(), *cramped).rgba, expected_.rgba);
}

TEST_F(Trouble, APictureThatTheDeviceHasNoRoomForIsAClearError) {
  const auto cramped = renderer(ProjectOn::cpu);
  its_functions_->TextureStorage2D = no_texture;
  its_functions_->GetError = take_error;
  EXPECT_THAT(failure(*cramped, torus(), ErrorCode::too_large), HasSubstr("64x48"));
  its_functions_->TextureStorage2D = real.TextureStorage2D;  // the context is kept
  EXPECT_EQ(draw_bytes(torus(), *cramped).rgba, expected_.rgba);
}

TEST_F(Trouble, AMeshMadeWhereAnotherWasIsNotTakenForIt) {
  const auto kept = renderer(ProjectOn::device);
  for (int turn = 0; turn < 4; ++turn) {
    DrawInput input = torus(turn % 2 ? "torus:10" : "torus:9");
    const Image again = draw_bytes(input, *kept), fresh = draw_bytes(input);
    int worst = 0;
    for (std::size_t i = 0; i < again.rgba.size(); ++i) worst = std::max(worst, std::abs(again.rgba[i] - fresh.rgba[i]));
    EXPECT_LE(worst, 1) << turn;
  }
}

TEST_F(Trouble, ThousandsOfIntervalsHaveTheirOwnLooks) {
  const int n = 3000;
  IntervalMesh mesh;
  for (int i = 0; i < n; ++i) {
    const double x = i % 60, y = i / 60;
    add_box(mesh, {x, y, 0}, {x + 1, y + 1, 1}, static_cast<std::uint16_t>(i), i);
  }
  DrawInput input = input_of(std::move(mesh), 1.0);
  for (int i = 0; i < n; ++i)
    input.styles[static_cast<std::size_t>(i)].color = {static_cast<float>(i % 60) / 255, static_cast<float>(i / 60) / 255, 1};
  input.unit_distance = 1e-3;
  input.camera = {{30, 25, 100}, {30, 25, 0}, {0, 1, 0}, 30, true};
  input.width = 120;
  input.height = 100;
  input.camera.fov_deg = 2 * std::atan(25.0 / 100) * 180 / std::numbers::pi;  // 2 pixels a box
  for (const ProjectOn where : {ProjectOn::cpu, ProjectOn::device}) {
    const auto drawn = make_gl_renderer(open_context(test_device()), "surfaceless", where);
    const Image image = draw_bytes(input, *drawn);
    for (int y = 0; y < 50; ++y)
      for (int x = 0; x < 60; ++x)
        ASSERT_EQ(pixel(image, 2 * x, 99 - 2 * y), (std::array<int, 4>{x, y, 255, 255})) << x << "," << y;
  }
}

}  // namespace
}  // namespace isostrata
