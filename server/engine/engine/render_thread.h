// The thread that owns the renderer of a device. A device that fails again and again is replaced by another renderer. A renderer that needs no device draws
// in lanes (draw_lanes.h); then this thread only shows that the engine lives.
#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "engine/engine/make_picture.h"
#include "engine/messages/activity.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// When another renderer has to take over: a plain count.
class DeviceFailures {
 public:
  static constexpr int kMost = 3;  // frames in a row

  /// Counts a frame that the device drew, or did not: why. Whether that is too often.
  bool note(const std::optional<std::string>& failure);
  /// What the replacement's frames say: what it replaces and why.
  std::string instead_of(const std::string& device) const;
  void forget() { in_a_row_ = 0; }

 private:
  int in_a_row_ = 0;
  std::string last_;
};

class RenderThread {
 public:
  using Make = std::function<std::unique_ptr<Renderer>()>;
  /// Called on the render thread.
  struct Ports {
    /// The renderer from now on, before its first picture; another one like it is made by `make`. instead: as in DrawLanes::draw_by.
    std::function<void(const Renderer& renderer, const Make& make, const std::string& instead)> take;
    enum class Turn { draw, idle, end };
    /// Waits for the next picture: it is `order`, or there was none for so long, or there will be none.
    std::function<Turn(std::chrono::milliseconds longest, std::optional<PictureOrder>& order)> wait;
    /// What can be drawn between two slices of `of`, by turns. Nothing: nobody waits.
    std::function<std::optional<PictureOrder>(const FrameRequest& of)> next_between;
    /// between: as FrameMaker::draw. Returns why the device failed, if it did. Does not throw.
    std::function<std::optional<std::string>(Renderer& renderer, PictureOrder order, const std::string& instead, const std::function<void()>& between)> draw;
  };

  /// Waits until the renderer is there, and throws what `make` throws. fallback: makes the replacement. board: as EngineOptions.
  RenderThread(Make make, Make fallback, ActivityBoard* board, Ports ports);
  /// Ports::wait must have said that it ends.
  ~RenderThread();

  /// Of the renderer that was asked for.
  const std::string& device() const { return device_; }

 private:
  void run(const Make& make, std::promise<std::string>& started);
  void draw_all(std::unique_ptr<Renderer> renderer);
  std::optional<std::string> draw(Renderer& renderer, PictureOrder order, const std::string& instead);

  const Make fallback_;
  ActivityBoard* const board_;
  const Ports ports_;
  std::string device_;
  std::thread thread_;
};

}  // namespace isostrata
