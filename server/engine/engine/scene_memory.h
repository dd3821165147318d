// Who may take how much of --max-memory, and who makes way: datasets and what all sessions share of them come first, then works that are under way, and
// scenes have what is left.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "engine/engine/scene_ledger.h"
#include "engine/messages/messages.h"

namespace isostrata {

/// Pure bookkeeping of bytes: whoever calls frees what is said to go. Not thread-safe.
class SceneMemory {
 public:
  static constexpr std::uint64_t kLeastWork = 32ull << 20;  // that an export or a measure is given

  /// held_elsewhere: bytes of datasets and of what all sessions share of them; it is asked at each decision.
  SceneMemory(std::uint64_t max_bytes, std::function<std::uint64_t()> held_elsewhere) : max_bytes_(max_bytes), held_elsewhere_(std::move(held_elsewhere)) {}

  /// Somebody looks at the session.
  void see(SessionKey session) { scenes_.see(session); }
  /// What the session's scene takes from now on.
  void hold(SessionKey session, std::uint64_t bytes) { scenes_.hold(session, bytes); }
  void forget(SessionKey session) { scenes_.forget(session); }

  /// What nobody has.
  std::uint64_t free() const;
  /// What a work of which nobody knows what it takes may ask for.
  std::uint64_t quarter_of_free() const;
  /// The same of a work on layers that the session shows: its facets and values come on top of them, and it needs some room to be told by numbers that it
  /// has too little.
  std::uint64_t for_work_on(SessionKey session) const;

  /// Whose scene may go, besides the one that room is made for: nobody draws or extracts it.
  using MayGo = std::function<bool(SessionKey session)>;
  struct Room {
    std::uint64_t bytes = 0;
    std::vector<SessionKey> gone;  // hold nothing from now on; those that nobody has looked at for longest
  };
  /// Begins a work of the session, if room.bytes is at least as much as it takes. Scenes make way, and no more of them than must.
  Room begin_work(SessionKey session, std::uint64_t bytes, const MayGo& may_go);
  /// The same of what is free; no scene makes way. Whether it begins.
  bool begin_work_in_free(std::uint64_t bytes);
  void end_work(std::uint64_t bytes) { scenes_.end_work(bytes); }
  bool any_work() const { return scenes_.in_work() > 0; }

  /// For the session's next scene, which takes the place of its last. Others make room for one as large as its last, or go altogether. Nobody knows yet
  /// what it takes, so it is given three quarters of what is left, or all, until it is there: who begins meanwhile has the rest.
  Room for_next_scene(SessionKey session, bool altogether, const MayGo& may_go);
  void end_next_scene(SessionKey session) { begun_.erase(session); }
  /// What for_next_scene would give altogether: all but what others have in use, or is given to scenes that they make.
  std::uint64_t altogether(SessionKey session, const MayGo& may_go) const;
  /// Whether that is at least three quarters of what there is for scenes: there is nobody to wait for.
  bool leave_most(SessionKey session, const MayGo& may_go) const { return altogether(session, may_go) >= for_scenes() / 2 / 4 * 3; }
  /// Who goes, because the session's scene has grown, so that all are within the limit again.
  std::vector<SessionKey> make_way_for(SessionKey session, const MayGo& may_go);

 private:
  std::uint64_t for_scenes() const;
  std::uint64_t begun_by_others(SessionKey session) const;
  std::vector<SessionKey> leave(std::uint64_t most, SessionKey but, const MayGo& may_go);

  const std::uint64_t max_bytes_;
  const std::function<std::uint64_t()> held_elsewhere_;
  SceneLedger scenes_;
  std::map<SessionKey, std::uint64_t> begun_;  // what is given to scenes that are being made
};

}  // namespace isostrata
