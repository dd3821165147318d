#include "session/people/viewer.h"

#include <algorithm>
#include <cmath>

#include "session/wire/wire.h"

namespace isostrata {

constexpr std::size_t kMaxNotedInputs = 4096;  // beyond it, what a frame is said to contain is too old, never too new

void Viewer::set_viewport(const v1::Viewport& wanted, TimePoint now) {
  viewport = wanted;
  auto width = static_cast<int>(viewport.width()), height = static_cast<int>(viewport.height());
  const double pixels = static_cast<double>(width) * height;
  const std::int64_t most = most_pixels();
  if (role == v1::ROLE_VIEWER && pixels > static_cast<double>(most)) {
    const double scale = std::sqrt(static_cast<double>(most) / pixels);
    const auto scaled = [&](int side, int other) {
      return std::clamp(static_cast<int>(side * scale), 1,
                        static_cast<int>(most / std::max(1, static_cast<int>(other * scale))));
    };
    const int wide = scaled(width, height);
    height = scaled(height, width);
    width = wide;
  }
  frames.set_viewport(width, height, viewport.hidden(), now);
}

std::optional<v1::Error> Viewer::refuse_still(const v1::RequestStill& still, TimePoint now) {
  if (role != v1::ROLE_VIEWER) return std::nullopt;
  const auto pixels = static_cast<std::int64_t>(still.width()) * still.height();
  if (pixels > most_pixels())
    return wire_error("too_large",
                      std::to_string(still.width()) + "x" + std::to_string(still.height()) + " pixels; expected at most " +
                          std::to_string(most_pixels()) + " for who may only look",
                      "width");
  if (const Duration wait = stills.wait(now); wait > Duration::zero())
    return wire_error("unavailable", "who may only look gets a still every " +
                                         std::to_string(static_cast<int>(1 / kViewerStillsPerSecond)) + " s; ask again in " +
                                         std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(wait).count()) +
                                         " ms");
  stills.take(1);
  return std::nullopt;
}

void Viewer::note_input(std::uint64_t seq, std::uint64_t revision) {
  if (!inputs_.empty() && inputs_.back().revision == revision)
    inputs_.back().seq = seq;
  else
    inputs_.push_back({revision, seq});
  if (inputs_.size() > kMaxNotedInputs) inputs_.erase(inputs_.begin() + 1);
}

std::uint64_t Viewer::input_of(std::uint64_t revision) {
  while (!inputs_.empty() && inputs_.front().revision <= revision) {
    contained_seq_ = inputs_.front().seq;
    // The newest entry stays: more messages of the same revision may still be noted on it.
    if (inputs_.size() == 1) break;
    inputs_.pop_front();
  }
  return contained_seq_;
}

}  // namespace isostrata
