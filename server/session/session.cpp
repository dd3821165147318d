#include "session/session.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "engine/draw_scene.h"
#include "engine/transfer_function.h"
#include "session/limits.h"
#include "session/random_token.h"
#include "session/wire.h"

namespace isostrata {
namespace {

constexpr std::size_t kMaxDeferred = 256;
constexpr int kMaxHistograms = 16;
constexpr Duration kAnnounce = std::chrono::milliseconds(4);  // between cameras that are told on, where more come than that

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

bool same_picture(const FrameRequest& a, const FrameRequest& b) {
  if (a.video.has_value() != b.video.has_value()) return false;
  // Whoever needs a key frame cannot do with an ordinary one; the other way round is no loss.
  if (a.video && (a.video->stream != b.video->stream || (b.video->key && !a.video->key))) return false;
  return a.width == b.width && a.height == b.height && a.lossless == b.lossless && a.jpeg == b.jpeg &&
         a.jpeg_quality == b.jpeg_quality && a.band_bytes == b.band_bytes;
}

}  // namespace

v1::Error wire_error(const RequestFailed& failed) { return wire_error(to_string(failed.code), failed.message); }

Session::Session(SessionKey key, EngineDoor& engine)
    : key_(key),
      id_(random_token(64)),
      resume_token_(random_token(192)),
      resume_hashes_{secret_hash(resume_token_)},
      engine_(engine) {
  state_.scene.revision = 1;
}

Session::~Session() {
  if (opening_) engine_.forget(opening_->request);
  engine_.post(CloseSession{key_});
}

v1::State Session::wire_state() const { return asleep_ ? *asleep_ : to_wire(state_.scene); }

Viewer* Session::living(ViewerKey key) {
  const auto it = viewers_.find(key);
  return it == viewers_.end() ? nullptr : it->second;
}

void Session::attach(Viewer& viewer, TimePoint now) {
  viewers_[viewer.key] = &viewer;
  viewer.session = key_;
  last_use_ = now;
  viewer.frames.set_video(is_video(viewer.ladder.front()));
  viewer.frames.scene_changed(state_.scene.revision, drawable(), now);
}

void Session::detach(Viewer& viewer, TimePoint now) {
  announce(now);  // nobody may be there later to see to it
  leave_picture(viewer);
  for (auto& [request, picture] : pictures_) picture.takers.erase(viewer.key);
  streams_.leave(viewer.key, true);
  viewer.stream = 0;
  end_streams();
  viewers_.erase(viewer.key);
  viewer.session = 0;
  last_use_ = now;
  people_changed();
}

// Whoever has missed a frame, or begins anew, gets a stream of their own, which begins with a key frame.
void Session::begin_stream(Viewer& viewer, TimePoint now) {
  streams_.missed(viewer.key, now);
  viewer.stream = 0;
  end_streams();
  viewer.frames.scene_changed(state_.scene.revision, drawable(), now);  // the picture it did not get
}

void Session::end_streams() {
  for (const StreamId stream : streams_.take_ended()) engine_.post(CloseStream{key_, stream});
}

void Session::step_down(Viewer& viewer, TimePoint now) {
  if (viewer.ladder.size() > 1) viewer.ladder.erase(viewer.ladder.begin());
  viewer.frames.set_video(is_video(viewer.ladder.front()));
  begin_stream(viewer, now);
}

void Session::broadcast(const v1::ServerMessage& message) {
  for (auto& [key, viewer] : viewers_) viewer->outbox->send(message);
}

void Session::changed(TimePoint now, bool soon) {
  unannounced_ = true;
  if (!soon || now - announced_ >= kAnnounce) announce(now);
  for (auto& [key, viewer] : viewers_) {
    viewer->frames.scene_changed(state_.scene.revision, drawable(), now);
    viewer->bands.clear();
  }
  engine_.session_changed(*this);
  pump(now);
}

// Thousands of cameras a second would be copied to everyone, and nobody sees them.
void Session::announce(TimePoint now) {
  if (!unannounced_) return;
  unannounced_ = false;
  announced_ = now;
  engine_.post(SceneUpdate{key_, drawn_scene(state_.scene)});
  const v1::State state = wire_state();
  for (auto& [key, viewer] : viewers_) viewer->outbox->send_state(state);
}

void Session::receive(Viewer& viewer, const v1::ClientMessage& message, TimePoint now) {
  last_use_ = now;
  const ViewerKey key = viewer.key;
  const std::uint64_t seq = message.seq();
  // An answer never overtakes the change that it answers.
  if (!message.has_set_camera() && !message.has_frame_ack()) announce(now);
  const Reply reply = [this, key, seq](std::optional<v1::Error> error) {
    Viewer* to = living(key);
    if (to && error) send_error(*to, seq, std::move(*error));
  };
  if (message.body_case() != v1::ClientMessage::kRequestStill && done_before(viewer, message))
    return;  // a picture may be asked for again
  if (forbidden(viewer, message))
    return reply(wire_error("forbidden", "this connection may only look; a controller of the session changes what is shown"));
  if (answer_people(viewer, message, reply)) return;
  if (is_scene_command(message)) return command(message, &viewer, now, reply);
  switch (message.body_case()) {
    case v1::ClientMessage::kOpenDataset:
      return open(message.open_dataset().id(), &viewer, now, reply);
    case v1::ClientMessage::kViewport: {
      const v1::Viewport& viewport = message.viewport();
      if (auto error = check_size(viewport.width(), viewport.height())) return reply(std::move(error));
      viewer.frames.set_viewport(static_cast<int>(viewport.width()), static_cast<int>(viewport.height()), viewport.hidden(), now);
      if (!viewer.bands.empty() &&
          (viewer.bands.front().frame.width() != viewport.width() || viewer.bands.front().frame.height() != viewport.height()))
        viewer.bands.clear();
      return pump(viewer, now);
    }
    case v1::ClientMessage::kInteraction:
      viewer.frames.set_interaction(message.interaction().active(), now);
      return pump(viewer, now);
    case v1::ClientMessage::kFrameAck: {
      const double decode_ms = message.frame_ack().decode_ms();  // may be anything; what is too much is not believed
      const double believed = decode_ms > 0 && decode_ms < 60000 ? decode_ms : 0;
      viewer.frames.acknowledged(message.frame_ack().frame_id(), now,
                                 std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(believed)));
      return pump(viewer, now);
    }
    case v1::ClientMessage::kDecoderFailed: {
      const v1::DecoderFailed& failed = message.decoder_failed();
      if (failed.stream_id() == 0 || failed.stream_id() != viewer.stream) return;  // of a stream that has ended
      if (!failed.again()) {
        step_down(viewer, now);
      } else {
        begin_stream(viewer, now);
      }
      return pump(viewer, now);
    }
    case v1::ClientMessage::kRequestStill: {
      if (waking())
        return after_waking([this, key, message](TimePoint then) {
          if (Viewer* to = living(key)) receive(*to, message, then);
        });
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
  if (asleep_)
    return reply(wire_error("unavailable", "dataset '" + asleep_->dataset() + "' of this session could not be opened again"));
  if (auto error = unexpected(expected)) return reply(std::move(error));
  CommandOutcome outcome = apply_command(state_, message, context(viewer));
  if (!outcome.error && viewer) viewer->note_input(message.seq(), state_.scene.revision);
  if (outcome.changed) changed(now, viewer && message.has_set_camera());
  if (outcome.error) announce(now);
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
    if (asleep_ && asleep_->dataset() == dataset_->id) {
      woken(*dataset_, now);
      opening.reply(std::nullopt);
      return run_deferred(now);
    }
    asleep_.reset();
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
  announce(now);
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
  if (now - announced_ >= kAnnounce) announce(now);
  play_cycle(now);
  for (auto& [key, viewer] : viewers_) pump(*viewer, now);
}

void Session::send_bands(Viewer& viewer, TimePoint now) {
  while (!viewer.bands.empty() && viewer.frames.next_band_at(now) <= now) {
    Viewer::Band& band = viewer.bands.front();
    band.frame.set_frame_id(viewer.frames.sent_band(band.payload->size(), now));
    viewer.outbox->send_frame(std::move(band.frame), std::move(band.payload));
    viewer.bands.pop_front();
  }
}

void Session::leave_picture(Viewer& viewer) {
  const auto it = pictures_.find(std::exchange(viewer.ordered_request, 0));
  if (it == pictures_.end()) return;
  it->second.takers.erase(viewer.key);
  if (!it->second.takers.empty()) return;
  engine_.post(ForgetFrame{key_, it->first});
  engine_.forget(it->first);
  pictures_.erase(it);
}

void Session::pump(Viewer& viewer, TimePoint now) {
  send_bands(viewer, now);
  if (viewer.frames.withdraw_order()) leave_picture(viewer);
  const auto order = viewer.frames.next(now);
  if (!order) return;
  announce(now);
  FrameRequest request{key_, 0, order->width, order->height, order->lossless, !order->lossless, order->quality};
  // A settled frame is a picture by itself, as good as pictures get that are not lossless.
  if (order->phase == FramePhase::moving && is_video(viewer.ladder.front())) {
    const auto choice = streams_.choose(viewer.key, viewer.ladder.front(), order->width, order->height, now);
    viewer.stream = choice.stream;
    end_streams();
    request.video = VideoOrder{viewer.ladder.front(), choice.stream, order->bitrate_kbps, choice.key};
  }
  if (order->lossless && !order->whole && viewer.takes_bands) request.band_bytes = viewer.frames.band_bytes(now);
  // One that is not being drawn yet will show the newest scene, and so will one that was asked for after the newest change.
  for (auto& [id, picture] : pictures_) {
    if ((picture.started && picture.revision != state_.scene.revision) || !same_picture(picture.request, request) ||
        picture.takers.contains(viewer.key))
      continue;
    picture.takers[viewer.key] = *order;
    if (picture.started)
      viewer.frames.started();
    else
      viewer.ordered_request = id;
    return;
  }
  // The listener learns its own number from the shared slot: it is called only later, from the io thread's loop.
  auto number = std::make_shared<RequestId>(0);
  *number =
      engine_.ask(request, [this, number](const EngineEvent& event, TimePoint then) { on_picture_event(*number, event, then); });
  pictures_[*number] = {request, state_.scene.revision, false, {{viewer.key, *order}}};
  viewer.ordered_request = *number;
}

void Session::give(Viewer& viewer, const FrameOrder& order, const FrameReady& ready, TimePoint now) {
  v1::Frame frame = to_wire(ready);
  std::shared_ptr<const Bytes> payload = ready.bytes;
  viewer.bands.clear();
  if (ready.bands) {
    v1::Frame next = frame;
    next.clear_facts();
    for (std::size_t i = 0; i < ready.bands->size(); ++i) {
      const PngBand& band = (*ready.bands)[i];
      const std::shared_ptr<const Bytes> bytes(ready.bands, &band.bytes);  // all viewers' pieces are these
      v1::Frame& piece = i == 0 ? frame : viewer.bands.emplace_back(Viewer::Band{next, bytes}).frame;
      if (i == 0) payload = bytes;
      piece.mutable_band()->set_first_row(static_cast<std::uint32_t>(band.first_row));
      piece.mutable_band()->set_rows(static_cast<std::uint32_t>(band.rows));
      piece.mutable_band()->set_index(static_cast<std::uint32_t>(i));
      piece.mutable_band()->set_count(static_cast<std::uint32_t>(ready.bands->size()));
      piece.set_input_seq(viewer.input_of(ready.revision));
    }
  }
  if (order.phase == FramePhase::settled) frame.set_phase(v1::FRAME_PHASE_SETTLED);
  frame.set_frame_id(viewer.frames.sent(order, ready.revision, payload->size(), now));
  frame.set_input_seq(viewer.input_of(ready.revision));
  viewer.outbox->send_frame(std::move(frame), std::move(payload));
}

void Session::on_picture_event(RequestId request, const EngineEvent& event, TimePoint now) {
  const auto it = pictures_.find(request);
  if (it == pictures_.end()) return;
  const auto each_taker = [&](const Picture& picture, const auto& act) {
    for (const auto& [key, order] : picture.takers)
      if (Viewer* viewer = living(key)) act(*viewer, order);
  };
  if (std::holds_alternative<FrameStarted>(event)) {
    it->second.started = true;
    each_taker(it->second, [](Viewer& viewer, const FrameOrder&) {
      viewer.ordered_request = 0;
      viewer.frames.started();
    });
    return pump(now);
  }
  const Picture picture = std::move(it->second);
  pictures_.erase(it);
  if (!picture.started) each_taker(picture, [](Viewer& viewer, const FrameOrder&) { viewer.ordered_request = 0; });
  if (const auto* ready = std::get_if<FrameReady>(&event)) {
    std::vector<ViewerKey> of_stream;
    if (ready->video) of_stream = streams_.takers(ready->video->stream, ready->video->key);
    const auto in_stream = [&](ViewerKey key) { return std::find(of_stream.begin(), of_stream.end(), key) != of_stream.end(); };
    each_taker(picture, [&](Viewer& viewer, const FrameOrder& order) {
      if (ready->video && !in_stream(viewer.key))
        viewer.frames.failed(picture.started);  // it was being drawn when the viewer left its stream
      else
        give(viewer, order, *ready, now);
    });
    // The stream's next frame is of use only to whoever has this one.
    for (const ViewerKey key : of_stream) {
      Viewer* viewer = living(key);
      if (!viewer || picture.takers.empty() || picture.takers.contains(key)) continue;
      if (viewer->frames.visible() && viewer->frames.in_flight() < viewer->frames.window() && !viewer->frames.stalled(now))
        give(*viewer, picture.takers.begin()->second, *ready, now);
      else
        begin_stream(*viewer, now);
    }
  } else if (const auto* failed = std::get_if<RequestFailed>(&event)) {
    each_taker(picture, [&](Viewer& viewer, const FrameOrder&) {
      viewer.frames.failed(picture.started);
      // One that had begun failed in drawing; the others failed with their extraction, which everyone has been told of.
      if (picture.started && !failed->encoder_failed && failed->code != ErrorCode::cancelled)
        send_error(viewer, 0, wire_error(*failed));
    });
    if (failed->encoder_failed && picture.request.video)
      for (const ViewerKey key : streams_.members(picture.request.video->stream))
        if (Viewer* viewer = living(key)) step_down(*viewer, now);
  }
  pump(now);
}

std::optional<TimePoint> Session::wake_at(TimePoint now) const {
  std::optional<TimePoint> earliest;
  if (watched()) earliest = next_phase_;
  if (unannounced_) earliest = earliest ? std::min(*earliest, announced_ + kAnnounce) : announced_ + kAnnounce;
  for (const auto& [key, viewer] : viewers_) {
    if (const auto at = viewer->frames.wake_at(now); at && (!earliest || *at < *earliest)) earliest = at;
    if (viewer->bands.empty()) continue;
    if (const TimePoint at = viewer->frames.next_band_at(now); at != TimePoint::max() && (!earliest || at < *earliest))
      earliest = at;
  }
  return earliest;
}

}  // namespace isostrata
