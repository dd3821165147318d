// The service manager that started this process (systemd, or whoever speaks its protocols): a socket that it listens on for us, and what it
// is told. Both protocols are a few environment variables and a datagram (sd_listen_fds(3), sd_notify(3)); without them nothing happens.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

namespace isostrata {

/// Listens already. Whoever gave it keeps it: a Unix socket's file is not ours to remove.
struct PassedSocket {
  int descriptor = -1;
  std::string host;            // the address that it is bound to; empty if it is a Unix socket
  unsigned short port = 0;     // likewise
  std::filesystem::path path;  // of a Unix socket; else empty
};

/// That of $LISTEN_FDS, where $LISTEN_PID is this process. Takes both out of the environment, and the descriptor out of the hands of the
/// programs that this one starts. Throws invalid_argument if there are several, or it is not a stream socket that listens. Before
/// there are threads.
std::optional<PassedSocket> passed_socket();

class ServiceManager {
 public:
  /// Reads $NOTIFY_SOCKET, $WATCHDOG_USEC and $WATCHDOG_PID, takes them out of the environment, and connects: later this process may not. Before there
  /// are threads.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  /// How often it wants to hear that this process is alive: half of what it waits; 0: it does not.
  std::chrono::milliseconds pulse() const { return pulse_; }
  /// `state` as sd_notify(3) lists: "READY=1\nSTATUS=...", "WATCHDOG=1". Does nothing if there is none, and never waits. Any thread.
  void tell(const std::string& state) const;

 private:
  int line_ = -1;  // nobody
  std::chrono::milliseconds pulse_{0};
};

}  // namespace isostrata
