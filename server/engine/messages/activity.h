// What each thread of an engine is at, in a form that another process can read while the engine runs, hangs or is dead: plain
// atomic numbers in memory that both share. It is how a watchdog tells slow from stuck, and what names the cause afterwards.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "base/pulse.h"

namespace isostrata {

enum class Stage : std::uint32_t { idle, starting, opening, extracting, drawing, encoding };
std::string to_string(Stage stage);  // "drawing"

/// One thread's. The thread that owns it writes, anybody reads.
struct Activity {
  std::atomic<std::uint32_t> stage{0};     // Stage
  std::atomic<std::uint32_t> patience{1};  // how many times longer than usual it may go without a pulse
  std::atomic<std::uint32_t> waiting{0};   // threads of the work that wait for its turn: then it does nothing
  std::atomic<std::uint64_t> session{0}, request{0}, operation{0};
  Pulse pulse{0};
};

/// Zeroed memory is a board on which everybody is idle.
struct ActivityBoard {
  static constexpr std::size_t kSlots = 256;
  static constexpr std::size_t kRenderThread = 0;  // its slot moves its pulse while idle, too
  std::array<Activity, kSlots> slots;
};
static_assert(Pulse::is_always_lock_free && std::atomic<std::uint32_t>::is_always_lock_free);

/// Says on the board what this thread does until it goes out of scope, and gives the thread its pulse. Where the board is null or
/// every slot is taken it does nothing.
class Doing {
 public:
  Doing(ActivityBoard* board, Stage stage, std::uint64_t session, std::uint64_t request, std::uint64_t operation = 0,
        std::uint32_t patience = 1);
  /// In the render thread's own slot.
  struct OnRenderThread {};
  Doing(OnRenderThread, ActivityBoard* board, Stage stage, std::uint64_t session, std::uint64_t request, std::uint32_t patience);
  ~Doing();
  Doing(const Doing&) = delete;
  Doing& operator=(const Doing&) = delete;

  /// Where Work says that it waits for its turn; null without a slot.
  std::atomic<std::uint32_t>* waiting() const { return slot_ ? &slot_->waiting : nullptr; }

 private:
  static Activity* take(ActivityBoard* board, Stage stage);
  Activity* const slot_;
  const PulseScope scope_;
};

/// A copy of one slot at one moment.
struct ActivityFacts {
  std::size_t slot = 0;
  Stage stage = Stage::idle;
  std::uint32_t patience = 1;
  std::uint64_t session = 0, request = 0, operation = 0, pulse = 0;
  bool waits = false;  // for its turn
};

/// Those that are not idle, and the render thread's, which is first. What stands there is not trusted: a stage that is none is
/// idle.
std::vector<ActivityFacts> read(const ActivityBoard& board);

}  // namespace isostrata
