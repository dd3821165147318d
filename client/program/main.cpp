// isostrata-client: an Isostrata server from the command line. Exit status: 0 done, 1 it failed (one line says why), 2 wrong
// usage.
#include <cstdio>
#include <exception>

#include "arguments.h"

int main(int argc, char** argv) {
  CLI::App app{"A thin client of an Isostrata server: what it offers, pictures of a session, how fast it answers"};
  isostrata::client::Options options;
  app.set_version_flag("--version", "isostrata-client " ISOSTRATA_VERSION);
  app.add_option("url", options.url, "The address that the server printed, with its token")->required()->type_name("URL");
  app.add_option("--token", options.token, "The token, where the address has none")->envname("ISOSTRATA_TOKEN");
  long timeout_s = 60;
  app.add_option("--timeout", timeout_s, "Seconds to wait for an answer")->check(CLI::Range(1, 86400))->capture_default_str();
  app.require_subcommand(1);
  app.parse_complete_callback([&] { options.timeout = std::chrono::seconds(timeout_s); });
  isostrata::client::add_info(app, options);
  isostrata::client::add_snapshot(app, options);
  isostrata::client::add_latency(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const isostrata::client::ClientError& error) {
    std::fprintf(stderr, "isostrata-client: %s\n", error.what());
    return error.code() == "bad_argument" || error.code() == "bad_url" ? 2 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "isostrata-client: %s\n", error.what());
    return 1;
  }
  return 0;
}
