// Counters of what the server does, in Prometheus' text format.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "session/sessions/sessions_observer.h"

namespace isostrata {

/// What is measured when somebody asks.
struct MetricsGauges {
  std::size_t sessions = 0, viewers = 0, connections = 0, operations = 0, worker_deaths = 0;
};

/// Not thread-safe: lives on the io thread. Label values come from closed sets (routes' templates, error codes, stages), never
/// from what a client sent, so that memory is bounded.
class Metrics final : public SessionsObserver {
 public:
  Metrics(const std::string& server, const std::string& device);
  ~Metrics() override;

  /// route: its template; empty: none was found.
  void http_answered(const std::string& method, const std::string& route, int status, double seconds, std::size_t bytes);
  void websocket_sent(std::size_t bytes);
  void websocket_error(const std::string& code);

  void session_began(const Session& session) override;
  void session_ended(const Session& session) override;
  void engine_event(const Session* session, const EngineEvent& event) override;

  std::string text(const MetricsGauges& gauges);

 private:
  struct Families;
  std::unique_ptr<Families> families_;
};

}  // namespace isostrata
