#include "net/http/json_body.h"

#include <google/protobuf/util/json_util.h>

#include <boost/json/basic_parser_impl.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <set>
#include <string_view>
#include <vector>

#include "base/utf8.h"
#include "net/http/problem.h"
#include "session/wire/message_bounds.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

namespace json = boost::json;
using boost::system::error_code;

// Listens to a JSON parser before anything is made of what it reads: for members that stand twice, since which of them counts is a
// question that two parsers answer differently, and for more values than a body that makes sense has.
class BodyCheck {
 public:
  static constexpr std::size_t max_object_size = 1 << 16;
  static constexpr std::size_t max_array_size = 1 << 20;
  static constexpr std::size_t max_key_size = 1 << 16;
  static constexpr std::size_t max_string_size = 1 << 24;

  std::string twice;  // the first such member
  std::string too_much;

  bool on_object_begin(error_code& error) {
    if (!count(error)) return false;
    members_.emplace_back();
    sizes_.push_back(0);
    in_list_.push_back(false);
    return true;
  }
  bool on_object_end(std::size_t, error_code&) {
    members_.pop_back();
    return close();
  }
  bool on_key_part(json::string_view part, std::size_t, error_code&) {
    key_.append(part.data(), part.size());
    return true;
  }
  bool on_key(json::string_view part, std::size_t, error_code&) {
    key_.append(part.data(), part.size());
    if (!members_.back().insert(key_).second && twice.empty()) twice = key_;
    key_.clear();
    return true;
  }
  bool on_document_begin(error_code&) { return true; }
  bool on_document_end(error_code&) { return true; }
  bool on_array_begin(error_code& error) {
    if (!count(error)) return false;
    sizes_.push_back(0);
    in_list_.push_back(true);
    return true;
  }
  bool on_array_end(std::size_t, error_code&) { return close(); }
  bool on_string_part(json::string_view, std::size_t, error_code&) { return true; }
  bool on_string(json::string_view, std::size_t, error_code& error) { return count(error); }
  bool on_number_part(json::string_view, error_code&) { return true; }
  bool on_int64(std::int64_t, json::string_view, error_code& error) { return count(error); }
  bool on_uint64(std::uint64_t, json::string_view, error_code& error) { return count(error); }
  bool on_double(double, json::string_view, error_code& error) { return count(error); }
  bool on_bool(bool, error_code& error) { return count(error); }
  bool on_null(error_code& error) { return count(error); }
  bool on_comment_part(json::string_view, error_code&) { return true; }
  bool on_comment(json::string_view, error_code&) { return true; }

 private:
  bool count(error_code& error) {
    if (++values_ > kMaxMessageValues)
      too_much = "more than " + std::to_string(kMaxMessageValues) + " values";
    else if (!in_list_.empty() && in_list_.back() && ++sizes_.back() > kMaxListed)
      too_much = "more than " + std::to_string(kMaxListed) + " elements in one list";
    if (too_much.empty()) return true;
    error = json::error::array_too_large;
    return false;
  }
  bool close() {
    sizes_.pop_back();
    in_list_.pop_back();
    return true;
  }

  std::vector<std::set<std::string>> members_;  // of the objects that are open
  std::vector<std::size_t> sizes_;              // of the objects and lists that are open
  std::vector<bool> in_list_;
  std::size_t values_ = 0;
  std::string key_;
};

void add_named(const google::protobuf::Descriptor& type, const json::object& document, const std::string& prefix,
               google::protobuf::FieldMask& mask) {
  for (const auto& [key, value] : document) {
    const auto* field = type.FindFieldByCamelcaseName(std::string(key));
    if (!field) field = type.FindFieldByName(std::string(key));
    if (!field) continue;  // the Protobuf parser has refused it already
    const bool nested = field->message_type() && !field->is_repeated() && value.is_object();
    if (nested)
      add_named(*field->message_type(), value.as_object(), prefix + field->name() + ".", mask);
    else
      mask.add_paths(prefix + field->name());
  }
}

/// The same text with ends that are open as Protobuf's JSON has them. Of text that is JSON; all other bytes stay what they are, since
/// a number that is parsed and written again may lose its last bit.
std::string with_open_ends(std::string_view text) {
  std::string out;
  std::vector<std::string_view> objects;  // the member that each open object or list is the value of
  std::string_view key;
  bool is_value = false;  // what comes next, of a member
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    std::size_t end = at + 1;
    if (c == '"') {
      while (text[end] != '"') end += text[end] == '\\' ? 2 : 1;
      ++end;
    } else if (c == 'n') {
      end = at + 4;  // null
    }
    const std::string_view token = text.substr(at, end - at);
    const bool is_end = is_value && (key == "\"lower\"" || key == "\"upper\"") && (objects.empty() || objects.back() != "\"surface\"");
    if (c == '{' || c == '[') objects.push_back(is_value ? key : objects.empty() ? std::string_view{} : objects.back());
    if ((c == '}' || c == ']') && !objects.empty()) objects.pop_back();
    if (is_end && (token == "\"inf\"" || (token == "null" && key == "\"upper\"")))
      out += "\"Infinity\"";
    else if (is_end && (token == "\"-inf\"" || token == "null"))
      out += "\"-Infinity\"";
    else
      out += token;
    if (c == ':')
      is_value = true;
    else if (c != ' ' && c != '\t' && c != '\r' && c != '\n')
      is_value = false;
    if (c == '"') key = token;
    at = end;
  }
  return out;
}

}  // namespace

bool is_interval_end(const google::protobuf::FieldDescriptor& field) {
  const std::string& of = field.containing_type()->name();
  return (field.name() == "lower" || field.name() == "upper") && (of == "Interval" || of == "PatchInterval" || of == "RangeTerm");
}

HttpResponse json_response(int status, const json::value& document) {
  return {status, "application/json", valid_json(json::serialize(document)), {{"Cache-Control", "no-store"}}};
}

std::string message_json(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.always_print_primitive_fields = true;
  std::string text;
  const auto done = google::protobuf::util::MessageToJsonString(message, &text, options);
  return done.ok() ? text : std::string();
}

HttpResponse message_response(int status, const google::protobuf::Message& message) {
  std::string text = message_json(message);
  if (text.empty()) return problem(500, "internal", "the answer could not be written as JSON");
  return {status, "application/json", std::move(text), {{"Cache-Control", "no-store"}}};
}

std::optional<v1::Error> parse_object(const std::string& body, json::object& object) {
  json::basic_parser<BodyCheck> check(json::parse_options{});
  error_code error;
  const std::size_t used = check.write_some(false, body.data(), body.size(), error);
  if (const std::string& what = check.handler().too_much; !what.empty())
    return wire_error("too_large", "the body has " + what + "; no request needs as many");
  const bool more = !error && body.find_first_not_of(" \t\r\n", used) != std::string::npos;
  if (error || more)
    return wire_error("malformed",
                      "the body is not a JSON object" + (error ? ": " + error.message() + " at byte " + std::to_string(used)
                                                               : std::string(": more follows it")));
  if (const std::string& twice = check.handler().twice; !twice.empty())
    return wire_error("malformed", "member '" + twice.substr(0, 64) + "' stands twice in one object; expected it once",
                      twice.substr(0, 64));
  const json::value document = json::parse(body, error);
  if (error || !document.is_object())
    return wire_error("malformed", "the body is not a JSON object" + (error ? ": " + error.message() : std::string()));
  object = document.as_object();
  return std::nullopt;
}

std::optional<v1::Error> parse_message(const std::string& body, google::protobuf::Message& message) {
  if (body.empty()) return std::nullopt;
  json::object object;
  if (auto error = parse_object(body, object)) return error;
  const auto done = google::protobuf::util::JsonStringToMessage(with_open_ends(body), &message);
  if (done.ok()) return std::nullopt;
  return wire_error("malformed", "the body is not a " + message.GetDescriptor()->name() + ": " + done.ToString());
}

google::protobuf::FieldMask named_fields(const google::protobuf::Descriptor& type, const json::object& document) {
  google::protobuf::FieldMask mask;
  add_named(type, document, "", mask);
  return mask;
}

}  // namespace isostrata
