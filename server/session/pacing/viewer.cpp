#include "session/pacing/viewer.h"

namespace isostrata {

constexpr std::size_t kMaxNotedInputs = 4096;  // beyond it, what a frame is said to contain is too old, never too new

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
