#include "session/pacing/link_model.h"

#include <algorithm>

#include "session/pacing/seconds.h"

namespace isostrata {
namespace {

constexpr Duration kLong =
    std::chrono::milliseconds(1500);                        // by the clock, so that a link that became fast is known as such soon
constexpr double kLongPassage = 0.5, kShortPassage = 0.12;  // by seconds of passing, so that one that became slow is, at once
constexpr std::size_t kMaxFlying = 4096;
constexpr double kGrain = 0.015, kDelay = 0.05;  // seconds: what threads and timers are late by, often and seldom
constexpr double kLeastPassage = 1e-4;           // clocks and threads are no better than that

enum class Word { none, doubtful, good };

// What should pass within the grain says nothing about the rate, since what it was late by was something else; where it
// is very late, the next one must say so too. But nothing is early by accident.
Word word_of(double bytes, double passing, double known_rate) {
  if (known_rate <= 0 || bytes >= known_rate * passing) return Word::good;
  const double expected = bytes / known_rate;
  if (expected >= kGrain) return Word::good;
  return passing > expected + kDelay ? Word::doubtful : Word::none;
}

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
  // What a decoder needs is the client's own matter; what it needs more than usual are frames that wait for it.
  decode_ = passages_.empty() ? decode : std::min(decode, decode_ + (decode - decode_) / 16);
  // All that came before has passed in one go with it, as far as can be told.
  double bytes = 0;
  for (auto each = flying_.begin(); each <= it; ++each) bytes += static_cast<double>(each->bytes);
  const TimePoint first_sent = flying_.front().at;
  const TimePoint passed = std::max(now - decode_ - shortest_round_trip(), first_sent);
  const TimePoint began = std::max(first_sent, last_passed_);
  const Duration waited = std::max(last_passed_ - first_sent, Duration::zero());
  queue_delay_ += (waited - queue_delay_) / 4;
  double passing = std::max(seconds(passed - began), kLeastPassage);
  Word word = word_of(bytes, passing, mean_rate());
  // Of frames that pass close behind each other, what one was late by the next one makes good: together they say more than one
  // by one.
  if (waited == Duration::zero()) run_ = {};
  run_.bytes += bytes;
  run_.seconds += passing;
  if (word == Word::none && run_.seconds >= kShortPassage && run_.bytes >= mean_rate() * 2 * kGrain) {
    word = Word::good;
    bytes = run_.bytes;
    passing = run_.seconds;
  }
  const bool doubted = !passages_.empty() && passages_.back().seconds < 0;
  if (word != Word::doubtful && doubted) passages_.pop_back();
  if (word == Word::doubtful && doubted) passages_.back().seconds *= -1;
  if (word != Word::none) {
    passages_.push_back({now, bytes, word == Word::doubtful && !doubted ? -passing : passing});
    run_ = {};
  }
  if (passages_.size() > 256) passages_.pop_front();
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
  return std::max(0.0, seconds(now - decode_ - shortest_round_trip() - began));
}

double LinkModel::mean_rate() const {
  double bytes = 0, passing = 0, lately = 0;
  for (auto it = passages_.rbegin(); it != passages_.rend(); ++it) {
    if (it->seconds < 0) continue;
    if (bytes > 0 && (passages_.back().at - it->at > kLong || passing > kLongPassage)) break;
    bytes += it->bytes;
    passing += it->seconds;
    if (lately == 0 && passing >= kShortPassage) lately = bytes / passing;
  }
  if (bytes <= 0) return 0;
  return lately > 0 ? std::min(bytes / passing, lately) : bytes / passing;
}

double LinkModel::bytes_per_second(TimePoint now) const {
  const double rate = mean_rate();
  if (rate <= 0 || flying_.empty()) return rate;
  const double overdue = overdue_seconds(now);
  const auto oldest = static_cast<double>(flying_.front().bytes);
  if (overdue <= 0 || oldest >= rate * overdue || word_of(oldest, overdue, rate) != Word::good) return rate;
  // As if it passed now, after others at the rate that was known.
  return std::min(rate, (kShortPassage * rate + oldest) / (kShortPassage + overdue));
}

TimePoint LinkModel::free_at(TimePoint now) const {
  const double rate = bytes_per_second(now);
  if (flying_.empty() || rate <= 0) return now;
  // What has not been heard of may have passed up to one round trip ago; beyond its time it passes any moment, but not before.
  const TimePoint heard_of = now - shortest_round_trip() - decode_;
  TimePoint free = last_passed_;
  bool oldest = true;
  for (const Flying& each : flying_) {
    free = std::max(free, each.at) + duration(static_cast<double>(each.bytes) / rate);
    if (std::exchange(oldest, false)) free = std::max(free, heard_of);
  }
  return free;
}

}  // namespace isostrata
