// Bodies of the HTTP side: canonical Protobuf JSON, read strictly.
#pragma once

#include <google/protobuf/field_mask.pb.h>
#include <google/protobuf/message.h>

#include <boost/json/object.hpp>
#include <optional>
#include <string>

#include "isostrata/v1/isostrata.pb.h"
#include "net/http/http_message.h"

namespace isostrata {

HttpResponse json_response(int status, const boost::json::value& document);
/// With all fields, those that have their default too.
HttpResponse message_response(int status, const google::protobuf::Message& message);
std::string message_json(const google::protobuf::Message& message);

/// One JSON object whose members stand once each, nested at most 32 deep, in UTF-8. "malformed" otherwise.
std::optional<v1::Error> parse_object(const std::string& body, boost::json::object& object);

/// The same as a message: unknown members, other types and numbers out of range are "malformed". An empty body is an empty
/// message. Numbers go through Protobuf's parser alone: a last bit lost at the top of an interval would lose the points that have
/// the value.
std::optional<v1::Error> parse_message(const std::string& body, google::protobuf::Message& message);

/// Whether the field is `lower` or `upper` of an interval or a term, which may be open: JSON says so by "inf", "-inf" or null, too.
bool is_interval_end(const google::protobuf::FieldDescriptor& field);

/// Which fields the document names, as the paths of a field mask; members of objects one by one, lists as a whole.
google::protobuf::FieldMask named_fields(const google::protobuf::Descriptor& type, const boost::json::object& document);

}  // namespace isostrata
