// Memory for a work, as long as somebody holds what was lent.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "engine/engine/jobs.h"
#include "engine/engine/live_sessions.h"

namespace isostrata {

/// As MemoryForJobs::lend. max_memory: of the server, for the message.
std::shared_ptr<void> lend(LiveSessions& sessions, SessionKey session, std::uint64_t bytes, const std::string& what, std::uint64_t max_memory);

/// What jobs borrow; `sessions` must outlive it.
MemoryForJobs memory_for_jobs(LiveSessions& sessions, std::uint64_t max_memory);

}  // namespace isostrata
