#include "net/rest_api.h"

#include <google/protobuf/util/field_mask_util.h>
#include <google/protobuf/util/json_util.h>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <boost/json/value.hpp>
#include <charconv>
#include <optional>

#include "session/limits.h"
#include "session/wire.h"

namespace isostrata {
namespace {

namespace json = boost::json;

TimePoint now() { return std::chrono::steady_clock::now(); }

int status_of(const std::string& code) {
  if (code == "not_found") return 404;
  if (code == "bad_data" || code == "unsupported") return 422;
  if (code == "too_large") return 413;
  if (code == "cancelled") return 409;
  if (code == "unavailable") return 503;
  if (code == "internal") return 500;
  return 400;
}

const char* hint_of(const std::string& code) {
  if (code == "not_found") return "GET api/v1/datasets and api/v1/sessions list what there is";
  if (code == "invalid_argument") return "see the field named here; what was not changed is as it was";
  if (code == "malformed") return "the body is one JSON document in Protobuf's canonical form";
  if (code == "unavailable") return "try again later";
  if (code == "too_large") return "ask for less";
  return "";
}

HttpResponse json_response(int status, const json::value& document) {
  return {status, "application/json", json::serialize(document), {{"Cache-Control", "no-store"}}};
}

HttpResponse message_response(int status, const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.always_print_primitive_fields = true;
  std::string text;
  if (const auto done = google::protobuf::util::MessageToJsonString(message, &text, options); !done.ok())
    return problem(500, "internal", "the answer could not be written as JSON");
  return {status, "application/json", std::move(text), {{"Cache-Control", "no-store"}}};
}

HttpResponse state_response(int status, const Session& session) {
  HttpResponse response = message_response(status, session.wire_state());
  response.headers.emplace_back("ETag", "\"" + std::to_string(session.scene().revision) + "\"");
  return response;
}

template <class Message>
std::optional<v1::Error> parse(const std::string& body, Message& message) {
  const auto done = google::protobuf::util::JsonStringToMessage(body, &message);
  if (done.ok()) return std::nullopt;
  return wire_error("malformed", "the body is not a " + message.GetDescriptor()->name() + ": " + done.ToString());
}

std::optional<v1::Error> parse_object(const std::string& body, json::object& object) {
  boost::system::error_code error;
  const json::value document = json::parse(body, error);
  if (error || !document.is_object())
    return wire_error("malformed", "the body is not a JSON object" + (error ? ": " + error.message() : std::string()));
  object = document.as_object();
  return std::nullopt;
}

// Which fields a document names, as the paths of a field mask. Numbers never pass through a second JSON library: a last bit lost
// at the top of an interval would lose the points that have the value.
void named_fields(const google::protobuf::Descriptor& type, const json::object& document, const std::string& prefix,
                  google::protobuf::FieldMask& mask) {
  for (const auto& [key, value] : document) {
    const auto* field = type.FindFieldByCamelcaseName(std::string(key));
    if (!field) field = type.FindFieldByName(std::string(key));
    if (!field) continue;  // the Protobuf parser has refused it already
    const bool nested = field->message_type() && !field->is_repeated() && value.is_object();
    if (nested)
      named_fields(*field->message_type(), value.as_object(), prefix + field->name() + ".", mask);
    else
      mask.add_paths(prefix + field->name());
  }
}

std::optional<v1::Error> number_parameter(const RequestTarget& target, const char* name, std::uint32_t& value) {
  const auto it = target.query.find(name);
  if (it == target.query.end()) return std::nullopt;
  const std::string& text = it->second;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc{} && end == text.data() + text.size() && !text.empty()) return std::nullopt;
  return wire_error("invalid_argument", std::string(name) + " '" + text.substr(0, 32) + "' is not a whole number", name);
}

HttpResponse not_allowed(const std::string& allowed) {
  HttpResponse response = problem(405, "unsupported", "this method is not known here; expected " + allowed);
  response.headers.emplace_back("Allow", allowed);
  return response;
}

HttpResponse no_route() { return problem(404, "not_found", "there is no such route; see api/v1/datasets and api/v1/sessions"); }

json::object session_object(const Session& session) {
  return {{"id", session.id()},
          {"resumeToken", session.resume_token()},
          {"revision", session.scene().revision},
          {"dataset", session.scene().dataset},
          {"viewers", session.viewer_count()}};
}

std::string parameter(const RequestTarget& target, const char* name, const std::string& otherwise) {
  const auto it = target.query.find(name);
  return it == target.query.end() ? otherwise : it->second;
}

bool is_get(const HttpRequest& request) { return request.method == "GET" || request.method == "HEAD"; }

// A patch of an interval uses the State's own JSON names, so it is an Interval whose absent fields are known by looking at the
// document.
v1::ClientMessage patch_message(std::uint32_t id, const v1::Interval& interval, const json::object& given) {
  v1::ClientMessage message;
  v1::PatchInterval& patch = *message.mutable_patch_interval();
  patch.set_id(id);
  if (given.contains("lower")) patch.set_lower(interval.lower());
  if (given.contains("upper")) patch.set_upper(interval.upper());
  if (given.contains("color")) *patch.mutable_color() = interval.color();
  if (given.contains("colorMap") || given.contains("color_map")) patch.set_color_map(interval.color_map());
  if (given.contains("opacity")) patch.set_opacity(interval.opacity());
  if (given.contains("visible")) patch.set_visible(interval.visible());
  for (const char* name : {"opacityUpper", "opacity_upper"})
    if (given.contains(name)) {
      if (interval.has_opacity_upper())
        patch.set_opacity_upper(interval.opacity_upper());
      else
        patch.set_clear_opacity_upper(true);  // null
    }
  if (given.contains("ownRange") || given.contains("own_range")) patch.set_own_range(interval.own_range());
  if (given.contains("surface")) *patch.mutable_surface() = interval.surface();
  return message;
}

}  // namespace

HttpResponse problem(const v1::Error& error) {
  const int status = status_of(error.code());
  json::object document{
      {"type", "about:blank"}, {"title", error.code()}, {"status", status}, {"detail", error.message()}, {"code", error.code()}};
  if (!error.field().empty()) document["field"] = error.field();
  if (const std::string hint = hint_of(error.code()); !hint.empty()) document["hint"] = hint;
  return {status, "application/problem+json", json::serialize(document), {{"Cache-Control", "no-store"}}};
}

HttpResponse problem(int status, const std::string& code, const std::string& message) {
  HttpResponse response = problem(wire_error(code, message));
  json::value document = json::parse(response.body);
  document.as_object()["status"] = status;
  response.status = status;
  response.body = json::serialize(document);
  return response;
}

HttpResponse RestApi::health() const {
  return json_response(200, json::object{{"status", "ok"},
                                         {"server", sessions_.options().server_name},
                                         {"device", sessions_.options().device},
                                         {"deviceIsSoftware", sessions_.options().device_is_software},
                                         {"sessions", sessions_.list().size()},
                                         {"viewers", sessions_.viewer_count()}});
}

void RestApi::handle(const HttpRequest& request, const RequestTarget& target, const std::vector<std::string>& path,
                     HttpReply reply) {
  if (path.empty()) return reply(no_route());
  if (path[0] == "health" && path.size() == 1) return reply(is_get(request) ? health() : not_allowed("GET"));
  if (path[0] == "datasets") return datasets(request, target, path, std::move(reply));
  if (path[0] == "sessions") return sessions(request, target, path, std::move(reply));
  reply(no_route());
}

void RestApi::datasets(const HttpRequest& request, const RequestTarget& target, const std::vector<std::string>& path,
                       HttpReply reply) {
  if (path.size() > 3 || (path.size() == 3 && path[2] != "histogram" && path[2] != "info")) return reply(no_route());
  if (!is_get(request)) return reply(not_allowed("GET"));
  if (path.size() == 1) {
    json::array entries;
    for (const v1::DatasetEntry& entry : sessions_.datasets())
      entries.push_back(json::object{{"id", entry.id()}, {"name", entry.name()}});
    return reply(json_response(200, json::object{{"datasets", std::move(entries)}}));
  }
  std::uint32_t step = 0;
  if (auto error = number_parameter(target, "step", step)) return reply(problem(*error));
  // Session 0: nobody watches its progress.
  const bool histogram_wanted = path.size() == 3 && path[2] == "histogram";
  sessions_.ask(OpenRequest{0, 0, path[1]},
                [this, target, histogram_wanted, step, reply = std::move(reply)](const EngineEvent& event, TimePoint) {
                  if (const auto* failed = std::get_if<RequestFailed>(&event)) return reply(problem(wire_error(*failed)));
                  const DatasetFacts& facts = std::get<DatasetReady>(event).facts;
                  if (histogram_wanted) return histogram(0, facts, static_cast<int>(step), target, reply);
                  reply(message_response(200, to_wire(facts)));
                });
}

void RestApi::histogram(SessionKey session, const DatasetFacts& facts, int step, const RequestTarget& target, HttpReply reply) {
  v1::RequestHistogram wanted;
  wanted.set_array(parameter(target, "array", facts.arrays.empty() ? "" : facts.arrays.front().name));
  std::uint32_t bins = 256;
  if (auto error = number_parameter(target, "bins", bins)) return reply(problem(*error));
  wanted.set_bins(bins);
  if (auto error = check_histogram(wanted, {&facts})) return reply(problem(*error));
  if (step < 0 || step >= static_cast<int>(facts.times.size()))
    return reply(problem(wire_error(
        "not_found", "step " + std::to_string(step) + " is not there; expected 0.." + std::to_string(facts.times.size() - 1),
        "step")));
  sessions_.ask(HistogramRequest{session, 0, facts.id, step, wanted.array(), static_cast<int>(bins)},
                [reply = std::move(reply)](const EngineEvent& event, TimePoint) {
                  if (const auto* failed = std::get_if<RequestFailed>(&event)) return reply(problem(wire_error(*failed)));
                  reply(message_response(200, to_wire(std::get<HistogramReady>(event))));
                });
}

void RestApi::sessions(const HttpRequest& request, const RequestTarget& target, const std::vector<std::string>& path,
                       HttpReply reply) {
  if (path.size() == 1) {
    if (request.method == "POST") return create_session(request, std::move(reply));
    if (!is_get(request)) return reply(not_allowed("GET, POST"));
    json::array all;
    for (const Session* session : sessions_.list()) all.push_back(session_object(*session));
    return reply(json_response(200, json::object{{"sessions", std::move(all)}}));
  }
  Session* found = sessions_.find(path[1]);
  if (!found) return reply(problem(wire_error("not_found", "there is no session of this id; it may have ended")));
  found->touch(now());
  session(*found, request, target, path, std::move(reply));
}

void RestApi::create_session(const HttpRequest& request, HttpReply reply) {
  json::object wanted;
  if (!request.body.empty())
    if (auto error = parse_object(request.body, wanted)) return reply(problem(*error));
  std::string dataset;
  for (const auto& [key, value] : wanted) {
    if (key != "dataset")
      return reply(problem(
          wire_error("invalid_argument", "unknown member '" + std::string(key) + "'; expected dataset", std::string(key))));
    if (!value.is_string()) return reply(problem(wire_error("invalid_argument", "dataset is not a string", "dataset")));
    dataset = std::string(value.as_string());
  }
  v1::Error error;
  Session* created = sessions_.create(now(), error);
  if (!created) return reply(problem(error));
  const auto answer = [this, id = created->id(), reply](std::optional<v1::Error> failed) {
    Session* session = sessions_.find(id);
    if (failed || !session) {
      // The session is still in the middle of telling this, so it may not go at once; and whoever has taken it over meanwhile
      // keeps it.
      if (session && failed->code() != "cancelled") sessions_.end_unwatched_soon(session->key());
      return reply(problem(failed ? *failed : wire_error("not_found", "the session has ended")));
    }
    HttpResponse response = json_response(201, session_object(*session));
    response.headers.emplace_back("Location", "sessions/" + id);
    reply(std::move(response));
  };
  if (dataset.empty()) return answer(std::nullopt);
  created->open(dataset, nullptr, now(), answer);
}

void RestApi::session(Session& session, const HttpRequest& request, const RequestTarget& target,
                      const std::vector<std::string>& path, HttpReply reply) {
  if (path.size() == 2) {
    if (is_get(request)) return reply(json_response(200, session_object(session)));
    if (request.method != "DELETE") return reply(not_allowed("GET, DELETE"));
    sessions_.end(session.id());
    return reply({204, "", "", {}});
  }
  const std::string& what = path[2];
  if (what == "state" && path.size() == 3) return state(session, request, std::move(reply));
  if (what == "intervals" && path.size() <= 4) return intervals(session, request, path, std::move(reply));
  if (what == "image" && path.size() == 3)
    return is_get(request) ? image(session, target, std::move(reply)) : reply(not_allowed("GET"));
  if (what == "histogram" && path.size() == 3) {
    if (!is_get(request)) return reply(not_allowed("GET"));
    if (!session.dataset()) return reply(problem(wire_error("not_found", "no dataset is open in this session")));
    return histogram(session.key(), *session.dataset(), session.scene().step, target, std::move(reply));
  }
  if (what == "commands" && path.size() == 3) {
    if (request.method != "POST") return reply(not_allowed("POST"));
    v1::ClientMessage message;
    if (auto error = parse(request.body, message)) return reply(problem(*error));
    return command(session, message, 200, std::move(reply));
  }
  reply(no_route());
}

void RestApi::command(Session& session, const v1::ClientMessage& message, int status, HttpReply reply) {
  const Session::Reply answer = [this, id = session.id(), status, reply](std::optional<v1::Error> error) {
    if (error) return reply(problem(*error));
    const Session* living = sessions_.find(id);
    if (!living) return reply(problem(wire_error("not_found", "the session has ended")));
    reply(state_response(status, *living));
  };
  if (message.has_open_dataset()) return session.open(message.open_dataset().id(), nullptr, now(), answer);
  if (!is_scene_command(message))
    return reply(problem(
        wire_error("unsupported", "this message has no meaning without a connection; expected one that changes the scene")));
  session.command(message, nullptr, now(), answer);
}

void RestApi::state(Session& session, const HttpRequest& request, HttpReply reply) {
  if (is_get(request)) return reply(state_response(200, session));
  if (request.method != "PUT" && request.method != "PATCH") return reply(not_allowed("GET, PUT, PATCH"));
  const std::string expected = request.header("if-match").empty() ? "*" : std::string(request.header("if-match"));
  if (expected != "*" && expected != "\"" + std::to_string(session.scene().revision) + "\"")
    return reply(
        problem(412, "cancelled", "the state is at revision " + std::to_string(session.scene().revision) + ", not " + expected));
  v1::State wanted;
  if (request.method == "PUT") {
    if (auto error = parse(request.body, wanted)) return reply(problem(*error));
  } else {
    json::object patch;
    if (auto error = parse_object(request.body, patch)) return reply(problem(*error));
    v1::State named;
    if (auto error = parse(request.body, named)) return reply(problem(*error));
    google::protobuf::FieldMask mask;
    named_fields(*v1::State::descriptor(), patch, "", mask);
    wanted = session.wire_state();
    if (patch.contains("dataset") && named.dataset() != session.scene().dataset) {
      // Another dataset has its own arrays and ranges: what is not named here has no meaning in it.
      wanted.clear_array();
      wanted.clear_color_by();
      wanted.clear_intervals();
      wanted.clear_camera();
      wanted.clear_step();
      wanted.clear_texture();
      wanted.clear_smear();
      wanted.clear_terms();
      wanted.clear_time();
    }
    google::protobuf::util::FieldMaskUtil::MergeOptions replace;
    replace.set_replace_message_fields(true);
    replace.set_replace_repeated_fields(true);
    google::protobuf::util::FieldMaskUtil::MergeMessageTo(named, mask, replace, &wanted);
  }
  session.set_state(wanted, now(), [this, id = session.id(), reply](std::optional<v1::Error> error) {
    if (error) return reply(problem(*error));
    const Session* living = sessions_.find(id);
    reply(living ? state_response(200, *living) : problem(wire_error("not_found", "the session has ended")));
  });
}

void RestApi::intervals(Session& session, const HttpRequest& request, const std::vector<std::string>& path, HttpReply reply) {
  const v1::State current = session.wire_state();
  if (path.size() == 3) {
    if (is_get(request)) {
      std::string list;
      for (const v1::Interval& interval : current.intervals())
        list += (list.empty() ? "" : ",") + message_response(200, interval).body;
      return reply({200, "application/json", "{\"intervals\":[" + list + "]}", {{"Cache-Control", "no-store"}}});
    }
    if (request.method != "POST") return reply(not_allowed("GET, POST"));
    json::object given;
    v1::Interval added;
    if (auto error = parse_object(request.body, given)) return reply(problem(*error));
    if (auto error = parse(request.body, added)) return reply(problem(*error));
    added.set_id(0);
    if (!given.contains("visible")) added.set_visible(true);
    if (!given.contains("opacity")) added.set_opacity(0.5);
    if (!given.contains("priority"))
      for (const v1::Interval& interval : current.intervals())
        if (interval.priority() < INT32_MAX) added.set_priority(std::max(added.priority(), interval.priority() + 1));
    v1::ClientMessage message;
    *message.mutable_set_intervals()->mutable_intervals() = current.intervals();
    *message.mutable_set_intervals()->add_intervals() = added;
    return command(session, message, 201, std::move(reply));
  }
  std::uint32_t id = 0;
  const std::string& text = path[3];
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  const v1::Interval* found = nullptr;
  if (error == std::errc{} && end == text.data() + text.size())
    for (const v1::Interval& interval : current.intervals())
      if (interval.id() == id) found = &interval;
  if (!found)
    return reply(problem(wire_error("not_found", "interval '" + text.substr(0, 32) + "' is not in this session", "id")));
  if (is_get(request)) return reply(message_response(200, *found));
  v1::ClientMessage message;
  if (request.method == "DELETE") {
    message.mutable_remove_interval()->set_id(id);
  } else if (request.method == "PATCH") {
    json::object given;
    v1::Interval patch;
    if (auto bad = parse_object(request.body, given)) return reply(problem(*bad));
    if (auto bad = parse(request.body, patch)) return reply(problem(*bad));
    if (given.contains("id") && patch.id() != id)
      return reply(problem(wire_error("invalid_argument", "the id in the body is another interval's", "id")));
    if (given.contains("priority"))
      return reply(
          problem(wire_error("unsupported", "priorities are set together, by the command reorderPriorities", "priority")));
    message = patch_message(id, patch, given);
  } else {
    return reply(not_allowed("GET, PATCH, DELETE"));
  }
  command(session, message, 200, std::move(reply));
}

void RestApi::image(Session& session, const RequestTarget& target, HttpReply reply) {
  std::uint32_t width = 800, height = 600;
  if (auto error = number_parameter(target, "width", width)) return reply(problem(*error));
  if (auto error = number_parameter(target, "height", height)) return reply(problem(*error));
  if (auto error = check_size(width, height)) return reply(problem(*error));
  const std::string format = parameter(target, "format", "png");
  const bool jpeg = format == "jpeg" || format == "jpg";
  if (!jpeg && format != "png")
    return reply(problem(
        wire_error("invalid_argument", "format '" + format.substr(0, 32) + "' is not known; expected png or jpeg", "format")));
  session.picture(
      static_cast<int>(width), static_cast<int>(height), jpeg,
      [reply = std::move(reply)](const EngineEvent& event, TimePoint) {
        if (std::holds_alternative<FrameStarted>(event)) return;
        if (const auto* failed = std::get_if<RequestFailed>(&event)) return reply(problem(wire_error(*failed)));
        const auto& frame = std::get<FrameReady>(event);
        HttpResponse response{200,
                              frame.jpeg ? "image/jpeg" : "image/png",
                              std::string(frame.bytes->begin(), frame.bytes->end()),
                              {{"Cache-Control", "no-store"}}};
        response.headers.emplace_back("ETag", "\"" + std::to_string(frame.revision) + "\"");
        response.headers.emplace_back("Isostrata-Revision", std::to_string(frame.revision));
        reply(std::move(response));
      },
      now());
}

}  // namespace isostrata
