#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "host_header.h"
#include "isostrata/client.h"

namespace isostrata::client {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

/// One thread runs everything: the io_context only runs inside receive() and send(). A read is always pending, so that a timeout
/// never cuts a message in two.
struct Connection::Socket {
  asio::io_context io;
  websocket::stream<beast::tcp_stream> stream{io};
  beast::flat_buffer buffer;
  bool reading = false;
  bool arrived = false;
  beast::error_code read_error;

  std::uint64_t next_seq = 1;
  v1::Welcome welcome;
  v1::State state;
  v1::DatasetInfo dataset_info;

  void start_reading() {
    if (reading) return;
    reading = true;
    arrived = false;
    buffer.clear();
    stream.async_read(buffer, [this](beast::error_code error, std::size_t) {
      read_error = error;
      reading = false;
      arrived = true;
    });
  }

  /// Runs the io_context until done() or the deadline.
  template <class Done>
  bool run_until(Done done, std::chrono::steady_clock::time_point deadline) {
    while (!done()) {
      if (io.stopped()) io.restart();
      if (io.run_one_until(deadline) == 0 && std::chrono::steady_clock::now() >= deadline) return done();
    }
    return true;
  }

  void remember(const v1::ServerMessage& message) {
    if (message.has_state()) state = message.state();
    if (message.has_dataset_info()) dataset_info = message.dataset_info();
    if (message.has_welcome()) {
      welcome = message.welcome();
      state = welcome.state();
      dataset_info = welcome.dataset_info();
    }
  }
};

namespace {

using Clock = std::chrono::steady_clock;

[[noreturn]] void lost(const beast::error_code& error) {
  throw Error("connection", "the connection ended: " + error.message());
}

[[noreturn]] void refuse(const v1::Error& error) { throw Error(error.code(), error.message()); }

std::chrono::milliseconds left(Clock::time_point deadline) {
  return std::max(std::chrono::milliseconds(0), std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()));
}

}  // namespace

Connection::Connection(std::unique_ptr<Socket> socket) : socket_(std::move(socket)) {}
Connection::Connection(Connection&&) noexcept = default;
Connection& Connection::operator=(Connection&&) noexcept = default;
Connection::~Connection() = default;

const v1::Welcome& Connection::welcome() const { return socket_->welcome; }
const v1::State& Connection::state() const { return socket_->state; }
const v1::DatasetInfo& Connection::dataset_info() const { return socket_->dataset_info; }

Connection Connection::open(std::string_view url, const Options& options) {
  const Address address = parse_address(url);
  const auto deadline = Clock::now() + options.connect_timeout;
  auto socket = std::make_unique<Socket>();
  auto& stream = socket->stream;
  const std::string where = host_header(address);

  beast::error_code error;
  asio::ip::tcp::resolver resolver(socket->io);
  const auto endpoints = resolver.resolve(address.host, address.port, error);
  if (error) throw Error("connection", where + ": " + error.message());

  bool done = false;
  const auto finish = [&](const char* doing) {
    if (!socket->run_until([&] { return done; }, deadline))
      throw Error("timeout", where + " did not answer within " + std::to_string(options.connect_timeout.count()) + " ms while " + doing);
    done = false;
  };

  beast::get_lowest_layer(stream).async_connect(endpoints, [&](beast::error_code e, const auto&) { error = e, done = true; });
  finish("connecting");
  if (error) throw Error("connection", where + ": " + error.message());
  beast::get_lowest_layer(stream).socket().set_option(asio::ip::tcp::no_delay(true));
  beast::get_lowest_layer(stream).expires_never();

  stream.binary(true);
  stream.read_message_max(256u << 20);  // a lossless 16384 x 4096 frame
  stream.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
    request.set(http::field::sec_websocket_protocol, "isostrata.v1");
    request.set(http::field::user_agent, "isostrata-client");
    if (!address.token.empty()) request.set(http::field::authorization, "Bearer " + address.token);
  }));
  websocket::response_type response;
  stream.async_handshake(response, where, address.base + "ws", [&](beast::error_code e) { error = e, done = true; });
  finish("upgrading to WebSocket");
  if (error == websocket::error::upgrade_declined)
    throw Error("refused", where + " refused the connection: HTTP " + std::to_string(response.result_int()) + " " + response.body());
  if (error) throw Error("connection", where + ": " + error.message());

  Connection connection(std::move(socket));
  v1::ClientMessage message;
  auto* hello = message.mutable_hello();
  hello->set_protocol_major(1);
  hello->set_client("isostrata-client");
  hello->mutable_viewport()->set_width(options.width);
  hello->mutable_viewport()->set_height(options.height);
  hello->add_still_formats("png");
  hello->add_moving_formats("jpeg");
  hello->set_resume_token(options.resume_token);
  connection.send(std::move(message));
  while (auto answer = connection.receive(left(deadline))) {
    if (answer->has_error()) refuse(answer->error());
    if (answer->has_welcome()) return connection;
  }
  throw Error("timeout", where + " did not welcome us within " + std::to_string(options.connect_timeout.count()) + " ms");
}

std::uint64_t Connection::send(v1::ClientMessage message) {
  Socket& s = *socket_;
  message.set_seq(s.next_seq++);
  const std::string bytes = message.SerializeAsString();
  beast::error_code error;
  bool done = false;
  s.stream.async_write(asio::buffer(bytes), [&](beast::error_code e, std::size_t) { error = e, done = true; });
  if (!s.run_until([&] { return done; }, Clock::now() + std::chrono::seconds(10))) {
    beast::get_lowest_layer(s.stream).cancel();
    s.run_until([&] { return done; }, Clock::now() + std::chrono::seconds(1));
    throw Error("timeout", "the server did not take a message for 10 s");
  }
  if (error) lost(error);
  return message.seq();
}

std::optional<v1::ServerMessage> Connection::receive(std::chrono::milliseconds timeout) {
  Socket& s = *socket_;
  if (!s.arrived) {
    s.start_reading();
    if (!s.run_until([&] { return s.arrived; }, Clock::now() + timeout)) return std::nullopt;
  }
  s.arrived = false;
  if (s.read_error == websocket::error::closed)
    throw Error("connection", "the server closed the connection: " + std::string(s.stream.reason().reason.c_str()));
  if (s.read_error) lost(s.read_error);
  v1::ServerMessage message;
  const auto bytes = s.buffer.cdata();
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    throw Error("connection", "the server sent " + std::to_string(bytes.size()) + " bytes that are not a ServerMessage");
  s.remember(message);
  return message;
}

void Connection::acknowledge(const v1::Frame& frame, double decode_ms) {
  v1::ClientMessage message;
  message.mutable_frame_ack()->set_frame_id(frame.frame_id());
  message.mutable_frame_ack()->set_decode_ms(decode_ms);
  send(std::move(message));
}

v1::Frame Connection::wait_for_frame(std::uint64_t seq, bool lossless, std::chrono::milliseconds timeout) {
  const auto deadline = Clock::now() + timeout;
  while (auto message = receive(left(deadline))) {
    if (message->has_error()) refuse(message->error());
    if (!message->has_frame()) continue;
    acknowledge(message->frame(), 0);
    const bool exact = message->frame().phase() == v1::FRAME_PHASE_LOSSLESS;
    if (message->frame().input_seq() >= seq && (exact || !lossless)) return std::move(*message->mutable_frame());
  }
  throw Error("timeout", "no frame that shows the last command within " + std::to_string(timeout.count()) + " ms");
}

v1::DatasetInfo Connection::wait_for_dataset(std::string_view id, std::chrono::milliseconds timeout) {
  const auto deadline = Clock::now() + timeout;
  while (state().dataset() != id || dataset_info().id() != id) {
    const auto message = receive(left(deadline));
    if (!message) throw Error("timeout", "dataset '" + std::string(id) + "' was not open within " + std::to_string(timeout.count()) + " ms");
    if (message->has_error()) refuse(message->error());
    if (message->has_frame()) acknowledge(message->frame(), 0);
  }
  return dataset_info();
}

}  // namespace isostrata::client
