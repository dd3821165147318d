#include "isostrata/client.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <boost/json/value.hpp>
#include <deque>

#include "server_address.h"

namespace isostrata::client {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using Steady = std::chrono::steady_clock;

constexpr std::size_t kMaxServerMessage = 512u << 20;        // a lossless frame of the largest size
constexpr auto kStopPeriod = std::chrono::milliseconds(50);  // how late a request to stop is seen at most

/// What REST tells of long work.
struct OperationStatus {
  std::string id, status, stage, code, detail;
  double fraction = 0;
};

OperationStatus parse_operation(const std::string& text) {
  try {
    const auto document = boost::json::parse(text);
    OperationStatus out;
    out.id = document.at("id").as_string();
    out.status = document.at("status").as_string();
    out.stage = document.at("stage").as_string();
    out.fraction = document.at("fraction").to_number<double>();
    if (const auto* error = document.as_object().if_contains("error")) {
      out.code = error->at("code").as_string();
      out.detail = error->at("detail").as_string();
    }
    return out;
  } catch (const std::exception& wrong) {
    throw ClientError("protocol", std::string("the server's answer is no operation: ") + wrong.what());
  }
}

// Cancels it, or forgets it and its file.
void give_up(const Options& options, const std::string& operation) {
  try {
    http_request(options, "DELETE", operation);
  } catch (const ClientError&) {  // it has ended by itself, or the server has
  }
}

[[noreturn]] void refuse(const v1::Error& error) { throw ClientError(error.code(), error.message(), error.field()); }

}  // namespace

class Client::Impl {
 public:
  explicit Impl(const Options& options) : options_(options), timeout_(options.timeout), socket_(io_) {
    const ServerAddress address = parse_address(options_);
    if (!options_.session.empty()) {
      const auto answer = boost::json::parse(http_get(options_, "api/v1/sessions/" + options_.session));
      const auto* token = answer.is_object() ? answer.as_object().if_contains("resumeToken") : nullptr;
      if (!token || !token->is_string()) throw ClientError("protocol", "the server's answer about a session has no resumeToken");
      options_.resume_token = token->as_string();
    }
    connect(address);
    v1::ClientMessage hello;
    v1::Hello& body = *hello.mutable_hello();
    body.set_protocol_major(1);
    body.set_client(options.name);
    if (options.width > 0) {
      body.mutable_viewport()->set_width(static_cast<std::uint32_t>(options.width));
      body.mutable_viewport()->set_height(static_cast<std::uint32_t>(options.height));
      body.mutable_viewport()->set_hidden(options.hidden);
    }
    body.add_still_formats("png");
    for (const std::string& format : options.moving_formats) body.add_moving_formats(format);
    body.set_resume_token(options_.resume_token);
    send(std::move(hello));
    const auto deadline = Steady::now() + timeout_;
    while (!welcomed_) {
      const auto message = receive_until(deadline);
      if (!message) throw ClientError("timeout", "the server did not answer Hello");
      if (message->has_error()) refuse(message->error());
    }
    if (!options_.session.empty() && welcome_.session() != options_.session)
      throw ClientError("not_found", "session " + options_.session + " has ended just now");
  }

  ~Impl() { close(); }

  void close() {
    if (!socket_.is_open()) return;
    bool closed = false;
    if (!failure_) socket_.async_close(websocket::close_code::normal, [&](beast::error_code) { closed = true; });
    io_.restart();
    const auto deadline = Steady::now() + std::chrono::milliseconds(500);
    while (!failure_ && !closed && Steady::now() < deadline) io_.run_one_for(deadline - Steady::now());
    beast::get_lowest_layer(socket_).close();
    io_.restart();
    io_.poll();  // what was pending ends while `closed` is still there
  }

  std::uint64_t send(v1::ClientMessage message) {
    const std::uint64_t seq = ++last_seq_;  // acknowledgements sent below take numbers of their own
    message.set_seq(seq);
    std::string bytes;
    message.SerializeToString(&bytes);
    outgoing_.push_back(std::move(bytes));
    if (outgoing_.size() == 1) write();
    io_.restart();
    io_.poll();
    return seq;
  }

  std::optional<v1::ServerMessage> receive_until(Steady::time_point deadline) {
    while (incoming_.empty()) {
      if (failure_) throw ClientError("closed", "the server ended the connection: " + why_closed());
      if (options_.stop && *options_.stop) stop();
      const auto now = Steady::now();
      io_.restart();
      if (now >= deadline) {
        io_.poll();
        if (incoming_.empty() && !failure_) return std::nullopt;
        continue;
      }
      io_.run_one_for(options_.stop ? std::min<Steady::duration>(deadline - now, kStopPeriod) : deadline - now);
    }
    v1::ServerMessage message = std::move(incoming_.front());
    incoming_.pop_front();
    note(message);
    return message;
  }

  /// Receives until `done` of a message. Progress is a word of the server: the timeout begins anew.
  template <class Done>
  void wait(const std::string& what, const Done& done) {
    auto deadline = Steady::now() + timeout_;
    for (;;) {
      auto message = receive_until(deadline);
      if (!message) throw ClientError("timeout", what);
      if (message->has_progress()) deadline = Steady::now() + timeout_;
      if (done(*message)) return;
    }
  }

  void command(v1::ClientMessage message) {
    const std::uint64_t seq = send(std::move(message));
    // Messages are answered in order: when the ping is answered, the command has been judged.
    v1::ClientMessage ping;
    const double mark = static_cast<double>(++pings_);
    ping.mutable_ping()->set_client_time_ms(mark);
    send(std::move(ping));
    wait("the server did not answer a command", [&](const v1::ServerMessage& answer) {
      if (answer.has_error() && answer.error().in_reply_to() == seq) refuse(answer.error());
      return answer.has_pong() && answer.pong().client_time_ms() == mark;
    });
  }

  void open_dataset(const std::string& dataset) {
    std::string id = dataset;
    for (const v1::DatasetEntry& entry : welcome_.datasets())
      if (entry.name() == dataset) id = entry.id();
    for (const v1::DatasetEntry& entry : welcome_.datasets())
      if (entry.id() == dataset) id = dataset;
    v1::ClientMessage message;
    message.mutable_open_dataset()->set_id(id);
    const std::uint64_t seq = send(std::move(message));
    bool described = false;
    wait("dataset '" + id + "' was not open in time", [&](const v1::ServerMessage& answer) {
      if (answer.has_error() && answer.error().in_reply_to() == seq) refuse(answer.error());
      described = described || (answer.has_dataset_info() && answer.dataset_info().id() == id);
      return described && answer.has_state() && state_.dataset() == id;
    });
  }

  v1::Frame lossless_frame() {
    v1::ClientMessage still;
    still.mutable_request_still();
    const std::uint64_t seq = send(std::move(still));
    v1::Frame frame;
    wait("no lossless frame came in time", [&](v1::ServerMessage& message) {
      if (message.has_error() && (message.error().in_reply_to() == seq || message.error().in_reply_to() == 0))
        refuse(message.error());
      if (!message.has_frame() || message.frame().phase() != v1::FRAME_PHASE_LOSSLESS ||
          message.frame().revision() < state_.revision())
        return false;
      frame = std::move(*message.mutable_frame());
      return true;
    });
    return frame;
  }

  v1::Histogram histogram(const std::string& array, int bins) {
    v1::ClientMessage message;
    message.mutable_request_histogram()->set_array(array);
    message.mutable_request_histogram()->set_bins(static_cast<std::uint32_t>(std::max(bins, 0)));
    const std::uint64_t seq = send(std::move(message));
    v1::Histogram histogram;
    wait("no histogram came in time", [&](v1::ServerMessage& answer) {
      if (answer.has_error() && answer.error().in_reply_to() == seq) refuse(answer.error());
      if (!answer.has_histogram() || answer.histogram().array() != array) return false;
      histogram = std::move(*answer.mutable_histogram());
      return true;
    });
    return histogram;
  }

  std::string still(int width, int height, const std::string& format) {
    return http_get(options_, "api/v1/sessions/" + welcome_.session() + "/image?width=" + std::to_string(width) +
                                  "&height=" + std::to_string(height) + "&format=" + format);
  }

  void restore_state(const std::string& text) {
    const HttpAnswer answer = http_request(options_, "PUT", "api/v1/sessions/" + welcome_.session() + "/state", text);
    boost::system::error_code error;
    const auto document = boost::json::parse(answer.body, error);
    const auto* revision = !error && document.is_object() ? document.as_object().if_contains("revision") : nullptr;
    // Protobuf's JSON writes 64-bit numbers as text.
    const std::uint64_t wanted =
        revision && revision->is_string() ? std::strtoull(revision->as_string().c_str(), nullptr, 10) : 0;
    if (wanted == 0) throw ClientError("protocol", "the server's answer to a state has no revision");
    v1::ClientMessage ping;  // whoever else changes the state meanwhile only raises the revision
    const double mark = static_cast<double>(++pings_);
    ping.mutable_ping()->set_client_time_ms(mark);
    send(std::move(ping));
    wait("the server did not tell the new state", [&](const v1::ServerMessage& answered) {
      return answered.has_pong() && answered.pong().client_time_ms() == mark && state_.revision() >= wanted;
    });
  }

  void export_mesh(std::ostream& to, const std::string& format, const std::vector<std::string>& facets) {
    boost::json::object wanted{{"format", format}};
    if (!facets.empty()) wanted["facets"] = boost::json::array(facets.begin(), facets.end());
    const std::string session = "api/v1/sessions/" + welcome_.session();
    auto operation = parse_operation(http_request(options_, "POST", session + "/exports", boost::json::serialize(wanted)).body);
    const std::string path = session + "/operations/" + operation.id;
    Options unstoppable = options_;  // what tidies up is not itself stopped
    unstoppable.stop = nullptr;
    try {
      auto deadline = Steady::now() + timeout_;
      auto pause = std::chrono::milliseconds(20);
      for (double before = -1; operation.status == "running"; before = operation.fraction) {
        if (operation.fraction != before) deadline = Steady::now() + timeout_;
        if (Steady::now() > deadline) throw ClientError("timeout", "the export did not go on in time");
        // Waiting by receiving: what happens in the session is heard, frames are acknowledged, a stop is seen.
        const auto end = Steady::now() + pause;
        while (auto message = receive_until(end))
          if (message->has_shutdown()) throw ClientError("closed", message->shutdown().reason());
        pause = std::min(pause * 2, std::chrono::milliseconds(500));
        operation = parse_operation(http_get(options_, path));
        if (options_.on_progress) {
          v1::Progress progress;
          progress.set_stage(operation.stage);
          progress.set_fraction(operation.fraction);
          options_.on_progress(progress);
        }
      }
      if (operation.status != "done") throw ClientError(operation.code, operation.detail);
      http_download(options_, session + "/exports/" + operation.id, to);
    } catch (...) {
      give_up(unstoppable, path);
      throw;
    }
    give_up(unstoppable, path);
  }

  Options options_;
  const std::chrono::milliseconds timeout_;
  v1::Welcome welcome_;
  v1::State state_;
  v1::DatasetInfo dataset_;

 private:
  [[noreturn]] void stop() {
    if (operation_ != 0) {
      v1::ClientMessage message;
      message.mutable_cancel()->set_operation(operation_);
      send(std::move(message));
      io_.restart();
      io_.run_for(kStopPeriod);  // so that it leaves before the connection does
    }
    throw ClientError("cancelled", "stopped");
  }

  // Not io_.run(): Beast's own timers keep it busy for half a minute after what was waited for.
  void run_until(const bool& done) {
    io_.restart();
    while (!done && io_.run_one() > 0) {
    }
  }

  void connect(const ServerAddress& address) {
    beast::error_code error;
    asio::ip::tcp::resolver resolver(io_);
    const auto found = resolver.resolve(address.connect_to, address.port, error);
    const std::string where = address.host + ":" + address.port;
    if (error) throw ClientError("connection", where + ": " + error.message());
    auto& tcp = beast::get_lowest_layer(socket_);
    tcp.expires_after(timeout_);
    error = asio::error::would_block;
    bool done = false;
    tcp.async_connect(found, [&](beast::error_code e, const asio::ip::tcp::endpoint&) {
      error = e;
      done = true;
    });
    run_until(done);
    if (error) throw ClientError("connection", where + ": " + error.message());
    tcp.socket().set_option(asio::ip::tcp::no_delay(true));
    tcp.expires_never();
    socket_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::client));
    socket_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      request.set(beast::http::field::sec_websocket_protocol, "isostrata.v1");
      request.set(beast::http::field::user_agent, "isostrata-client");
      if (!address.token.empty()) request.set(beast::http::field::authorization, "Bearer " + address.token);
    }));
    socket_.binary(true);
    socket_.auto_fragment(false);
    socket_.read_message_max(kMaxServerMessage);
    websocket::response_type response;
    error = asio::error::would_block;
    done = false;
    socket_.async_handshake(response, where, address.base_path + "ws", [&](beast::error_code e) {
      error = e;
      done = true;
    });
    run_until(done);
    if (error == websocket::error::upgrade_declined) {
      const auto status = response.result_int();
      throw ClientError(status == 401 ? "unauthorized" : "connection",
                        where + ": the server refused the WebSocket with status " + std::to_string(status) +
                            (status == 401 ? "; use the address it printed, with its token" : ""));
    }
    if (error) throw ClientError("connection", where + ": " + error.message());
    read();
  }

  void read() {
    socket_.async_read(buffer_, [this](beast::error_code error, std::size_t) {
      if (error) {
        failure_ = error;
        return;
      }
      v1::ServerMessage message;
      if (message.ParseFromArray(buffer_.data().data(), static_cast<int>(buffer_.size()))) {
        // The picture has arrived: that is what the acknowledgement is to prove, so it is not kept back until someone looks.
        if (message.has_frame()) {
          v1::ClientMessage ack;
          ack.mutable_frame_ack()->set_frame_id(message.frame().frame_id());
          ack.set_seq(++last_seq_);
          std::string bytes;
          ack.SerializeToString(&bytes);
          outgoing_.push_back(std::move(bytes));
          if (outgoing_.size() == 1) write();
        }
        incoming_.push_back(std::move(message));
      }
      buffer_.clear();
      read();
    });
  }

  void write() {
    socket_.async_write(asio::buffer(outgoing_.front()), [this](beast::error_code error, std::size_t) {
      if (error) {
        if (!failure_) failure_ = error;
        return;
      }
      outgoing_.pop_front();
      if (!outgoing_.empty()) write();
    });
  }

  void note(const v1::ServerMessage& message) {
    if (message.has_welcome()) {
      welcome_ = message.welcome();
      state_ = welcome_.state();
      dataset_ = welcome_.dataset_info();
      welcomed_ = true;
    } else if (message.has_state()) {
      state_ = message.state();
    } else if (message.has_dataset_info()) {
      dataset_ = message.dataset_info();
    } else if (message.has_shutdown()) {
      last_words_ = message.shutdown().reason();
    } else if (message.has_error()) {
      last_words_ = message.error().message();
    } else if (message.has_progress()) {
      operation_ = message.progress().operation();
      if (options_.on_progress) options_.on_progress(message.progress());
    } else if (message.has_done()) {
      operation_ = 0;
    }
  }

  std::string why_closed() const {
    if (!last_words_.empty()) return last_words_;
    if (failure_ == websocket::error::closed && !socket_.reason().reason.empty()) return socket_.reason().reason.c_str();
    return failure_.message();
  }

  asio::io_context io_{1};
  websocket::stream<beast::tcp_stream> socket_;
  beast::flat_buffer buffer_;
  std::deque<std::string> outgoing_;
  std::deque<v1::ServerMessage> incoming_;
  beast::error_code failure_;
  std::string last_words_;
  std::uint64_t last_seq_ = 0;
  std::uint64_t pings_ = 0;
  std::uint64_t operation_ = 0;  // the newest that has told of its progress and has not ended
  bool welcomed_ = false;
};

Client::Client(const Options& options) : impl_(std::make_unique<Impl>(options)) {}
Client::~Client() = default;
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;
const v1::Welcome& Client::welcome() const { return impl_->welcome_; }
const v1::State& Client::state() const { return impl_->state_; }
const v1::DatasetInfo& Client::dataset() const { return impl_->dataset_; }
std::uint64_t Client::send(v1::ClientMessage message) { return impl_->send(std::move(message)); }
std::optional<v1::ServerMessage> Client::receive(std::chrono::milliseconds timeout) {
  return impl_->receive_until(Steady::now() + timeout);
}
void Client::command(v1::ClientMessage message) { impl_->command(std::move(message)); }
void Client::open_dataset(const std::string& dataset) { impl_->open_dataset(dataset); }
v1::Histogram Client::histogram(const std::string& array, int bins) { return impl_->histogram(array, bins); }
v1::Frame Client::lossless_frame() { return impl_->lossless_frame(); }
std::string Client::still(int width, int height, const std::string& format) { return impl_->still(width, height, format); }
void Client::export_mesh(std::ostream& to, const std::string& format, const std::vector<std::string>& facets) {
  impl_->export_mesh(to, format, facets);
}
void Client::restore_state(const std::string& json) { impl_->restore_state(json); }
void Client::close() { impl_->close(); }

}  // namespace isostrata::client
