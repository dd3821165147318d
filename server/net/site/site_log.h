// Log lines of what happens in sessions and on connections.
#pragma once

#include "net/site/log_line.h"
#include "session/sessions/sessions.h"

namespace isostrata {

/// Not thread-safe: lives on the io thread.
class SiteLog final : public SessionsObserver {
 public:
  explicit SiteLog(LogSink sink) : sink_(std::move(sink)) {}

  void write(const LogLine& line) const {
    if (sink_) sink_(line);
  }
  void http_answered(const std::string& method, const std::string& path, int status, double seconds, const std::string& session,
                     const std::string& request, const std::string& address) const;
  void websocket_error(const std::string& session, ViewerKey viewer, const v1::Error& error) const;

  void session_began(const Session& session) override;
  void session_ended(const Session& session) override;
  void viewer_joined(const Session& session) override;
  void viewer_left(const Session& session) override;
  void asked(const Session& session, const Viewer& viewer, const std::string& act, std::uint64_t seq, const std::string& detail) override;
  void engine_event(const Session* session, const EngineEvent& event) override;

 private:
  const LogSink sink_;
};

}  // namespace isostrata
