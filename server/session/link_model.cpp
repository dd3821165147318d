#include "session/link_model.h"

#include <algorithm>

namespace isostrata {
namespace {

constexpr Duration kLong =
    std::chrono::milliseconds(1500);                        // by the clock, so that a link that became fast is known as such soon
constexpr double kLongPassage = 0.5, kShortPassage = 0.12;  // by seconds of passing, so that one that became slow is, at once
constexpr std::size_t kMaxFlying = 4096;
constexpr double kLeastPassage = 1e-4;  // clocks and threads are no better than that

double seconds(Duration d) { return std::chrono::duration<double>(d).count(); }
Duration duration(double s) { return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s)); }

}  // namespace

void LinkModel::sent(std::uint64_t frame, std::size_t bytes, TimePoint now) {
  flying_.push_back({frame, bytes, now});
  if (flying_.size() > kMaxFlying) flying_.pop_front();
}

void LinkModel::acknowledged(std::uint64_t frame, Duration decode, TimePoint now) {
  const auto it = std::find_if(flying_.begin(), flying_.end(), [&](const Flying& f) { return f.frame == frame; });
  if (it == flying_.end()) return;
  const Duration trip = now - it->at;
  decode = std::clamp(decode, Duration::zero(), trip);
  note_round_trip(trip - decode, now);
  last_decode_ = decode;
  // All that came before has passed in one go with it, as far as can be told.
  double bytes = 0;
  for (auto each = flying_.begin(); each <= it; ++each) bytes += static_cast<double>(each->bytes);
  const TimePoint first_sent = flying_.front().at;
  const TimePoint passed = std::max(now - decode - shortest_round_trip(), first_sent);
  const TimePoint began = std::max(first_sent, last_passed_);
  const Duration waited = std::max(last_passed_ - first_sent, Duration::zero());
  queue_delay_ += (waited - queue_delay_) / 4;
  passages_.push_back({now, bytes, std::max(seconds(passed - began), kLeastPassage)});
  while (now - passages_.front().at > kMemory || passages_.size() > 256) passages_.pop_front();
  last_passed_ = std::max(passed, last_passed_);
  flying_.erase(flying_.begin(), it + 1);
}

void LinkModel::round_trip(Duration time, TimePoint now) { note_round_trip(std::max(time, Duration::zero()), now); }

void LinkModel::note_round_trip(Duration time, TimePoint now) {
  while (!round_trips_.empty() && round_trips_.back().second >= time) round_trips_.pop_back();
  round_trips_.emplace_back(now, time);
  while (now - round_trips_.front().first > kMemory) round_trips_.pop_front();
}

Duration LinkModel::shortest_round_trip() const { return round_trips_.empty() ? Duration::zero() : round_trips_.front().second; }

// How long the oldest frame in flight has been passing, by what is known now.
double LinkModel::overdue_seconds(TimePoint now) const {
  if (flying_.empty()) return 0;
  const TimePoint began = std::max(flying_.front().at, last_passed_);
  return std::max(0.0, seconds(now - last_decode_ - shortest_round_trip() - began));
}

double LinkModel::bytes_per_second(TimePoint now) const {
  double bytes = 0, passing = 0, lately = 0;
  bool has_short = false;
  for (auto it = passages_.rbegin(); it != passages_.rend(); ++it) {
    if (it != passages_.rbegin() && (now - it->at > kLong || passing > kLongPassage)) break;
    bytes += it->bytes;
    passing += it->seconds;
    if (!has_short && passing >= kShortPassage) {
      has_short = true;
      lately = bytes / passing;
    }
  }
  if (bytes <= 0) return 0;
  double rate = bytes / passing;
  if (has_short) rate = std::min(rate, lately);
  if (const double overdue = overdue_seconds(now); overdue > 0) {
    const auto oldest = static_cast<double>(flying_.front().bytes);
    if (oldest < rate * overdue) rate = std::min(rate, (bytes + oldest) / (passing + overdue));
  }
  return rate;
}

TimePoint LinkModel::free_at(TimePoint now) const {
  const double rate = bytes_per_second(now);
  if (flying_.empty() || rate <= 0) return now;
  // What has not been heard of may have passed up to one round trip ago; beyond its time it passes any moment, but not before.
  const TimePoint heard_of = now - shortest_round_trip() - last_decode_;
  TimePoint free = last_passed_;
  bool oldest = true;
  for (const Flying& each : flying_) {
    free = std::max(free, each.at) + duration(static_cast<double>(each.bytes) / rate);
    if (std::exchange(oldest, false)) free = std::max(free, heard_of);
  }
  return free;
}

std::size_t LinkModel::bytes_in_flight() const {
  std::size_t bytes = 0;
  for (const Flying& each : flying_) bytes += each.bytes;
  return bytes;
}

}  // namespace isostrata
