// Of a session: what becomes of the files of its dataset while it is open.
//
// A series that grows gains its steps by itself: nothing that is shown changes. A file that was rewritten is shown again when somebody asks for it (ReloadDataset), as
// in ParaView (Reload Files) and VisIt (ReOpen): a picture that people look at, talk about and measure in does not change under their hands, and steps of an old and
// a new run are never mixed in one animation. A deleted file is shown from memory.
#include <algorithm>
#include <utility>

#include "session/sessions/session.h"
#include "session/wire/wire.h"

namespace isostrata {

/// Whether the failure is one of a moment: the file was being written, or has changed since it was asked for. The catalogue may hear of that a little later.
bool Session::try_again(const RequestFailed& failed, Opening& opening, TimePoint now) {
  const CatalogueEntry* entry = engine_.entry(opening.dataset);
  if (!entry || failed.code == ErrorCode::cancelled || failed.code == ErrorCode::too_large || failed.code == ErrorCode::unsupported) return false;
  if (entry->news == CatalogueNews::gone) return false;
  const bool same = entry->version == opening.asked.version && entry->parts == opening.asked.parts && entry->bytes == opening.asked.bytes;
  const bool moment = failed.code == ErrorCode::unavailable && opening.tries < 2;
  if (same && !entry->writing && !opening.asked.writing && !moment) return false;
  opening.until = now + (entry->writing ? std::chrono::hours(24) : same ? Duration(std::chrono::seconds(3)) : Duration::zero());
  opening.failure = failed;
  return true;
}

void Session::wait_for_file(TimePoint now) {
  Opening& opening = *opening_;
  opening.request = 0;
  if (opening.until <= now) return ask_again();
  if (opening.waiting_as == 0) {
    static std::uint64_t last = std::uint64_t{1} << 40;  // of no operation of the engine's
    opening.waiting_as = ++last;
  }
  v1::ServerMessage message;
  message.mutable_progress()->set_operation(opening.waiting_as);
  const CatalogueEntry* entry = engine_.entry(opening.dataset);
  message.mutable_progress()->set_stage((entry ? entry->name : opening.dataset) + " is being written; it is read once it is complete");
  broadcast(message);
}

void Session::ask_again() {
  tell_waited(false);
  const CatalogueEntry* entry = engine_.entry(opening_->dataset);
  if (entry) opening_->asked = *entry;
  ++opening_->tries;
  opening_->failure.reset();
  opening_->named = engine_.newest(opening_->dataset);
  opening_->request =
      engine_.ask(OpenRequest{key_, 0, opening_->named}, [this](const EngineEvent& event, TimePoint then) { opened(event, then); });
}

void Session::tell_waited(bool cancelled) {
  if (!opening_ || opening_->waiting_as == 0) return;
  v1::ServerMessage message;
  message.mutable_done()->set_operation(std::exchange(opening_->waiting_as, 0));
  message.mutable_done()->set_cancelled(cancelled);
  broadcast(message);
}

void Session::give_up_waiting(TimePoint now) {
  tell_waited(true);
  Opening opening = std::move(*opening_);
  opening_.reset();
  opening.reply(wire_error("cancelled", "the file is not waited for any more"));
  run_deferred(now);
}

void Session::look_at_waiting(TimePoint now) {
  if (!opening_ || !opening_->failure || now < opening_->until) return;
  tell_waited(false);
  const RequestFailed failed = *opening_->failure;
  opening_->tries = 1000;  // enough
  opened(failed, now);
}

void Session::on_disk(TimePoint now) {
  if (opening_ && opening_->failure) {
    const CatalogueEntry* entry = engine_.entry(opening_->dataset);
    if (!entry || entry->news == CatalogueNews::gone) {
      opening_->until = now;
      return look_at_waiting(now);
    }
    if (!entry->writing) return ask_again();
  }
  if (!dataset_ || state_.scene.dataset != dataset_->id) return;
  const CatalogueEntry* entry = engine_.entry(dataset_->id);
  if (!entry) return set_on_disk(OnDisk::gone);
  if (entry->news == CatalogueNews::gone) return set_on_disk(OnDisk::gone);
  if (engine_.newest(dataset_->id) != shown_) return set_on_disk(OnDisk::changed);
  set_on_disk(OnDisk::as_read);
  if (std::exchange(unread_, false)) {  // the engine tries again, too, now that it has been told
    engine_.post(SceneUpdate{key_, drawn()});
    draw_again(now);
  }
  if (entry->parts > parts_) read_new_steps(entry->parts);
}

void Session::set_on_disk(OnDisk what) {
  if (dataset_->on_disk == what) return;
  auto facts = std::make_shared<DatasetFacts>(*dataset_);
  facts->on_disk = what;
  dataset_ = std::move(facts);
  broadcast(dataset_message(*dataset_));
}

void Session::read_new_steps(int parts) {
  if (reading_steps_) return;  // once that is answered it is looked at again
  reading_steps_ = engine_.ask(OpenRequest{key_, 0, shown_}, [this, parts, of = shown_](const EngineEvent& event, TimePoint now) {
    reading_steps_ = 0;
    if (of != shown_ || !dataset_) return;
    const auto* ready = std::get_if<DatasetReady>(&event);
    if (!ready) return;  // the file says so when it is asked for; the next change is another occasion
    parts_ = parts;
    const OnDisk was = dataset_->on_disk;
    auto facts = std::make_shared<DatasetFacts>(ready->facts);
    facts->on_disk = was;
    dataset_ = std::move(facts);
    broadcast(dataset_message(*dataset_));
    if (!reading_ranges_) read_ranges();
    pump(now);
    if (const CatalogueEntry* entry = engine_.entry(dataset_->id); entry && entry->parts > parts_) read_new_steps(entry->parts);
  });
}

void Session::reload(Viewer* viewer, TimePoint now, Reply reply) {
  if (state_.scene.dataset.empty()) return reply(wire_error("not_found", "no dataset is open; open one first"));
  open(state_.scene.dataset, viewer, now, std::move(reply), true);
}

/// The scene goes on with what is there now, as far as it fits.
void Session::show_reloaded(const Opening& opening, TimePoint now) {
  v1::State saved = to_wire(state_.scene);
  const auto steps = static_cast<std::int32_t>(dataset_->times.size());
  saved.set_step(std::clamp(saved.step(), 0, std::max(steps - 1, 0)));
  if (saved.has_time() && (dataset_->times.empty() || saved.time() < dataset_->times.front() || saved.time() > dataset_->times.back())) saved.clear_time();
  const std::uint64_t revision = state_.scene.revision;
  const auto error = restore_state(state_, saved, state_.last_interval_id, context());
  if (error) open_in_scene(state_, *dataset_, opening.aspect);
  state_.scene.revision = revision + 1;
  if (Viewer* viewer = living(opening.viewer)) {
    viewer->heeded = std::max(viewer->heeded, opening.seq);
    viewer->note_input(opening.seq, state_.scene.revision);
  }
  broadcast(dataset_message(*dataset_));
  changed(now);
  if (error)
    broadcast(error_message(wire_error("bad_data", "dataset '" + dataset_->id + "' is not what it was (" + error->message() + "); it is shown as if opened for the first time")));
}

}  // namespace isostrata
