// The whole server: engine, sessions and one listening port. Wires the rooms; main calls it.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/data/living_catalogue.h"
#include "net/site/log_line.h"
#include "worker/worker_engine.h"

namespace isostrata {

struct ServerOptions {
  std::string name = "isostrata";  // with its version, for clients
  std::string host = "127.0.0.1";  // an address or a name of this machine
  unsigned short port = 8080;      // 0: any that is free
  std::filesystem::path socket{};  // a Unix socket, which this user alone can open, in place of host and port; empty: none
  int listening = -1;              // a socket that listens already there, in place of one that is made; the socket's file stays
  std::string base_url = "/";      // "/prefix/" or the whole URL under which a proxy shows it
  std::filesystem::path web_root;  // the built page
  std::string token;               // empty: everyone may ask
  std::vector<std::string> allowed_hosts;
  std::filesystem::path tls_certificate, tls_key;  // PEM; both or none: without them the port speaks plain HTTP
  std::size_t max_sessions = 32;
  std::size_t max_viewers = 64;  // connections of one session
  std::int64_t max_viewer_pixels = 4096 * 2160;  // of a picture of who may only look
  std::chrono::seconds session_ttl{600};
  std::chrono::seconds idle_timeout{0};  // ends after that long without a connection; 0: never
  // How long one client may stand still before it is given up; the others never wait for it.
  std::chrono::milliseconds stall_time{4000};      // without an acknowledgement: nothing more is drawn for it
  std::chrono::milliseconds hello_timeout{10000};  // a WebSocket without its Hello is closed
  std::chrono::milliseconds write_timeout{10000};  // and one that does not take 64 KiB of what is sent
  double messages_per_second = 1000;  // of one WebSocket; more are passed over or read later
  std::filesystem::path state_dir;  // where sessions survive the process (session/journal/journal.h); empty: they do not
  std::optional<std::chrono::system_clock::time_point> ends;  // when this process will be ended from outside; told to clients before
  std::chrono::milliseconds pulse{0};                         // how often `alive` is called while the server's thread runs; 0: never
  std::function<void()> alive;                                // on the thread of run()
  std::function<void(const std::string& reason)> ending;      // on the thread of run(), once; empty: nobody is told
  std::function<void(const std::string& what)> warn;          // of trouble that the server lives with; any thread
  /// Follows its files while the server runs, in place of engine.catalogue; null: that one, which stays as it is.
  std::shared_ptr<LivingCatalogue> living;
  EngineOptions engine;
  std::optional<WorkerOptions> worker;  // the engine runs in a process of its own; none: in this one
  LogSink log;                          // called on the thread of run(); empty: nobody listens
};

class Server {
 public:
  static constexpr std::chrono::milliseconds kGoodbye{3000};

  /// Opens the device and the port. Throws unavailable (no device, port taken), invalid_argument.
  explicit Server(ServerOptions options);
  ~Server();

  unsigned short port() const;
  std::string url() const;  // with its token
  const FrameEngine& engine() const;
  /// What can be opened when the server begins.
  const Catalogue& catalogue() const;

  /// Serves until stop(), SIGTERM, SIGINT or SIGHUP where `signals` is set, or the idle timeout; calls `ready` once it answers. Clients are
  /// told the reason, sessions are on the disk, and it returns within kGoodbye.
  void run(bool signals, const std::function<void()>& ready = {});
  /// Any thread, also before run.
  void stop(const std::string& reason);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isostrata
