#include "session/people/session_use.h"

#include <utility>

namespace isostrata {

bool SessionUse::goes_to_rest(TimePoint now, bool watched) {
  if (!looked_ || now - *looked_ < (watched ? kHiddenRests : kUnwatchedRests)) return false;
  looked_ = now;
  return true;
}

bool SessionUse::come() {
  vanished_ = false;
  return std::exchange(abandoned_, false);
}

bool SessionUse::leave(bool goodbye, bool watched) {
  vanished_ = vanished_ || !goodbye;
  const bool abandoned = !watched && !vanished_;
  return std::exchange(abandoned_, abandoned) != abandoned;
}

SessionUse::Holds SessionUse::holds(bool open, bool invites) const {
  if ((worked_on_ || invites) && !abandoned_) return Holds::work;
  return open ? Holds::look : Holds::nothing;
}

RoomForSession make_room(std::span<const UnwatchedSession> unwatched, NewFor whom, TimePoint now) {
  RoomForSession room;
  const UnwatchedSession* least = nullptr;
  for (const UnwatchedSession& of : unwatched) {
    if ((whom == NewFor::nobody && of.holds != SessionUse::Holds::nothing) ||
        (of.holds == SessionUse::Holds::work && now - of.last_use < SessionUse::kComesBack)) {
      room.kept = true;
      continue;
    }
    if (!least || std::pair(of.holds, of.last_use) < std::pair(least->holds, least->last_use)) least = &of;
  }
  if (least) room.ends = least->key;
  return room;
}

}  // namespace isostrata
