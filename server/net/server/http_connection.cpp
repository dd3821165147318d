// HTTP on one socket. Beast 1.81 needs care: it is compiled with NDEBUG, bodies in chunks are refused, and any parse error ends
// the connection.
#include <poll.h>

#include <algorithm>
#include <array>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/file.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <optional>

#include "net/http/event_stream.h"
#include "net/http/problem.h"
#include "net/http/security_headers.h"
#include "net/server/connections.h"
#include "net/server/websocket_connection.h"
#include "session/wire/limits.h"

namespace isostrata {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;

constexpr auto kHeaderTimeout = std::chrono::seconds(5);  // without a token: for a request's head, from when it is waited for
constexpr auto kIdleTimeout = std::chrono::seconds(60);   // with one: between two requests
constexpr auto kDrainTimeout = std::chrono::seconds(1);   // for a body that is not wanted, so that its sender reads the answer
constexpr std::size_t kMostDrained = 64 << 10;
constexpr auto kBodyTimeout = std::chrono::seconds(20);
constexpr auto kWriteTimeout = std::chrono::seconds(60);
constexpr auto kAnswerTimeout = std::chrono::seconds(600);  // loading a dataset may take that long
constexpr auto kHeartbeat = std::chrono::seconds(15);       // a comment in an event stream that has no news
constexpr auto kLookWhetherGone = std::chrono::milliseconds(20);
constexpr std::size_t kMostUnread = std::size_t{256} << 20;  // bytes of answers on their way, of all connections together
constexpr std::uint32_t kMaxHeaderBytes = 16384;

using Parser = http::request_parser<http::string_body>;

constexpr std::size_t kReadAtOnce = 16384;

/// A header line that goes on in the next one. Beast reads it as one line, other programs as two, or end the head there: RFC 9112,
/// section 5.2, has a server refuse it. What is not consumed yet is enough to see it, since Beast waits for the first byte of the next line.
bool has_folded_line(const beast::flat_buffer& buffer) {
  std::string_view bytes(static_cast<const char*>(buffer.data().data()), buffer.size());
  if (bytes.starts_with(' ') || bytes.starts_with('\t')) return true;
  bytes = bytes.substr(0, bytes.find("\r\n\r\n"));
  return bytes.find("\r\n ") != std::string_view::npos || bytes.find("\r\n\t") != std::string_view::npos;
}

/// As Beast's, but that folded lines are an error. More than the head may be left in the buffer.
asio::awaitable<void> read_head(beast::tcp_stream& stream, beast::flat_buffer& buffer, Parser& parser, boost::system::error_code& error) {
  for (bool needs_more = buffer.size() == 0; !parser.is_header_done();) {
    if (needs_more) {
      const std::size_t room = std::min(kReadAtOnce, buffer.max_size() - buffer.size());
      const std::size_t count = co_await stream.async_read_some(buffer.prepare(room), asio::redirect_error(asio::use_awaitable, error));
      if (error == asio::error::eof) error = parser.got_some() ? http::error::partial_message : http::error::end_of_stream;
      if (error) co_return;
      buffer.commit(count);
    }
    if (has_folded_line(buffer)) {
      error = http::error::bad_obs_fold;
      co_return;
    }
    buffer.consume(parser.put(buffer.data(), error));
    needs_more = error == http::error::need_more;
    if (needs_more) error = {};
    if (error) co_return;
  }
}

/// What is well formed and still means one thing here and another elsewhere; nothing if there is none.
std::optional<std::string> ambiguous(const http::request<http::string_body>& request) {
  const auto lengths = request.count(http::field::content_length);
  const std::string_view length = request[http::field::content_length];
  if (lengths > 1 || (lengths == 1 && (length.empty() || length.find_first_not_of("0123456789") != std::string_view::npos)))
    return "Content-Length is to stand once, with one number";
  for (const http::field once : {http::field::host, http::field::authorization, http::field::content_type})
    if (request.count(once) > 1) return std::string(http::to_string(once)) + " is to stand once";
  return std::nullopt;
}

HttpRequest plain(const http::request<http::string_body>& request) {
  HttpRequest out;
  out.method = std::string(request.method_string());
  out.target = std::string(request.target());
  out.body = request.body();
  for (const auto& field : request) {
    std::string name(field.name_string());
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    out.headers.emplace_back(std::move(name), std::string(field.value()));
  }
  return out;
}

template <class Body>
http::response<Body> wire_head(const HttpResponse& response, unsigned version, bool keep_alive) {
  http::response<Body> out{static_cast<http::status>(response.status), version};
  out.set(http::field::server, "isostrata");
  if (!response.content_type.empty()) out.set(http::field::content_type, response.content_type);
  for (const auto& [name, value] : security_headers(response)) out.insert(name, value);
  for (const auto& [name, value] : response.headers) out.insert(name, value);
  out.keep_alive(keep_alive);
  return out;
}

http::response<http::string_body> wire(HttpResponse&& response, unsigned version, bool keep_alive, bool head) {
  auto out = wire_head<http::string_body>(response, version, keep_alive);
  const std::size_t length = response.body.size();
  if (!head) out.body() = std::move(response.body);
  if (response.status != 204 && response.status != 304) out.content_length(length);
  return out;
}

// Whether nobody is at the other end any more, or nobody who would read.
bool has_gone(beast::tcp_stream& stream) {
  pollfd socket{stream.socket().native_handle(), POLLRDHUP, 0};
  return ::poll(&socket, 1, 0) > 0 && (socket.revents & (POLLRDHUP | POLLHUP | POLLERR | POLLNVAL)) != 0;
}

// Waits for the site's one reply. Where the client goes meanwhile, its work is ended and there is none.
asio::awaitable<std::optional<HttpResponse>> answer(Site& site, HttpRequest request, beast::tcp_stream& stream) {
  struct Slot {
    explicit Slot(const asio::any_io_executor& executor) : arrived(executor) {}
    asio::steady_timer arrived;
    std::optional<HttpResponse> response;
  };
  const auto slot = std::make_shared<Slot>(co_await asio::this_coro::executor);
  const auto until = std::chrono::steady_clock::now() + kAnswerTimeout;
  const auto gone = request.gone = std::make_shared<ClientGone>();
  try {
    site.handle(request, [slot](HttpResponse response) {
      if (slot->response) return;
      slot->response = std::move(response);
      slot->arrived.cancel();
    });
  } catch (const std::exception&) {
    slot->response = problem(500, "internal", "this request could not be handled");
    site.refused(500);
  }
  boost::system::error_code error;
  while (!slot->response && std::chrono::steady_clock::now() < until) {
    slot->arrived.expires_after(kLookWhetherGone);
    co_await slot->arrived.async_wait(asio::redirect_error(asio::use_awaitable, error));
    if (slot->response || !has_gone(stream)) continue;
    if (gone->then) gone->then();
    slot->response.emplace();  // what comes late is not taken
    co_return std::nullopt;
  }
  if (!slot->response) {
    if (gone->then) gone->then();
    slot->response = problem(503, "unavailable", "this took longer than ten minutes and was given up");
  }
  co_return std::move(slot->response);
}

asio::awaitable<bool> write(beast::tcp_stream& stream, http::response<http::string_body> response) {
  boost::system::error_code error;
  stream.expires_after(kWriteTimeout);
  co_await http::async_write(stream, response, asio::redirect_error(asio::use_awaitable, error));
  co_return !error && response.keep_alive();
}

// A file, while it is read. The write timeout is that of a piece: a slow link may take as long as it needs for the whole.
asio::awaitable<bool> write_file(beast::tcp_stream& stream, HttpResponse response, unsigned version, bool keep_alive, bool head) {
  boost::system::error_code error;
  auto out = wire_head<http::file_body>(response, version, keep_alive);
  out.body().open(response.file.c_str(), beast::file_mode::scan, error);
  if (error) {
    HttpResponse gone = problem(404, "not_found", "the file is not there any more");
    co_return co_await write(stream, wire(std::move(gone), version, keep_alive, head));
  }
  out.content_length(out.body().size());
  http::response_serializer<http::file_body> serializer(out);
  serializer.split(head);
  while (!error && !(head ? serializer.is_header_done() : serializer.is_done())) {
    stream.expires_after(kWriteTimeout);
    if (head)
      co_await http::async_write_header(stream, serializer, asio::redirect_error(asio::use_awaitable, error));
    else
      co_await http::async_write_some(stream, serializer, asio::redirect_error(asio::use_awaitable, error));
  }
  co_return !error && keep_alive;
}

// Server-sent events until they end, the client goes or does not read; the connection ends with them, which tells their end.
asio::awaitable<void> write_events(beast::tcp_stream& stream, HttpResponse response, unsigned version) {
  boost::system::error_code error;
  const auto events = response.events;
  auto out = wire_head<http::empty_body>(response, version, false);
  http::response_serializer<http::empty_body> serializer(out);
  stream.expires_after(kWriteTimeout);
  co_await http::async_write_header(stream, serializer, asio::redirect_error(asio::use_awaitable, error));
  const auto news = std::make_shared<asio::steady_timer>(stream.get_executor());
  events->wake = [weak = std::weak_ptr(news)] {
    if (const auto timer = weak.lock()) timer->cancel();
  };
  while (!error && !events->ended()) {
    std::optional<std::string> text = events->take();
    if (!text) {
      boost::system::error_code woken;
      news->expires_after(kHeartbeat);
      co_await news->async_wait(asio::redirect_error(asio::use_awaitable, woken));
      if (woken || events->ended()) continue;
      text = ": still there\n\n";
    }
    stream.expires_after(kWriteTimeout);
    co_await asio::async_write(stream, asio::buffer(*text), asio::redirect_error(asio::use_awaitable, error));
  }
  events->wake = nullptr;
}

// What is on its way is read and thrown away: a socket that is closed over unread bytes takes the answer back.
asio::awaitable<void> drain(beast::tcp_stream& stream) {
  boost::system::error_code error;
  stream.socket().shutdown(asio::ip::tcp::socket::shutdown_send, error);
  std::array<char, 4096> piece;
  stream.expires_after(kDrainTimeout);
  for (std::size_t drained = 0; !error && drained < kMostDrained;)
    drained += co_await stream.async_read_some(asio::buffer(piece), asio::redirect_error(asio::use_awaitable, error));
}

/// An answer that is being sent counts until it has been read, or its reader is given up.
class Unread {
 public:
  Unread(Connections& connections, std::size_t bytes) : connections_(connections), bytes_(bytes) { connections_.unread_bytes += bytes_; }
  ~Unread() { connections_.unread_bytes -= bytes_; }
  Unread(const Unread&) = delete;
  Unread& operator=(const Unread&) = delete;

 private:
  Connections& connections_;
  const std::size_t bytes_;
};

std::string megabytes(std::size_t bytes) { return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB"; }

/// Ends a connection with an answer that nobody's request was handled for.
asio::awaitable<void> refuse(beast::tcp_stream& stream, HttpResponse refusal, Site& site) {
  site.refused(refusal.status);
  co_await write(stream, wire(std::move(refusal), 11, false, false));
}

/// What came is not a request's head. Only what is a malformed request deserves an answer; a socket that ended does not hear it.
std::optional<HttpResponse> answer_to_no_head(const boost::system::error_code& error) {
  if (error == http::error::header_limit || error == http::error::body_limit || error == http::error::buffer_overflow)
    return problem(error == http::error::body_limit ? 413 : 431, "too_large", "the request is larger than this server reads");
  if (error.category() == make_error_code(http::error::bad_method).category() && error != http::error::end_of_stream && error != http::error::partial_message)
    return problem(400, "malformed", "this is not an HTTP request: " + error.message());
  return std::nullopt;
}

/// Why a head is refused before anybody looks at what it asks for.
std::optional<HttpResponse> refusal_of(const Parser& parser) {
  if (parser.chunked() || parser.get().count(http::field::transfer_encoding) > 0)
    return problem(411, "malformed", "bodies in chunks are refused; send Content-Length");
  if (const auto what = ambiguous(parser.get())) return problem(400, "malformed", *what);
  return std::nullopt;
}

/// Becomes a WebSocket, or refuses to. Either way the connection ends with it.
asio::awaitable<void> upgrade(beast::tcp_stream& stream, const beast::flat_buffer& buffer, Parser& parser, const HttpRequest& asked, Connections& connections,
                              Places::Place& place) {
  Sessions::Admission admission;
  auto refusal = connections.site.refuse_upgrade(asked, admission);
  if (!refusal && place.caller() == Caller::guest && !connections.places.guests_may_settle())
    refusal = problem(503, "unavailable", "as many guests are here as this server has places for; try again later");
  if (refusal) {
    co_await refuse(stream, std::move(*refusal), connections.site);
    co_return;
  }
  // A client may say something before it has heard that it is welcome.
  PrefixedStream socket(std::move(stream), std::string(static_cast<const char*>(buffer.data().data()), buffer.size()));
  co_await serve_websocket(std::move(socket), parser.release(), connections, place, std::move(admission));
}

/// Answers a request that was read whole. Whether another one may follow.
asio::awaitable<bool> serve_request(beast::tcp_stream& stream, const HttpRequest& asked, const http::request<http::string_body>& request,
                                    Connections& connections) {
  const bool head = request.method() == http::verb::head;
  connections.site.set_connections(connections.places.taken());
  std::optional<HttpResponse> answered = co_await answer(connections.site, asked, stream);
  connections.wake();
  if (!answered) co_return false;
  HttpResponse response = std::move(*answered);
  if (connections.unread_bytes > 0 && connections.unread_bytes + response.body.size() > kMostUnread) {
    connections.site.refused(503);
    response = problem(503, "unavailable", "an answer of " + megabytes(response.body.size()) + " finds " + megabytes(connections.unread_bytes) +
                                               " of others that nobody has read yet; expected at most " + megabytes(kMostUnread) +
                                               " in all. Try again later");
  }
  const Unread counted(connections, response.body.size());
  if (response.events && !head) {
    co_await write_events(stream, std::move(response), request.version());
    co_return false;
  }
  if (!response.file.empty()) co_return co_await write_file(stream, std::move(response), request.version(), request.keep_alive(), head);
  co_return co_await write(stream, wire(std::move(response), request.version(), request.keep_alive(), head));
}

asio::awaitable<void> serve(beast::tcp_stream stream, const std::string& address, Connections& connections, Places::Place& place) {
  beast::flat_buffer buffer(kMaxHeaderBytes + kMaxMessageBytes);
  place.set_close([&stream] { stream.close(); });

  for (bool more = true; more;) {
    boost::system::error_code error;
    Parser parser;
    parser.header_limit(kMaxHeaderBytes);
    parser.body_limit(kMaxMessageBytes);
    stream.expires_after(place.caller() == Caller::stranger ? kHeaderTimeout : kIdleTimeout);
    place.be_idle(true);
    co_await read_head(stream, buffer, parser, error);
    place.be_idle(false);
    if (auto refusal = error ? answer_to_no_head(error) : refusal_of(parser)) {
      co_await refuse(stream, std::move(*refusal), connections.site);
      break;
    }
    if (error) break;
    HttpRequest asked = plain(parser.get());
    asked.address = address;
    const Site::Head head_says = connections.site.look_at_head(asked);
    place.show(head_says.caller);
    if (head_says.wrong_token) {
      asio::steady_timer later(stream.get_executor(), connections.wrong_tokens.note(address, std::chrono::steady_clock::now()));
      co_await later.async_wait(asio::redirect_error(asio::use_awaitable, error));
    }
    if (beast::websocket::is_upgrade(parser.get())) co_return co_await upgrade(stream, buffer, parser, asked, connections, place);
    // Whoever may send no body is answered by the head alone.
    const bool unread = !head_says.may_send_body && !parser.is_done();
    if (unread) {
      std::optional<HttpResponse> response = co_await answer(connections.site, asked, stream);
      if (!response) break;
      co_await write(stream, wire(std::move(*response), parser.get().version(), false, parser.get().method() == http::verb::head));
      co_return co_await drain(stream);
    }
    stream.expires_after(kBodyTimeout);
    co_await http::async_read(stream, buffer, parser, asio::redirect_error(asio::use_awaitable, error));
    if (error) {
      if (error == http::error::body_limit || error == http::error::buffer_overflow)
        co_await write(stream,
                       wire(problem(413, "too_large", "a body of at most " + std::to_string(kMaxMessageBytes) + " bytes is read"),
                            11, false, false));
      break;
    }
    const http::request<http::string_body> request = parser.release();
    stream.expires_never();
    asked.body = request.body();
    more = co_await serve_request(stream, asked, request, connections);
  }
  boost::system::error_code ignored;
  stream.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
}

}  // namespace

std::string address_of(const asio::ip::tcp::socket& socket) {
  boost::system::error_code error;
  const auto end = socket.remote_endpoint(error);
  if (!error && end.protocol().family() == AF_UNIX) return "unix";
  return error ? std::string() : end.address().to_string();
}

boost::asio::awaitable<void> serve_connection(asio::ip::tcp::socket socket, std::string address, Connections& connections) {
  try {
    Places::Place place(connections.places, address, [] {});
    boost::system::error_code ignored;
    socket.set_option(asio::ip::tcp::no_delay(true), ignored);
    co_await serve(beast::tcp_stream(std::move(socket)), address, connections, place);
  } catch (const std::exception&) {
    // Out of memory or a broken invariant in one connection ends that connection.
  }
}

}  // namespace isostrata
