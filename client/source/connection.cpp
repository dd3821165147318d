#include "connection.h"

#include <google/protobuf/util/json_util.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <boost/json/parse.hpp>
#include <cstdio>
#include <thread>

#include "isostrata/rest.h"

namespace isostrata::client {
namespace {

constexpr auto kLongestPause = std::chrono::milliseconds(2000);  // between two tries
constexpr std::size_t kMostLogged = 4096, kMostNumbers = 16384, kMarkEvery = 64;
constexpr std::size_t kMostJudgedBytes = 4 << 20, kMostLoggedBytes = 64 << 20, kMostUnsentBytes = 1 << 20;
constexpr auto kKeepJudged = std::chrono::seconds(10);  // a server that is killed may lose the last moments of what it kept
constexpr std::size_t kMostFramesWaiting = 32;          // that nobody takes: then the server is not told that they came
constexpr unsigned kProtocolError = 1002, kPolicy = 1008;

std::string random_id() {
  std::array<unsigned char, 16> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) throw ClientError("connection", "no random numbers");
  std::string text;
  for (const unsigned char byte : bytes) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x", byte);
    text += digits;
  }
  return text;
}

// What must be done once, and not be lost. Everything else is about this connection, or a question that can be put again.
bool is_command(const v1::ClientMessage& message) {
  switch (message.body_case()) {
    case v1::ClientMessage::kHello:
    case v1::ClientMessage::kViewport:
    case v1::ClientMessage::kInteraction:
    case v1::ClientMessage::kFrameAck:
    case v1::ClientMessage::kRequestStill:
    case v1::ClientMessage::kRequestHistogram:
    case v1::ClientMessage::kProbePoint:
    case v1::ClientMessage::kProbeLine:
    case v1::ClientMessage::kProbeSteps:
    case v1::ClientMessage::kRequestLayerStatistics:
    case v1::ClientMessage::kCancel:
    case v1::ClientMessage::kPing:
    case v1::ClientMessage::kDecoderFailed:
    case v1::ClientMessage::kListInvitations:
    case v1::ClientMessage::BODY_NOT_SET:
      return false;
    default:
      return true;
  }
}

// A word about the way there, which may be better in a moment; others are final.
bool may_pass(const ClientError& error) {
  return error.code() == "connection" || error.code() == "timeout" || error.code() == "closed" || error.code() == "unavailable";
}

}  // namespace

Connection::Connection(Options options)
    : options_(std::move(options)), address_(parse_address(options_)), client_id_(random_id()) {
  if (!options_.session.empty()) {
    const auto answer = boost::json::parse(http_get(options_, "api/v1/sessions/" + options_.session));
    const auto* token = answer.is_object() ? answer.as_object().if_contains("resumeToken") : nullptr;
    if (!token || !token->is_string()) throw ClientError("protocol", "the server's answer about a session has no resumeToken");
    options_.resume_token = token->as_string();
  }
  joined_ = !options_.resume_token.empty();
  const std::string wanted = options_.resume_token;
  open(Steady::now() + options_.timeout);
  const v1::Welcome& welcome = incoming_.front().welcome();
  if (!options_.session.empty() && welcome.session() != options_.session)
    throw ClientError("not_found", "session " + options_.session + " has ended just now");
  // One that an invitation opens is its maker's; a token that nobody knows any more has made a new one.
  joined_ = welcome.resume_token().empty() || (joined_ && welcome.resume_token() == wanted);
  session_ = welcome.session();
}

void Connection::open(Steady::time_point deadline) {
  socket_.reset();
  marks_.clear();
  numbers_.clear();
  last_wire_ = since_mark_ = 0;
  frames_waiting_ = 0;
  operation_ = 0;
  // Frames of the old connection are not acknowledged any more, and what it said of the state is older than Welcome.
  incoming_.clear();
  decoded_frame_ = 0;
  socket_ = std::make_unique<WebSocket>(address_, options_, deadline,
                                        [this](const void* data, std::size_t size) { arrived(data, size); });
  v1::ClientMessage message;
  v1::Hello& hello = *message.mutable_hello();
  hello.set_protocol_major(1);
  hello.set_client(options_.name);
  hello.set_client_id(client_id_);
  if (options_.width > 0) {
    hello.mutable_viewport()->set_width(static_cast<std::uint32_t>(options_.width));
    hello.mutable_viewport()->set_height(static_cast<std::uint32_t>(options_.height));
    hello.mutable_viewport()->set_hidden(options_.hidden);
  }
  if (options_.lossless_bands) hello.add_still_formats("png-bands");
  hello.add_still_formats("png");
  for (const std::string& format : options_.moving_formats) hello.add_moving_formats(format);
  hello.set_moving_format(options_.moving_format);
  hello.set_resume_token(options_.resume_token);
  write(message);
  wait_for_welcome(deadline);
  const v1::Welcome welcome = incoming_.front().welcome();
  if (!welcome.resume_token().empty()) options_.resume_token = welcome.resume_token();
  ++made_;
  // A session that sleeps since a restart has a state, and its dataset only in a moment: commands would wait, and questions be
  // refused.
  const auto told = [&] {
    return welcome.state().dataset().empty() || welcome.has_dataset_info() ||
           std::any_of(incoming_.begin(), incoming_.end(),
                       [](const v1::ServerMessage& m) { return m.has_dataset_info() || m.has_error(); });
  };
  while (!told()) {
    if (socket_->failed()) throw ClientError("closed", "the server ended the connection: " + why_lost());
    if (Steady::now() >= deadline) throw ClientError("timeout", "the session's dataset was not open in time");
    run(deadline);
  }
}

// Leaves Welcome as the first message.
void Connection::wait_for_welcome(Steady::time_point deadline) {
  while (incoming_.empty()) {
    if (socket_->failed()) throw ClientError("closed", "the server ended the connection: " + why_lost());
    if (Steady::now() >= deadline) throw ClientError("timeout", "the server did not answer Hello");
    run(deadline);
  }
  const v1::ServerMessage& first = incoming_.front();
  if (first.has_error()) {
    const v1::Error error = first.error();
    incoming_.clear();
    throw ClientError(error.code(), error.message(), error.field());
  }
  if (!first.has_welcome()) {
    incoming_.clear();
    throw ClientError("protocol", "the server's first message is not a Welcome");
  }
}

// One event, or the time; a stop is seen.
void Connection::run(Steady::time_point deadline) {
  if (options_.stop && *options_.stop) stop();
  const auto left = deadline - Steady::now();
  if (left <= Steady::duration::zero())
    socket_->poll();
  else
    socket_->run_for(options_.stop ? std::min<Steady::duration>(left, kStopPeriod) : left);
}

void Connection::stop() {
  if (operation_ != 0 && socket_) {
    v1::ClientMessage message;
    message.mutable_cancel()->set_operation(operation_);
    write(message);
    const auto end = Steady::now() + kStopPeriod;  // so that it leaves before the connection does
    while (Steady::now() < end) socket_->run_for(end - Steady::now());
  }
  throw ClientError("cancelled", "stopped");
}

void Connection::close() {
  if (!ended_) ended_ = {"closed", "the connection has been closed"};
  if (socket_) socket_->close();
}

// ---- sending
// -------------------------------------------------------------------------------------------------------------------

void Connection::write(v1::ClientMessage& message) {
  message.set_seq(++last_wire_);
  socket_->send(message.SerializeAsString());
}

void Connection::acknowledge(std::uint64_t frame) {
  v1::ClientMessage ack;
  ack.mutable_frame_ack()->set_frame_id(frame);
  if (decoded_frame_ != 0) {
    ack.mutable_frame_ack()->set_decoded_frame_id(std::exchange(decoded_frame_, 0));
    ack.mutable_frame_ack()->set_decoded_ms(decoded_ms_);
  }
  write(ack);
}

std::uint64_t Connection::send(v1::ClientMessage message) {
  if (ended_) throw ClientError(ended_->first, ended_->second);
  const std::uint64_t number = ++last_number_;
  if (message.has_interaction()) interacting_ = message.interaction().active();
  if (message.has_viewport()) {
    options_.width = static_cast<int>(message.viewport().width());
    options_.height = static_cast<int>(message.viewport().height());
    options_.hidden = message.viewport().hidden();
  }
  if (message.has_ping()) marks_.push_back({message.ping().client_time_ms(), number, false});
  if (marks_.size() > kMostLogged) marks_.pop_front();
  if (is_command(message)) {
    message.set_command(++last_command_);
    // A hand goes on turning while nobody is there; the server would read no more than a thousand of its cameras at once.
    if (lost() && message.has_set_camera() && !log_.empty() && !log_.back().judged && log_.back().message.has_set_camera())
      log_bytes_ -= log_.back().bytes, log_.pop_back();
    log_.push_back({number, last_command_, message, Steady::now(), message.ByteSizeLong()});
    log_bytes_ += log_.back().bytes;
    forget_old();
    ++since_mark_;
  }
  if (lost()) return number;  // whoever waits next finds that out, and commands are sent again
  write(message);
  numbers_.emplace_back(last_wire_, number);
  if (numbers_.size() > kMostNumbers) numbers_.pop_front();
  // Whoever only ever sends would have to be believed to have lost everything; an answer to this says what has come.
  if (since_mark_ >= kMarkEvery) {
    since_mark_ = 0;
    v1::ClientMessage ping;
    ping.mutable_ping()->set_client_time_ms(-static_cast<double>(number));
    marks_.push_back({ping.ping().client_time_ms(), number, true});
    write(ping);
  }
  socket_->poll();
  // Whoever says more than the server takes waits for it, and does not fill the memory.
  const auto give_up = Steady::now() + options_.timeout;
  while (!lost() && socket_->waiting_bytes() > kMostUnsentBytes) {
    if (Steady::now() >= give_up)
      throw ClientError("timeout", "the server has taken nothing for a while; what was sent waits still");
    run(give_up);
  }
  return number;
}

void Connection::forget_old() {
  const auto now = Steady::now();
  const auto is_old = [&](const Sent& sent) {
    if (log_.size() > kMostLogged || log_bytes_ > kMostLoggedBytes) return true;
    return sent.judged && (log_bytes_ > kMostJudgedBytes || now - sent.at > kKeepJudged);
  };
  while (!log_.empty() && is_old(log_.front())) {
    log_bytes_ -= log_.front().bytes;
    log_.pop_front();
  }
}

// ---- receiving
// -----------------------------------------------------------------------------------------------------------------

// Of the newest message up to this one: acknowledgements have numbers on the wire alone.
std::uint64_t Connection::own_number(std::uint64_t wire) const {
  const auto after = std::upper_bound(numbers_.begin(), numbers_.end(), wire,
                                      [](std::uint64_t value, const auto& entry) { return value < entry.first; });
  return after == numbers_.begin() ? contained_ : std::prev(after)->second;
}

// 0 if it is none of the caller's.
std::uint64_t Connection::exact_number(std::uint64_t wire) const {
  const auto at = std::lower_bound(numbers_.begin(), numbers_.end(), wire,
                                   [](const auto& entry, std::uint64_t value) { return entry.first < value; });
  return at != numbers_.end() && at->first == wire ? at->second : 0;
}

void Connection::judged_until(std::uint64_t number) {
  for (auto it = log_.begin(); it != log_.end() && it->number <= number; ++it) it->judged = true;
}

void Connection::arrived(const void* data, std::size_t size) {
  v1::ServerMessage message;
  if (!message.ParseFromArray(data, static_cast<int>(size))) return;
  note(message);
  if (message.has_pong()) {
    const auto mark = std::find_if(marks_.begin(), marks_.end(),
                                   [&](const Mark& m) { return m.client_time_ms == message.pong().client_time_ms(); });
    if (mark != marks_.end()) {
      const bool ours = mark->ours;
      judged_until(mark->number);
      marks_.erase(marks_.begin(), std::next(mark));  // they are answered in order
      if (ours) return;
    }
  }
  incoming_.push_back(std::move(message));
}

void Connection::note(v1::ServerMessage& message) {
  switch (message.body_case()) {
    case v1::ServerMessage::kWelcome:
      newest_state_ = message.welcome().state();
      break;
    case v1::ServerMessage::kState:
      newest_state_ = message.state();
      break;
    case v1::ServerMessage::kFrame: {
      v1::Frame& frame = *message.mutable_frame();
      frame.set_input_seq(own_number(frame.input_seq()));
      judged_until(frame.input_seq());
      // The picture has arrived: that is what the acknowledgement is to prove, so it is not kept back until someone looks.
      if (++frames_waiting_ <= kMostFramesWaiting) acknowledge(frame.frame_id());
      break;
    }
    case v1::ServerMessage::kError:
      if (message.error().in_reply_to() != 0)
        message.mutable_error()->set_in_reply_to(exact_number(message.error().in_reply_to()));
      last_words_ = message.error().message();
      break;
    case v1::ServerMessage::kProbeResult:
      message.mutable_probe_result()->set_in_reply_to(exact_number(message.probe_result().in_reply_to()));
      break;
    case v1::ServerMessage::kProbedCurve:
      message.mutable_probed_curve()->set_in_reply_to(exact_number(message.probed_curve().in_reply_to()));
      break;
    case v1::ServerMessage::kLayerStatistics:
      message.mutable_layer_statistics()->set_in_reply_to(exact_number(message.layer_statistics().in_reply_to()));
      break;
    case v1::ServerMessage::kShutdown:
      last_words_ = message.shutdown().reason();
      if (!message.shutdown().notice()) ends_for_good_ = !message.shutdown().comes_back();
      break;
    case v1::ServerMessage::kProgress:
      operation_ = message.progress().operation();
      break;
    case v1::ServerMessage::kDone:
      operation_ = 0;
      break;
    default:
      break;
  }
}

std::optional<v1::ServerMessage> Connection::receive_until(Steady::time_point deadline) {
  while (incoming_.empty()) {
    if (ended_) throw ClientError(ended_->first, ended_->second);
    if (lost()) {
      recover();
      continue;
    }
    const bool late = Steady::now() >= deadline;
    run(deadline);
    if (late && incoming_.empty() && !lost()) return std::nullopt;
  }
  v1::ServerMessage message = std::move(incoming_.front());
  incoming_.pop_front();
  if (message.has_frame() && frames_waiting_-- > kMostFramesWaiting) {
    // It was one too many; the oldest of those that were not acknowledged is now within the bound.
    std::size_t place = 0;
    for (const v1::ServerMessage& waiting : incoming_)
      if (waiting.has_frame() && ++place == kMostFramesWaiting) acknowledge(waiting.frame().frame_id());
  }
  return message;
}

void Connection::keep_until(Steady::time_point deadline) {
  while (Steady::now() < deadline) {
    if (ended_) throw ClientError(ended_->first, ended_->second);
    if (lost())
      recover();
    else
      run(deadline);
  }
}

// ---- coming back
// ---------------------------------------------------------------------------------------------------------------

// What was refused long ago is not a reason; what was said with a goodbye is.
std::string Connection::why_lost() const {
  if (!socket_) return "it could not be made";
  return socket_->close_code() != 0 && !last_words_.empty() ? last_words_ : socket_->why();
}

void Connection::give_up(const std::string& code, const std::string& why) {
  ended_ = {code, why};
  incoming_.clear();
  tell({ConnectionEvent::Kind::given_up, why});
  throw ClientError(code, why);
}

void Connection::recover() {
  const std::string why = why_lost();
  const unsigned goodbye = socket_ ? socket_->close_code() : 0;
  if (options_.reconnect_for.count() <= 0 || ends_for_good_ || goodbye == kPolicy || goodbye == kProtocolError) {
    ended_ = {"closed", "the server ended the connection: " + why};
    throw ClientError(ended_->first, ended_->second);
  }
  const v1::State known = newest_state_;
  tell({ConnectionEvent::Kind::lost, why});
  const auto end = Steady::now() + options_.reconnect_for;
  std::string last = why;
  for (auto pause = std::chrono::milliseconds(0);; pause = std::clamp(2 * pause, std::chrono::milliseconds(50), kLongestPause)) {
    const auto next = std::min(Steady::now() + pause, end);
    while (Steady::now() < next) {
      if (options_.stop && *options_.stop) throw ClientError("cancelled", "stopped");
      std::this_thread::sleep_for(std::min<Steady::duration>(next - Steady::now(), kStopPeriod));
    }
    if (Steady::now() >= end)
      give_up("closed", "the connection was lost (" + why + ") and could not be made again in " +
                            std::to_string(options_.reconnect_for.count() / 1000) + " s: " + last);
    try {
      last_words_.clear();
      open(std::min(end, Steady::now() + options_.timeout));
      const v1::Welcome welcome = incoming_.front().welcome();
      const bool same = welcome.session() == session_;
      if (!same) bring_state_back(welcome.session(), known);
      const std::size_t again = send_again(welcome, same, known.revision());
      wait_for_dataset(end);
      session_ = welcome.session();
      return tell({ConnectionEvent::Kind::restored, "", again, !same});
    } catch (const ClientError& error) {
      if (error.code() == "cancelled") throw;
      if (!may_pass(error)) give_up(error.code(), error.what());
      last = error.what();
    }
  }
}

// Nobody else is there, and what was shown here is known: a session begins with it.
void Connection::bring_state_back(const std::string& session, const v1::State& known) {
  if (joined_) give_up("session_lost", "the server came back without session " + session_);
  if (known.dataset().empty()) return;
  google::protobuf::util::JsonPrintOptions print;
  print.always_print_primitive_fields = true;
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(known, &text, print).ok())
    give_up("session_lost", "the state cannot be written as JSON");
  try {
    http_request(options_, "PUT", "api/v1/sessions/" + session + "/state", text);
  } catch (const ClientError& error) {
    if (may_pass(error) || error.code() == "cancelled") throw;
    give_up("session_lost", "the server came back without session " + session_ + ", and refuses what it showed: " + error.what());
  }
}

// Commands that follow a dataset wait for it in the server, and pings do not: where one was to be opened again, it is waited for.
void Connection::wait_for_dataset(Steady::time_point deadline) {
  std::string opening;
  for (const Sent& sent : log_)
    if (!sent.judged && sent.message.has_open_dataset()) opening = sent.message.open_dataset().id();
  const auto told = [&] {
    return opening.empty() || newest_state_.dataset() == opening ||
           std::any_of(incoming_.begin(), incoming_.end(), [](const v1::ServerMessage& m) { return m.has_error(); });
  };
  while (!told() && !socket_->failed() && Steady::now() < deadline) run(deadline);
  if (socket_->failed()) throw ClientError("closed", why_lost());
}

// Commands without a verdict; and, where the server has lost the last moments of what it kept, those too that it had done then.
std::size_t Connection::send_again(const v1::Welcome& welcome, bool same_session, std::uint64_t known_revision) {
  const bool lost_some = same_session && welcome.state().revision() < known_revision;
  if (same_session)
    for (Sent& sent : log_)
      if (!sent.judged && sent.command <= welcome.last_command()) sent.judged = true;
  contained_ = last_number_;
  std::size_t count = 0;
  for (Sent& sent : log_) {
    if (sent.judged && !(lost_some && sent.command > welcome.last_command())) continue;
    if (count++ == 0) contained_ = sent.number - 1;
    sent.judged = false;
    write(sent.message);
    numbers_.emplace_back(last_wire_, sent.number);
  }
  since_mark_ = count;
  if (interacting_) {
    v1::ClientMessage message;
    message.mutable_interaction()->set_active(true);
    write(message);
  }
  return count;
}

}  // namespace isostrata::client
