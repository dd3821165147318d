#include "rendering/choice/native_renderer.h"

#include <algorithm>
#include <new>

#include "base/error.h"
#include "base/parallel.h"
#include "base/simd_level.h"
#include "base/stopwatch.h"
#include "extraction/surfaces/interval_surfaces.h"
#include "rendering/crossings/draw_crossings.h"
#include "rendering/picture/check_draw_input.h"
#include "rendering/picture/lit_surfaces.h"
#include "rendering/segments/draw_segments.h"

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
      const bool constant = drawn_by_facets(input);
      const bool lit = std::any_of(input.styles.begin(), input.styles.end(),
                                   [](const IntervalStyle& style) { return style.visible && style.surface.drawn(); });
      if (input.bricks && !constant) throw Error(ErrorCode::invalid_argument, "picture: the CPU draws layers without a mesh in constant colours only");
      if (constant && !input.cut_intervals.empty() && (lit || !input.count_fragments))
        draw_surfaces(input, lit, sink, result.facts);
      else if (constant && input.cut_intervals.empty())
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
  bool cuts_intervals() const override { return true; }

 private:
  /// Of cut intervals in constant colours. The surfaces are kept as long as the ends stay.
  void draw_surfaces(const DrawInput& input, bool lit, TileSink& sink, DrawFacts& facts) {
    const Stopwatch watch;
    const bool with_normals = lit && lit_along_gradient(input);
    const bool same_base = surfaces_of_.lock() == input.base;
    if (!same_base) directions_.clear();
    if (!surfaces_ || !same_base || surfaces_between_ != input.cut_intervals || (with_normals && !normals_)) {
      SurfaceNormals normals;
      if (with_normals) {
        if (directions_.empty()) directions_ = point_directions(*input.base);
        normals.at_base = directions_;
      }
      surfaces_ = std::make_shared<const IntervalMesh>(
          interval_surfaces(*input.base, input.cut_intervals, with_normals ? &normals : nullptr));
      normals_ = with_normals ? std::make_shared<const std::vector<Vec3f>>(std::move(normals.normals)) : nullptr;
      surfaces_of_ = input.base;
      surfaces_between_ = input.cut_intervals;
    }
    DrawInput drawn = input;
    drawn.mesh = surfaces_;
    drawn.color_values = nullptr;
    drawn.normals = with_normals ? normals_ : nullptr;
    const double cut_ms = watch.elapsed_ms();
    crossings_.draw(drawn, sink, facts);
    facts.order_ms += cut_ms;
    facts.stages.push_back({"cut", cut_ms});
  }

  std::weak_ptr<const BaseTetrahedra> surfaces_of_;
  std::vector<Interval> surfaces_between_;
  std::shared_ptr<const IntervalMesh> surfaces_;       // of those
  std::shared_ptr<const std::vector<Vec3f>> normals_;  // at their points, if they were wanted
  std::vector<Vec3f> directions_;                      // at the base mesh's points, once surfaces were lit
  const std::string device_ =
      "CPU (" + simd_level() + ", " + std::to_string(thread_count()) + (thread_count() == 1 ? " thread)" : " threads)");
  CrossingsRenderer crossings_;
  SegmentsRenderer segments_;
};

}  // namespace

std::unique_ptr<Renderer> make_native_renderer() { return std::make_unique<NativeRenderer>(); }

bool needs_no_device(const Renderer& renderer) { return dynamic_cast<const NativeRenderer*>(&renderer) != nullptr; }

}  // namespace isostrata
