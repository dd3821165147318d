// How a connection comes in and how it is let go: what its first message must be and what that makes of the viewer; what the server says first
// and last.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "session/sessions/session.h"
#include "session/sessions/sessions_options.h"

namespace isostrata {

constexpr std::uint16_t kCloseGoingAway = 1001, kCloseProtocolError = 1002, kClosePolicy = 1008,
                        kCloseTryAgainLater = 1013;  // RFC 6455, section 7.4.1

/// Why a connection cannot go on.
struct Refusal {
  v1::Error error;
  std::uint16_t close_code = kClosePolicy;
};
/// Tells the viewer, in answer to its message `seq` (0: to none), and closes.
void refuse(Viewer& viewer, Refusal refusal, std::uint64_t seq = 0);

/// Why a message of this number cannot follow the one of `last`.
std::optional<Refusal> refuse_seq(std::uint64_t seq, std::uint64_t last);
/// Why the message is not one by which a client may come in.
std::optional<Refusal> refuse_hello(const v1::ClientMessage& message);
/// Makes of the viewer what its Hello says, which was not refused; its invitation is known. moving_codecs: that the server has, the best first.
void introduce(Viewer& viewer, const v1::Hello& hello, std::span<const Codec> moving_codecs);
/// What a viewer who was let in is told first.
v1::ServerMessage welcome(const Viewer& viewer, const Session& session, const Catalogue& catalogue, const SessionsOptions& options,
                          const EngineFacts& drawing);

/// The server will end at that moment, and goes on until then. comes_back: sessions survive it.
v1::ServerMessage end_notice(const std::string& reason, UnixMs ends, UnixMs now, bool comes_back);
/// The server ends within that time, and connections are closed now.
v1::ServerMessage last_word(const std::string& reason, Duration deadline, UnixMs now, bool comes_back);

}  // namespace isostrata
