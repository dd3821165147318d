#include "rendering/choice/quicker_renderer.h"

#include <utility>

#include "base/stopwatch.h"
#include "rendering/choice/frame_judge.h"
#include "rendering/choice/native_renderer.h"
#include "rendering/picture/check_draw_input.h"

namespace isostrata {
namespace {

class QuickerRenderer final : public Renderer {
 public:
  explicit QuickerRenderer(std::unique_ptr<Renderer> device) : device_(std::move(device)) {}

  DrawResult draw(const DrawInput& input) override {
    const bool constant = drawn_by_facets(input);
    if (!input.mesh || !input.cut_intervals.empty() || (input.bricks && constant)) return native_->draw(input);
    if (input.bricks) return device_->draw(input);
    FrameJudge& judge = constant ? of_constant_ : of_running_;
    const bool other = judge.other_is_next(input.mesh);
    const Stopwatch watch;
    DrawResult result = (constant != other ? *native_ : *device_).draw(input);
    judge.took(input.mesh, other, watch.elapsed_ms());
    return result;
  }
  const std::string& device() const override { return device_->device(); }
  bool cuts_intervals() const override { return true; }
  bool extracts() const override { return device_->extracts(); }

 private:
  const std::unique_ptr<Renderer> device_, native_ = make_native_renderer();
  FrameJudge of_constant_, of_running_;
};

}  // namespace

std::unique_ptr<Renderer> make_quicker_renderer(std::unique_ptr<Renderer> device) { return std::make_unique<QuickerRenderer>(std::move(device)); }

}  // namespace isostrata
