// info: what a server offers, which sessions live there, and what the session shows.
#include <google/protobuf/util/json_util.h>

#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>
#include <cstdio>
#include <string_view>

#include "arguments.h"

namespace isostrata::client {

void add_info(CLI::App& app, Options& options) {
  CLI::App* command =
      app.add_subcommand("info", "What the server offers, and the sessions that live on it (snapshot --session ID shows one)");
  const auto json = std::make_shared<bool>(false);
  const auto arguments = std::make_shared<SceneArguments>();
  command->add_flag("--json", *json, "The server's Welcome as one JSON document");
  command->add_option("--session", arguments->session, "Id or resume token of the session to join; none: a new one");
  arguments->size.clear();
  command->callback([&options, json, arguments] {
    const Client client = connect(options, *arguments);
    const v1::Welcome& welcome = client.welcome();
    if (*json) {
      google::protobuf::util::JsonPrintOptions print;
      print.always_print_primitive_fields = true;
      std::string text;
      if (!google::protobuf::util::MessageToJsonString(welcome, &text, print).ok())
        throw ClientError("protocol", "the server's Welcome is not JSON");
      std::printf("%s\n", text.c_str());
      return;
    }
    std::printf("server   %s\ndevice   %s\nsession  %s\n", welcome.server().c_str(), welcome.device().c_str(),
                welcome.session().c_str());
    for (const v1::DatasetEntry& entry : welcome.datasets())
      std::printf("dataset  %s  (%s)\n", entry.id().c_str(), entry.name().c_str());
    const boost::json::value living = boost::json::parse(http_get(options, "api/v1/sessions"));
    for (const boost::json::value& session : living.at("sessions").as_array())
      if (session.at("id").as_string() != std::string_view(welcome.session()))
        std::printf("living   %s  shows %s to %lld viewers\n", session.at("id").as_string().c_str(),
                    session.at("dataset").as_string().empty() ? "nothing" : session.at("dataset").as_string().c_str(),
                    static_cast<long long>(session.at("viewers").to_number<std::int64_t>()));
    const v1::State& state = welcome.state();
    if (state.dataset().empty()) return;
    std::printf("shows    %s, array %s, step %d, revision %llu\n", state.dataset().c_str(), state.array().c_str(), state.step(),
                static_cast<unsigned long long>(state.revision()));
    for (const v1::Interval& i : state.intervals())
      std::printf("interval %u  %.9g:%.9g  opacity %g%s\n", i.id(), i.lower(), i.upper(), i.opacity(),
                  i.visible() ? "" : "  hidden");
  });
}

}  // namespace isostrata::client
