// What observers are told of what one viewer asks for.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "isostrata/v1/isostrata.pb.h"
#include "session/pacing/link_model.h"

namespace isostrata {

struct ObservedAct {
  std::string act;     // the field of the message
  std::string detail;  // of what, if that is a matter of words
};

/// Of one viewer. Pure decisions on a clock that the caller passes in. Not thread-safe.
class ObservedActs {
 public:
  static constexpr Duration kOneDrag = std::chrono::seconds(10);

  /// Nothing if the message concerns nobody but the viewer, or belongs to a drag of which something was told less than kOneDrag ago.
  std::optional<ObservedAct> note(const v1::ClientMessage& message, TimePoint now);

 private:
  int kind_ = 0;  // of what was told last, and when
  TimePoint at_{};
};

}  // namespace isostrata
