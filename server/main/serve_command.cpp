// isostrata serve: the server, from its flags to its last line.
#include <fcntl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <array>
#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>

#include "base/parallel.h"
#include "main/arguments.h"
#include "main/commands.h"
#include "main/picture_arguments.h"
#include "main/ranks.h"
#include "main/sandbox_option.h"
#include "main/serve_arguments.h"
#include "main/server_log.h"
#include "main/shut_in.h"
#include "main/systemd.h"
#include "net/server/listen.h"
#include "net/server/server.h"
#include "net/site/static_files.h"
#include "session/journal/protobuf_log.h"
#include "session/wire/random_token.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

constexpr std::size_t kTokenBits = 256;

std::string read_token_file(const std::string& path) {
  std::ifstream file(path);
  std::string token;
  if (!file || !std::getline(file, token))
    throw Error(ErrorCode::not_found, path + ": no token could be read from its first line");
  while (!token.empty() && (token.back() == '\r' || token.back() == ' ')) token.pop_back();
  return token;
}

std::string token_of(const ServeArguments& arguments) {
  if (arguments.no_auth) return {};
  std::string token = !arguments.token_file.empty() ? read_token_file(arguments.token_file) : arguments.token;
  if (token.empty() && arguments.token_file.empty()) return random_token(kTokenBits);
  if (token.size() < 8 || token.size() > 512 ||
      token.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~") != std::string::npos)
    throw Error(ErrorCode::invalid_argument,
                "the token has " + std::to_string(token.size()) +
                    " characters; expected 8 to 512 of A-Z a-z 0-9 - . _ ~ (leave it out to have one made)");
  return token;
}

// Where programs keep what should survive them: XDG Base Directory Specification.
fs::path default_state_dir() {
  const char* state = std::getenv("XDG_STATE_HOME");
  if (state && *state == '/') return fs::path(state) / "isostrata";
  const char* home = std::getenv("HOME");
  return home && *home == '/' ? fs::path(home) / ".local" / "state" / "isostrata" : fs::path();
}

// Slurm's word on when the job's time is over.
std::optional<std::chrono::system_clock::time_point> job_end(ServerLog& log) {
  const char* text = std::getenv("SLURM_JOB_END_TIME");
  if (!text || !*text) return std::nullopt;
  std::int64_t seconds = 0;
  const char* end = text + std::strlen(text);
  const auto [stop, error] = std::from_chars(text, end, seconds);
  constexpr std::int64_t kFarthest = 253402300799;  // the year 9999
  if (error != std::errc{} || stop != end || seconds <= 0 || seconds > kFarthest) {
    log.warn("job_end", "SLURM_JOB_END_TIME is '" + std::string(text).substr(0, 40) +
                            "', expected seconds since 1970; nobody will be told before the job ends");
    return std::nullopt;
  }
  return std::chrono::system_clock::time_point(std::chrono::seconds(seconds));
}

bool loopback(const std::string& host) { return host == "localhost" || host == "::1" || host.starts_with("127."); }

/// Of whoever reaches the port one may have written a file that another opens, so beyond this machine nothing is read without.
void choose_sandbox(bool open_to_others, ServerLog& log) {
  if (!sandbox_is_chosen()) use_sandbox(to_string(open_to_others ? Sandbox::require : Sandbox::attempt));
  if (sandbox() == Sandbox::off)
    return log.warn("sandbox", "--sandbox off: a broken or hostile file can do whatever this user can");
  const std::string missing = missing_of(sandbox_support());
  if (missing.empty()) return;
  if (sandbox() == Sandbox::require)
    throw Error(ErrorCode::unavailable, "this machine lacks " + missing +
                                            "; files are read without that only if --sandbox try says so, which is the default "
                                            "on a loopback address");
  log.warn("sandbox", "files are read without " + missing);
}

std::string or_nothing(const std::string& shut_in) { return shut_in.empty() ? "nothing" : shut_in; }

// The process that draws first, if it is not the server's; it may be replaced (/api/v1/engine).
json::value worker_of(const Server& server) {
  const EngineFacts facts = server.engine().facts();
  return facts.own_process ? json::value(facts.process) : json::value(nullptr);
}

// It holds the token.
std::string ready_text(const Server& server, const std::string& socket) {
  return json::serialize(json::object{{"url", server.url()},
                                      {"port", server.port()},
                                      {"socket", socket.empty() ? json::value(nullptr) : json::value(socket)},
                                      {"pid", getpid()},
                                      {"device", server.engine().device()},
                                      {"worker", worker_of(server)}}) +
         "\n";
}

void print_address(const Server& server, const std::string& socket) {
  std::array<char, 256> machine{};
  if (gethostname(machine.data(), machine.size() - 1) != 0) machine = {"this-machine"};
  const char* user = std::getenv("USER");
  if (!socket.empty()) {
    const std::string url = server.url();
    const auto name = url.find("localhost");  // to a port of the reader's own machine
    std::printf("\nFrom your machine\n      ssh -L 8080:%s %s%s%s\n\nand open  %slocalhost:8080%s\n\n", socket.c_str(), user ? user : "",
                user ? "@" : "", machine.data(), url.substr(0, name).c_str(), url.substr(name + 9).c_str());
    std::fflush(stdout);
    return;
  }
  const std::string port = std::to_string(server.port());
  std::printf("\nOpen  %s\n\nFrom another machine, first\n      ssh -L %s:127.0.0.1:%s %s%s%s\n\n", server.url().c_str(),
              port.c_str(), port.c_str(), user ? user : "", user ? "@" : "", machine.data());
  std::fflush(stdout);
}

/// While it lives, what libprotobuf has to say is a few lines of the log.
struct ProtobufLines {
  explicit ProtobufLines(ServerLog& log) {
    set_protobuf_log([&log](const std::string& text) { log.warn("bad_text", text); });
  }
  ~ProtobufLines() { silence_protobuf(); }
};

/// A socket that is passed comes before --host, --port and --socket: whoever passes it has said where the server listens.
int take_passed_socket(ServeArguments& arguments, ServerLog& log) {
  const std::optional<PassedSocket> passed = passed_socket();
  if (!passed) return -1;
  arguments.socket = passed->path.string();
  if (passed->path.empty()) arguments.host = passed->host, arguments.port = passed->port;
  log.info("passed_socket", "listening on " + (passed->path.empty() ? passed->host + " port " + std::to_string(passed->port) : arguments.socket) +
                                ", as the service manager does for this server");
  return passed->descriptor;
}

/// The built-in fields, or what lies at the paths now and later.
void offer_data(ServerOptions& options, const std::vector<std::string>& sources, bool inotify, ServerLog& log) {
  if (sources.empty()) {
    options.engine.catalogue = Catalogue::analytic();
    return;
  }
  LivingOptions living;
  living.watch.inotify = inotify;
  options.living = std::make_shared<LivingCatalogue>(sources, living);
  const std::shared_ptr<const Catalogue> found = options.living->now();
  options.engine.catalogue = *found;  // what is there at the start, for the first worker and those that replace it; what comes later is told
  if (found->entries().empty()) log.warn("no_data", "none of the paths holds a file that can be opened yet");
  if (found->cut_off()) log.warn("too_many_files", "there are more files than are looked at (200000, 8 folders deep); name a smaller directory to see others");
  log.info("watching", "changes of files are noticed by " + options.living->how());
}

void warn_of(const ServerOptions& options, const ServeArguments& arguments, ServerLog& log) {
  if (arguments.no_auth) log.warn("no_auth", "NO TOKEN IS ASKED FOR: whoever reaches the port may use the server");
  if (options.socket.empty() && !loopback(arguments.host))
    log.warn("not_loopback", "listening on " + arguments.host + ": the port is open to the network" +
                                 (arguments.tls_certificate.empty() ? ", unencrypted; an ssh tunnel to 127.0.0.1 is safer" : ""));
  if (!StaticFiles(options.web_root).built())
    log.warn("no_page", "the web page is not built (npm ci && npm run build in web/), only the API is served");
}

void tell_device(const Server& server, const std::string& server_shut_in, ServerLog& log) {
  log.info("device", "drawing on " + server.engine().device());
  if (sandbox() != Sandbox::off)
    log.info("shut_in", "kept to their own files: the server by " + or_nothing(server_shut_in) + ", the process that draws by " +
                            or_nothing(server.engine().facts().shut_in));
  if (const std::string trial = server.engine().facts().renderer_trial; !trial.empty()) log.info("renderer", trial);
  if (server.engine().device_is_software())
    log.warn("software_device",
             "SOFTWARE RENDERING: no GPU is used, pictures will be slow; `isostrata doctor` says what was tried");
}

void serve(ServeArguments arguments) {
  if (!arguments.ranks.empty()) launcher_words(arguments.ranks), rank_program();  // throw before anything is begun
  ServerLog log(arguments.log_format == "json");
  const ServiceManager manager;
  const int passed = take_passed_socket(arguments, log);
  const ProtobufLines protobuf_lines(log);
  if (arguments.threads > 0) set_thread_count(arguments.threads);
  std::signal(SIGPIPE, SIG_IGN);
  prctl(PR_SET_DUMPABLE, 0);  // no other process of this user reads the token or somebody's data from its memory
  choose_sandbox(arguments.socket.empty() && !loopback(arguments.host), log);

  std::vector<std::string> sources = arguments.paths;
  sources.insert(sources.end(), arguments.data_roots.begin(), arguments.data_roots.end());
  ServerOptions options;
  const std::string socket = arguments.socket.empty() ? "" : fs::absolute(arguments.socket).string();
  options.listening = passed >= 0 ? passed : socket.empty() ? listening_port(arguments.host, static_cast<unsigned short>(arguments.port)) : listening_socket(socket);
  if (arguments.state_dir != "none") options.state_dir = arguments.state_dir.empty() ? default_state_dir() : fs::absolute(arguments.state_dir);
  options.web_root = find_web_root(arguments.web_root);
  const ShutIn shut_in({.sources = sources,
                        .state_dir = options.state_dir,
                        .files = {options.web_root, arguments.tls_certificate, arguments.tls_key},
                        .duties = {.ready_file = arguments.ready_file.empty() ? fs::path() : fs::absolute(arguments.ready_file),
                                   .socket_file = passed >= 0 ? "" : socket},
                        .ranks = arguments.ranks});
  options.token = token_of(arguments);
  const std::string server_shut_in = shut_in.confine();
  offer_data(options, sources, arguments.watch != "poll", log);
  options.engine.renderer_choice = {arguments.renderer, arguments.device};
  options.engine.store.max_bytes = arguments.max_memory;
  options.engine.store.part = region_of_arguments();
  options.worker.emplace();
  options.worker->launcher = shut_in.helper();
  options.worker->threads = arguments.threads;
  options.worker->log = [&log](std::string_view event, const std::string& text) {
    if (event == "worker_replaced")
      log.info(std::string(event), text);
    else
      log.warn(std::string(event), text);
  };
  options.name = "isostrata " ISOSTRATA_VERSION;
  options.host = arguments.host;
  options.port = static_cast<unsigned short>(arguments.port);
  options.socket = socket;
  options.pulse = manager.pulse();
  options.alive = [&manager] { manager.tell("WATCHDOG=1"); };
  options.ending = [&manager](const std::string& reason) { manager.tell("STOPPING=1\nSTATUS=" + reason); };
  options.base_url = arguments.base_url;
  options.allowed_hosts = arguments.allowed_hosts;
  options.tls_certificate = arguments.tls_certificate;
  options.tls_key = arguments.tls_key;
  options.max_sessions = arguments.max_sessions;
  options.max_viewers = arguments.max_viewers;
  const auto [width, height] = parse_size(arguments.max_viewer_size, "--max-viewer-size");
  options.max_viewer_pixels = std::int64_t{width} * height;
  options.ends = job_end(log);
  options.warn = [&log](const std::string& what) { log.warn("journal", what); };
  options.session_ttl = std::chrono::seconds(arguments.session_ttl_s);
  options.idle_timeout = std::chrono::seconds(arguments.idle_timeout_s);
  options.log = [&log](const LogLine& line) { log.write(line); };

  warn_of(options, arguments, log);

  Server server(std::move(options));
  tell_device(server, server_shut_in, log);
  server.run(true, [&] {
    log.info("ready", "serving " + std::to_string(server.catalogue().entries().size()) + " datasets on " +
                          (socket.empty() ? "port " + std::to_string(server.port()) : "the socket " + socket));
    print_address(server, socket);
    if (!arguments.ready_file.empty()) shut_in.helper()->write_ready_file(ready_text(server, socket));
    manager.tell("READY=1\nSTATUS=serving " + std::to_string(server.catalogue().entries().size()) + " datasets on " +
                 server.engine().device());
  });
  log.info("ended", "the server has ended");
}

}  // namespace

void add_serve_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("serve", "Serves the page, the WebSocket and the API on one port until it is interrupted");
  const auto arguments = std::make_shared<ServeArguments>();
  add_serve_options(*command, *arguments);
  command->callback([arguments] { serve(*arguments); });
}

}  // namespace isostrata
