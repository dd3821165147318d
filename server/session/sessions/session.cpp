#include "session/sessions/session.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/utf8.h"
#include "engine/picture/layer_request.h"
#include "engine/picture/scene_styles.h"
#include "scene/color_range.h"
#include "scene/transfer_function.h"
#include "session/wire/limits.h"
#include "session/wire/random_token.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

constexpr std::size_t kMaxDeferred = 256;
constexpr int kMaxHistograms = 16;
constexpr Duration kAnnounce = std::chrono::milliseconds(4);  // between cameras that are told on, where more come than that

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

Session::Holds Session::holds() const {
  if ((worked_on_ || !invitations_.all().empty()) && !left_) return Holds::work;
  return state_.scene.dataset.empty() && !opening_ ? Holds::nothing : Holds::look;
}

void Session::note_left(bool goodbye) {
  vanished_ = vanished_ || !goodbye;
  const bool left = !watched() && !vanished_;
  if (left == left_) return;
  left_ = left;
  engine_.session_changed(*this, false);
}

Viewer* Session::living(ViewerKey key) {
  const auto it = viewers_.find(key);
  return it == viewers_.end() ? nullptr : it->second;
}

void Session::attach(Viewer& viewer, TimePoint now) {
  viewers_[viewer.key] = &viewer;
  vanished_ = false;
  if (std::exchange(left_, false)) engine_.session_changed(*this, false);
  viewer.session = key_;
  last_use_ = now;
  viewer.frames.set_codec(viewer.codec());
  viewer.frames.scene_changed(state_.scene.revision, drawable(), now);
}

void Session::set_viewport(Viewer& viewer, const v1::Viewport& viewport, TimePoint now) {
  viewer.viewport = viewport;
  auto width = static_cast<int>(viewport.width()), height = static_cast<int>(viewport.height());
  const double pixels = static_cast<double>(width) * height;
  if (viewer.role == v1::ROLE_VIEWER && pixels > kMaxViewerPixels) {
    const double scale = std::sqrt(kMaxViewerPixels / pixels);
    const auto scaled = [&](int side, int other) {
      return std::clamp(static_cast<int>(side * scale), 1,
                        static_cast<int>(kMaxViewerPixels / std::max(1, static_cast<int>(other * scale))));
    };
    const int wide = scaled(width, height);
    height = scaled(height, width);
    width = wide;
  }
  viewer.frames.set_viewport(width, height, viewport.hidden(), now);
}

std::optional<v1::Error> Session::refuse_still(Viewer& viewer, const v1::RequestStill& still, TimePoint now) {
  if (viewer.role != v1::ROLE_VIEWER) return std::nullopt;
  const auto pixels = static_cast<std::int64_t>(still.width()) * still.height();
  if (pixels > kMaxViewerPixels)
    return wire_error("too_large",
                      std::to_string(still.width()) + "x" + std::to_string(still.height()) + " pixels; expected at most " +
                          std::to_string(kMaxViewerPixels) + " for who may only look",
                      "width");
  if (const Duration wait = viewer.stills.wait(now); wait > Duration::zero())
    return wire_error("unavailable", "who may only look gets a still every " +
                                         std::to_string(static_cast<int>(1 / kViewerStillsPerSecond)) + " s; ask again in " +
                                         std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(wait).count()) +
                                         " ms");
  viewer.stills.take(1);
  return std::nullopt;
}

void Session::detach(Viewer& viewer, TimePoint now) {
  announce(now);  // nobody may be there later to see to it
  leave_picture(viewer);
  for (const RequestId request : std::exchange(viewer.keepsakes, {})) {
    engine_.post(ForgetFrame{key_, request});
    engine_.forget(request);
  }
  for (auto it = pictures_.begin(); it != pictures_.end();) {
    const bool was_taker = it->second.takers.erase(viewer.key) > 0;
    if (!was_taker || !it->second.takers.empty() || it->second.request.video) {  // every frame of a stream has to come
      ++it;
      continue;
    }
    engine_.post(ForgetFrame{key_, it->first});
    engine_.forget(it->first);
    it = pictures_.erase(it);
  }
  streams_.leave(viewer.key, true);
  viewer.stream = 0;
  end_streams();
  viewers_.erase(viewer.key);
  if (viewers_.empty()) made_.clear();
  viewer.session = 0;
  last_use_ = now;
  people_changed();
}

void Session::broadcast(const v1::ServerMessage& message) {
  for (auto& [key, viewer] : viewers_) viewer->outbox->send(message);
}

void Session::changed(TimePoint now, Cause cause) {
  engine_.session_changed(*this, cause == Cause::command);
  unannounced_ = true;
  if (cause != Cause::camera || now - announced_ >= kAnnounce) announce(now);
  made_.clear();
  for (auto& [key, viewer] : viewers_) {
    viewer->frames.scene_changed(state_.scene.revision, drawable(), now);
    viewer->bands.clear();
  }
  pump(now);
}

Scene Session::drawn() const {
  Scene scene = drawn_scene(state_.scene);
  const ArrayFacts* array = dataset_ ? dataset_->find_array(scene.color_by.empty() ? scene.array : scene.color_by) : nullptr;
  if (!scene.dataset.empty() && !shown_.empty()) scene.dataset = shown_;
  scene.color_range = resolved(scene.color_range, array ? array->lower : 1, array ? array->upper : 0);
  return scene;
}

// Thousands of cameras a second would be copied to everyone, and nobody sees them.
void Session::announce(TimePoint now) {
  if (!unannounced_) return;
  unannounced_ = false;
  announced_ = now;
  Scene scene = drawn();
  if (!costs_.extracts && !same_extraction(told_, scene)) {
    costs_.extracts = true;
    for (auto& [key, viewer] : viewers_) viewer->chosen_at = {};  // the gesture begins with a size that is in time with cutting layers
  }
  told_ = scene;
  engine_.post(SceneUpdate{key_, std::move(scene)});
  const v1::State state = wire_state();
  for (auto& [key, viewer] : viewers_) viewer->outbox->send_state(state, viewer->heeded);
  engine_.state_told(*this);
}

void Session::receive(Viewer& viewer, const v1::ClientMessage& message, TimePoint now) {
  last_use_ = now;
  const ViewerKey key = viewer.key;
  const std::uint64_t seq = message.seq();
  // An answer never overtakes the change that it answers.
  if (!message.has_set_camera() && !message.has_frame_ack()) announce(now);
  const Reply reply = [this, key, seq, client = viewer.client_id, command = message.command()](std::optional<v1::Error> error) {
    if (!error) return;
    if (command != 0) note_refused(client, command, *error);
    // An answer that was long in coming follows its client to a newer connection, where the number means nothing.
    if (Viewer* to = living(key))
      to->outbox->send(error_message(std::move(*error), seq));
    else if (Viewer* again = back_again(client))
      again->outbox->send(error_message(std::move(*error)));
  };
  if (message.body_case() != v1::ClientMessage::kRequestStill &&
      done_before(viewer, message)) {  // a picture may be asked for again
    viewer.heeded = std::max(viewer.heeded, seq);
    return viewer.outbox->send_state(wire_state(), viewer.heeded);
  }
  if (const auto why = forbidden(viewer, message)) return reply(wire_error("forbidden", *why));
  if (answer_people(viewer, message, reply)) return;
  if (is_scene_command(message)) return command(message, &viewer, now, reply);
  switch (message.body_case()) {
    case v1::ClientMessage::kOpenDataset:
      open(message.open_dataset(), &viewer, now, reply);
      if (opening_ && opening_->viewer == key && opening_->seq == seq && opening_->command == 0) {
        opening_->client = viewer.client_id;
        opening_->command = message.command();
      }
      return;
    case v1::ClientMessage::kViewport: {
      const v1::Viewport& viewport = message.viewport();
      if (auto error = check_size(viewport.width(), viewport.height())) return reply(std::move(error));
      set_viewport(viewer, viewport, now);
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
      note_decoded(viewer, message.frame_ack().frame_id(), decode_ms, now);
      note_decoded(viewer, message.frame_ack().decoded_frame_id(), message.frame_ack().decoded_ms(), now);
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
      if (auto error = refuse_still(viewer, still, now)) return reply(std::move(error));
      if (still.has_annotations()) return keepsake(viewer, message, now);
      viewer.frames.request_still(static_cast<int>(still.width()), static_cast<int>(still.height()));
      return pump(viewer, now);
    }
    case v1::ClientMessage::kRequestHistogram:
      return send_histogram(viewer, message);
    case v1::ClientMessage::kReloadDataset:
      return reload(&viewer, now, reply);
    case v1::ClientMessage::kCancel:
      if (opening_ && opening_->waiting_as != 0 && opening_->waiting_as == message.cancel().operation()) give_up_waiting(now);
      engine_.post(CancelRequest{key_, message.cancel().operation(), 0});
      viewer.heeded = std::max(viewer.heeded, seq);
      return viewer.outbox->send_state(wire_state(), viewer.heeded);
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

// A picture that is not shown: neither credits nor the ladder have to do with it.
void Session::keepsake(Viewer& viewer, const v1::ClientMessage& message, TimePoint now) {
  constexpr std::size_t kMost = 2;
  const std::uint64_t seq = message.seq();
  const v1::RequestStill& wanted = message.request_still();
  const auto refuse = [&](const char* code, const std::string& why) {
    viewer.outbox->send(error_message(wire_error(code, why), seq));
  };
  if (viewer.keepsakes.size() >= kMost)
    return refuse("unavailable", std::to_string(kMost) + " pictures of this connection are being drawn; ask again later");
  const bool as_shown = wanted.width() == 0 && wanted.height() == 0;
  const int width = as_shown ? viewer.frames.width() : static_cast<int>(wanted.width());
  const int height = as_shown ? viewer.frames.height() : static_cast<int>(wanted.height());
  if (width < 1)
    return refuse("invalid_argument", "there is no viewport whose size the picture could have; say width and height");
  announce(now);
  FrameRequest request{key_, 0, width, height, true, false};
  request.still = StillFormat::png;
  request.annotations = annotations_of(wanted.annotations());
  auto number = std::make_shared<RequestId>(0);
  *number = engine_.ask(std::move(request), [this, key = viewer.key, seq, number](const EngineEvent& event, TimePoint) {
    if (std::holds_alternative<FrameStarted>(event)) return;
    Viewer* to = living(key);
    if (!to) return;
    to->keepsakes.erase(*number);
    if (const auto* failed = std::get_if<RequestFailed>(&event)) return to->outbox->send(error_message(wire_error(*failed), seq));
    if (const auto* ready = std::get_if<FrameReady>(&event)) {
      v1::Frame frame = to_wire(*ready);
      frame.set_in_reply_to(seq);
      to->outbox->send_frame(std::move(frame), ready->bytes);
    }
  });
  viewer.keepsakes.insert(*number);
}

void Session::send_histogram(Viewer& viewer, const v1::ClientMessage& message) {
  const std::uint64_t seq = message.seq();
  const v1::RequestHistogram& wanted = message.request_histogram();
  if (opening_) {
    // It means the dataset that the viewer has asked for.
    if (deferred_.size() >= kMaxDeferred)
      return viewer.outbox->send(error_message(wire_error("unavailable", "too many commands wait for the dataset"), seq));
    deferred_.push_back({[this, key = viewer.key, message](TimePoint) {
      if (Viewer* to = living(key)) send_histogram(*to, message);
    }});
    return;
  }
  if (auto error = check_histogram(wanted, context())) return viewer.outbox->send(error_message(std::move(*error), seq));
  if (histograms_ >= kMaxHistograms)
    return viewer.outbox->send(error_message(
        wire_error("unavailable", std::to_string(kMaxHistograms) + " histograms are being counted; ask again later"), seq));
  ++histograms_;
  HistogramRequest request{key_,
                           0,
                           state_.scene.dataset,
                           state_.scene.step,
                           wanted.array(),
                           static_cast<int>(wanted.bins()),
                           {}};
  const ArrayFacts& array = *dataset_->find_array(wanted.array());
  if (state_.scene.array == array.name) request.values = state_.scene.values;
  request.least = array.range(request.values);
  engine_.ask(std::move(request), [this, key = viewer.key, seq](const EngineEvent& event, TimePoint) {
    --histograms_;
    Viewer* to = living(key);
    if (!to) return;
    if (const auto* failed = std::get_if<RequestFailed>(&event)) return to->outbox->send(error_message(wire_error(*failed), seq));
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
    Deferred& last = deferred_.emplace_back();
    last.run = [this, message, key = viewer ? viewer->key : 0, expected, reply = std::move(reply)](TimePoint then) {
      command(message, living(key), then, reply, expected);
    };
    if (viewer) {
      last.client = viewer->client_id;
      last.command = message.command();
    }
    return;
  }
  if (asleep_)
    return reply(wire_error("unavailable", "dataset '" + asleep_->dataset() + "' of this session could not be opened again"));
  if (auto error = unexpected(expected)) return reply(std::move(error));
  CommandOutcome outcome = apply_command(state_, message, context(viewer));
  if (viewer) viewer->heeded = std::max(viewer->heeded, message.seq());
  if (!outcome.error && viewer) viewer->note_input(message.seq(), state_.scene.revision);
  worked_on_ = worked_on_ || outcome.changed;
  if (outcome.changed) changed(now, message.has_set_camera() ? Cause::camera : Cause::command);
  if (outcome.error) announce(now);
  // Whoever waits for an answer gets one; an outbox sends the newest of them alone.
  if (!outcome.error && !outcome.changed && viewer) {
    if (message.has_set_camera())
      unannounced_ = true;  // with others that may follow
    else
      viewer->outbox->send_state(wire_state(), viewer->heeded);
  }
  reply(std::move(outcome.error));
}

void Session::open(const v1::OpenDataset& wanted, Viewer* viewer, TimePoint now, const Reply& reply) {
  std::optional<v1::Error> error;
  const std::string id = asked_dataset(wanted, error);
  if (error) return reply(std::move(error));
  open(id, viewer, now, reply);
}

void Session::open(const std::string& id, Viewer* viewer, TimePoint now, Reply reply, bool reload) {
  last_use_ = now;
  if (id.empty() || id.size() > kMaxNameBytes) return reply(wire_error("invalid_argument", "a dataset's id is expected", "id"));
  if (opening_ && opening_->dataset == id) {
    if (viewer) {
      opening_->viewer = viewer->key;
      opening_->seq = viewer->last_seq;
      opening_->aspect = viewer->frames.aspect();
    }
    opening_->reply = [first = std::move(opening_->reply), second = std::move(reply)](std::optional<v1::Error> error) {
      first(error);
      second(std::move(error));
    };
    return;
  }
  if (!opening_ && dataset_ && state_.scene.dataset == id && (!reload || engine_.newest(id) == shown_ || dataset_->on_disk == OnDisk::gone)) {
    if (viewer) {
      viewer->note_input(viewer->last_seq, state_.scene.revision);
      viewer->outbox->send(dataset_message(*dataset_));
      viewer->heeded = viewer->last_seq;
      viewer->outbox->send_state(wire_state(), viewer->heeded);
    }
    return reply(std::nullopt);
  }
  if (opening_) {
    engine_.post(CancelRequest{key_, 0, opening_->request, true});
    engine_.forget(opening_->request);
    tell_waited(true);
    Opening given_up = std::move(*opening_);
    opening_.reset();
    given_up.reply(wire_error("cancelled", "another dataset was asked for"));
    // What was said in between was meant for a dataset that never came; it is judged by the one that is open now.
    run_deferred(now);
  }
  Opening opening{0, id, viewer ? viewer->key : 0, viewer ? viewer->last_seq : 0, viewer ? viewer->frames.aspect() : 1, std::move(reply)};
  opening.reload = reload && dataset_ && state_.scene.dataset == id;
  opening.named = engine_.newest(id);
  if (const CatalogueEntry* entry = engine_.entry(id)) opening.asked = *entry;
  opening.request =
      engine_.ask(OpenRequest{key_, 0, opening.named}, [this](const EngineEvent& event, TimePoint then) { opened(event, then); });
  opening_ = std::move(opening);
}

void Session::opened(const EngineEvent& event, TimePoint now) {
  if (!opening_) return;
  Opening opening = std::move(*opening_);
  opening_.reset();
  last_use_ = now;
  if (const auto* failed = std::get_if<RequestFailed>(&event)) {
    if (try_again(*failed, opening, now)) {
      opening_ = std::move(opening);
      return wait_for_file(now);
    }
    opening.reply(wire_error(*failed));
  } else if (const auto* ready = std::get_if<DatasetReady>(&event)) {
    give_up_ranges();
    dataset_ = std::make_shared<const DatasetFacts>(ready->facts);
    shown_ = opening.named;
    parts_ = opening.asked.parts;
    unread_ = false;
    read_ranges();
    if (opening.reload) {
      show_reloaded(opening, now);
      opening.reply(std::nullopt);
      run_deferred(now);
      return on_disk(now);
    }
    if (asleep_ && asleep_->dataset() == dataset_->id) {
      woken(*dataset_, now);
      opening.reply(std::nullopt);
      run_deferred(now);
      return on_disk(now);
    }
    asleep_.reset();
    open_in_scene(state_, *dataset_, opening.aspect);
    if (reading_ranges_) first_look_ = state_.scene;
    if (Viewer* viewer = living(opening.viewer)) {
      viewer->heeded = std::max(viewer->heeded, opening.seq);
      viewer->note_input(opening.seq, state_.scene.revision);
    }
    broadcast(dataset_message(*dataset_));
    changed(now);
    opening.reply(std::nullopt);
  }
  run_deferred(now);
  on_disk(now);  // it may have changed while it was read
}

void Session::read_ranges() {
  if (dataset_->missing_steps == 0) return;
  reading_ranges_ = engine_.ask(OpenRequest{key_, 0, shown_, true},
                                [this](const EngineEvent& event, TimePoint now) { ranges_read(event, now); });
}

void Session::give_up_ranges() {
  first_look_.reset();
  if (!reading_ranges_) return;
  engine_.post(CancelRequest{key_, 0, reading_ranges_, true});
  engine_.forget(std::exchange(reading_ranges_, 0));
}

// Cancelled or failed, the ranges stay what is known of them.
void Session::ranges_read(const EngineEvent& event, TimePoint now) {
  reading_ranges_ = 0;
  const std::optional<Scene> first_look = std::exchange(first_look_, std::nullopt);
  const auto* ready = std::get_if<DatasetReady>(&event);
  if (!ready) return;
  const ColorRange colors_before = drawn().color_range;
  auto facts = std::make_shared<DatasetFacts>(ready->facts);
  facts->on_disk = dataset_->on_disk;
  dataset_ = std::move(facts);
  broadcast(dataset_message(*dataset_));
  // Layers that nobody has touched were chosen by what was known then.
  if (first_look && first_look->array == state_.scene.array && first_look->intervals == state_.scene.intervals &&
      show_first_layers(state_, *dataset_))
    return changed(now);
  if (drawn().color_range == colors_before) return;
  ++state_.scene.revision;
  changed(now);
}

void Session::run_deferred(TimePoint now) {
  while (!opening_ && !deferred_.empty()) {
    const Deferred next = std::move(deferred_.front());
    deferred_.pop_front();
    next.run(now);
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
  worked_on_ = worked_on_ || outcome.changed;
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
    message.mutable_progress()->set_stage(valid_utf8(progress->stage));
    message.mutable_progress()->set_fraction(progress->fraction);
    message.mutable_progress()->set_background(reading_ranges_ != 0 && progress->works_for == reading_ranges_);
  } else if (const auto* done = std::get_if<OperationDone>(&event)) {
    message.mutable_done()->set_operation(done->operation);
    message.mutable_done()->set_cancelled(done->cancelled);
    message.mutable_done()->set_superseded(done->superseded);
  } else if (const auto* failed = std::get_if<RequestFailed>(&event)) {
    message = error_message(wire_error(*failed));
    unread_ = true;
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
  if (advance_cycle(state_, steps)) changed(now, Cause::clock);
}

void Session::draw_again(TimePoint now) {
  for (auto& [key, viewer] : viewers_) viewer->frames.scene_changed(state_.scene.revision, drawable(), now);
  pump(now);
}

void Session::pump(TimePoint now) {
  if (now - announced_ >= kAnnounce) announce(now);
  play_cycle(now);
  for (auto& [key, viewer] : viewers_) pump(*viewer, now);
}

std::optional<TimePoint> Session::wake_at(TimePoint now) const {
  std::optional<TimePoint> earliest;
  if (watched()) earliest = next_phase_;
  if (unannounced_) earliest = earliest ? std::min(*earliest, announced_ + kAnnounce) : announced_ + kAnnounce;
  const bool wait = crowded();  // until a picture is ready
  for (const auto& [key, viewer] : viewers_) {
    auto at = viewer->frames.wake_at(now);
    if (at) at = std::max(*at, viewer->pays_at);
    if (at && !wait && (!earliest || *at < *earliest)) earliest = at;
    if (viewer->bands.empty()) continue;
    if (const TimePoint at = viewer->frames.next_band_at(now); at != TimePoint::max() && (!earliest || at < *earliest))
      earliest = at;
  }
  return earliest;
}

}  // namespace isostrata
