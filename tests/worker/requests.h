// Requests that tests of the worker's parts make.
#pragma once

#include "engine/messages/messages.h"

namespace isostrata {

inline FrameRequest frame(SessionKey session, RequestId number) {
  FrameRequest request;
  request.session = session;
  request.request = number;
  return request;
}

}  // namespace isostrata
