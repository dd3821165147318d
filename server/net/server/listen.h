// Where a server listens: a port, a Unix socket, or what somebody listens on for it.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <filesystem>
#include <string>

namespace isostrata {

/// Throws invalid_argument (no address of this machine), unavailable (taken).
boost::asio::ip::tcp::acceptor listen_on_port(boost::asio::io_context& io, const std::string& host, unsigned short port);

/// A Unix socket that its user alone may connect to (mode 0600), in the shape of a port's acceptor: to Asio a stream is a stream.
/// One that a dead server has left is replaced. Throws unavailable where it cannot be made or another server answers at it.
boost::asio::ip::tcp::acceptor listen_on_socket(boost::asio::io_context& io, const std::filesystem::path& path);

/// A socket that listens already, of a port or a Unix socket. It is closed with the acceptor. Throws unavailable.
boost::asio::ip::tcp::acceptor listen_on_descriptor(boost::asio::io_context& io, int descriptor);

}  // namespace isostrata
