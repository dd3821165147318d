// The server's log on standard error.
#pragma once

#include <spdlog/logger.h>

#include <string>

#include "net/site/log_line.h"

namespace isostrata {

/// As text, a line for what a person wants to know; as JSON, one object a line, with a line for every request. Each has
/// "time_ms", "level", "event", "message", "session" and "request" (null: of none), and what the event knows beside. No line ever
/// holds the token. Any thread.
class ServerLog {
 public:
  explicit ServerLog(bool json);
  void write(const LogLine& line);
  void info(const std::string& event, const std::string& text) { write({.event = event, .message = text}); }
  void warn(const std::string& event, const std::string& text) { write({.warning = true, .event = event, .message = text}); }

 private:
  const bool json_;
  spdlog::logger logger_;
};

}  // namespace isostrata
