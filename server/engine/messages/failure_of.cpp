#include "engine/messages/failure_of.h"

#include "base/as_error.h"

namespace isostrata {

RequestFailed failure_of(const std::exception_ptr& failure, SessionKey session, RequestId request, std::uint64_t revision) {
  const Error error = as_error(failure);
  return {session, request, revision, error.code(), error.what()};
}

}  // namespace isostrata
