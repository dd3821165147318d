#include "engine/engine/scene_memory.h"

#include <algorithm>

namespace isostrata {
namespace {

std::uint64_t less(std::uint64_t bytes, std::uint64_t taken) { return bytes - std::min(bytes, taken); }

}  // namespace

std::uint64_t SceneMemory::for_scenes() const { return less(max_bytes_, held_elsewhere_() + scenes_.in_work()); }

std::uint64_t SceneMemory::free() const { return less(for_scenes(), scenes_.bytes()); }

std::uint64_t SceneMemory::quarter_of_free() const { return std::max(free() / 4, kLeastWork); }

std::uint64_t SceneMemory::for_work_on(SessionKey session) const { return std::max(2 * scenes_.bytes_of(session), kLeastWork); }

std::vector<SessionKey> SceneMemory::leave(std::uint64_t most, SessionKey but, const MayGo& may_go) {
  auto gone = scenes_.too_many(most, [&](SessionKey session) { return session != but && may_go(session); });
  for (const SessionKey session : gone) scenes_.hold(session, 0);
  return gone;
}

SceneMemory::Room SceneMemory::begin_work(SessionKey session, std::uint64_t bytes, const MayGo& may_go) {
  const std::uint64_t most = for_scenes();
  Room room;
  room.gone = leave(less(most, bytes), session, may_go);
  room.bytes = less(most, scenes_.bytes());
  if (bytes <= room.bytes) scenes_.begin_work(bytes);
  return room;
}

bool SceneMemory::begin_work_in_free(std::uint64_t bytes) {
  if (bytes > free()) return false;
  scenes_.begin_work(bytes);
  return true;
}

SceneMemory::Room SceneMemory::for_next_scene(SessionKey session, bool altogether, const MayGo& may_go) {
  const std::uint64_t most = less(for_scenes(), begun_by_others(session)), own = scenes_.bytes_of(session);
  Room room;
  room.gone = leave(altogether ? 0 : less(most, 2 * own), session, may_go);
  const std::uint64_t left = less(most, scenes_.bytes() - own);
  const std::uint64_t given = altogether ? left : std::max(left / 4 * 3, std::min(left, own + own / 4));
  begun_[session] = given;
  // What a renderer makes of it comes on top; and who has little room is told so by the extraction, with the numbers.
  room.bytes = given / 2;
  return room;
}

std::uint64_t SceneMemory::begun_by_others(SessionKey session) const {
  std::uint64_t bytes = 0;
  for (const auto& [of, given] : begun_)
    if (of != session) bytes += given;
  return bytes;
}

std::uint64_t SceneMemory::altogether(SessionKey session, const MayGo& may_go) const {
  std::uint64_t in_use = less(scenes_.bytes(), scenes_.bytes_of(session));
  for (const SessionKey other : scenes_.too_many(0, [&](SessionKey of) { return of != session && may_go(of); })) in_use -= scenes_.bytes_of(other);
  return less(for_scenes(), begun_by_others(session) + in_use) / 2;
}

std::vector<SessionKey> SceneMemory::make_way_for(SessionKey session, const MayGo& may_go) { return leave(for_scenes(), session, may_go); }

}  // namespace isostrata
