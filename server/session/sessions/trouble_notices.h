// What everyone is told of trouble that the server has as a whole: nothing can be drawn, nothing can be kept. Each is told once when it begins,
// to whoever comes while it lasts, and acted on when it ends. Pure decisions on a clock that the caller passes in.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "isostrata/v1/isostrata.pb.h"
#include "session/pacing/link_model.h"

namespace isostrata {

/// Of one server. Not thread-safe.
class TroubleNotices {
 public:
  static constexpr Duration kLook = std::chrono::milliseconds(500);  // between looks at the engine

  /// Whether the engine is to be looked at, which begins the next pause.
  bool look_is_due(TimePoint now);
  /// trouble: why nothing can be drawn; empty: it can. What everyone is told now.
  std::optional<v1::ServerMessage> engine(const std::string& trouble);
  /// Whether nothing could be drawn before the last call of engine(), and can be after it, so that whoever has missed a picture gets it.
  bool draws_again() const { return draws_again_; }
  /// kept: what changes is written down. What everyone is told now: what is done while the disk is full, say, is done and not kept, and
  /// whoever does it is to know.
  std::optional<v1::ServerMessage> journal(bool kept);
  /// What one who comes now is told.
  std::vector<v1::ServerMessage> standing() const;

 private:
  std::string engine_trouble_;
  bool draws_again_ = false;
  bool kept_ = true;
  TimePoint looked_at_{};
};

}  // namespace isostrata
