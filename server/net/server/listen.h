// Where a server listens: a port, a Unix socket, or what somebody listens on for it.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <filesystem>
#include <string>

namespace isostrata {

/// A descriptor that listens on a port of this machine. Throws invalid_argument (no address of this machine), unavailable (taken).
int listening_port(const std::string& host, unsigned short port);

/// The same of a Unix socket that its user alone may connect to (mode 0600). One that a dead server has left is replaced. Throws unavailable where
/// it cannot be made or another server answers at it.
int listening_socket(const std::filesystem::path& path);

/// What listens already, a port or a Unix socket, in the shape of a port's acceptor: to Asio a stream is a stream. It is closed with the
/// acceptor. Throws unavailable.
boost::asio::ip::tcp::acceptor listen_on_descriptor(boost::asio::io_context& io, int descriptor);

}  // namespace isostrata
