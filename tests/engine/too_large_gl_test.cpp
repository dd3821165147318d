// A device whose buffers hold 1 MiB: what does not fit there is drawn by the CPU, and what fits by the device as before.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "engine/engine/engine.h"
#include "engine/heard_events.h"
#include "rendering/choice/device_or_native.h"
#include "rendering/choice/native_renderer.h"
#include "rendering/compute/compute_renderer.h"
#include "rendering/raster/gl_renderer.h"

namespace isostrata {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// What the replaced functions do; the render thread calls them.
constexpr GLint64 kLargest = 1 << 20;
GlFunctions real;
std::atomic<int> opened{0}, programs{0}, refused{0};

void APIENTRY at_most_a_mebibyte(GLenum name, GLint64* value) {
  real.GetInteger64v(name, value);
  if (name == GL_MAX_SHADER_STORAGE_BLOCK_SIZE) *value = std::min(*value, kLargest);
}
GLuint APIENTRY counted_program() {
  ++programs;
  return real.CreateProgram();
}

/// Counts what is thrown, behind which a device that is not asked again cannot hide.
class Counted final : public Renderer {
 public:
  explicit Counted(std::unique_ptr<Renderer> renderer) : renderer_(std::move(renderer)) {}
  DrawResult draw(const DrawInput& input) override {
    try {
      return renderer_->draw(input);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::too_large) << error.what();
      ++refused;
      throw;
    }
  }
  const std::string& device() const override { return renderer_->device(); }

 private:
  const std::unique_ptr<Renderer> renderer_;
};

class TooLarge : public ::testing::TestWithParam<const char*>, protected HeardEvents {
 protected:
  void start(std::function<std::unique_ptr<Renderer>()> renderer) {
    engine_.reset();
    EngineOptions options;
    options.catalogue = Catalogue::from_sources({"torus:12", "torus:48"});
    options.renderer = std::move(renderer);
    engine_ = std::make_unique<Engine>(std::move(options), [this](EngineEvent event) { note(std::move(event)); });
  }
  ~TooLarge() override { engine_.reset(); }

  static std::unique_ptr<Renderer> cramped(bool compute) {
    auto context = open_context("surfaceless");
    ++opened;
    real = context->gl();
    context->gl_to_break().GetInteger64v = at_most_a_mebibyte;
    context->gl_to_break().CreateProgram = counted_program;
    return make_device_or_native(std::make_unique<Counted>(compute ? make_compute_renderer(std::move(context), "surfaceless")
                                                                   : make_gl_renderer(std::move(context), "surfaceless")));
  }
  FrameReady draw(std::uint64_t revision, const std::string& dataset, int width = 64) {
    Scene wanted = scene(revision, 0.5, dataset);
    wanted.intervals[0].surface.upper = true;  // raster keeps facets on the device, and a mesh only of a GPU
    engine_->post(SceneUpdate{1, wanted});
    FrameRequest request = frame(1, ++request_, true);
    request.width = width;
    request.height = 48;
    engine_->post(request);
    return frame_of(request_);
  }

  std::unique_ptr<Engine> engine_;
  RequestId request_ = 0;
};

TEST_P(TooLarge, IsDrawnByTheCpuAsLongAsThatMeshIsShown) {
  const bool compute = GetParam() == std::string("compute");
  start([=] { return cramped(compute); });
  opened = programs = refused = 0;
  const FrameReady small = draw(1, "torus-12");
  EXPECT_THAT(small.device, AllOf(StartsWith("llvmpipe"), Not(HasSubstr("in place of"))));
  const int compiled = programs;
  EXPECT_GT(compiled, 0);

  const FrameReady large = draw(2, "torus-48");
  EXPECT_THAT(large.device, AllOf(StartsWith("CPU"), HasSubstr("in place of llvmpipe"), HasSubstr("draw with native")));
  EXPECT_EQ(refused, 1);
  draw(3, "torus-48");
  draw(4, "torus-48", 96);
  EXPECT_EQ(refused, 1) << "nothing that needs as much is tried again";
  EXPECT_THAT(draw(5, "torus-48", 32).device, StartsWith("CPU"));
  EXPECT_EQ(refused, 2) << "a smaller picture might fit";

  const FrameReady again = draw(6, "torus-12");
  EXPECT_THAT(again.device, AllOf(StartsWith("llvmpipe"), Not(HasSubstr("in place of"))));
  EXPECT_EQ(*again.bytes, *small.bytes);
  EXPECT_EQ(opened, 0) << "the context is kept";
  EXPECT_EQ(programs, compiled) << "and so are its programs";

  start([] { return make_native_renderer(); });
  EXPECT_EQ(*draw(7, "torus-48").bytes, *large.bytes);
}

INSTANTIATE_TEST_SUITE_P(Renderers, TooLarge, ::testing::Values("compute", "raster"), [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace isostrata
