#include "net/http/places.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace isostrata {

bool Places::make_room() {
  if (taken_.size() < most_) return true;
  std::map<std::string, std::size_t> strangers;  // of each address
  for (const auto& [id, of] : taken_)
    if (of.caller == Caller::stranger) ++strangers[of.address];
  auto victim = taken_.end();
  // The less the sooner.
  const auto rank = [&](const Taken& of) {
    return std::make_tuple(of.caller, of.caller == Caller::stranger ? most_ - std::min(most_, strangers[of.address]) : 0, of.since);
  };
  for (auto it = taken_.begin(); it != taken_.end(); ++it) {
    const Taken& of = it->second;
    if (of.settled || (of.caller == Caller::owner && !of.idle)) continue;
    if (victim == taken_.end() || rank(of) < rank(victim->second)) victim = it;
  }
  if (victim == taken_.end()) return false;
  const auto close = std::move(victim->second.close);
  taken_.erase(victim);
  close();
  return true;
}

bool Places::guests_may_settle() const {
  const auto guests = std::count_if(taken_.begin(), taken_.end(),
                                    [](const auto& of) { return of.second.settled && of.second.caller == Caller::guest; });
  return static_cast<std::size_t>(guests) < most_ - most_ / 4;
}

void Places::close_all() {
  for (auto& [id, of] : std::exchange(taken_, {})) of.close();
}

Places::Place::Place(Places& places, std::string address, std::function<void()> close) : places_(places), id_(++places.last_) {
  places_.taken_[id_] = {std::move(address), std::move(close)};
}

void Places::Place::set_close(std::function<void()> close) {
  if (const auto it = places_.taken_.find(id_); it != places_.taken_.end()) it->second.close = std::move(close);
}

void Places::Place::show(Caller caller) {
  caller_ = std::max(caller_, caller);
  if (const auto it = places_.taken_.find(id_); it != places_.taken_.end()) it->second.caller = caller_;
}

void Places::Place::be_idle(bool idle) {
  const auto it = places_.taken_.find(id_);
  if (it == places_.taken_.end()) return;
  it->second.idle = idle;
  it->second.since = Clock::now();
}

void Places::Place::settle() {
  if (const auto it = places_.taken_.find(id_); it != places_.taken_.end()) it->second.settled = true;
}

}  // namespace isostrata
