#include "engine/engine/lend_memory.h"

namespace isostrata {
namespace {

/// Of a work that has begun.
std::shared_ptr<void> loan(LiveSessions& sessions, std::uint64_t bytes) {
  return {static_cast<void*>(&sessions), [&sessions, bytes](void*) { sessions.end_work(bytes); }};
}

std::string mb(std::uint64_t bytes) { return std::to_string(bytes / 1'000'000); }

}  // namespace

std::shared_ptr<void> lend(LiveSessions& sessions, SessionKey session, std::uint64_t bytes, const std::string& what, std::uint64_t max_memory) {
  const std::uint64_t free = sessions.begin_work(session, bytes);
  if (bytes <= free) return loan(sessions, bytes);
  throw Error(ErrorCode::too_large, what + " needs about " + mb(bytes) + " MB; " + mb(free) + " of the " + mb(max_memory) +
                                        " MB that this server may take are free (--max-memory)");
}

MemoryForJobs memory_for_jobs(LiveSessions& sessions, std::uint64_t max_memory) {
  const auto lend_what_is_free = [&sessions](std::uint64_t bytes) {
    if (!sessions.begin_work_in_free(bytes)) throw Error(ErrorCode::unavailable, "no memory is free for a small picture at the moment");
    return loan(sessions, bytes);
  };
  return {[&sessions, max_memory](SessionKey session, std::uint64_t bytes, const std::string& what) { return lend(sessions, session, bytes, what, max_memory); },
          lend_what_is_free, [&sessions] { return sessions.quarter_of_free(); }, [&sessions](const ExportRequest& request) { return sessions.room_for_export(request); }};
}

}  // namespace isostrata
