// What the server is and can do.
#include <boost/json/array.hpp>

#include "net/http/json_body.h"
#include "net/rest/rest_routes.h"
#include "scene/style.h"
#include "session/wire/limits.h"

namespace isostrata {

namespace json = boost::json;

namespace {

json::object limits_object() {
  return {{"maxIntervals", kMaxIntervals},
          {"maxTerms", kMaxTerms},
          {"maxSmearSteps", kMaxSmearSteps},
          {"maxClipPlanes", kMaxClipPlanes},
          {"maxSide", kMaxSide},
          {"maxPixels", kMaxPixels},
          {"maxBins", kMaxBins},
          {"maxBodyBytes", kMaxMessageBytes},
          {"maxExports", Operations::kMostFiles},
          {"maxOperations", Operations::kMostRecords}};
}

json::object version_object(const Sessions& sessions) {
  const EngineFacts engine = sessions.engine();
  return {{"server", sessions.options().server_name},
          {"api", "v1"},
          {"protocolMajor", kProtocolMajor},
          {"protocolMinor", kProtocolMinor},
          {"device", engine.device},
          {"deviceIsSoftware", engine.device_is_software},
          {"imageFormats", json::array{"png", "jpeg", "webp", "exr"}},
          {"exportFormats", json::array{"vtu", "vtkhdf", "ply", "stl"}},
          {"limits", limits_object()}};
}

json::object engine_object(const Sessions& sessions) {
  const EngineFacts engine = sessions.engine();
  return {{"device", engine.device},          {"deviceIsSoftware", engine.device_is_software},
          {"ownProcess", engine.own_process}, {"process", engine.process},
          {"processes", engine.processes},    {"deaths", engine.deaths},
          {"lastDeath", engine.last_death},   {"fallback", engine.fallback},
          {"trouble", engine.trouble}};
}

}  // namespace

void add_server_routes(std::vector<Route>& routes, RestContext& context) {
  routes.push_back({.method = "GET",
                    .path = "/version",
                    .id = "getVersion",
                    .tag = "server",
                    .summary = "The server's version, device, formats and limits",
                    .answers = {{200, "What this server is", "Version"}},
                    .handler = [&context](Call call) { call.reply(json_response(200, version_object(context.sessions))); }});
  routes.push_back({.method = "GET",
                    .path = "/health",
                    .id = "getHealth",
                    .tag = "server",
                    .summary = "That the server answers, and how many use it",
                    .description = "Without a token, or by another name, the status alone. The same is at /healthz; /readyz says whether new work is welcome.",
                    .answers = {{200, "It answers", "Health"}},
                    .open = true,
                    .handler = [&context](Call call) {
                      const Sessions& sessions = context.sessions;
                      const EngineFacts engine = sessions.engine();
                      call.reply(json_response(200, json::object{{"status", "ok"},
                                                                 {"server", sessions.options().server_name},
                                                                 {"device", engine.device},
                                                                 {"deviceIsSoftware", engine.device_is_software},
                                                                 {"sessions", sessions.list().size()},
                                                                 {"viewers", sessions.viewer_count()}}));
                    }});
  routes.push_back({.method = "GET",
                    .path = "/engine",
                    .id = "getEngine",
                    .tag = "server",
                    .summary = "Whose process draws, and what became of those before it",
                    .answers = {{200, "The engine", "Engine"}},
                    .handler = [&context](Call call) { call.reply(json_response(200, engine_object(context.sessions))); }});
  routes.push_back({.method = "GET",
                    .path = "/color-maps",
                    .id = "listColorMaps",
                    .tag = "server",
                    .summary = "The built-in colour maps",
                    .description = "Beside them a ramp between two colours, `#0000ff-#ffffff`, is a colour map everywhere.",
                    .answers = {{200, "Their names", "ColorMaps"}},
                    .handler = [](Call call) {
                      json::array names;
                      for (const auto name : color_map_names()) names.emplace_back(std::string(name));
                      call.reply(json_response(200, json::object{{"colorMaps", std::move(names)}}));
                    }});
}

}  // namespace isostrata
