// The REST API below api/v1: the routes of rest_*.cpp, dispatched with the rules that all of them share. They become the commands
// that a WebSocket would carry; bodies are canonical Protobuf JSON; errors are RFC 9457 problem documents. GET openapi.json
// describes every route, made from the same list.
#pragma once

#include <string>
#include <vector>

#include "net/http/http_message.h"
#include "net/http/request_target.h"
#include "net/http/router.h"
#include "net/rest/rest_routes.h"

namespace isostrata {

/// Not thread-safe: lives on the io thread.
class RestApi {
 public:
  /// The sessions must outlive it.
  explicit RestApi(Sessions& sessions);

  /// path: the segments after api/v1. Replies once, now or later. HEAD is answered as GET, OPTIONS with Allow. `route`, where it
  /// is not null, is set to the route's path, for metrics and logs.
  void handle(const HttpRequest& request, const RequestTarget& target, const std::vector<std::string>& path, HttpReply reply,
              std::string* route = nullptr) {
    handle(request, target, path, std::move(reply), route, true);
  }

  /// Whether an invitation's token suffices.
  bool is_for_guests(const std::string& method, const std::vector<std::string>& path) const {
    const Router::Match match = router_.find(method, path);
    return match.route && match.route->guests;
  }

  const Router& router() const { return router_; }
  const Operations& operations() const { return operations_; }

 private:
  /// wakes: a session that sleeps since a restart is waited for. Once: one whose dataset does not open is answered for as it is.
  void handle(const HttpRequest& request, const RequestTarget& target, const std::vector<std::string>& path, HttpReply reply, std::string* route,
              bool wakes);
  static std::vector<Route> all_routes(RestContext& context, const std::string& document);

  Sessions& sessions_;
  Operations operations_;
  SessionEvents events_;
  RestContext context_;
  std::string document_;
  Router router_;
};

}  // namespace isostrata
