// Bytes of what sessions' scenes take, and whose are given back first: those that nobody has looked at for longest; and of the works beside them.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "engine/messages/messages.h"

namespace isostrata {

/// Pure bookkeeping; not thread-safe.
class SceneLedger {
 public:
  /// Somebody looks at the session.
  void see(SessionKey session) { entries_[session].seen = ++looks_; }
  /// What the session's scene takes from now on.
  void hold(SessionKey session, std::uint64_t bytes) {
    Entry& entry = entries_[session];
    total_ = total_ - entry.bytes + bytes;
    entry.bytes = bytes;
  }
  void forget(SessionKey session) {
    hold(session, 0);
    entries_.erase(session);
  }
  std::uint64_t bytes() const { return total_; }

  /// What a work under way takes beside the scenes, from its beginning to its end: a large still, an export.
  void begin_work(std::uint64_t bytes) { in_work_ += bytes; }
  void end_work(std::uint64_t bytes) { in_work_ -= bytes; }
  std::uint64_t in_work() const { return in_work_; }

  std::uint64_t bytes_of(SessionKey session) const {
    const auto it = entries_.find(session);
    return it == entries_.end() ? 0 : it->second.bytes;
  }

  /// The sessions without whose scenes the rest is at most `most`, the longest unseen first, of those that may go. Fewer where
  /// that does not suffice.
  std::vector<SessionKey> too_many(std::uint64_t most, const std::function<bool(SessionKey)>& may_go) const {
    std::multimap<std::uint64_t, SessionKey> by_age;  // several may never have been seen
    for (const auto& [session, entry] : entries_)
      if (entry.bytes > 0) by_age.emplace(entry.seen, session);
    std::vector<SessionKey> gone;
    std::uint64_t left = total_;
    for (const auto& [seen, session] : by_age) {
      if (left <= most) break;
      if (!may_go(session)) continue;
      left -= bytes_of(session);
      gone.push_back(session);
    }
    return gone;
  }

 private:
  struct Entry {
    std::uint64_t bytes = 0, seen = 0;
  };
  std::map<SessionKey, Entry> entries_;
  std::uint64_t looks_ = 0, total_ = 0, in_work_ = 0;
};

}  // namespace isostrata
