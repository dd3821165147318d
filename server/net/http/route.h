// What one route of the REST API is: how it is asked for, what it answers, and what does the work. The router dispatches by the
// list of them, and the OpenAPI document is made from the same list.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "net/http/http_message.h"
#include "net/http/request_target.h"
#include "session/sessions/session.h"

namespace isostrata {

/// A query parameter. Others than those that a route names are refused.
struct QueryParameter {
  std::string name;
  std::string description;
  bool integer = false;                       // else text
  std::int64_t least = 0, most = UINT32_MAX;  // of integers, for the document; handlers check
  std::string otherwise;                      // what is meant if it is absent; empty: see the description
  std::vector<std::string> one_of;            // texts; empty: any
  bool real = false;                          // else; a number in [least, most]
};

/// What a request's body is.
struct RequestBody {
  std::string schema;  // a Protobuf message's name or one of rest_schemas.json
  std::string description;
  bool required = true;
};

/// What an answer that is not a problem looks like.
struct Answer {
  int status = 200;
  std::string description;
  std::string schema;  // as RequestBody; empty: none
  std::string content_type = "application/json";
  std::vector<std::string> more_types;  // that the same answer may have
};

/// One request on its way to its handler. The references live until the handler returns; the reply is called once, now or later.
struct Call {
  const HttpRequest& request;
  const RequestTarget& target;
  std::map<std::string, std::string> path;  // the values of the template's names
  Session* session = nullptr;               // of {session}
  std::optional<std::uint64_t> expected;    // the revision that If-Match names; a change of another one is refused
  HttpReply reply;

  /// The query's value, or what the route says is meant without it.
  std::string parameter(const char* name, const std::string& otherwise = {}) const {
    const auto it = target.query.find(name);
    return it == target.query.end() ? otherwise : it->second;
  }
};

struct Route {
  std::string method;  // GET (answers HEAD, too), POST, PUT, PATCH, DELETE
  std::string path;    // below api/v1: "/sessions/{session}/intervals/{interval}"
  std::string id;      // operationId: "patchInterval"
  std::string tag;
  std::string summary;
  std::string description;
  std::vector<QueryParameter> query;
  std::optional<RequestBody> body;
  std::vector<Answer> answers;
  bool conditional = false;  // honours If-Match
  bool open = false;         // needs no token
  bool guests = false;       // an invitation's token suffices
  std::function<void(Call call)> handler;
};

}  // namespace isostrata
