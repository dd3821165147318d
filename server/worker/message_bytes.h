// Messages as bytes, for another process of the same program: both ends are the same binary, so there are no versions. Every
// field of every message is carried because it is there (Boost.PFR lists an aggregate's fields), so a message that grows needs
// nothing here but the last value of an enum that is new to it.
//
// Numbers as they lie in memory, a bool and the alternative of a variant as one byte, an optional as a bool and what follows,
// texts and lists as a 64-bit count and their items. A picture's bytes (FrameReady::bytes) are not in the message but beside it,
// since they may be long.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "worker/rank_messages.h"
#include "worker/worker_messages.h"

namespace isostrata {

struct MessageBytes {
  std::string body;
  std::shared_ptr<const Bytes> picture;  // may be null
};

MessageBytes to_bytes(const ToWorker& message);
MessageBytes to_bytes(const FromWorker& message);
MessageBytes to_bytes(const RankOrder& message);
MessageBytes to_bytes(const RankReply& message);

/// Throw bad_data if the bytes are not such a message: too short, too long, a bool, an enum or an alternative that is none.
ToWorker to_worker(const MessageBytes& bytes);
FromWorker from_worker(const MessageBytes& bytes);
RankOrder to_rank_order(const MessageBytes& bytes);
RankReply to_rank_reply(const MessageBytes& bytes);

}  // namespace isostrata
