// libprotobuf's own lines. It writes one to standard error for every message whose text is not UTF-8, so that a client could fill
// an operator's log; the client itself is told by a typed error, in any case.
#pragma once

#include <functional>
#include <string>

namespace isostrata {

constexpr int kProtobufLinesAMinute = 3;

/// From here on they go to `log`, at most kProtobufLinesAMinute, and the next one says how many were left out. Empty: to nobody,
/// as from silence_protobuf on. For the whole process; any thread, and `log` is called on any.
void set_protobuf_log(std::function<void(const std::string& text)> log);

inline void silence_protobuf() { set_protobuf_log(nullptr); }

}  // namespace isostrata
