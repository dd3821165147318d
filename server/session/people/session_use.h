// What is lost with a session, and which one makes room for another. Pure decisions on a clock that the caller passes in.
#pragma once

#include <chrono>
#include <optional>
#include <span>

#include "engine/messages/messages.h"
#include "session/pacing/link_model.h"

namespace isostrata {

/// Who used one session last, and what they have left in it. Not thread-safe.
class SessionUse {
 public:
  /// Nothing, a first look that anyone can have again, what somebody has made of it.
  enum class Holds { nothing, look, work };
  /// Who vanished may come back so long.
  static constexpr Duration kComesBack = std::chrono::minutes(2);

  /// So long after nobody looks any more, what is extracted for the session is let go: whoever loads a page again needs a moment, and who looks at
  /// another page is back later.
  static constexpr Duration kUnwatchedRests = std::chrono::seconds(15), kHiddenRests = std::chrono::minutes(5);

  TimePoint last() const { return last_; }
  void touch(TimePoint now) { last_ = now; }
  /// Somebody sees it, or has asked for a picture of it or changed it.
  void look(TimePoint now) { looked_ = now; }
  /// Whether what is extracted for it has to be let go now; true again after as long, for somebody may have waited for a picture. watched: by hidden pages.
  bool goes_to_rest(TimePoint now, bool watched);
  /// Somebody has changed what a dataset shows at first.
  void note_work() { worked_on_ = true; }
  /// Somebody comes. True if abandoned() is another than before, as of leave().
  bool come();
  /// Somebody is gone: done with it, or vanished and perhaps back in a moment. watched: others are still there.
  bool leave(bool goodbye, bool watched);
  /// Nobody who may come back has left it.
  bool abandoned() const { return abandoned_; }
  /// open: a dataset is shown or being opened. invites: there are invitations to it.
  Holds holds(bool open, bool invites) const;
  /// As it was in a server that has ended.
  void restore(bool worked_on, bool abandoned) {
    worked_on_ = worked_on;
    abandoned_ = abandoned;
  }

 private:
  TimePoint last_{};
  std::optional<TimePoint> looked_;  // nothing: never
  bool worked_on_ = false;
  bool abandoned_ = false;
  bool vanished_ = false;  // somebody has, without a word, since somebody came
};

/// Who a new session is for: somebody who is there, a script that says what it shows, or one that has not said.
enum class NewFor { viewer, script, nobody };

/// One that nobody watches.
struct UnwatchedSession {
  SessionKey key = 0;
  SessionUse::Holds holds = SessionUse::Holds::nothing;
  TimePoint last_use{};
};

/// Which of them makes room for a new one: one that holds least, of those the longest unused. What a person has made of one is not given
/// up for a session that is empty, nor for anyone while it was used a moment ago: that person may be on the way back.
struct RoomForSession {
  std::optional<SessionKey> ends;
  bool kept = false;  // some were not taken for what they hold
};
RoomForSession make_room(std::span<const UnwatchedSession> unwatched, NewFor whom, TimePoint now);

}  // namespace isostrata
