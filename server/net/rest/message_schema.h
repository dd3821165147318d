// JSON Schemas of Protobuf messages, as canonical Protobuf JSON has them, with the comments of the .proto file.
#pragma once

#include <boost/json/object.hpp>
#include <string>

namespace isostrata {

/// Adds the schema of a message of package isostrata.v1 under its name, and those of all that it contains. Draft 2020-12, for
/// OpenAPI 3.1's components. Nothing if there is no such message. Throws internal if the program's own descriptors are
/// broken.
void add_message_schema(const std::string& message, boost::json::object& schemas);

}  // namespace isostrata
