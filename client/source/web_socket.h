// One WebSocket to a server, without a word of what goes over it. Everything happens on the caller's thread, inside the calls.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "transport.h"

namespace isostrata::client {

class WebSocket {
 public:
  using Receiver = std::function<void(const void* data, std::size_t size)>;

  /// Connects and upgrades. The receiver is called inside run_for and poll with each message. Throws ClientError: "connection",
  /// "tls", "unauthorized", "timeout", "cancelled".
  WebSocket(const ServerAddress& address, const Options& options, Steady::time_point deadline, Receiver receiver);
  /// Says goodbye where the connection still is, for half a second at most.
  ~WebSocket();
  WebSocket(const WebSocket&) = delete;
  WebSocket& operator=(const WebSocket&) = delete;

  /// Queued; written while this runs.
  void send(std::string bytes);
  /// That were queued and are not written.
  std::size_t waiting_bytes() const;
  /// Until something has happened, or the time is over.
  void run_for(Steady::duration time);
  /// What can be done without waiting.
  void poll();
  /// The connection has ended.
  bool failed() const;
  std::string why() const;
  /// Of the server's goodbye; 0: it said none.
  unsigned close_code() const;
  void close();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isostrata::client
