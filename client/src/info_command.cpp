#include <google/protobuf/util/json_util.h>

#include <cstdio>
#include <memory>

#include "commands.h"

namespace isostrata::client {

void add_info_command(CLI::App& app, const std::string& url) {
  auto* command = app.add_subcommand("info", "What the server offers: datasets, device, limits, living sessions");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "One JSON document: the server's Welcome and its sessions");
  command->callback([&url, json] {
    const std::string sessions = http_get(parse_address(url), "api/v1/sessions", std::chrono::seconds(10));
    const Connection connection = Connection::open(url, {});
    v1::Welcome welcome = connection.welcome();
    if (*json) {
      welcome.clear_resume_token();  // a secret of this connection's own short session
      std::string text;
      google::protobuf::util::JsonPrintOptions options;
      options.preserve_proto_field_names = true;
      if (!google::protobuf::util::MessageToJsonString(welcome, &text, options).ok())
        throw Error("internal", "the server's welcome cannot be written as JSON");
      std::printf("{\"welcome\":%s,\"sessions\":%s}\n", text.c_str(), sessions.c_str());
      return;
    }
    std::printf("%s on %s%s\n", welcome.server().c_str(), welcome.device().c_str(), welcome.device_is_software() ? " (software)" : "");
    std::printf("limits    %u intervals, frames up to %ux%u\n", welcome.limits().max_intervals(), welcome.limits().max_width(),
                welcome.limits().max_height());
    for (const auto& entry : welcome.datasets()) std::printf("dataset   %-12s %s\n", entry.id().c_str(), entry.name().c_str());
    std::printf("sessions  %s\n", sessions.c_str());
  });
}

}  // namespace isostrata::client
