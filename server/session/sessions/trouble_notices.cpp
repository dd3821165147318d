#include "session/sessions/trouble_notices.h"

#include <utility>

#include "session/wire/wire.h"

namespace isostrata {
namespace {

v1::ServerMessage not_drawn(const std::string& trouble) { return error_message(wire_error("unavailable", "nothing can be drawn: " + trouble)); }

v1::ServerMessage not_kept() {
  return error_message(wire_error("unavailable",
                                  "what changes here is not being kept, since the server cannot write it down (is its disk full?): it is "
                                  "lost when the server ends"));
}

}  // namespace

bool TroubleNotices::look_is_due(TimePoint now) {
  if (now - looked_at_ < kLook) return false;
  looked_at_ = now;
  return true;
}

std::optional<v1::ServerMessage> TroubleNotices::engine(const std::string& trouble) {
  draws_again_ = trouble.empty() && !engine_trouble_.empty();
  const bool began = !trouble.empty() && engine_trouble_.empty();
  if (began || draws_again_) engine_trouble_ = trouble;
  if (!began) return std::nullopt;
  return not_drawn(trouble);
}

std::optional<v1::ServerMessage> TroubleNotices::journal(bool kept) {
  const bool began = std::exchange(kept_, kept) && !kept;
  if (!began) return std::nullopt;
  return not_kept();
}

std::vector<v1::ServerMessage> TroubleNotices::standing() const {
  std::vector<v1::ServerMessage> all;
  if (!engine_trouble_.empty()) all.push_back(not_drawn(engine_trouble_));
  if (!kept_) all.push_back(not_kept());
  return all;
}

}  // namespace isostrata
