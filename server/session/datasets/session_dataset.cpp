#include "session/datasets/session_dataset.h"

#include <utility>

#include "session/wire/wire.h"

namespace isostrata {
namespace {

constexpr int kTries = 2;                                  // of a file that may have been read in a bad moment
constexpr Duration kCatalogueLags = std::chrono::seconds(3);  // behind the disk
constexpr Duration kWriting = std::chrono::hours(24);      // that a file may take to be written

}  // namespace

SessionDataset::~SessionDataset() {
  if (opening_) engine_.forget(opening_->request);
}

// ---- opening ----

bool SessionDataset::is_open(const std::string& id, bool reload) {
  if (opening_ || !facts_ || facts_->id != id) return false;
  return !reload || engine_.newest(id) == version_ || facts_->on_disk == OnDisk::gone;
}

void SessionDataset::open(const std::string& id, Asker asker, bool reload, TimePoint now, Reply reply) {
  if (opening_ && opening_->dataset == id) {
    CommandNumber command = opening_->asker.command.number != 0 ? opening_->asker.command : asker.command;
    if (asker.viewer != 0) opening_->asker = std::move(asker);
    opening_->asker.command = std::move(command);
    opening_->reply = [first = std::move(opening_->reply), second = std::move(reply)](std::optional<v1::Error> error) {
      first(error);
      second(std::move(error));
    };
    return;
  }
  if (opening_) {
    engine_.post(CancelRequest{session_, 0, opening_->request, true});
    engine_.forget(opening_->request);
    tell_waited(false);  // nobody has cancelled it
    const Opening given_up = std::move(*opening_);
    opening_.reset();
    given_up.reply(wire_error("cancelled", "another dataset was asked for"));
    // What was said in between was meant for a dataset that never came; it is judged by the one that is open now.
    audience_.opening_ended(now);
  }
  opening_ = Opening{.dataset = id, .asker = std::move(asker), .reply = std::move(reply), .reload = reload && facts_ && facts_->id == id};
  ask();
}

void SessionDataset::ask() {
  opening_->version = engine_.newest(opening_->dataset);
  if (const CatalogueEntry* entry = engine_.entry(opening_->dataset)) opening_->asked = *entry;
  opening_->request = engine_.ask(OpenRequest{session_, 0, opening_->version}, [this](const EngineEvent& event, TimePoint then) { answered(event, then); });
}

void SessionDataset::answered(const EngineEvent& event, TimePoint now) {
  if (!opening_) return;
  Opening opening = std::move(*opening_);
  opening_.reset();
  audience_.in_use(now);
  if (const auto* failed = std::get_if<RequestFailed>(&event)) {
    if (waits_for_file(*failed, opening, now)) {
      opening_ = std::move(opening);
      return wait_for_file(now);
    }
    opening.reply(wire_error(*failed));
  } else if (const auto* ready = std::get_if<DatasetReady>(&event)) {
    give_up_ranges();
    facts_ = std::make_shared<const DatasetFacts>(ready->facts);
    version_ = opening.version;
    parts_ = opening.asked.parts;
    unread_ = false;
    read_ranges();
    audience_.show_dataset(opening.asker, opening.reload, now);
    opening.reply(std::nullopt);
  }
  audience_.opening_ended(now);
  look_at_files(now);  // they may have changed while they were read
}

// ---- a file that is waited for ----

/// Whether the failure is one of a moment: the file was being written, or has changed since it was asked for. The catalogue may hear of that a little later.
bool SessionDataset::waits_for_file(const RequestFailed& failed, Opening& opening, TimePoint now) const {
  const CatalogueEntry* entry = engine_.entry(opening.dataset);
  if (!entry || failed.code == ErrorCode::cancelled || failed.code == ErrorCode::too_large || failed.code == ErrorCode::unsupported) return false;
  if (entry->news == CatalogueNews::gone) return false;
  const bool same = entry->version == opening.asked.version && entry->parts == opening.asked.parts && entry->bytes == opening.asked.bytes;
  const bool moment = failed.code == ErrorCode::unavailable && opening.tries < kTries;
  if (same && !entry->writing && !opening.asked.writing && !moment) return false;
  opening.until = now + (entry->writing ? kWriting : same ? kCatalogueLags : Duration::zero());
  opening.failure = failed;
  return true;
}

void SessionDataset::wait_for_file(TimePoint now) {
  Opening& opening = *opening_;
  opening.request = 0;
  if (opening.until <= now) return ask_again();
  if (opening.waiting_as == 0) {
    static std::uint64_t last = std::uint64_t{1} << 40;  // of no operation of the engine's
    opening.waiting_as = ++last;
  }
  v1::ServerMessage message;
  message.mutable_progress()->set_operation(opening.waiting_as);
  message.mutable_progress()->set_purpose(v1::PURPOSE_DATASET);
  const CatalogueEntry* entry = engine_.entry(opening.dataset);
  message.mutable_progress()->set_stage((entry ? entry->name : opening.dataset) + " is being written; it is read once it is complete");
  audience_.tell(message);
}

void SessionDataset::ask_again() {
  tell_waited(false);
  ++opening_->tries;
  opening_->failure.reset();
  ask();
}

void SessionDataset::tell_waited(bool cancelled) {
  if (!opening_ || opening_->waiting_as == 0) return;
  v1::ServerMessage message;
  message.mutable_done()->set_operation(std::exchange(opening_->waiting_as, 0));
  message.mutable_done()->set_cancelled(cancelled);
  audience_.tell(message);
}

void SessionDataset::cancel(std::uint64_t operation, TimePoint now) {
  if (!opening_ || opening_->waiting_as == 0 || opening_->waiting_as != operation) return;
  tell_waited(true);
  const Opening opening = std::move(*opening_);
  opening_.reset();
  opening.reply(wire_error("cancelled", "the file is not waited for any more"));
  audience_.opening_ended(now);
}

void SessionDataset::look_at_waiting(TimePoint now) {
  if (!opening_ || !opening_->failure || now < opening_->until) return;
  tell_waited(false);
  const RequestFailed failed = *opening_->failure;
  opening_->tries = 1000;  // enough
  answered(failed, now);
}

// ---- the one that is open ----

void SessionDataset::look_at_files(TimePoint now) {
  if (opening_ && opening_->failure) {
    const CatalogueEntry* entry = engine_.entry(opening_->dataset);
    if (!entry || entry->news == CatalogueNews::gone) {
      opening_->until = now;
      return look_at_waiting(now);
    }
    if (!entry->writing) return ask_again();
  }
  if (!facts_) return;
  const CatalogueEntry* entry = engine_.entry(facts_->id);
  if (!entry || entry->news == CatalogueNews::gone) return set_on_disk(OnDisk::gone);
  if (engine_.newest(facts_->id) != version_) return set_on_disk(OnDisk::changed);
  set_on_disk(OnDisk::as_read);
  if (std::exchange(unread_, false)) audience_.try_drawing_again(now);  // the engine tries again, too, now that it has been told
  if (entry->parts > parts_) read_new_steps(entry->parts);
}

/// The same dataset, of which something new is known.
void SessionDataset::set_facts(DatasetFacts facts) {
  facts.on_disk = facts_->on_disk;
  facts_ = std::make_shared<const DatasetFacts>(std::move(facts));
  audience_.tell(dataset_message(*facts_));
}

void SessionDataset::set_on_disk(OnDisk what) {
  if (facts_->on_disk == what) return;
  auto facts = std::make_shared<DatasetFacts>(*facts_);
  facts->on_disk = what;
  facts_ = std::move(facts);
  audience_.tell(dataset_message(*facts_));
}

void SessionDataset::read_ranges() {
  if (facts_->missing_steps == 0) return;
  reading_ranges_ = engine_.ask(OpenRequest{session_, 0, version_, true}, [this](const EngineEvent& event, TimePoint now) {
    reading_ranges_ = 0;
    const auto* ready = std::get_if<DatasetReady>(&event);
    const auto before = ready ? facts_ : nullptr;  // cancelled or failed, the ranges stay what is known of them
    if (ready) set_facts(ready->facts);
    audience_.ranges_read(before, now);
  });
}

void SessionDataset::give_up_ranges() {
  if (!reading_ranges_) return;
  engine_.post(CancelRequest{session_, 0, reading_ranges_, true});
  engine_.forget(std::exchange(reading_ranges_, 0));
}

void SessionDataset::read_new_steps(int parts) {
  if (reading_steps_) return;  // once that is answered it is looked at again
  reading_steps_ = engine_.ask(OpenRequest{session_, 0, version_}, [this, parts, of = version_](const EngineEvent& event, TimePoint now) {
    reading_steps_ = 0;
    if (of != version_ || !facts_) return;
    const auto* ready = std::get_if<DatasetReady>(&event);
    if (!ready) return;  // the file says so when it is asked for; the next change is another occasion
    parts_ = parts;
    set_facts(ready->facts);
    if (!reading_ranges_) read_ranges();
    audience_.steps_read(now);
    if (const CatalogueEntry* entry = engine_.entry(facts_->id); entry && entry->parts > parts_) read_new_steps(entry->parts);
  });
}

}  // namespace isostrata
