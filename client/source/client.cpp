#include "isostrata/client.h"

#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <array>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <boost/json/value.hpp>
#include <charconv>

#include "connection.h"

namespace isostrata::client {
namespace {

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
    throw ClientError("protocol", std::string("the server's answer is not an operation: ") + wrong.what());
  }
}

// Cancels it, or forgets it and its file.
void give_up(const Options& options, const std::string& operation) {
  try {
    http_request(options, "DELETE", operation);
  } catch (const ClientError&) {  // it has ended by itself, or the server has
  }
}

/// In as many digits as tell it from every other.
std::string in_full(double number) {
  std::array<char, 32> buffer{};
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr};
}

std::string in_full(const std::array<double, 3>& point) { return in_full(point[0]) + "," + in_full(point[1]) + "," + in_full(point[2]); }

/// As a value in a URL's query.
std::string percent_encoded(const std::string& text) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string out;
  for (const char letter : text) {
    const auto byte = static_cast<unsigned char>(letter);
    if ((byte >= '0' && byte <= '9') || (byte >= 'A' && byte <= 'Z') || (byte >= 'a' && byte <= 'z') || byte == '-' || byte == '_' || byte == '.')
      out += letter;
    else
      out += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
  }
  return out;
}

std::string of_array(const std::string& name) { return name.empty() ? "" : "&array=" + percent_encoded(name); }

[[noreturn]] void refuse(const v1::Error& error) { throw ClientError(error.code(), error.message(), error.field()); }

}  // namespace

class Client::Impl {
 public:
  explicit Impl(const Options& options) : connection_(options), timeout_(options.timeout), on_progress_(options.on_progress) {
    receive_until(Steady::now());  // Welcome is there
  }

  void close() { connection_.close(); }
  void note_decoded(std::uint64_t frame, double ms) { connection_.note_decoded(frame, ms); }
  std::uint64_t send(v1::ClientMessage message) { return connection_.send(std::move(message)); }

  std::optional<v1::ServerMessage> receive_until(Steady::time_point deadline) {
    std::optional<v1::ServerMessage> message = connection_.receive_until(deadline);
    if (message) note(*message);
    return message;
  }

  /// Receives until `done` of a message. Progress is a word of the server, and so is Welcome after a lost connection: the timeout
  /// begins anew.
  template <class Done>
  void wait(const std::string& what, const Done& done) {
    auto deadline = Steady::now() + timeout_;
    for (;;) {
      auto message = receive_until(deadline);
      if (!message) throw ClientError("timeout", what);
      if (message->has_progress() || message->has_welcome()) deadline = Steady::now() + timeout_;
      if (done(*message)) return;
    }
  }

  /// Puts a question and waits for its answer. What a lost connection took with it is asked again.
  template <class Done>
  void ask(const v1::ClientMessage& question, const std::string& what, const Done& done) {
    std::uint64_t number = send(question);
    int made = connection_.made();
    wait(what, [&](v1::ServerMessage& answer) {
      if (std::exchange(made, connection_.made()) != made) number = send(question);
      if (answer.has_error() && answer.error().in_reply_to() == number) refuse(answer.error());
      return done(answer);
    });
  }

  /// Waits until everything that was sent before has been judged and `holds`; `number`: of a command, whose refusal is thrown.
  template <class Holds>
  void judged(std::uint64_t number, std::uint64_t command, const std::string& what, const Holds& holds) {
    v1::ClientMessage ping;
    const double mark = static_cast<double>(++pings_);
    ping.mutable_ping()->set_client_time_ms(mark);
    bool answered = false;
    ask(ping, what, [&](const v1::ServerMessage& answer) {
      if (answer.has_error() && number != 0 && answer.error().in_reply_to() == number) refuse(answer.error());
      // It may have been judged, and only the verdict been lost.
      if (answer.has_welcome() && command != 0 && answer.welcome().last_command() == command &&
          answer.welcome().has_last_command_error())
        refuse(answer.welcome().last_command_error());
      answered = answered || (answer.has_pong() && answer.pong().client_time_ms() == mark);
      return answered && holds();
    });
  }

  /// A request of its own connection, tried as long as that of the session would be.
  template <class Request>
  auto patiently(const Request& request) {
    const auto end = Steady::now() + connection_.options().reconnect_for;
    for (auto pause = std::chrono::milliseconds(50);; pause = std::min(2 * pause, std::chrono::milliseconds(1000))) {
      try {
        return request();
      } catch (const ClientError& error) {
        if ((error.code() != "connection" && error.code() != "not_found") || Steady::now() >= end) throw;
        if (error.code() == "not_found") {
          // A server that came back without the session does not have it under its old name.
          const int before = connection_.made();
          connection_.keep_until(Steady::now() + std::chrono::milliseconds(1));
          if (connection_.made() == before) throw;
          continue;
        }
      }
      connection_.keep_until(Steady::now() + pause);
    }
  }

  void command(v1::ClientMessage message) {
    const std::uint64_t number = send(std::move(message));
    // Messages are answered in order: when the ping is answered, the command has been judged.
    judged(number, connection_.last_command(), "the server did not answer a command", [] { return true; });
  }

  void open_dataset(const std::string& dataset, const std::string& region, const std::string& stride) {
    std::string id = dataset;
    for (const v1::DatasetEntry& entry : welcome_.datasets())
      if (entry.name() == dataset) id = entry.id();
    for (const v1::DatasetEntry& entry : welcome_.datasets())
      if (entry.id() == dataset) id = dataset;
    v1::ClientMessage message;
    message.mutable_open_dataset()->set_id(id);
    message.mutable_open_dataset()->set_region(region);
    message.mutable_open_dataset()->set_stride(stride);
    // A part has its text behind the id, as the server writes it.
    const bool part = !region.empty() || !stride.empty();
    const auto is_it = [&](const std::string& of) { return of == id || (part && of.starts_with(id.substr(0, id.find('@')) + '@')); };
    const std::uint64_t number = send(std::move(message)), command = connection_.last_command();
    bool described = false, lost = false;
    wait("dataset '" + id + "' was not open in time", [&](const v1::ServerMessage& answer) {
      if (answer.has_error() && answer.error().in_reply_to() == number) refuse(answer.error());
      if (answer.has_welcome()) {
        if (answer.welcome().last_command() == command && answer.welcome().has_last_command_error())
          refuse(answer.welcome().last_command_error());
        lost = true;
        described = answer.welcome().last_command() >= command && is_it(dataset_.id());
        return described && is_it(state_.dataset());
      }
      described = described || (answer.has_dataset_info() && is_it(answer.dataset_info().id()));
      // Not before it has been read: a newcomer's session opens a dataset by itself, and what was asked for would come later.
      return described && answer.has_state() && is_it(state_.dataset()) && (lost || answer.heeded() >= number);
    });
  }

  v1::Frame lossless_frame() {
    if (connection_.options().lossless_bands)
      throw ClientError("bad_argument", "lossless frames come in bands here; next_picture puts them together");
    v1::ClientMessage still;
    still.mutable_request_still();
    v1::Frame frame;
    ask(still, "no lossless frame came in time", [&](v1::ServerMessage& message) {
      if (message.has_error() && message.error().in_reply_to() == 0) refuse(message.error());
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
    v1::Histogram histogram;
    ask(message, "no histogram came in time", [&](v1::ServerMessage& answer) {
      if (!answer.has_histogram() || answer.histogram().array() != array) return false;
      histogram = std::move(*answer.mutable_histogram());
      return true;
    });
    return histogram;
  }

  std::string still(int width, int height, const std::string& format) {
    return patiently([&] {
      return http_get(connection_.options(), session_path() + "/image?width=" + std::to_string(width) +
                                                 "&height=" + std::to_string(height) + "&format=" + format);
    });
  }

  template <class Message>
  Message get(const std::string& path) {
    const std::string text = patiently([&] { return http_get(connection_.options(), session_path() + path); });
    Message message;
    google::protobuf::util::JsonParseOptions lenient;
    lenient.ignore_unknown_fields = true;
    if (!google::protobuf::util::JsonStringToMessage(text, &message, lenient).ok())
      throw ClientError("protocol", "the server's answer is not a " + std::string(Message::descriptor()->name()) + ": " + text.substr(0, 200));
    return message;
  }

  v1::ProbeResult probe(double x, double y, int width, int height) {
    return get<v1::ProbeResult>("/probe?x=" + in_full(x) + "&y=" + in_full(y) + "&width=" + std::to_string(width) + "&height=" + std::to_string(height));
  }

  v1::ProbedCurve probe_line(const std::array<double, 3>& from, const std::array<double, 3>& to, const std::string& array) {
    return get<v1::ProbedCurve>("/probe/line?from=" + in_full(from) + "&to=" + in_full(to) + of_array(array));
  }
  v1::ProbedCurve probe_steps(const std::array<double, 3>& at, const std::string& array) {
    return get<v1::ProbedCurve>("/probe/steps?at=" + in_full(at) + of_array(array));
  }

  v1::LayerStatistics layer_statistics(std::uint32_t interval, const std::string& array) {
    return get<v1::LayerStatistics>("/intervals/" + std::to_string(interval) + "/statistics" + (array.empty() ? "" : "?array=" + percent_encoded(array)));
  }

  void restore_state(const std::string& text) {
    const HttpAnswer answer =
        patiently([&] { return http_request(connection_.options(), "PUT", session_path() + "/state", text); });
    boost::system::error_code error;
    const auto document = boost::json::parse(answer.body, error);
    const auto* revision = !error && document.is_object() ? document.as_object().if_contains("revision") : nullptr;
    // Protobuf's JSON writes 64-bit numbers as text.
    const std::uint64_t wanted =
        revision && revision->is_string() ? std::strtoull(revision->as_string().c_str(), nullptr, 10) : 0;
    if (wanted == 0) throw ClientError("protocol", "the server's answer to a state has no revision");
    // Whoever else changes the state meanwhile only raises the revision.
    judged(0, 0, "the server did not tell the new state", [&] { return state_.revision() >= wanted; });
  }

  void export_mesh(std::ostream& to, const std::string& format, const std::vector<std::string>& facets) {
    const Options& options = connection_.options();
    boost::json::object wanted{{"format", format}};
    if (!facets.empty()) wanted["facets"] = boost::json::array(facets.begin(), facets.end());
    const std::string session = session_path();
    auto operation = parse_operation(
        patiently([&] { return http_request(options, "POST", session + "/exports", boost::json::serialize(wanted)); }).body);
    const std::string path = session + "/operations/" + operation.id;
    Options unstoppable = options;  // what tidies up is not itself stopped
    unstoppable.stop = nullptr;
    const int made = connection_.made();
    try {
      auto deadline = Steady::now() + timeout_;
      auto pause = std::chrono::milliseconds(20);
      for (double before = -1; operation.status == "running"; before = operation.fraction) {
        if (operation.fraction != before) deadline = Steady::now() + timeout_;
        if (Steady::now() > deadline) throw ClientError("timeout", "the export did not go on in time");
        connection_.keep_until(Steady::now() + pause);  // frames are acknowledged, a stop is seen
        pause = std::min(pause * 2, std::chrono::milliseconds(500));
        operation = parse_operation(patiently([&] { return http_get(options, path); }));
        if (on_progress_) {
          v1::Progress progress;
          progress.set_stage(operation.stage);
          progress.set_fraction(operation.fraction);
          on_progress_(progress);
        }
      }
      if (operation.status != "done") throw ClientError(operation.code, operation.detail);
      http_download(options, session + "/exports/" + operation.id, to);
    } catch (const ClientError& error) {
      give_up(unstoppable, path);
      if (error.code() == "not_found" && connection_.made() != made)
        throw ClientError("interrupted", "the server that wrote the export is gone; ask again");
      throw;
    } catch (...) {
      give_up(unstoppable, path);
      throw;
    }
    give_up(unstoppable, path);
  }

  void note_dataset(const v1::DatasetEntry& entry) {
    for (v1::DatasetEntry& known : *welcome_.mutable_datasets())
      if (known.id() == entry.id()) {
        known = entry;
        return;
      }
    *welcome_.add_datasets() = entry;
  }

  v1::Welcome welcome_;
  v1::State state_;
  v1::DatasetInfo dataset_;

 private:
  std::string session_path() const { return "api/v1/sessions/" + connection_.session(); }

  void note(const v1::ServerMessage& message) {
    if (message.has_welcome()) {
      welcome_ = message.welcome();
      state_ = welcome_.state();
      dataset_ = welcome_.dataset_info();
    } else if (message.has_state()) {
      state_ = message.state();
    } else if (message.has_dataset_info()) {
      dataset_ = message.dataset_info();
    } else if (message.has_datasets_changed()) {
      for (const v1::DatasetEntry& entry : message.datasets_changed().entries()) note_dataset(entry);
    } else if (message.has_progress() && on_progress_) {
      on_progress_(message.progress());
    }
  }

  Connection connection_;
  const std::chrono::milliseconds timeout_;
  const std::function<void(const v1::Progress&)> on_progress_;
  std::uint64_t pings_ = 0;
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
void Client::open_dataset(const std::string& dataset, const std::string& region, const std::string& stride) {
  impl_->open_dataset(dataset, region, stride);
}
v1::LayerFacts Client::layer_facts() { return impl_->get<v1::LayerFacts>("/layers"); }
v1::ProbeResult Client::probe(double x, double y, int width, int height) { return impl_->probe(x, y, width, height); }
v1::ProbedCurve Client::probe_line(const std::array<double, 3>& from, const std::array<double, 3>& to, const std::string& array) {
  return impl_->probe_line(from, to, array);
}
v1::ProbedCurve Client::probe_steps(const std::array<double, 3>& at, const std::string& array) { return impl_->probe_steps(at, array); }
v1::LayerStatistics Client::layer_statistics(std::uint32_t interval, const std::string& array) { return impl_->layer_statistics(interval, array); }
v1::Histogram Client::histogram(const std::string& array, int bins) { return impl_->histogram(array, bins); }
v1::Frame Client::lossless_frame() { return impl_->lossless_frame(); }
std::string Client::still(int width, int height, const std::string& format) { return impl_->still(width, height, format); }
void Client::export_mesh(std::ostream& to, const std::string& format, const std::vector<std::string>& facets) {
  impl_->export_mesh(to, format, facets);
}
void Client::restore_state(const std::string& json) { impl_->restore_state(json); }
void Client::close() { impl_->close(); }
void Client::note_decoded(std::uint64_t frame, double ms) { impl_->note_decoded(frame, ms); }

}  // namespace isostrata::client
