// The one file of the client that compiles Beast's WebSocket.
#include "web_socket.h"

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <utility>

namespace isostrata::client {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;

constexpr std::size_t kMaxServerMessage = 512u << 20;  // a lossless frame of the largest size
// The server pings every 17 s. Whoever makes no call for long has not looked, so a silence is believed only after one more ping.
constexpr auto kSilence = std::chrono::seconds(40);

}  // namespace

class WebSocket::Impl {
 public:
  Impl(const ServerAddress& address, const Options& options, Steady::time_point deadline, Receiver receiver)
      : receiver_(std::move(receiver)), socket_(io_) {
    const std::string where = address.host + ":" + address.port;
    socket_.next_layer().connect(address, options, deadline);
    websocket::stream_base::timeout timeouts{websocket::stream_base::none(), kSilence, true};
    socket_.set_option(timeouts);
    socket_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      request.set(beast::http::field::sec_websocket_protocol, "isostrata.v1");
      request.set(beast::http::field::user_agent, "isostrata-client");
      if (!address.token.empty()) request.set(beast::http::field::authorization, "Bearer " + address.token);
    }));
    socket_.binary(true);
    socket_.auto_fragment(false);
    socket_.read_message_max(kMaxServerMessage);
    websocket::response_type response;
    beast::error_code error;
    bool done = false;
    socket_.async_handshake(response, where, address.base_path + "ws", [&](beast::error_code e) { error = e, done = true; });
    socket_.next_layer().finish(done, options, deadline, where + ": the server did not answer in time");
    if (error == websocket::error::upgrade_declined) {
      const auto status = response.result_int();
      throw ClientError(status == 401 ? "unauthorized" : "connection",
                        where + ": the server refused the WebSocket with status " + std::to_string(status) +
                            (status == 401 ? "; use the address it printed, with its token" : ""));
    }
    if (error) throw ClientError("connection", where + ": " + error.message());
    read();
  }

  void close() {
    if (closed_) return;
    closed_ = true;
    bool said = false;
    if (!failure_) socket_.async_close(websocket::close_code::normal, [&](beast::error_code) { said = true; });
    io_.restart();
    const auto deadline = Steady::now() + std::chrono::milliseconds(500);
    while (!failure_ && !said && Steady::now() < deadline) io_.run_one_for(deadline - Steady::now());
    socket_.next_layer().close();
    if (!failure_) failure_ = asio::error::operation_aborted;
    io_.restart();
    io_.poll();  // what was pending ends while `said` is still there
  }

  void send(std::string bytes) {
    waiting_bytes_ += bytes.size();
    outgoing_.push_back(std::move(bytes));
    if (outgoing_.size() == 1) write();
  }
  std::size_t waiting_bytes() const { return waiting_bytes_; }

  asio::io_context io_{1};
  beast::error_code failure_;
  Receiver receiver_;
  websocket::stream<Transport> socket_;
  bool closed_ = false;

 private:
  void read() {
    socket_.async_read(buffer_, [this](beast::error_code error, std::size_t) {
      if (closed_) return;
      if (error) {
        if (!failure_) failure_ = error;
        return;
      }
      receiver_(buffer_.data().data(), buffer_.size());
      buffer_.clear();
      read();
    });
  }

  // A write that fails leaves what the server said before to be read: its last words may be among it.
  void write() {
    socket_.async_write(asio::buffer(outgoing_.front()), [this](beast::error_code error, std::size_t) {
      if (error) return;
      waiting_bytes_ -= outgoing_.front().size();
      outgoing_.pop_front();
      if (!outgoing_.empty()) write();
    });
  }

  beast::flat_buffer buffer_;
  std::deque<std::string> outgoing_;
  std::size_t waiting_bytes_ = 0;
};

WebSocket::WebSocket(const ServerAddress& address, const Options& options, Steady::time_point deadline, Receiver receiver)
    : impl_(std::make_unique<Impl>(address, options, deadline, std::move(receiver))) {}
WebSocket::~WebSocket() { close(); }
void WebSocket::send(std::string bytes) { impl_->send(std::move(bytes)); }
void WebSocket::run_for(Steady::duration time) {
  impl_->io_.restart();
  impl_->io_.run_one_for(time);
}
void WebSocket::poll() {
  impl_->io_.restart();
  impl_->io_.poll();
}
std::size_t WebSocket::waiting_bytes() const { return impl_->waiting_bytes(); }
bool WebSocket::failed() const { return static_cast<bool>(impl_->failure_); }
std::string WebSocket::why() const {
  if (impl_->failure_ == websocket::error::closed && !impl_->socket_.reason().reason.empty())
    return impl_->socket_.reason().reason.c_str();
  return impl_->failure_.message();
}
unsigned WebSocket::close_code() const { return impl_->failure_ == websocket::error::closed ? impl_->socket_.reason().code : 0; }
void WebSocket::close() { impl_->close(); }

}  // namespace isostrata::client
