// TLS in front of the connections. It ends here, in one unit: behind it a connection is served over a pair of local sockets, so
// that HTTP and WebSocket are compiled for one kind of stream. That costs a copy of each byte, which TLS costs anyway.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <filesystem>
#include <memory>

#include "net/server/connections.h"

namespace isostrata {

/// Lives on the io thread and outlives every connection.
class TlsGate {
 public:
  /// PEM files: the certificate, with those that sign it, and its key. Throws invalid_argument, naming the file and the reason.
  TlsGate(const std::filesystem::path& certificate, const std::filesystem::path& key);
  ~TlsGate();

  /// As serve_connection, after a handshake (TLS 1.2 or newer) that may take ten seconds. At most 64 KiB wait each way, beside
  /// what the sockets hold. Never throws.
  boost::asio::awaitable<void> serve(boost::asio::ip::tcp::socket socket, std::string address, Connections& connections);

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace isostrata
