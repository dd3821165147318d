// One GET over a plain socket. HTTP/1.0 asks for a body that ends with the connection, so there is nothing to parse but the head.
#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/json/parse.hpp>

#include "isostrata/client.h"
#include "server_address.h"

namespace isostrata::client {

std::string http_get(const Options& options, const std::string& path) {
  namespace asio = boost::asio;
  const ServerAddress address = parse_address(options);
  const std::string where = address.host + ":" + address.port;
  boost::system::error_code error;
  asio::io_context io;
  asio::ip::tcp::resolver resolver(io);
  const auto found = resolver.resolve(address.connect_to, address.port, error);
  asio::ip::tcp::socket socket(io);
  if (!error) asio::connect(socket, found, error);
  if (error) throw ClientError("connection", where + ": " + error.message());

  std::string request = "GET " + address.base_path + path + " HTTP/1.0\r\nHost: " + where + "\r\nConnection: close\r\n";
  if (!address.token.empty()) request += "Authorization: Bearer " + address.token + "\r\n";
  asio::write(socket, asio::buffer(request + "\r\n"), error);
  if (error) throw ClientError("connection", where + ": " + error.message());

  std::string answer;
  bool ended = false;
  asio::async_read(socket, asio::dynamic_buffer(answer), [&](boost::system::error_code e, std::size_t) {
    ended = true;
    error = e;
  });
  io.run_for(options.timeout);
  if (!ended) throw ClientError("timeout", where + ": no answer to GET " + path);
  if (error && error != asio::error::eof) throw ClientError("connection", where + ": " + error.message());

  const auto head_end = answer.find("\r\n\r\n");
  if (!answer.starts_with("HTTP/1.") || head_end == std::string::npos || answer.size() < 12)
    throw ClientError("protocol", where + ": this is not an HTTP server");
  const int status = std::atoi(answer.c_str() + 9);
  std::string body = answer.substr(head_end + 4);
  if (status < 400 && status >= 200) return body;
  std::string code = status == 401 ? "unauthorized" : "protocol";
  std::string detail = "status " + std::to_string(status);
  if (const auto document = boost::json::parse(body, error); !error && document.is_object()) {
    const auto text = [&](const char* key, std::string& to) {
      if (const auto* value = document.as_object().if_contains(key); value && value->is_string()) to = value->as_string();
    };
    text("code", code);
    text("detail", detail);
  }
  throw ClientError(code, detail);
}

}  // namespace isostrata::client
