// One request over a socket of its own.
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/json/parse.hpp>
#include <ostream>

#include "isostrata/rest.h"
#include "server_address.h"
#include "transport.h"

namespace isostrata::client {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using Error = boost::system::error_code;

constexpr std::size_t kMaxHead = 64 << 10, kPiece = 256 << 10;

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
  const std::string where = address.host + ":" + address.port, name = what.method + " " + what.path;
  for (const char c : what.path + what.if_match)
    if (static_cast<unsigned char>(c) <= ' ')
      throw ClientError("bad_argument", "'" + what.path + "' has a character that a URL has not");

  // They outlive the io_context, whose operations use them.
  http::request<http::string_body> request;
  boost::beast::flat_buffer read(kPiece);
  http::response_parser<http::buffer_body> answer;
  std::string piece(kPiece, '\0');
  Error error;
  bool done = false;
  asio::io_context io(1);
  const auto note = [&](Error e, std::size_t) { error = e, done = true; };
  // Each step has the timeout for itself: a large file may take longer than one as long as it comes.
  const auto step = [&] {
    run_until(io, done, options, Steady::now() + options.timeout, where + ": no answer to " + name);
    done = false;
    if (error == http::error::need_buffer) error = {};
    if (!error) return;
    // Servers and what stands between seldom say TLS's own goodbye.
    if (error == http::error::end_of_stream || (error == asio::ssl::error::stream_truncated && !answer.got_some()))
      throw ClientError("connection", where + ": it ended without an answer");
    if (error == http::error::partial_message || error == asio::ssl::error::stream_truncated)
      throw ClientError("connection", where + ": the answer to " + name + " was cut short");
    if (error.category() == http::make_error_code(http::error::bad_version).category())
      throw ClientError("protocol", where + ": this is not an HTTP server");
    throw ClientError("connection", where + ": " + error.message());
  };
  Transport socket(io);
  socket.connect(address, options, Steady::now() + options.timeout);

  request.version(11);
  request.method_string(what.method);
  request.target(address.base_path + what.path);
  request.set(http::field::host, where);
  request.keep_alive(false);
  if (!address.token.empty()) request.set(http::field::authorization, "Bearer " + address.token);
  if (!what.if_match.empty()) request.set(http::field::if_match, what.if_match);
  if (!what.body.empty()) {
    request.set(http::field::content_type, "application/json");
    request.body() = what.body;
    request.prepare_payload();
  }
  http::async_write(socket, request, note);
  step();
  answer.header_limit(kMaxHead);
  answer.body_limit(boost::none);
  answer.skip(what.method == "HEAD");
  http::async_read_header(socket, read, answer, note);
  step();
  HttpAnswer result{static_cast<int>(answer.get().result_int()), answer.get()[http::field::content_type],
                    answer.get()[http::field::etag], {}};
  std::ostream* const to = result.status < 300 ? what.to : nullptr;  // a refusal is read as one
  while (!answer.is_done()) {
    answer.get().body().data = piece.data();
    answer.get().body().size = piece.size();
    http::async_read(socket, read, answer, note);
    step();
    const std::size_t came = piece.size() - answer.get().body().size;
    if (!to)
      result.body.append(piece, 0, came);
    else if (!to->write(piece.data(), static_cast<std::streamsize>(came)))
      throw ClientError("unwritable", "what is downloaded cannot be written");
  }
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
