// isostrata-client: a server seen from a script.
#include <cstdio>
#include <exception>

#include "commands.h"

int main(int argc, char** argv) {
  CLI::App app{"Talks to a running Isostrata server: isostrata-client URL info|snapshot|latency"};
  app.set_version_flag("--version", "isostrata-client " ISOSTRATA_VERSION);
  std::string url;
  app.add_option("URL", url, "What the server printed: http://HOST:PORT/?token=TOKEN")->required();
  app.require_subcommand(1);
  isostrata::client::add_info_command(app, url);
  isostrata::client::add_snapshot_command(app, url);
  isostrata::client::add_latency_command(app, url);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "isostrata-client: %s\n", error.what());
    return 1;
  }
  return 0;
}
