// Whose turn it is: sessions in a ring, each once before any a second time.
#pragma once

#include "engine/messages/messages.h"

namespace isostrata {

/// Plain state; not thread-safe.
class Turns {
 public:
  /// Asks the sessions (a map by SessionKey), from the one behind the last that had something on. `take(session)` gives what it has, or something false. The
  /// first that has something has had its turn.
  template <class Sessions, class Take>
  auto next(Sessions& sessions, const Take& take) -> decltype(take(sessions.begin()->second)) {
    auto it = sessions.upper_bound(last_);
    for (auto n = sessions.size(); n > 0; --n, ++it) {
      if (it == sessions.end()) it = sessions.begin();
      if (auto taken = take(it->second)) {
        last_ = it->first;
        return taken;
      }
    }
    return {};
  }

 private:
  SessionKey last_ = 0;
};

}  // namespace isostrata
