#include "main/server_log.h"

#include <spdlog/sinks/stdout_sinks.h>

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <chrono>
#include <memory>

#include "base/utf8.h"

namespace isostrata {
namespace {

namespace json = boost::json;

json::value id_or_null(const std::string& id) { return id.empty() ? json::value(nullptr) : json::value(id); }

std::string json_line(const LogLine& line) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  json::object document{{"time_ms", std::chrono::duration_cast<std::chrono::milliseconds>(now).count()},
                        {"level", line.warning ? "warning" : "info"},
                        {"event", line.event},
                        {"message", line.message},
                        {"session", id_or_null(line.session)},
                        {"request", id_or_null(line.request)}};
  for (const auto& [name, value] : line.fields) document[name] = value;
  for (const auto& [name, value] : line.numbers) document[name] = value;
  return valid_json(json::serialize(document));
}

std::string text_line(const LogLine& line) {
  return line.message + (line.session.empty() ? "" : " [session " + line.session + "]") +
         (line.request.empty() ? "" : " [request " + line.request + "]");
}

}  // namespace

ServerLog::ServerLog(bool json) : json_(json), logger_("isostrata", std::make_shared<spdlog::sinks::stderr_sink_mt>()) {
  logger_.set_pattern(json ? "%v" : "%Y-%m-%dT%H:%M:%S.%e%z %l %v");
}

void ServerLog::write(const LogLine& line) {
  if (!json_ && line.detail) return;
  // As a value, not as a format: clients' words have braces.
  logger_.log(line.warning ? spdlog::level::warn : spdlog::level::info, "{}", json_ ? json_line(line) : valid_utf8(text_line(line)));
}

}  // namespace isostrata
