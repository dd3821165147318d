// The bytes to and from a server: a TCP socket, with TLS in it for https. To Asio and Beast it is one kind of stream, so that
// what is built on it is compiled once.
#pragma once

#include <boost/asio/append.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/error.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/role.hpp>
#include <chrono>
#include <optional>
#include <utility>

#include "server_address.h"

namespace isostrata::client {

using Steady = std::chrono::steady_clock;

constexpr auto kStopPeriod = std::chrono::milliseconds(50);  // how late a request to stop is seen at most

/// Runs handlers until one has set `done`. Throws ClientError "timeout" with `late` at the deadline, "cancelled" soon after
/// options.stop was set.
void run_until(boost::asio::io_context& io, const bool& done, const Options& options, Steady::time_point deadline,
               const std::string& late);

/// An AsyncStream. One read and one write may be under way at a time.
class Transport {
 public:
  using executor_type = boost::asio::any_io_executor;
  explicit Transport(boost::asio::io_context& io) : io_(io), socket_(io) {}

  /// Looks the address up, connects, and for https shakes hands and judges the certificate. Throws ClientError: "connection",
  /// "tls", "timeout", "cancelled".
  void connect(const ServerAddress& address, const Options& options, Steady::time_point deadline);
  void close() {
    boost::system::error_code ignored;
    socket_.close(ignored);
  }
  /// run_until for an operation on this: where it throws, this is closed and the operation has ended.
  void finish(const bool& done, const Options& options, Steady::time_point deadline, const std::string& late);

  executor_type get_executor() { return socket_.get_executor(); }

  template <class Buffers, class Token>
  auto async_read_some(const Buffers& buffers, Token&& token) {
    return boost::asio::async_initiate<Token, void(boost::system::error_code, std::size_t)>(
        [this](auto handler, const Buffers& to) {
          if (tls_)
            tls_->async_read_some(to, std::move(handler));
          else
            socket_.async_read_some(to, std::move(handler));
        },
        token, buffers);
  }
  template <class Buffers, class Token>
  auto async_write_some(const Buffers& buffers, Token&& token) {
    return boost::asio::async_initiate<Token, void(boost::system::error_code, std::size_t)>(
        [this](auto handler, const Buffers& from) {
          if (tls_)
            tls_->async_write_some(from, std::move(handler));
          else
            socket_.async_write_some(from, std::move(handler));
        },
        token, buffers);
  }

  // What Beast asks of a stream when a WebSocket ends. Nothing is to be said after its own closing frames.
  friend void beast_close_socket(Transport& transport) { transport.close(); }
  template <class Handler>
  friend void async_teardown(boost::beast::role_type, Transport& transport, Handler&& handler) {
    boost::system::error_code ignored;
    transport.socket_.shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
    boost::asio::post(transport.get_executor(), boost::asio::append(std::forward<Handler>(handler), boost::system::error_code()));
  }

 private:
  void shake_hands(const ServerAddress& address, const Options& options, Steady::time_point deadline);

  boost::asio::io_context& io_;
  boost::asio::ip::tcp::socket socket_;
  std::optional<boost::asio::ssl::context> context_;
  std::optional<boost::asio::ssl::stream<boost::asio::ip::tcp::socket&>> tls_;
};

}  // namespace isostrata::client
