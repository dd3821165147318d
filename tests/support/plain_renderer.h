// A renderer without OpenGL: one colour a picture, made from what it was asked to draw. For tests of what happens around drawing.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>

#include "base/error.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// What tests see and steer; any thread.
struct PlainRendererControl {
  std::atomic<int> drawn{0};
  std::atomic<int> delay_ms{0};
  std::atomic<bool> fail{false};
  std::atomic<bool> noise{false};  // pictures that no encoder makes small, instead of one colour
};

class PlainRenderer final : public Renderer {
 public:
  explicit PlainRenderer(std::shared_ptr<PlainRendererControl> control) : control_(std::move(control)) {}

  DrawResult draw(const DrawInput& input) override {
    if (control_->delay_ms > 0) std::this_thread::sleep_for(std::chrono::milliseconds(control_->delay_ms));
    ++control_->drawn;
    if (control_->fail) throw Error(ErrorCode::unavailable, "the plain renderer was told to fail");
    // The first interval's share of the tetrahedra as red, the camera's place as green.
    const auto byte = [](double v) { return static_cast<std::uint8_t>(std::fmod(std::abs(v), 256.0)); };
    const std::uint8_t red = byte(input.mesh->summaries.empty() ? 0 : static_cast<double>(input.mesh->summaries[0].tetrahedra));
    const std::uint8_t green = byte(input.camera.eye.x * 16);
    Image image{
        input.width, input.height,
        std::vector<std::uint8_t>(static_cast<std::size_t>(input.width) * static_cast<std::size_t>(input.height) * 4, 255)};
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
      image.rgba[i] = red;
      image.rgba[i + 1] = green;
      image.rgba[i + 2] = 77;
    }
    if (control_->noise) {
      std::uint32_t state = 1;
      for (std::uint8_t& value : image.rgba) value = static_cast<std::uint8_t>((state = state * 1664525u + 1013904223u) >> 24);
    }
    DrawFacts facts;
    facts.device = device_;
    facts.order = "none needed";
    facts.order_exact = true;
    facts.tetrahedra = static_cast<std::int64_t>(input.mesh->tetrahedra.size());
    if (!input.float_image) return {std::move(image), std::move(facts)};
    FloatImage floats{input.width, input.height, {}, {}};
    for (const std::uint8_t value : image.rgba) floats.rgba.push_back(static_cast<float>(value) / 255);
    if (input.mean_depth) floats.mean_depth.assign(image.rgba.size() / 4, 1);
    return {std::move(floats), std::move(facts)};
  }
  const std::string& device() const override { return device_; }

 private:
  const std::shared_ptr<PlainRendererControl> control_;
  const std::string device_ = "plain";
};

}  // namespace isostrata
