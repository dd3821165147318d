// The OpenAPI 3.1 document of a list of routes.
#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <vector>

#include "net/http/route.h"

namespace isostrata {

/// Schemas are those of Protobuf messages (message_schema.h) and of rest_schemas.json. Throws internal if a route names a
/// schema that is in neither.
boost::json::object openapi_document(const std::vector<Route>& routes, const std::string& version);

}  // namespace isostrata
