// One request over a socket of its own. HTTP/1.0 asks for a body that ends with the connection, so there is nothing to parse but
// the head.
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <boost/json/parse.hpp>
#include <cstdint>
#include <ostream>

#include "isostrata/rest.h"
#include "server_address.h"
#include "transport.h"

namespace isostrata::client {
namespace {

namespace asio = boost::asio;
using Error = boost::system::error_code;

constexpr std::size_t kMaxHead = 64 << 10, kPiece = 256 << 10;

// The value of a header field of the answer's head; names have no case.
std::string field_of(const std::string& head, std::string_view name) {
  for (std::size_t at = head.find("\r\n"); at != std::string::npos; at = head.find("\r\n", at + 2)) {
    const std::size_t begin = at + 2, colon = begin + name.size();
    if (colon >= head.size() || head[colon] != ':') continue;
    bool same = true;
    for (std::size_t i = 0; i < name.size(); ++i) same = same && (head[begin + i] | 0x20) == (name[i] | 0x20);
    if (!same) continue;
    const auto value = head.find_first_not_of(' ', colon + 1);
    return head.substr(value, head.find("\r\n", value) - value);
  }
  return {};
}

[[noreturn]] void refuse(int status, const std::string& body) {
  std::string code = status == 401 ? "unauthorized" : "protocol", field;
  std::string detail = "status " + std::to_string(status);
  Error error;
  if (const auto document = boost::json::parse(body, error); !error && document.is_object()) {
    const auto text = [&](const char* key, std::string& to) {
      if (const auto* value = document.as_object().if_contains(key); value && value->is_string()) to = value->as_string();
    };
    text("code", code);
    text("detail", detail);
    text("field", field);
  }
  throw ClientError(code, detail, field);
}

/// What a request sends, and where the body of its answer goes.
struct Exchange {
  std::string method, path, body, if_match;
  std::ostream* to = nullptr;  // null: into the answer
};

HttpAnswer exchange(const Options& options, const Exchange& what) {
  const ServerAddress address = parse_address(options);
  const std::string where = address.host + ":" + address.port;
  for (const char c : what.path + what.if_match)
    if (static_cast<unsigned char>(c) <= ' ')
      throw ClientError("bad_argument", "'" + what.path + "' has a character that a URL has not");
  Error error;
  bool done = false;
  std::size_t read = 0;
  const auto late = where + ": no answer to " + what.method + " " + what.path;
  std::string answer, request;  // outlive the io_context, whose operations use them
  asio::io_context io(1);
  // Each step has the timeout for itself: a large file may take longer than one as long as it comes.
  const auto finish = [&] {
    run_until(io, done, options, Steady::now() + options.timeout, late);
    done = false;
    // Servers and what stands between seldom say TLS's own goodbye; whether all has come, the length says.
    if (error == asio::ssl::error::stream_truncated) error = asio::error::eof;
  };
  const auto step = [&] {
    finish();
    if (error && error != asio::error::eof) throw ClientError("connection", where + ": " + error.message());
  };
  Transport socket(io);
  socket.connect(address, options, Steady::now() + options.timeout);

  request = what.method + " " + address.base_path + what.path + " HTTP/1.0\r\nHost: " + where + "\r\nConnection: close\r\n";
  if (!address.token.empty()) request += "Authorization: Bearer " + address.token + "\r\n";
  if (!what.if_match.empty()) request += "If-Match: " + what.if_match + "\r\n";
  if (!what.body.empty())
    request += "Content-Type: application/json\r\nContent-Length: " + std::to_string(what.body.size()) + "\r\n";
  request += "\r\n" + what.body;
  asio::async_write(socket, asio::buffer(request), [&](Error e, std::size_t) { error = e, done = true; });
  step();
  asio::async_read_until(socket, asio::dynamic_buffer(answer, kMaxHead), "\r\n\r\n",
                         [&](Error e, std::size_t n) { error = e, read = n, done = true; });
  finish();
  const auto head_end = answer.find("\r\n\r\n");
  if (error && error != asio::error::eof && error != asio::error::not_found)
    throw ClientError("connection", where + ": " + error.message());
  if (error == asio::error::eof && answer.empty()) throw ClientError("connection", where + ": it ended without an answer");
  if (!answer.starts_with("HTTP/1.") || head_end == std::string::npos || answer.size() < 12)
    throw ClientError("protocol", where + ": this is not an HTTP server");

  const std::string head = answer.substr(0, head_end + 2);
  HttpAnswer result{std::atoi(answer.c_str() + 9), field_of(head, "content-type"), field_of(head, "etag"),
                    answer.substr(head_end + 4)};
  std::ostream* const to = result.status < 300 ? what.to : nullptr;  // a refusal is read as one
  std::uint64_t size = result.body.size();
  const auto pass_on = [&] {
    if (!to) return;
    if (!to->write(result.body.data(), static_cast<std::streamsize>(result.body.size())))
      throw ClientError("unwritable", "what is downloaded cannot be written");
    result.body.clear();
  };
  std::string piece(kPiece, '\0');
  for (pass_on(); error != asio::error::eof; pass_on()) {
    socket.async_read_some(asio::buffer(piece), [&](Error e, std::size_t n) { error = e, read = n, done = true; });
    step();
    result.body.append(piece, 0, read);
    size += read;
  }
  if (const std::string length = field_of(head, "content-length");
      !length.empty() && what.method != "HEAD" && std::strtoull(length.c_str(), nullptr, 10) != size)
    throw ClientError("connection", where + ": the answer to " + what.method + " " + what.path + " was cut short");
  if (result.status >= 400 || result.status < 200) refuse(result.status, result.body);
  return result;
}

}  // namespace

HttpAnswer http_request(const Options& options, const std::string& method, const std::string& path, const std::string& body,
                        const std::string& if_match) {
  return exchange(options, {method, path, body, if_match});
}

std::string http_get(const Options& options, const std::string& path) { return exchange(options, {"GET", path}).body; }

void http_download(const Options& options, const std::string& path, std::ostream& to) {
  exchange(options, {.method = "GET", .path = path, .to = &to});
}

}  // namespace isostrata::client
