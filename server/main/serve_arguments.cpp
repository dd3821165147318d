#include "main/serve_arguments.h"

#include "main/arguments.h"
#include "main/config_file.h"
#include "main/ranks.h"
#include "main/sandbox_option.h"

namespace isostrata {
namespace {

void add_data_options(CLI::App& command, ServeArguments& arguments) {
  command
      .add_option("path", arguments.paths,
                   "Files, directories of files, or names of analytic data; none: the built-in analytic scenes. Files that come later are offered, too")
      ->type_name("PATH");
  command.add_option("--data-root", arguments.data_roots, "More directories whose files may be opened")->type_name("DIR");
  command
      .add_option("--watch", arguments.watch,
                   "How files that come, grow, change and go are noticed: auto: by inotify, and by looking every second if that does not work (files of other "
                   "machines, more folders than watches); poll: by looking every second, for file systems that accept inotify and report nothing")
      ->check(CLI::IsMember({"auto", "poll"}))
      ->capture_default_str();
}

/// Where it listens, and who gets in.
void add_door_options(CLI::App& command, ServeArguments& arguments) {
  command.add_option("--host", arguments.host, "Address to listen on")->capture_default_str();
  command.add_option("--port", arguments.port, "Port to listen on; 0 picks a free one")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  command
      .add_option("--socket", arguments.socket,
                   "Unix socket to listen on, in place of a port. It has mode 0600, for you alone; everybody on this machine can reach a port")
      ->type_name("PATH");
  command.add_option("--base-url", arguments.base_url, "Path, or whole URL, under which a proxy shows the server")
      ->capture_default_str();
  auto* token =
      command
          .add_option("--token", arguments.token,
                       "Token to ask for; others on this machine can read it here, so prefer ISOSTRATA_TOKEN or --token-file")
          ->envname("ISOSTRATA_TOKEN");
  auto* token_file =
      command.add_option("--token-file", arguments.token_file, "File whose first line is the token")->excludes(token);
  command.add_flag("--no-auth", arguments.no_auth, "Ask for no token")->excludes(token)->excludes(token_file);
  auto* certificate = command
                          .add_option("--tls-cert", arguments.tls_certificate,
                                       "Certificate, and those that sign it, in PEM: https instead of http")
                          ->type_name("FILE");
  command.add_option("--tls-key", arguments.tls_key, "The certificate's key, in PEM, without a password")
      ->type_name("FILE")
      ->needs(certificate);
  command.add_option("--allow-host", arguments.allowed_hosts, "A further name by which browsers may reach the server (Host and Origin), NAME or NAME:PORT")
      ->type_name("NAME[:PORT]");
}

void add_session_options(CLI::App& command, ServeArguments& arguments) {
  command.add_option("--max-sessions", arguments.max_sessions, "Sessions at a time")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command.add_option("--max-viewers", arguments.max_viewers, "Connections of one session at a time")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command
      .add_option("--max-viewer-size", arguments.max_viewer_size,
                   "WIDTHxHEIGHT: who may only look gets pictures and stills of at most as many pixels")
      ->type_name("SIZE")
      ->capture_default_str();
  command
      .add_option("--state-dir", arguments.state_dir,
                   "Directory that keeps sessions for the next start (default: $XDG_STATE_HOME/isostrata); none: they end with the server")
      ->type_name("DIR");
  command.add_option("--session-ttl", arguments.session_ttl_s, "Seconds that a session is kept without anyone using it")
      ->check(CLI::Range(1, 31536000))
      ->capture_default_str();
  command
      .add_option("--idle-timeout", arguments.idle_timeout_s,
                   "Seconds without a connection after which the server ends; 0: never")
      ->check(CLI::Range(0, 31536000))
      ->capture_default_str();
}

}  // namespace

void add_serve_options(CLI::App& command, ServeArguments& arguments) {
  add_data_options(command, arguments);
  add_door_options(command, arguments);
  command
      .add_option(
          "--renderer", arguments.renderer,
          "native: the CPU; raster, compute: OpenGL on the device; auto: native if no device is hardware, else the faster")
      ->check(CLI::IsMember({"auto", "native", "raster", "compute"}))
      ->capture_default_str();
  command.add_option("--device", arguments.device, "auto, native, egl:INDEX, egl:UUID, surfaceless or osmesa")
      ->capture_default_str();
  add_session_options(command, arguments);
  add_region_options(command);
  command
      .add_option("--max-memory", arguments.max_memory,
                   "Bytes of loaded data that are kept, and the most one dataset may need (suffixes KB, MB, GB)")
      ->transform(CLI::AsSizeValue(false))
      ->capture_default_str();
  command.add_option("--threads", arguments.threads, "Threads that compute; 0: all cores")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  add_ranks_option(command, arguments.ranks);
  command.add_option("--ready-file", arguments.ready_file, "A file to write, as JSON, once the server answers")->type_name("FILE");
  command.add_option("--log-format", arguments.log_format, "text or json, on standard error")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  command.add_option("--web-root", arguments.web_root, "Directory of the built page")->check(CLI::ExistingDirectory);
  add_sandbox_option(command, "require if --host is not this machine alone, else try",
                     "the process that reads files, the one that draws and the server");
  add_config_option(command);
}

}  // namespace isostrata
