#include "session/session.h"

#include <algorithm>
#include <utility>

#include "engine/draw_scene.h"

#include "session/limits.h"
#include "session/random_token.h"
#include "session/wire.h"

namespace isostrata {
namespace {

constexpr std::size_t kMaxDeferred = 256;
constexpr int kMaxHistograms = 16;
constexpr int kMovingJpegQuality = 90;

void send_error(Viewer& viewer, std::uint64_t seq, v1::Error error) {
  v1::ServerMessage message;
  error.set_in_reply_to(seq);
  *message.mutable_error() = std::move(error);
  viewer.outbox->send(std::move(message));
}

v1::ServerMessage dataset_message(const DatasetFacts& facts) {
  v1::ServerMessage message;
  *message.mutable_dataset_info() = to_wire(facts);
  return message;
}

}  // namespace

v1::Error wire_error(const RequestFailed& failed) { return wire_error(to_string(failed.code), failed.message); }

Session::Session(SessionKey key, EngineDoor& engine)
    : key_(key), id_(random_token(64)), resume_token_(random_token(192)), engine_(engine) {
  state_.scene.revision = 1;
}

Session::~Session() {
  if (opening_) engine_.forget(opening_->request);
  engine_.post(CloseSession{key_});
}

v1::State Session::wire_state() const { return to_wire(state_.scene); }

Viewer* Session::living(ViewerKey key) {
  const auto it = viewers_.find(key);
  return it == viewers_.end() ? nullptr : it->second;
}

void Session::attach(Viewer& viewer, TimePoint now) {
  viewers_[viewer.key] = &viewer;
  viewer.session = key_;
  last_use_ = now;
  viewer.frames.scene_changed(state_.scene.revision, !state_.scene.dataset.empty(), now);
}

void Session::detach(Viewer& viewer, TimePoint now) {
  if (viewer.ordered_request != 0) {
    engine_.post(ForgetFrame{key_, viewer.ordered_request});
    engine_.forget(viewer.ordered_request);
  }
  viewers_.erase(viewer.key);
  viewer.session = 0;
  last_use_ = now;
}

void Session::broadcast(const v1::ServerMessage& message) {
  for (auto& [key, viewer] : viewers_) viewer->outbox->send(message);
}

void Session::changed(TimePoint now) {
  engine_.post(SceneUpdate{key_, state_.scene});
  const v1::State state = wire_state();
  for (auto& [key, viewer] : viewers_) {
    viewer->frames.scene_changed(state_.scene.revision, !state_.scene.dataset.empty(), now);
    viewer->outbox->send_state(state);
  }
  pump(now);
}

void Session::receive(Viewer& viewer, const v1::ClientMessage& message, TimePoint now) {
  last_use_ = now;
  const ViewerKey key = viewer.key;
  const std::uint64_t seq = message.seq();
  const Reply reply = [this, key, seq](std::optional<v1::Error> error) {
    Viewer* to = living(key);
    if (to && error) send_error(*to, seq, std::move(*error));
  };
  if (is_scene_command(message)) return command(message, &viewer, now, reply);
  switch (message.body_case()) {
    case v1::ClientMessage::kOpenDataset:
      return open(message.open_dataset().id(), &viewer, now, reply);
    case v1::ClientMessage::kViewport: {
      const v1::Viewport& viewport = message.viewport();
      if (auto error = check_size(viewport.width(), viewport.height())) return reply(std::move(error));
      viewer.frames.set_viewport(static_cast<int>(viewport.width()), static_cast<int>(viewport.height()), viewport.hidden(), now);
      return pump(viewer, now);
    }
    case v1::ClientMessage::kInteraction:
      viewer.frames.set_interaction(message.interaction().active(), now);
      return pump(viewer, now);
    case v1::ClientMessage::kFrameAck:
      viewer.frames.acknowledged(message.frame_ack().frame_id(), now);
      return pump(viewer, now);
    case v1::ClientMessage::kRequestStill: {
      const v1::RequestStill& still = message.request_still();
      if (state_.scene.dataset.empty()) return reply(wire_error("not_found", "no dataset is open; open one first"));
      if (still.width() != 0 || still.height() != 0)
        if (auto error = check_size(still.width(), still.height())) return reply(std::move(error));
      viewer.frames.request_still(static_cast<int>(still.width()), static_cast<int>(still.height()));
      return pump(viewer, now);
    }
    case v1::ClientMessage::kRequestHistogram:
      return send_histogram(viewer, message);
    case v1::ClientMessage::kCancel:
      return engine_.post(CancelRequest{key_, message.cancel().operation(), 0});
    case v1::ClientMessage::kPing: {
      v1::ServerMessage pong;
      pong.mutable_pong()->set_client_time_ms(message.ping().client_time_ms());
      return viewer.outbox->send(std::move(pong));
    }
    case v1::ClientMessage::kHello:
      return reply(wire_error("invalid_argument", "hello was said already; it is the first message only"));
    default:
      ++viewer.ignored_messages;  // of a newer minor version
  }
}

void Session::send_histogram(Viewer& viewer, const v1::ClientMessage& message) {
  const std::uint64_t seq = message.seq();
  const v1::RequestHistogram& wanted = message.request_histogram();
  if (opening_) {
    // It means the dataset that the viewer has asked for.
    if (deferred_.size() >= kMaxDeferred)
      return send_error(viewer, seq, wire_error("unavailable", "too many commands wait for the dataset"));
    deferred_.push_back([this, key = viewer.key, message](TimePoint) {
      if (Viewer* to = living(key)) send_histogram(*to, message);
    });
    return;
  }
  if (auto error = check_histogram(wanted, context())) return send_error(viewer, seq, std::move(*error));
  if (histograms_ >= kMaxHistograms)
    return send_error(
        viewer, seq,
        wire_error("unavailable", std::to_string(kMaxHistograms) + " histograms are being counted; ask again later"));
  ++histograms_;
  HistogramRequest request{key_, 0, state_.scene.dataset, state_.scene.step, wanted.array(), static_cast<int>(wanted.bins())};
  engine_.ask(std::move(request), [this, key = viewer.key, seq](const EngineEvent& event, TimePoint) {
    --histograms_;
    Viewer* to = living(key);
    if (!to) return;
    if (const auto* failed = std::get_if<RequestFailed>(&event)) return send_error(*to, seq, wire_error(*failed));
    if (const auto* ready = std::get_if<HistogramReady>(&event)) {
      v1::ServerMessage answer;
      *answer.mutable_histogram() = to_wire(*ready);
      to->outbox->send(std::move(answer));
    }
  });
}

std::optional<v1::Error> Session::unexpected(std::optional<std::uint64_t> expected) const {
  if (!expected || *expected == state_.scene.revision) return std::nullopt;
  return wire_error("precondition_failed",
                    "the state is at revision " + std::to_string(state_.scene.revision) + ", not " + std::to_string(*expected),
                    "If-Match");
}

void Session::command(const v1::ClientMessage& message, Viewer* viewer, TimePoint now, Reply reply,
                      std::optional<std::uint64_t> expected) {
  last_use_ = now;
  if (opening_) {
    if (deferred_.size() >= kMaxDeferred)
      return reply(wire_error("unavailable", std::to_string(kMaxDeferred) + " commands wait for the dataset already"));
    deferred_.push_back([this, message, key = viewer ? viewer->key : 0, expected, reply = std::move(reply)](TimePoint then) {
      command(message, living(key), then, reply, expected);
    });
    return;
  }
  if (auto error = unexpected(expected)) return reply(std::move(error));
  CommandOutcome outcome = apply_command(state_, message, context(viewer));
  if (!outcome.error && viewer) viewer->note_input(message.seq(), state_.scene.revision);
  if (outcome.changed) changed(now);
  reply(std::move(outcome.error));
}

void Session::open(const std::string& id, Viewer* viewer, TimePoint now, Reply reply) {
  last_use_ = now;
  if (id.empty() || id.size() > kMaxNameBytes) return reply(wire_error("invalid_argument", "a dataset's id is expected", "id"));
  if (opening_ && opening_->dataset == id) {
    opening_->viewer = viewer ? viewer->key : opening_->viewer;
    opening_->seq = viewer ? viewer->last_seq : opening_->seq;
    opening_->reply = [first = std::move(opening_->reply), second = std::move(reply)](std::optional<v1::Error> error) {
      first(error);
      second(std::move(error));
    };
    return;
  }
  if (!opening_ && dataset_ && state_.scene.dataset == id) {
    if (viewer) {
      viewer->note_input(viewer->last_seq, state_.scene.revision);
      viewer->outbox->send(dataset_message(*dataset_));
      viewer->outbox->send_state(wire_state());
    }
    return reply(std::nullopt);
  }
  if (opening_) {
    engine_.post(CancelRequest{key_, 0, opening_->request});
    engine_.forget(opening_->request);
    Opening given_up = std::move(*opening_);
    opening_.reset();
    given_up.reply(wire_error("cancelled", "another dataset was asked for"));
    // What was said in between was meant for a dataset that never came; it is judged by the one that is open now.
    run_deferred(now);
  }
  Opening opening{0, id, viewer ? viewer->key : 0, viewer ? viewer->last_seq : 0, std::move(reply)};
  opening.request =
      engine_.ask(OpenRequest{key_, 0, id}, [this](const EngineEvent& event, TimePoint then) { opened(event, then); });
  opening_ = std::move(opening);
}

void Session::opened(const EngineEvent& event, TimePoint now) {
  if (!opening_) return;
  Opening opening = std::move(*opening_);
  opening_.reset();
  last_use_ = now;
  if (const auto* failed = std::get_if<RequestFailed>(&event)) {
    opening.reply(wire_error(*failed));
  } else if (const auto* ready = std::get_if<DatasetReady>(&event)) {
    dataset_ = std::make_shared<const DatasetFacts>(ready->facts);
    const Viewer* asker = living(opening.viewer);
    open_in_scene(state_, *dataset_, asker ? asker->frames.aspect() : 1);
    if (Viewer* viewer = living(opening.viewer)) viewer->note_input(opening.seq, state_.scene.revision);
    broadcast(dataset_message(*dataset_));
    changed(now);
    opening.reply(std::nullopt);
  }
  run_deferred(now);
}

void Session::run_deferred(TimePoint now) {
  while (!opening_ && !deferred_.empty()) {
    const auto next = std::move(deferred_.front());
    deferred_.pop_front();
    next(now);
  }
}

void Session::set_state(const v1::State& wanted, TimePoint now, Reply reply, std::optional<std::uint64_t> expected) {
  if (auto error = unexpected(expected)) return reply(std::move(error));
  if (!wanted.dataset().empty() && (opening_ || wanted.dataset() != state_.scene.dataset)) {
    // A state that would be refused leaves the newly opened dataset behind: it can be judged only by its arrays.
    return open(wanted.dataset(), nullptr, now, [this, wanted, reply = std::move(reply)](std::optional<v1::Error> error) {
      if (error) return reply(std::move(error));
      set_state(wanted, last_use_, reply);
    });
  }
  last_use_ = now;
  CommandOutcome outcome = apply_state(state_, wanted, context());
  if (outcome.changed) changed(now);
  reply(std::move(outcome.error));
}

RequestId Session::picture(int width, int height, StillFormat format, EngineDoor::Listener listener, TimePoint now) {
  last_use_ = now;
  FrameRequest request{key_, 0, width, height, true, format == StillFormat::jpeg};
  request.still = format;
  return engine_.ask(std::move(request), std::move(listener));
}

void Session::on_event(const EngineEvent& event, TimePoint now) {
  v1::ServerMessage message;
  if (const auto* progress = std::get_if<OperationProgress>(&event)) {
    message.mutable_progress()->set_operation(progress->operation);
    message.mutable_progress()->set_stage(progress->stage);
    message.mutable_progress()->set_fraction(progress->fraction);
  } else if (const auto* done = std::get_if<OperationDone>(&event)) {
    message.mutable_done()->set_operation(done->operation);
    message.mutable_done()->set_cancelled(done->cancelled);
  } else if (const auto* failed = std::get_if<RequestFailed>(&event)) {
    *message.mutable_error() = wire_error(*failed);
  } else {
    return;
  }
  broadcast(message);
  pump(now);
}

// The phase follows the clock and not the frames: a viewer who is slow misses intervals, and the next picture is of now.
void Session::play_cycle(TimePoint now) {
  const Scene& scene = state_.scene;
  const bool seen = std::any_of(viewers_.begin(), viewers_.end(), [](const auto& of) { return of.second->frames.visible(); });
  if (scene.mode != SceneMode::cycled || !scene.cycle.playing || !seen || scene.dataset.empty() || cycle_length(scene) < 2) {
    next_phase_.reset();
    return;
  }
  const auto period = std::chrono::duration_cast<Duration>(std::chrono::duration<double>(scene.cycle.seconds));
  if (!next_phase_ || *next_phase_ > now + period) next_phase_ = now + period;  // it began, or became faster
  if (now < *next_phase_) return;
  const std::int64_t steps = 1 + (now - *next_phase_) / period;
  *next_phase_ += steps * period;
  if (advance_cycle(state_, steps)) changed(now);
}

void Session::pump(TimePoint now) {
  play_cycle(now);
  for (auto& [key, viewer] : viewers_) pump(*viewer, now);
}

void Session::pump(Viewer& viewer, TimePoint now) {
  if (viewer.frames.withdraw_order()) {
    engine_.post(ForgetFrame{key_, viewer.ordered_request});
    engine_.forget(viewer.ordered_request);
    viewer.ordered_request = 0;
  }
  const auto order = viewer.frames.next(now);
  if (!order) return;
  FrameRequest request{key_, 0, order->width, order->height, order->lossless, !order->lossless, kMovingJpegQuality};
  // The listener learns its own number from the shared slot: it is called only later, from the io thread's loop.
  auto number = std::make_shared<RequestId>(0);
  *number = engine_.ask(std::move(request),
                        [this, key = viewer.key, number, had_started = false](const EngineEvent& event, TimePoint then) mutable {
                          on_frame_event(key, *number, had_started, event, then);
                        });
  viewer.ordered_request = *number;
}

void Session::on_frame_event(ViewerKey key, RequestId request, bool& had_started, const EngineEvent& event, TimePoint now) {
  Viewer* viewer = living(key);
  if (!viewer) return;
  if (std::holds_alternative<FrameStarted>(event)) {
    had_started = true;
    if (viewer->ordered_request == request) viewer->ordered_request = 0;
    viewer->frames.started();
  } else if (const auto* ready = std::get_if<FrameReady>(&event)) {
    v1::Frame frame = to_wire(*ready);
    frame.set_frame_id(viewer->frames.sent(ready->revision, ready->lossless, now));
    frame.set_input_seq(viewer->input_of(ready->revision));
    viewer->outbox->send_frame(std::move(frame));
  } else if (const auto* failed = std::get_if<RequestFailed>(&event)) {
    if (viewer->ordered_request == request) viewer->ordered_request = 0;
    viewer->frames.failed(had_started);
    // One that had begun failed in drawing; the others failed with their extraction, which everyone has been told of.
    if (had_started) send_error(*viewer, 0, wire_error(*failed));
  }
  pump(*viewer, now);
}

std::optional<TimePoint> Session::wake_at(TimePoint now) const {
  std::optional<TimePoint> earliest;
  if (watched()) earliest = next_phase_;
  for (const auto& [key, viewer] : viewers_)
    if (const auto at = viewer->frames.wake_at(now); at && (!earliest || *at < *earliest)) earliest = at;
  return earliest;
}

}  // namespace isostrata
