#include "rendering/native_renderer.h"

#include <algorithm>
#include <new>

#include "base/error.h"
#include "base/parallel.h"
#include "rendering/check_draw_input.h"
#include "rendering/draw_crossings.h"
#include "rendering/draw_segments.h"
#include "rendering/project_vertices.h"

namespace isostrata {
namespace {

class NativeRenderer final : public Renderer {
 public:
  DrawResult draw(const DrawInput& input) override {
    check(input);
    try {
      DrawResult result;
      result.facts.renderer = "native";
      result.facts.device = device_;
      TileSink sink(input);
      const bool constant = std::all_of(input.styles.begin(), input.styles.end(),
                                        [](const IntervalStyle& style) { return !style.visible || style.constant(); });
      if (constant && input.cut_intervals.empty())
        crossings_.draw(input, sink, result.facts);
      else
        segments_.draw(input, sink, result.facts);
      result.image = sink.take();
      return result;
    } catch (const std::bad_alloc&) {
      throw Error(ErrorCode::too_large,
                  "picture of " + std::to_string(input.width) + "x" + std::to_string(input.height) + ": out of memory");
    }
  }
  const std::string& device() const override { return device_; }

 private:
  const std::string device_ = std::string("CPU (") + vector_name() + ", " + std::to_string(thread_count()) +
                              (thread_count() == 1 ? " thread)" : " threads)");
  CrossingsRenderer crossings_;
  SegmentsRenderer segments_;
};

}  // namespace

std::unique_ptr<Renderer> make_native_renderer() { return std::make_unique<NativeRenderer>(); }

}  // namespace isostrata
