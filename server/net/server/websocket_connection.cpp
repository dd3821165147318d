#include "net/server/websocket_connection.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/wire_format_lite.h>

#include <algorithm>
#include <array>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <optional>

#include "session/wire/limits.h"
#include "session/wire/message_bounds.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using Steady = std::chrono::steady_clock;

constexpr std::size_t kMessagePieceBytes = 64 << 10;  // what a client must take within the write timeout: a slow link is not a stuck one
constexpr std::size_t kMaxWaitingBytes = 8 << 20;  // of control messages; frames are bounded by their credits

// Of a client that is over its budget:
constexpr auto kPassedOverPause = std::chrono::milliseconds(4);  // between cameras that are heeded
constexpr auto kRemindPause = std::chrono::seconds(1);           // between errors that say so

constexpr auto kProbePause = std::chrono::seconds(2);
constexpr const char* kProbe = "way";  // tells our pings' answers from those of Beast's keep-alive

/// A frame whose payload other connections send, too.
struct Waiting {
  v1::Frame frame;
  std::shared_ptr<const Bytes> payload;
};

/// What is sent as one message: first `head`, then the payload if there is one.
struct Outgoing {
  std::string head;
  std::shared_ptr<const Bytes> payload;
};

// The message with the frame's payload last, so that its bytes need not be copied for each connection. Fields may stand in any
// order, and a message that is given twice is merged, but not every reader knows that: the frame is written once, by hand.
Outgoing frame_bytes(v1::ServerMessage message, Waiting&& waiting) {
  using google::protobuf::internal::WireFormatLite;
  using google::protobuf::io::CodedOutputStream;
  Outgoing out{message.SerializeAsString(), std::move(waiting.payload)};
  const std::string frame = waiting.frame.SerializeAsString();
  const auto size = static_cast<std::uint32_t>(out.payload->size());
  std::string payload_head;
  {
    google::protobuf::io::StringOutputStream stream(&payload_head);
    CodedOutputStream coded(&stream);
    coded.WriteTag(WireFormatLite::MakeTag(v1::Frame::kPayloadFieldNumber, WireFormatLite::WIRETYPE_LENGTH_DELIMITED));
    coded.WriteVarint32(size);
  }
  google::protobuf::io::StringOutputStream stream(&out.head);  // appends
  CodedOutputStream coded(&stream);
  coded.WriteTag(WireFormatLite::MakeTag(v1::ServerMessage::kFrameFieldNumber, WireFormatLite::WIRETYPE_LENGTH_DELIMITED));
  coded.WriteVarint32(static_cast<std::uint32_t>(frame.size() + payload_head.size()) + size);
  coded.WriteString(frame);
  coded.WriteString(payload_head);
  return out;
}

/// Kept alive by its coroutines.
class WebSocketConnection final : public Outbox, public std::enable_shared_from_this<WebSocketConnection> {
 public:
  WebSocketConnection(PrefixedStream stream, Connections& connections, Places::Place& place, Sessions::Admission admission)
      : socket_(std::move(stream)),
        wake_writer_(socket_.get_executor()),
        watch_(socket_.get_executor()),
        next_ping_(socket_.get_executor()),
        held_until_(socket_.get_executor()),
        go_on_reading_(socket_.get_executor()),
        connections_(connections),
        place_(place),
        admission_(std::move(admission)),
        budget_(Steady::now(), connections.messages_per_second) {}

  asio::awaitable<void> run(beast::http::request<beast::http::string_body> request) {
    const auto self = shared_from_this();
    boost::system::error_code error;
    beast::get_lowest_layer(socket_).expires_never();
    websocket::stream_base::timeout timeouts{std::chrono::seconds(10), std::chrono::seconds(34),
                                             true};  // pings at half the idle time
    socket_.set_option(timeouts);
    socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
      response.set(beast::http::field::sec_websocket_protocol, "isostrata.v1");
      response.set(beast::http::field::server, "isostrata");
    }));
    socket_.read_message_max(kMaxMessageBytes);
    socket_.auto_fragment(false);
    socket_.binary(true);
    socket_.control_callback([this](websocket::frame_type type, beast::string_view payload) {
      if (type == websocket::frame_type::pong && payload == kProbe && pinged_) {
        connections_.sessions.round_trip(viewer_, Steady::now() - *pinged_, Steady::now());
        pinged_.reset();
      }
    });
    place_.set_close([this] { end(); });
    co_await socket_.async_accept(request, asio::redirect_error(asio::use_awaitable, error));
    if (error) co_return place_.set_close([] {});

    viewer_ = connections_.sessions.attach(*this, Steady::now(), std::move(admission_));
    asio::co_spawn(
        socket_.get_executor(), [self] { return self->write_all(); }, asio::detached);
    asio::co_spawn(
        socket_.get_executor(), [self] { return self->watch(); }, asio::detached);
    asio::co_spawn(
        socket_.get_executor(), [self] { return self->measure(); }, asio::detached);
    co_await read_all();
    heed_held();  // the last that a client says before it goes counts
    place_.set_close([] {});
    connections_.sessions.detach(viewer_, Steady::now(), goodbye_);
    connections_.wake();
    end();
  }

  void send(v1::ServerMessage message) override {
    if (message.has_error()) note(message.error());
    if (state_) {
      // What is said after a state is heard after it: an answer never overtakes the change that it answers.
      v1::ServerMessage earlier;
      *earlier.mutable_state() = std::move(*state_);
      earlier.set_heeded(heeded_);
      state_.reset();
      queue(std::move(earlier));
    }
    queue(std::move(message));
  }
  void send_state(v1::State state, std::uint64_t heeded) override {
    if (ended_ || closing_) return;
    state_ = std::move(state);
    heeded_ = heeded;
    wake_writer_.cancel();
  }
  void send_frame(v1::Frame frame, std::shared_ptr<const Bytes> payload) override {
    if (ended_ || closing_) return;
    frames_.push_back({std::move(frame), std::move(payload)});
    wake_writer_.cancel();
  }
  void close(std::uint16_t code, const std::string& reason) override {
    if (closing_) return;
    closing_ = websocket::close_reason(static_cast<websocket::close_code>(code), reason.substr(0, 100));
    wake_writer_.cancel();
  }

 private:
  asio::awaitable<void> read_all() {
    beast::flat_buffer buffer(kMaxMessageBytes + kMessagePieceBytes);  // so that Beast, which says 1009, is the one to count
    while (!ended_) {
      boost::system::error_code error;
      buffer.clear();
      co_await socket_.async_read(buffer, asio::redirect_error(asio::use_awaitable, error));
      if (error) {
        // Programs that are done close normally; pages that are left, and lines that are lost, do not.
        goodbye_ = error == websocket::error::closed && socket_.reason().code == websocket::close_code::normal;
        co_return;
      }
      if (closing_) continue;  // nothing more is done for it; what it sends is drained until the close is answered
      if (!socket_.got_binary()) {
        connections_.sessions.receive_malformed(viewer_, "a text message came; expected binary Protobuf");
        continue;
      }
      v1::ClientMessage message;
      const std::string_view bytes(static_cast<const char*>(buffer.data().data()), buffer.size());
      if (const auto what = holds_too_much(*message.GetDescriptor(), bytes)) {
        heed_held();
        connections_.sessions.receive_malformed(viewer_, "a message with " + *what);
        continue;
      }
      if (!message.ParseFromArray(buffer.data().data(), static_cast<int>(buffer.size()))) {
        heed_held();
        connections_.sessions.receive_malformed(
            viewer_, std::to_string(buffer.size()) + " bytes that are not a ClientMessage of isostrata.v1");
        continue;
      }
      const auto now = Steady::now();
      if (message.has_set_camera() && (held_ || !budget_.has_room(now))) {
        hold(std::move(message));
        co_await pause(budget_.take(now, MessageBudget::kPassedOver));
        continue;
      }
      heed_held();
      heed(message);
      co_await pause(budget_.take(now, 1 + static_cast<double>(buffer.size()) / MessageBudget::kBytes));
    }
  }

  // Nothing is read meanwhile: what the client goes on to send fills its own socket.
  asio::awaitable<void> pause(Steady::duration time) {
    if (time <= Steady::duration::zero()) co_return;
    boost::system::error_code error;
    go_on_reading_.expires_after(time);
    co_await go_on_reading_.async_wait(asio::redirect_error(asio::use_awaitable, error));
  }

  void heed(const v1::ClientMessage& message) {
    try {
      connections_.sessions.receive(viewer_, message, Steady::now());
    } catch (const std::exception&) {
      v1::ServerMessage failed;
      failed.mutable_error()->set_code("internal");
      failed.mutable_error()->set_in_reply_to(message.seq());
      failed.mutable_error()->set_message("this message could not be handled; the session is as it was");
      send(std::move(failed));
    }
    if (connections_.sessions.watched_by(viewer_)) place_.settle();
    connections_.wake();
  }

  // Of the cameras of a client that is over its budget the newest is heeded, and no more of them than would be drawn.
  void hold(v1::ClientMessage camera) {
    const auto now = Steady::now();
    if (held_ && camera.seq() <= held_->seq()) heed_held();  // replayed: refused as it would be anywhere
    if (!held_) {
      held_ = std::move(camera);
      held_until_.expires_after(kPassedOverPause);
      held_until_.async_wait([self = shared_from_this()](boost::system::error_code error) {
        if (!error && !self->ended_) self->heed_held();
      });
      return;
    }
    if (!reminded_ || now - *reminded_ >= kRemindPause) {
      reminded_ = now;
      v1::ServerMessage answer;
      *answer.mutable_error() = wire_error(
          "too_many_messages", "more than " + std::to_string(static_cast<int>(connections_.messages_per_second)) +
                                   " messages a second came on this connection: of cameras the newest is taken and others, as "
                                   "this one, are passed over");
      answer.mutable_error()->set_in_reply_to(held_->seq());
      send(std::move(answer));
    }
    held_ = std::move(camera);
  }

  void heed_held() {
    if (!held_) return;
    held_until_.cancel();
    const v1::ClientMessage camera = std::move(*held_);
    held_.reset();
    if (!closing_) heed(camera);
  }

  void note(const v1::Error& error) {
    const Session* session = connections_.sessions.watched_by(viewer_);
    connections_.site.metrics().websocket_error(error.code());
    connections_.site.log().websocket_error(session ? session->id() : "", viewer_, error);
  }

  void queue(v1::ServerMessage message) {
    if (ended_ || closing_) return;
    waiting_bytes_ += message.ByteSizeLong();
    if (waiting_bytes_ > kMaxWaitingBytes) return end();  // it has stopped reading and goes on asking
    greeted_ = true;
    control_.push_back(std::move(message));
    wake_writer_.cancel();
  }

  // Whatever waits, the most urgent first.
  std::optional<Outgoing> next_bytes() {
    v1::ServerMessage message;
    Outgoing out;
    if (!control_.empty()) {
      message = std::move(control_.front());
      control_.pop_front();
      waiting_bytes_ -= std::min(waiting_bytes_, static_cast<std::size_t>(message.ByteSizeLong()));
    } else if (closing_) {
      return std::nullopt;
    } else if (state_) {
      *message.mutable_state() = std::move(*state_);
      message.set_heeded(heeded_);
      state_.reset();
    } else if (!frames_.empty()) {
      message.set_seq(++last_seq_);
      out = frame_bytes(std::move(message), std::move(frames_.front()));
      connections_.site.metrics().websocket_sent(out.head.size() + out.payload->size());
      frames_.pop_front();
      return out;
    } else {
      return std::nullopt;
    }
    message.set_seq(++last_seq_);
    message.SerializeToString(&out.head);
    connections_.site.metrics().websocket_sent(out.head.size());
    return out;
  }

  asio::awaitable<void> write_all() {
    const auto self = shared_from_this();
    boost::system::error_code error;
    while (!ended_) {
      const auto bytes = next_bytes();
      if (!bytes && !closing_) {
        wake_writer_.expires_at(Steady::time_point::max());
        co_await wake_writer_.async_wait(asio::redirect_error(asio::use_awaitable, error));
        continue;
      }
      if (!bytes) {
        write_began_ = Steady::now();
        co_await socket_.async_close(*closing_, asio::redirect_error(asio::use_awaitable, error));
        co_return end();
      }
      // The head goes with the payload's first piece.
      const std::size_t total = bytes->payload ? bytes->payload->size() : 0;
      for (std::size_t at = 0; at < total || at == 0;) {
        const std::size_t room = at == 0 ? kMessagePieceBytes - std::min(bytes->head.size(), kMessagePieceBytes / 2) : kMessagePieceBytes;
        const std::size_t size = std::min(room, total - at);
        const std::array<asio::const_buffer, 2> pieces{at == 0 ? asio::buffer(bytes->head) : asio::const_buffer(),
                                                       total == 0 ? asio::const_buffer() : asio::buffer(bytes->payload->data() + at, size)};
        write_began_ = Steady::now();
        co_await socket_.async_write_some(at + size == total, pieces, asio::redirect_error(asio::use_awaitable, error));
        write_began_.reset();
        if (error) co_return end();
        at += size;
        if (total == 0) break;
      }
    }
  }

  // Ends what has stood still for too long.
  asio::awaitable<void> watch() {
    const auto self = shared_from_this();
    boost::system::error_code error;
    const auto accepted = Steady::now();
    const auto pause =
        std::min<Steady::duration>({std::chrono::seconds(1), connections_.write_timeout / 4, connections_.hello_timeout / 4});
    while (!ended_) {
      watch_.expires_after(pause);
      co_await watch_.async_wait(asio::redirect_error(asio::use_awaitable, error));
      const auto now = Steady::now();
      if (write_began_ && now - *write_began_ > connections_.write_timeout) co_return end();
      if (!greeted_ && now - accepted > connections_.hello_timeout) co_return end();
    }
  }

  // Round trips of what has no weight: frames tell how fast the way is only against how long it is. The first goes before any
  // frame. A coroutine of its own, since on a blocked socket it stands still.
  asio::awaitable<void> measure() {
    const auto self = shared_from_this();
    boost::system::error_code error;
    while (!ended_ && !closing_) {
      if (!pinged_) {
        pinged_ = Steady::now();
        co_await socket_.async_ping(kProbe, asio::redirect_error(asio::use_awaitable, error));
        if (error) co_return;
      }
      next_ping_.expires_after(kProbePause);
      co_await next_ping_.async_wait(asio::redirect_error(asio::use_awaitable, error));
    }
  }

  void end() {
    if (ended_) return;
    ended_ = true;
    boost::system::error_code ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
    wake_writer_.cancel();
    watch_.cancel();
    next_ping_.cancel();
    held_until_.cancel();
    go_on_reading_.cancel();
  }

  websocket::stream<PrefixedStream> socket_;
  asio::steady_timer wake_writer_;
  asio::steady_timer watch_;
  asio::steady_timer next_ping_;
  asio::steady_timer held_until_, go_on_reading_;
  std::optional<Steady::time_point> pinged_;  // when the ping went that is not answered yet
  Connections& connections_;
  Places::Place& place_;  // until run() ends
  Sessions::Admission admission_;
  ViewerKey viewer_ = 0;
  bool ended_ = false;
  bool goodbye_ = false;  // the client has said that it is done
  bool greeted_ = false;  // an answer to its Hello, at least, is on its way
  std::optional<websocket::close_reason> closing_;
  std::optional<Steady::time_point> write_began_;
  std::deque<v1::ServerMessage> control_;
  std::size_t waiting_bytes_ = 0;
  std::optional<v1::State> state_;
  std::uint64_t heeded_ = 0;  // with it
  std::deque<Waiting> frames_;
  std::uint64_t last_seq_ = 0;
  MessageBudget budget_;
  std::optional<v1::ClientMessage> held_;       // a camera that a newer one may replace
  std::optional<Steady::time_point> reminded_;  // when the client was last told that it is over its budget
};

}  // namespace

boost::asio::awaitable<void> serve_websocket(PrefixedStream stream, beast::http::request<beast::http::string_body> request,
                                             Connections& connections, Places::Place& place, Sessions::Admission admission) {
  co_await std::make_shared<WebSocketConnection>(std::move(stream), connections, place, std::move(admission))->run(std::move(request));
}

}  // namespace isostrata
