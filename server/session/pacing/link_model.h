// What acknowledgements tell about the way to one client: how far it is, how fast, and how much of what was sent still waits on
// it. Pure arithmetic on a clock that the caller passes in.
//
// The way is taken for a queue with one server (D. V. Lindley, The Theory of Queues with a Single Server, 1952): a frame begins
// to pass when it is sent or when the one before has passed, whichever is later, passes at the link's rate, and is heard of one
// shortest round trip afterwards. Acknowledgements give the times of passing, so each frame tells the rate by itself, also where
// the link is idle between frames, and how long it waited behind others (the queue delay). Sockets are not asked: what lies
// between here and the client (sshd, proxies) takes megabytes at once.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>

namespace isostrata {

using TimePoint = std::chrono::steady_clock::time_point;
using Duration = std::chrono::steady_clock::duration;

/// Frames are named by increasing ids. Not thread-safe.
class LinkModel {
 public:
  static constexpr Duration kMemory = std::chrono::seconds(10);  // of the shortest round trip

  void sent(std::uint64_t frame, std::size_t bytes, TimePoint now);
  /// decode: what the client says that it took; what is usual of it is not a fault of the way, and no more than the round trip is
  /// believed. Frames before it count as arrived with it. Unknown ids do nothing.
  void acknowledged(std::uint64_t frame, Duration decode, TimePoint now);
  /// The round trip of something without weight: a WebSocket ping.
  void round_trip(Duration time, TimePoint now);

  /// 0 while nothing is known. Falls, too, while an acknowledgement is overdue.
  double bytes_per_second(TimePoint now) const;
  /// The shortest round trip of the last ten seconds; 0 while nothing is known.
  Duration shortest_round_trip() const;
  /// How long frames waited behind others lately; smoothed over a few.
  Duration queue_delay() const { return queue_delay_; }
  /// When the link will have passed all that was sent; not later than now if it is idle or its rate is unknown.
  TimePoint free_at(TimePoint now) const;

  std::size_t in_flight() const { return flying_.size(); }
  /// When the oldest of what is in flight was sent; only while something is.
  TimePoint oldest() const { return flying_.front().at; }

 private:
  struct Flying {
    std::uint64_t frame;
    std::size_t bytes;
    TimePoint at;
  };
  struct Passage {
    TimePoint at{};
    double bytes = 0, seconds = 0;  // seconds < 0: doubtful, until the next one says the same
  };

  void note_round_trip(Duration time, TimePoint now);
  double mean_rate() const;
  double overdue_seconds(TimePoint now) const;

  std::deque<Flying> flying_;
  Passage run_;                                             // of frames that passed close behind each other and have told nothing yet
  std::deque<Passage> passages_;                            // the newest last
  std::deque<std::pair<TimePoint, Duration>> round_trips_;  // increasing in both: only what may become the shortest is kept
  TimePoint last_passed_{};
  Duration decode_{};  // that is usual
  Duration queue_delay_{};
};

}  // namespace isostrata
