#include "net/rest/openapi.h"

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/parse.hpp>

#include "base/error.h"
#include "net/http/router.h"
#include "net/rest/message_schema.h"
#include "net/rest_schemas.h"  // generated from rest_schemas.json

namespace isostrata {
namespace {

namespace json = boost::json;

constexpr const char* kAbout =
    "Everything that the page can do, for scripts. Bodies are canonical Protobuf JSON of the messages that the WebSocket "
    "carries; errors "
    "are problem documents (RFC 9457) with `code`, `field` and `hint`. A script and a browser that share a session see one state "
    "with one "
    "revision: it is the ETag of the state and of its parts, and If-Match makes a change depend on it. Unknown members, members "
    "that "
    "stand twice and unknown query parameters are refused.";

const std::vector<std::pair<const char*, const char*>> kTags = {
    {"server", "What this server is and can do"},
    {"datasets", "What can be opened"},
    {"sessions", "Who looks at what"},
    {"people", "Who is in a session, and whom they invite"},
    {"state", "Everything that a session shows"},
    {"scene", "Parts of the state"},
    {"intervals", "Intervals one by one"},
    {"pictures", "Pictures and numbers of what is shown"},
    {"operations", "Long work: progress and cancel"},
    {"exports", "Mesh files"},
    {"films", "Films: turns and steps"},
};

const json::object& rest_schemas() {
  static const json::object kSchemas = json::parse(kRestSchemas).as_object();
  return kSchemas;
}

json::object schema_of(const std::string& name, json::object& schemas) {
  add_message_schema(name, schemas);
  if (!schemas.contains(name)) throw Error(ErrorCode::internal, "no schema is known by the name " + name);
  return {{"$ref", "#/components/schemas/" + name}};
}

json::object with_schema(const std::string& name, const std::string& type, json::object& schemas) {
  return {{type, json::object{{"schema", schema_of(name, schemas)}}}};
}

json::object parameter(const QueryParameter& query) {
  json::object schema{{"type", query.integer ? "integer" : query.real ? "number" : "string"}};
  if (query.integer || query.real) {
    schema["minimum"] = query.least;
    schema["maximum"] = query.most;
    if (!query.otherwise.empty()) schema["default"] = std::stoll(query.otherwise);
  } else {
    if (!query.one_of.empty()) schema["enum"] = json::array(query.one_of.begin(), query.one_of.end());
    if (!query.otherwise.empty()) schema["default"] = query.otherwise;
  }
  return {{"name", query.name}, {"in", "query"}, {"description", query.description}, {"schema", std::move(schema)}};
}

json::array parameters(const Route& route) {
  json::array all;
  for (const std::string& segment : path_segments(route.path))
    if (segment.starts_with('{'))
      all.push_back(json::object{{"name", segment.substr(1, segment.size() - 2)},
                                 {"in", "path"},
                                 {"required", true},
                                 {"schema", json::object{{"type", "string"}}}});
  for (const QueryParameter& query : route.query) all.push_back(parameter(query));
  if (route.conditional) all.push_back(json::object{{"$ref", "#/components/parameters/IfMatch"}});
  return all;
}

json::object responses(const Route& route, json::object& schemas) {
  json::object all;
  for (const Answer& answer : route.answers) {
    json::object response{{"description", answer.description}};
    if (!answer.schema.empty()) {
      response["content"] = with_schema(answer.schema, answer.content_type, schemas);
    } else if (answer.content_type != "application/json") {
      json::object content{{answer.content_type, json::object()}};
      for (const std::string& type : answer.more_types) content[type] = json::object();
      response["content"] = std::move(content);
    }
    all[std::to_string(answer.status)] = std::move(response);
  }
  all["4XX"] = json::object{{"$ref", "#/components/responses/Problem"}};
  all["5XX"] = json::object{{"$ref", "#/components/responses/Problem"}};
  return all;
}

json::object operation(const Route& route, json::object& schemas) {
  json::object of{{"operationId", route.id}, {"tags", json::array{route.tag}}, {"summary", route.summary}};
  if (!route.description.empty()) of["description"] = route.description;
  if (json::array all = parameters(route); !all.empty()) of["parameters"] = std::move(all);
  if (route.body) {
    json::object content = with_schema(route.body->schema, "application/json", schemas);
    if (route.method == "PATCH") content["application/merge-patch+json"] = content["application/json"];
    of["requestBody"] = json::object{
        {"description", route.body->description}, {"required", route.body->required}, {"content", std::move(content)}};
  }
  of["responses"] = responses(route, schemas);
  if (route.open) of["security"] = json::array();
  return of;
}

json::object components(json::object schemas) {
  json::object problem{{"description", "What went wrong"},
                       {"content", with_schema("Problem", "application/problem+json", schemas)}};
  json::object if_match{
      {"name", "If-Match"},
      {"in", "header"},
      {"description", "The ETag of the revision that this is meant for; of another one the answer is 412 and nothing changes"},
      {"schema", json::object{{"type", "string"}}}};
  json::object schemes{
      {"bearer", json::object{{"type", "http"}, {"scheme", "bearer"}, {"description", "The token that the server printed"}}},
      {"query",
       json::object{{"type", "apiKey"}, {"in", "query"}, {"name", "token"}, {"description", "The same in the address"}}}};
  return {{"schemas", std::move(schemas)},
          {"responses", json::object{{"Problem", std::move(problem)}}},
          {"parameters", json::object{{"IfMatch", std::move(if_match)}}},
          {"securitySchemes", std::move(schemes)}};
}

}  // namespace

json::object openapi_document(const std::vector<Route>& routes, const std::string& version) {
  json::object schemas = rest_schemas(), paths;
  // What they refer to.
  for (const char* message : {"DatasetEntry", "ArrayInfo"}) add_message_schema(message, schemas);
  for (const Route& route : routes) {
    std::string method = route.method;
    std::transform(method.begin(), method.end(), method.begin(), [](char c) { return static_cast<char>(c - 'A' + 'a'); });
    if (!paths.contains(route.path)) paths[route.path] = json::object();
    paths[route.path].as_object()[method] = operation(route, schemas);
  }
  json::array tags;
  for (const auto& [name, about] : kTags) tags.push_back(json::object{{"name", name}, {"description", about}});
  return {{"openapi", "3.1.0"},
          {"info", json::object{{"title", "Isostrata"},
                                {"version", version},
                                {"description", kAbout},
                                {"license", json::object{{"name", "Apache License 2.0"}, {"identifier", "Apache-2.0"}}}}},
          {"servers", json::array{json::object{{"url", "."}, {"description", "Beside this document"}}}},
          {"security", json::array{json::object{{"bearer", json::array()}}, json::object{{"query", json::array()}}}},
          {"tags", std::move(tags)},
          {"paths", std::move(paths)},
          {"components", components(std::move(schemas))}};
}

}  // namespace isostrata
