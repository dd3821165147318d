#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>

#include "host_header.h"
#include "isostrata/client.h"

namespace isostrata::client {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;

std::string http_get(const Address& address, std::string_view path, std::chrono::milliseconds timeout) {
  const std::string where = host_header(address);
  asio::io_context io;
  beast::error_code error;
  const auto endpoints = asio::ip::tcp::resolver(io).resolve(address.host, address.port, error);
  if (error) throw Error("connection", where + ": " + error.message());

  http::request<http::empty_body> request{http::verb::get, address.base + std::string(path), 11};
  request.set(http::field::host, where);
  request.set(http::field::user_agent, "isostrata-client");
  if (!address.token.empty()) request.set(http::field::authorization, "Bearer " + address.token);

  beast::tcp_stream stream(io);
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  parser.body_limit(1ull << 30);
  // Each step starts the next; the first error ends the chain.
  const auto keep = [&](beast::error_code e, auto next) {
    error = e;
    if (!e) next();
  };
  stream.expires_after(timeout);
  stream.async_connect(endpoints, [&](beast::error_code e, const auto&) {
    keep(e, [&] {
      http::async_write(stream, request, [&](beast::error_code e2, std::size_t) {
        keep(e2, [&] { http::async_read(stream, buffer, parser, [&](beast::error_code e3, std::size_t) { error = e3; }); });
      });
    });
  });
  io.run();
  if (error == beast::error::timeout)
    throw Error("timeout", where + " did not answer within " + std::to_string(timeout.count()) + " ms");
  if (error) throw Error("connection", where + ": " + error.message());
  auto& response = parser.get();
  if (response.result() != http::status::ok)
    throw Error("refused", "GET " + address.base + std::string(path) + ": HTTP " + std::to_string(response.result_int()) + " " + response.body());
  return std::move(response.body());
}

}  // namespace isostrata::client
