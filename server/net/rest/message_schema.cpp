#include "net/rest/message_schema.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include <boost/json/array.hpp>
#include <memory>

#include "base/error.h"
#include "net/http/json_body.h"

// The compiled .proto file with its comments, taken in by the assembler (CMakeLists.txt names it).
asm(".pushsection .rodata\n"
    ".global isostrata_descriptors_begin\n"
    "isostrata_descriptors_begin:\n"
    ".incbin \"" ISOSTRATA_DESCRIPTORS
    "\"\n"
    ".global isostrata_descriptors_end\n"
    "isostrata_descriptors_end:\n"
    ".byte 0\n"
    ".popsection\n");
extern "C" const char isostrata_descriptors_begin[];
extern "C" const char isostrata_descriptors_end[];

namespace isostrata {
namespace {

namespace json = boost::json;
namespace pb = google::protobuf;

const pb::DescriptorPool& pool() {
  static const std::unique_ptr<pb::DescriptorPool> kPool = [] {
    pb::FileDescriptorSet files;
    auto made = std::make_unique<pb::DescriptorPool>();
    const auto size = static_cast<int>(isostrata_descriptors_end - isostrata_descriptors_begin);
    if (!files.ParseFromArray(isostrata_descriptors_begin, size))
      throw Error(ErrorCode::internal, "the protocol's descriptors cannot be read");
    for (const pb::FileDescriptorProto& file : files.file())
      if (!made->BuildFile(file)) throw Error(ErrorCode::internal, "the protocol's descriptors do not fit together");
    return made;
  }();
  return *kPool;
}

// The comment before it, or behind it on its line, as one paragraph. Headings of the file ("---- values ----") are not a comment of
// anything.
template <class Descriptor>
std::string comment_of(const Descriptor& of) {
  pb::SourceLocation location;
  if (!of.GetSourceLocation(&location)) return {};
  std::string text, raw = location.leading_comments + location.trailing_comments;
  if (raw.find("----") != std::string::npos) return {};
  for (const char c : raw)
    if (c != '\n' && !(c == ' ' && (text.empty() || text.back() == ' ')))
      text += c;
    else if (!text.empty() && text.back() != ' ')
      text += ' ';
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

json::object reference(const std::string& name) { return {{"$ref", "#/components/schemas/" + name}}; }

// Doubles may be written as strings if they are not finite.
json::object number_schema(json::object& schemas) {
  if (!schemas.contains("Number"))
    schemas["Number"] = json::object{
        {"description", "A number; as text if it is not finite."},
        {"anyOf", json::array{json::object{{"type", "number"}},
                              json::object{{"type", "string"}, {"enum", json::array{"NaN", "Infinity", "-Infinity"}}}}}};
  return reference("Number");
}

// Of an interval or a term.
json::object end_schema(json::object& schemas) {
  if (!schemas.contains("End"))
    schemas["End"] = json::object{
        {"description",
         "An end of an interval. Open, with everything below or above: \"-inf\", \"inf\" or null; answers say \"-Infinity\" and "
         "\"Infinity\"."},
        {"anyOf", json::array{json::object{{"type", "number"}},
                              json::object{{"type", "string"}, {"enum", json::array{"inf", "-inf", "Infinity", "-Infinity"}}},
                              json::object{{"type", "null"}}}}};
  return reference("End");
}

void add(const pb::Descriptor& message, json::object& schemas);

json::object value_schema(const pb::FieldDescriptor& field, json::object& schemas) {
  switch (field.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_BOOL:
      return {{"type", "boolean"}};
    case pb::FieldDescriptor::CPPTYPE_INT32:
      return {{"type", "integer"}, {"minimum", INT32_MIN}, {"maximum", INT32_MAX}};
    case pb::FieldDescriptor::CPPTYPE_UINT32:
      return {{"type", "integer"}, {"minimum", 0}, {"maximum", UINT32_MAX}};
    case pb::FieldDescriptor::CPPTYPE_INT64:
      return {{"type", json::array{"string", "integer"}}, {"pattern", "^-?[0-9]+$"}};
    case pb::FieldDescriptor::CPPTYPE_UINT64:
      return {{"type", json::array{"string", "integer"}}, {"pattern", "^[0-9]+$"}};
    case pb::FieldDescriptor::CPPTYPE_FLOAT:
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
      return is_interval_end(field) ? end_schema(schemas) : number_schema(schemas);
    case pb::FieldDescriptor::CPPTYPE_ENUM: {
      json::array names;
      for (int i = 0; i < field.enum_type()->value_count(); ++i) names.emplace_back(field.enum_type()->value(i)->name());
      return {{"type", "string"}, {"enum", std::move(names)}};
    }
    case pb::FieldDescriptor::CPPTYPE_STRING:
      if (field.type() == pb::FieldDescriptor::TYPE_BYTES) return {{"type", "string"}, {"contentEncoding", "base64"}};
      return {{"type", "string"}};
    default:
      add(*field.message_type(), schemas);
      return reference(field.message_type()->name());
  }
}

json::object field_schema(const pb::FieldDescriptor& field, json::object& schemas) {
  json::object schema;
  if (field.is_map())
    schema = {{"type", "object"}, {"additionalProperties", value_schema(*field.message_type()->map_value(), schemas)}};
  else if (field.is_repeated())
    schema = {{"type", "array"}, {"items", value_schema(field, schemas)}};
  else
    schema = value_schema(field, schemas);
  // An absent value may be written as null.
  if (!field.is_repeated() && (field.message_type() || field.has_optional_keyword())) {
    json::array either{std::move(schema), json::object{{"type", "null"}}};
    schema = {{"anyOf", std::move(either)}};
  }
  if (const std::string comment = comment_of(field); !comment.empty()) schema["description"] = comment;
  return schema;
}

void add(const pb::Descriptor& message, json::object& schemas) {
  if (schemas.contains(message.name())) return;
  schemas[message.name()] = nullptr;  // it may contain itself
  json::object properties;
  for (int i = 0; i < message.field_count(); ++i)
    properties[message.field(i)->json_name()] = field_schema(*message.field(i), schemas);
  json::object schema{{"type", "object"}};
  if (const std::string comment = comment_of(message); !comment.empty()) schema["description"] = comment;
  schema["properties"] = std::move(properties);
  schema["additionalProperties"] = false;
  schemas[message.name()] = std::move(schema);
}

}  // namespace

void add_message_schema(const std::string& message, json::object& schemas) {
  if (const auto* found = pool().FindMessageTypeByName("isostrata.v1." + message)) add(*found, schemas);
}

}  // namespace isostrata
