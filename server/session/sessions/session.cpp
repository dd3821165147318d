#include "session/sessions/session.h"

#include <algorithm>
#include <utility>

#include "base/utf8.h"
#include "engine/picture/scene_styles.h"
#include "scene/transfer_function.h"
#include "session/wire/limits.h"
#include "session/wire/random_token.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

constexpr Duration kAnnounce = std::chrono::milliseconds(4);  // between cameras that are told on, where more come than that

}  // namespace

Session::Session(SessionKey key, EngineDoor& engine, SessionKeeper& keeper) : Session(key, engine, keeper, random_token(64), {}) {}

Session::Session(SessionKey key, EngineDoor& engine, SessionKeeper& keeper, std::string id, ResumeTokens resume)
    : key_(key),
      id_(std::move(id)),
      engine_(engine),
      keeper_(keeper),
      resume_(std::move(resume)),
      scene_(state_),
      people_({.people_changed = [this] { keeper_.people_changed(*this); },
               .kept_changed = [this] { keeper_.session_changed(*this, true); },
               .invitation_ended = [this](const std::string& invitation) { keeper_.invitation_ended(*this, invitation); }}),
      dataset_(key, engine, *this),
      frames_(key, engine, people_, state_.scene,
              {.announce = [this](TimePoint now) { announce(now); },
               .pump = [this](TimePoint now) { pump(now); },
               .drawable = [this] { return drawable(); },
               .budget = [this]() -> ViewerBudget& { return keeper_.viewer_budget(); }}),
      answers_(key, engine, people_) {
  state_.scene.revision = 1;
}

Session::~Session() { engine_.post(CloseSession{key_}); }

v1::State Session::wire_state() const { return scene_.asleep() ? *scene_.asleep() : to_wire(state_.scene); }

SessionUse::Holds Session::holds() const {
  return use_.holds(!state_.scene.dataset.empty() || dataset_.opening(), !people_.invitations().all().empty());
}

void Session::attach(Viewer& viewer, TimePoint now) {
  people_.add(viewer);
  if (use_.come()) keeper_.session_changed(*this, false);
  viewer.session = key_;
  use_.touch(now);
  frames_.come(viewer, now);
}

void Session::detach(Viewer& viewer, TimePoint now, bool goodbye) {
  announce(now);  // nobody may be there later to see to it
  frames_.leave(viewer);
  answers_.leave(viewer.key);
  people_.remove(viewer);
  if (!watched()) frames_.forget_kept();
  viewer.session = 0;
  use_.touch(now);
  people_.changed();
  if (use_.leave(goodbye, watched())) keeper_.session_changed(*this, false);
}

// ---- the scene ----

void Session::changed(TimePoint now, Cause cause) {
  keeper_.session_changed(*this, cause == Cause::command);
  unannounced_ = true;
  if (cause != Cause::camera || now - announced_ >= kAnnounce) announce(now);
  frames_.scene_changed(now);
  pump(now);
}

Scene Session::drawn() const {
  Scene scene = drawn_scene(state_.scene);
  if (!scene.dataset.empty() && !shown().empty()) scene.dataset = shown();
  scene.color_range = known_color_range(scene, dataset());
  return scene;
}

// Thousands of cameras a second would be copied to everyone, and nobody sees them.
void Session::announce(TimePoint now) {
  if (!unannounced_) return;
  unannounced_ = false;
  announced_ = now;
  Scene scene = drawn();
  frames_.note_told(told_, scene);
  told_ = scene;
  engine_.post(SceneUpdate{key_, std::move(scene)});
  use_.look(now);
  const v1::State state = wire_state();
  for (const auto& [key, viewer] : people_.viewers()) viewer->outbox->send_state(state, viewer->heeded);
  keeper_.state_told(*this);
}

std::optional<v1::Error> Session::unexpected(std::optional<std::uint64_t> expected) const {
  if (!expected || *expected == state_.scene.revision) return std::nullopt;
  return wire_error("precondition_failed",
                    "the state is at revision " + std::to_string(state_.scene.revision) + ", not " + std::to_string(*expected),
                    "If-Match");
}

void Session::command(const v1::ClientMessage& message, Viewer* viewer, TimePoint now, Reply reply,
                      std::optional<std::uint64_t> expected) {
  use_.touch(now);
  if (dataset_.opening()) {
    if (queue_.full())
      return reply(wire_error("unavailable", std::to_string(CommandQueue::kMost) + " commands wait for the dataset already"));
    return queue_.add(
        [this, message, key = viewer ? viewer->key : 0, expected, reply = std::move(reply)](TimePoint then) {
          command(message, people_.find(key), then, reply, expected);
        },
        viewer ? CommandNumber{viewer->client_id, message.command()} : CommandNumber{});
  }
  if (scene_.asleep())
    return reply(wire_error("unavailable", "dataset '" + scene_.asleep()->dataset() + "' of this session could not be opened again"));
  if (auto error = unexpected(expected)) return reply(std::move(error));
  CommandOutcome outcome = apply_command(state_, message, context(viewer));
  if (viewer) viewer->heeded = std::max(viewer->heeded, message.seq());
  if (!outcome.error && viewer) viewer->note_input(message.seq(), state_.scene.revision);
  if (outcome.changed) {
    use_.note_work();
    changed(now, message.has_set_camera() ? Cause::camera : Cause::command);
  }
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

void Session::set_state(const v1::State& wanted, TimePoint now, Reply reply, std::optional<std::uint64_t> expected) {
  if (auto error = unexpected(expected)) return reply(std::move(error));
  if (!wanted.dataset().empty() && (dataset_.opening() || wanted.dataset() != state_.scene.dataset)) {
    // A state that would be refused leaves the newly opened dataset behind: it can be judged only by its arrays.
    return open(wanted.dataset(), nullptr, now, [this, wanted, reply = std::move(reply)](std::optional<v1::Error> error) {
      if (error) return reply(std::move(error));
      set_state(wanted, use_.last(), reply);
    });
  }
  use_.touch(now);
  CommandOutcome outcome = apply_state(state_, wanted, context());
  if (outcome.changed) {
    use_.note_work();
    changed(now);
  }
  reply(std::move(outcome.error));
}

bool Session::seen() const {
  return std::ranges::any_of(people_.viewers(), [](const auto& of) { return of.second->frames.visible(); });
}

void Session::let_rest(TimePoint now) {
  if (seen()) return use_.look(now);
  if (use_.goes_to_rest(now, watched())) engine_.post(RestScene{key_});
}

void Session::play_cycle(TimePoint now) {
  const Scene& scene = state_.scene;
  if (scene.mode != SceneMode::cycled || !scene.cycle.playing || !seen() || scene.dataset.empty() || cycle_length(scene) < 2)
    return cycle_.stop();
  if (const std::int64_t steps = cycle_.advance(scene.cycle.seconds, now); steps > 0 && advance_cycle(state_, steps))
    changed(now, Cause::clock);
}

// ---- the dataset ----

void Session::open(const v1::OpenDataset& wanted, Viewer* viewer, TimePoint now, const Reply& reply, std::uint64_t command) {
  std::optional<v1::Error> error;
  const std::string id = asked_dataset(wanted, error);
  if (error) return reply(std::move(error));
  open_dataset(id, viewer, now, reply, false, command);
}

void Session::reload(Viewer* viewer, TimePoint now, Reply reply) {
  if (state_.scene.dataset.empty()) return reply(wire_error("not_found", "no dataset is open; open one first"));
  open_dataset(state_.scene.dataset, viewer, now, std::move(reply), true, 0);
}

void Session::open_dataset(const std::string& id, Viewer* viewer, TimePoint now, Reply reply, bool reload, std::uint64_t command) {
  use_.touch(now);
  if (id.empty() || id.size() > kMaxNameBytes) return reply(wire_error("invalid_argument", "a dataset's id is expected", "id"));
  if (dataset_.is_open(id, reload)) {
    if (viewer) {
      viewer->note_input(viewer->last_seq, state_.scene.revision);
      viewer->outbox->send(dataset_message(*dataset()));
      viewer->heeded = viewer->last_seq;
      viewer->outbox->send_state(wire_state(), viewer->heeded);
    }
    return reply(std::nullopt);
  }
  SessionDataset::Asker asker;
  if (viewer) asker = {viewer->key, viewer->last_seq, viewer->frames.aspect(), {viewer->client_id, command}};
  dataset_.open(id, std::move(asker), reload, now, std::move(reply));
}

void Session::run_queue(TimePoint now) {
  queue_.run(now, [this] { return dataset_.opening(); });
}

void Session::show_dataset(const SessionDataset::Asker& asker, bool reload, TimePoint now) {
  const DatasetInScene::Shown shown = scene_.show(*dataset(), reload, asker.aspect, reading_ranges() != 0);
  if (Viewer* viewer = shown.woken ? nullptr : people_.find(asker.viewer)) {
    viewer->heeded = std::max(viewer->heeded, asker.seq);
    viewer->note_input(asker.seq, state_.scene.revision);
  }
  people_.tell(dataset_message(*dataset()));
  if (shown.changed)
    changed(now);
  else
    try_drawing_again(now);
  if (shown.error) people_.tell(error_message(*shown.error));
}

void Session::ranges_read(std::shared_ptr<const DatasetFacts> before, TimePoint now) {
  if (scene_.ranges_read(before.get(), *dataset())) changed(now);
}

void Session::try_drawing_again(TimePoint now) {
  engine_.post(SceneUpdate{key_, drawn()});
  use_.look(now);
  draw_again(now);
}

void Session::wake(TimePoint now) {
  if (!scene_.asleep() || dataset_.opening()) return;
  open(scene_.asleep()->dataset(), nullptr, now, [this](std::optional<v1::Error> error) {
    if (!error) return;
    // It stays as it was kept, and the next who comes tries again.
    error->set_message("the session's dataset cannot be opened again: " + error->message());
    people_.tell(error_message(std::move(*error)));
  });
}

// ---- frames and events ----

RequestId Session::picture(int width, int height, StillFormat format, bool transparent, EngineDoor::Listener listener, TimePoint now) {
  use_.touch(now);
  use_.look(now);
  announce(now);
  FrameRequest request{key_, 0, width, height, true, format == StillFormat::jpeg};
  request.still = format;
  request.transparent = transparent;
  return engine_.ask(std::move(request), std::move(listener));
}

RequestId Session::probe(double x, double y, int width, int height, EngineDoor::Listener listener, TimePoint now) {
  use_.touch(now);
  return engine_.ask(ProbeRequest{key_, 0, drawn(), x, y, width, height}, std::move(listener));
}

RequestId Session::curve(const std::string& array, Vec3d from, std::optional<Vec3d> to, EngineDoor::Listener listener, TimePoint now) {
  use_.touch(now);
  return engine_.ask(CurveRequest{key_, 0, drawn(), array, from, to}, std::move(listener));
}

RequestId Session::layer_statistics(std::uint32_t interval, const std::string& array, EngineDoor::Listener listener, TimePoint now) {
  use_.touch(now);
  return engine_.ask(LayerStatisticsRequest{key_, 0, drawn(), interval, array}, std::move(listener));
}

v1::Purpose Session::purpose_of(RequestId works_for) const {
  if (works_for == 0) return v1::PURPOSE_PICTURE;
  if (works_for == opening()) return v1::PURPOSE_DATASET;
  return works_for == reading_ranges() ? v1::PURPOSE_RANGES : v1::PURPOSE_UNSPECIFIED;
}

void Session::on_event(const EngineEvent& event, TimePoint now) {
  v1::ServerMessage message;
  if (const auto* progress = std::get_if<OperationProgress>(&event)) {
    message.mutable_progress()->set_operation(progress->operation);
    message.mutable_progress()->set_stage(valid_utf8(progress->stage));
    message.mutable_progress()->set_fraction(progress->fraction);
    message.mutable_progress()->set_purpose(purpose_of(progress->works_for));
  } else if (const auto* done = std::get_if<OperationDone>(&event)) {
    message.mutable_done()->set_operation(done->operation);
    message.mutable_done()->set_cancelled(done->cancelled);
    message.mutable_done()->set_superseded(done->superseded);
  } else if (const auto* failed = std::get_if<RequestFailed>(&event)) {
    message = error_message(wire_error(*failed));
    dataset_.note_unread();
  } else {
    return;
  }
  people_.tell(message);
  pump(now);
}

void Session::draw_again(TimePoint now) {
  frames_.draw_again(now);
  pump(now);
}

void Session::pump(TimePoint now) {
  if (now - announced_ >= kAnnounce) announce(now);
  play_cycle(now);
  frames_.pump(now);
}

std::optional<TimePoint> Session::wake_at(TimePoint now) const {
  std::optional<TimePoint> earliest = frames_.wake_at(now);
  const auto also = [&](std::optional<TimePoint> at) {
    if (at && (!earliest || *at < *earliest)) earliest = at;
  };
  if (watched()) also(cycle_.next());
  if (unannounced_) also(announced_ + kAnnounce);
  return earliest;
}

}  // namespace isostrata
