// What is worth a line in the log. Where it goes is main's business.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace isostrata {

/// Never holds a token: paths come without their queries.
struct LogLine {
  bool warning = false;
  bool detail = false;  // of one request that went well: too much for a person to read along
  std::string event;    // "request", "session_began", ... for programs
  std::string message;  // for people
  std::string session;  // its id; empty: of none
  std::string request;  // X-Request-Id, or "wCONNECTION-SEQ" of a WebSocket's message; empty: of none
  std::vector<std::pair<std::string, std::string>> fields{};
  std::vector<std::pair<std::string, double>> numbers{};
};

/// Called on the io thread; must return quickly.
using LogSink = std::function<void(const LogLine& line)>;

}  // namespace isostrata
