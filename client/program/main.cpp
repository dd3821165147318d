// isostrata-client: an Isostrata server from the command line. Exit status: 0 done, 1 it failed (one line says why), 2 wrong
// usage.
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>

#include "arguments.h"

namespace {

std::atomic<bool> stopped = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");

// Where somebody sits at a terminal, long work is one line that changes.
void show_progress(const isostrata::v1::Progress& progress) {
  std::fprintf(stderr, "\r%-12s %3d %%\x1b[K%s", progress.stage().c_str(), static_cast<int>(progress.fraction() * 100),
               progress.fraction() >= 1 ? "\r\x1b[K" : "");
}

void show_connection(const isostrata::client::ConnectionEvent& event) {
  using Kind = isostrata::client::ConnectionEvent::Kind;
  if (event.kind == Kind::lost) std::fprintf(stderr, "\rthe connection is lost (%s), trying again\x1b[K", event.reason.c_str());
  if (event.kind == Kind::restored) std::fprintf(stderr, "\r\x1b[K");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "A thin client of an Isostrata server: what it offers, pictures and films of a session, what happens in it, how fast it "
      "answers"};
  isostrata::client::Options options;
  options.stop = &stopped;
  if (isatty(STDERR_FILENO)) options.on_progress = show_progress;
  // The first Ctrl-C ends in order, the second at once.
  struct sigaction action {};
  action.sa_handler = [](int) { stopped = true; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  app.set_version_flag("--version", "isostrata-client " ISOSTRATA_VERSION);
  app.add_option("url", options.url, "The address that the server printed, with its token; `tunnel` and `view` find it")->type_name("URL");
  app.add_option("--token", options.token, "The token, if the address has none")->envname("ISOSTRATA_TOKEN");
  long timeout_s = 60;
  app.add_option("--timeout", timeout_s, "Seconds to wait for an answer")->check(CLI::Range(1, 86400))->capture_default_str();
  app.add_option("--ca-file", options.ca_file, "Of https: the certificates, in PEM, that are trusted in place of the system's")
      ->envname("ISOSTRATA_CA_FILE")
      ->type_name("FILE");
  app.add_flag("--insecure", options.insecure, "Of https: takes any certificate");
  double reconnect_s = 30;
  app.add_option("--reconnect", reconnect_s, "Seconds that a lost connection is tried again; 0: not at all")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.require_subcommand(1);
  app.parse_complete_callback([&] {
    if (options.url.empty() && !app.got_subcommand("tunnel") && !app.got_subcommand("view")) throw CLI::RequiredError("url");
    options.timeout = std::chrono::seconds(timeout_s);
    options.reconnect_for = std::chrono::milliseconds(static_cast<long>(reconnect_s * 1000));
  });
  if (isatty(STDERR_FILENO)) options.on_connection = show_connection;
  isostrata::client::add_info(app, options);
  isostrata::client::add_snapshot(app, options);
  isostrata::client::add_set(app, options);
  isostrata::client::add_record(app, options);
  isostrata::client::add_export(app, options);
  isostrata::client::add_watch(app, options);
  isostrata::client::add_latency(app, options);
  isostrata::client::add_tunnel(app, options);
  isostrata::client::add_view(app, options);
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
