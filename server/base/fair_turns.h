// Whose turn it is on cores that many share. Pure decisions on times that the caller passes in: no thread, no clock, no lock.
//
// One piece of work at a time has the turn. Work of a more urgent class takes it at once, and so does work of a session that is
// more than a turn behind; else it goes, after each kTurn, to the session that has had least time (start-time fair queueing after Goyal, Vin, Cheng, "Start-time Fair Queueing: A
// Scheduling Algorithm for Integrated Services Packet Switching Networks", 1996, with sessions as flows). Less urgent classes are
// not starved: what was passed over for as long as patience_of() says gets one turn.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>

namespace isostrata {

/// In the order of their urgency.
enum class WorkClass : std::uint8_t {
  encoding,   // such a picture's bytes, once it is drawn: a few milliseconds; the next drawing can wait
  frame,      // pictures that somebody waits for with a hand on the mouse
  scene,      // opening and extracting what they show
  still,      // single pictures, numbers
  background,  // exports, and what will be looked at soon
  idle         // what nobody waits for
};

/// Not thread-safe. Times are of any one clock that does not go back.
class FairTurns {
 public:
  using Time = std::chrono::nanoseconds;
  using Id = std::uint64_t;
  static constexpr Time kTurn = std::chrono::milliseconds(15);
  /// So much less than the others' a session's time may be that comes back after a pause: it does not save up while it is away.
  static constexpr Time kCredit = std::chrono::milliseconds(100);
  /// Turns of others that a class is passed over for, by one of its own: a quarter of the time is the least that it gets; a sixteenth, if nobody waits for it.
  static constexpr std::int64_t patience_of(WorkClass of) { return of == WorkClass::idle ? 15 : 3; }

  /// Work that wants the turn from now on, until end().
  Id begin(std::uint64_t session, WorkClass of, Time now);
  void end(Id id, Time now);
  /// `from` waits for `to`, which is as urgent as `from` from now on, if it was less.
  void lend_urgency(Id from, Id to, Time now);
  /// The work goes on. Work that did not say so in a whole turn (it waits for a disk, or is at what cannot be divided) gets no other
  /// one before it does.
  void step(Id id);
  /// Who has the turn now; 0: nobody wants it.
  Id holder(Time now);
  /// When holder() is to be asked again, unless something begins, ends or steps.
  Time turn_ends() const { return turn_began_ + kTurn; }

 private:
  struct Session {
    Time used{0};
    int works = 0;
  };
  struct Work {
    std::uint64_t session = 0;
    WorkClass of = WorkClass::frame;
    bool goes_on = true;  // said so since its turn began, or has had none
  };
  static constexpr std::size_t kClasses = 6;

  void charge(Time now);
  Id best() const;
  bool is_before(Id a, Id b) const;
  bool takes_at_once(const Work& next, const Work& has) const;
  bool is_passed_over(WorkClass of) const { return passed_over_[static_cast<std::size_t>(of)] >= patience_of(of) * kTurn; }

  std::map<Id, Work> works_;
  std::map<std::uint64_t, Session> sessions_;  // that have work, and those whose time is not forgotten yet
  std::array<Time, kClasses> passed_over_{};   // of classes that have work, less what they got
  Id holder_ = 0, next_ = 1;
  bool due_ = false;  // the turn was given to a class that had been passed over: nobody takes it away
  Time turn_began_{0}, charged_{0};
  Time least_{0};  // the time that was used by whoever had the turn last: where newcomers begin
};

}  // namespace isostrata
