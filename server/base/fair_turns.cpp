#include "base/fair_turns.h"

#include <algorithm>

namespace isostrata {

FairTurns::Id FairTurns::begin(std::uint64_t session, WorkClass of, Time now) {
  charge(now);
  Session& its = sessions_[session];
  if (its.works++ == 0) {
    // As far behind as the least of those that are here, but for the credit.
    Time least = least_;
    bool alone = true;
    for (const auto& [key, other] : sessions_)
      if (other.works > 0 && key != session) least = alone ? other.used : std::min(least, other.used), alone = false;
    its.used = std::max(its.used, least - kCredit);
  }
  works_[next_] = {session, of, true};
  return next_++;
}

void FairTurns::end(Id id, Time now) {
  charge(now);
  const auto it = works_.find(id);
  if (it == works_.end()) return;
  const auto session = sessions_.find(it->second.session);
  works_.erase(it);
  if (holder_ == id) holder_ = 0;
  if (--session->second.works > 0) return;
  // A session that is as far as it would begin again need not be remembered.
  std::erase_if(sessions_, [this](const auto& of) { return of.second.works == 0 && of.second.used <= least_ - kCredit; });
}

void FairTurns::lend_urgency(Id from, Id to, Time now) {
  charge(now);
  const auto lender = works_.find(from), maker = works_.find(to);
  if (lender != works_.end() && maker != works_.end()) maker->second.of = std::min(maker->second.of, lender->second.of);
}

void FairTurns::step(Id id) {
  if (const auto it = works_.find(id); it != works_.end()) it->second.goes_on = true;
}

// Of the time since the last call.
void FairTurns::charge(Time now) {
  const Time passed = std::max(now - charged_, Time{0});
  charged_ = std::max(charged_, now);
  const auto it = works_.find(holder_);
  if (it == works_.end()) return;
  Time& used = sessions_.at(it->second.session).used;
  used += passed;
  least_ = std::max(least_, used);
  std::array<bool, kClasses> waits{};
  for (const auto& [id, work] : works_)
    if (id != holder_ && work.goes_on && work.of != it->second.of) waits[static_cast<std::size_t>(work.of)] = true;
  for (std::size_t c = 0; c < kClasses; ++c) {
    const bool has = c == static_cast<std::size_t>(it->second.of);
    if (has)
      passed_over_[c] = std::max(passed_over_[c] - patience_of(it->second.of) * passed, Time{0});
    else if (waits[c] && c > static_cast<std::size_t>(it->second.of))
      passed_over_[c] += passed;
  }
}

bool FairTurns::is_before(Id a, Id b) const {
  const Work &x = works_.at(a), &y = works_.at(b);
  if (x.of != y.of) {
    const bool x_is_due = is_passed_over(x.of), y_is_due = is_passed_over(y.of);
    if (x_is_due != y_is_due) return x_is_due;
    return x.of < y.of;
  }
  const Time used_x = sessions_.at(x.session).used, used_y = sessions_.at(y.session).used;
  if (x.session != y.session && used_x != used_y) return used_x < used_y;
  return a < b;
}

bool FairTurns::takes_at_once(const Work& next, const Work& has) const {
  if (next.of != has.of) return next.of < has.of;
  return sessions_.at(next.session).used + kTurn <= sessions_.at(has.session).used;
}

FairTurns::Id FairTurns::best() const {
  Id best = 0;
  for (const auto& [id, work] : works_)
    if (work.goes_on && (best == 0 || is_before(id, best))) best = id;
  return best;
}

FairTurns::Id FairTurns::holder(Time now) {
  charge(now);
  const auto it = works_.find(holder_);
  const bool over = it == works_.end() || now >= turn_ends();
  const Id next = best();
  const bool more_urgent = !over && next != 0 && !due_ && takes_at_once(works_.at(next), it->second);
  if (!over && !more_urgent) return holder_;
  // Nobody else can go on: whoever has the turn keeps it, whatever it is at.
  if (next == 0 && it != works_.end()) {
    turn_began_ = now;
    return holder_;
  }
  holder_ = next;
  turn_began_ = now;
  due_ = next != 0 && is_passed_over(works_.at(next).of);
  if (next != 0) works_.at(next).goes_on = false;
  return holder_;
}

}  // namespace isostrata
