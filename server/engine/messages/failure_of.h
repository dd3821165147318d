// What was thrown, as what is told to whoever asked.
#pragma once

#include <cstdint>
#include <exception>

#include "engine/messages/messages.h"

namespace isostrata {

/// Code and text are those of as_error. revision: of the scene that was to be drawn; 0: no picture was asked for.
/// Precondition: failure is not null. Any thread.
RequestFailed failure_of(const std::exception_ptr& failure, SessionKey session, RequestId request, std::uint64_t revision = 0);

}  // namespace isostrata
