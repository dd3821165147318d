// The same commands for scripts: REST routes under api/v1 that become the ClientMessages a WebSocket would carry. Bodies are
// canonical Protobuf JSON; errors are RFC 9457 problem documents with code, field and hint.
//
//   GET    health                                  no token needed; also /healthz
//   GET    datasets                                what can be opened
//   GET    datasets/{id}                           DatasetInfo (loads it)
//   GET    datasets/{id}/histogram?array&bins&step Histogram
//   GET    sessions                                POST {"dataset": id}: a new one
//   GET    sessions/{id}                           DELETE: ends it
//   GET    sessions/{id}/state                     State, ETag its revision; PUT replaces it, PATCH merges (RFC 7396); If-Match
//   is honoured GET    sessions/{id}/intervals                 POST an Interval: adds it GET    sessions/{id}/intervals/{n} PATCH
//   some fields; DELETE GET    sessions/{id}/histogram?array&bins GET    sessions/{id}/image?width&height&format png or jpeg POST
//   sessions/{id}/commands                  any scene command or OpenDataset, as a ClientMessage
#pragma once

#include <string>
#include <vector>

#include "net/http_message.h"
#include "net/request_target.h"
#include "session/sessions.h"

namespace isostrata {

/// Not thread-safe: lives on the io thread.
class RestApi {
 public:
  explicit RestApi(Sessions& sessions) : sessions_(sessions) {}

  /// path: the segments after api/v1. Replies once, now or later.
  void handle(const HttpRequest& request, const RequestTarget& target, const std::vector<std::string>& path, HttpReply reply);
  HttpResponse health() const;

 private:
  void datasets(const HttpRequest& request, const RequestTarget& target, const std::vector<std::string>& path, HttpReply reply);
  void sessions(const HttpRequest& request, const RequestTarget& target, const std::vector<std::string>& path, HttpReply reply);
  void session(Session& session, const HttpRequest& request, const RequestTarget& target, const std::vector<std::string>& path,
               HttpReply reply);
  void create_session(const HttpRequest& request, HttpReply reply);
  void state(Session& session, const HttpRequest& request, HttpReply reply);
  void intervals(Session& session, const HttpRequest& request, const std::vector<std::string>& path, HttpReply reply);
  void image(Session& session, const RequestTarget& target, HttpReply reply);
  void histogram(SessionKey session, const DatasetFacts& facts, int step, const RequestTarget& target, HttpReply reply);
  void command(Session& session, const v1::ClientMessage& message, int status, HttpReply reply);

  Sessions& sessions_;
};

HttpResponse problem(const v1::Error& error);
HttpResponse problem(int status, const std::string& code, const std::string& message);

}  // namespace isostrata
