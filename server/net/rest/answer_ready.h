// What the engine answers once, as the answer of a route.
#pragma once

#include <string>
#include <variant>

#include "net/http/json_body.h"
#include "net/http/problem.h"
#include "net/rest/rest_routes.h"
#include "session/wire/wire.h"

namespace isostrata {

/// A listener that replies with the Ready, as it is on the wire, or with why there is none.
template <class Ready>
auto answer_ready(const Call& call) {
  return [reply = call.reply](const EngineEvent& event, TimePoint) {
    if (const auto* failed = std::get_if<RequestFailed>(&event)) return reply(problem(wire_error(*failed)));
    reply(message_response(200, to_wire(std::get<Ready>(event))));
  };
}

/// The query's array; empty if it names none.
inline std::string array_parameter(const Call& call) {
  const auto it = call.target.query.find("array");
  return it == call.target.query.end() ? "" : it->second;
}

}  // namespace isostrata
