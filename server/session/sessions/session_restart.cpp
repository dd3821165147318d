// Of a session: what a journal keeps of it, and how it comes back after a restart.
#include <algorithm>
#include <utility>

#include "scene/transfer_function.h"
#include "session/sessions/session.h"
#include "session/wire/limits.h"
#include "session/wire/random_token.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

constexpr std::size_t kMaxResumeHashes = 8;

}  // namespace

Session::Session(SessionKey key, EngineDoor& engine, const journal::Entry& kept)
    : key_(key),
      id_(kept.session()),
      resume_token_(random_token(192)),
      resume_hashes_(kept.resume_hashes().begin(), kept.resume_hashes().end()),
      engine_(engine) {
  // The journal has no token, only what proves one. This new one is for who finds the session by its id.
  if (resume_hashes_.size() >= kMaxResumeHashes) resume_hashes_.resize(kMaxResumeHashes - 1);
  resume_hashes_.push_back(secret_hash(resume_token_));
  std::vector<Invitation> invitations;
  for (const auto& i : kept.invitations())
    if (invitations.size() < Invitations::kMaxInvitations)
      invitations.push_back({i.id(), i.token_hash(), i.role() == v1::ROLE_CONTROLLER ? v1::ROLE_CONTROLLER : v1::ROLE_VIEWER,
                             i.expires_unix_ms(), i.name(), i.made_by()});
  invitations_.restore(std::move(invitations));
  for (const auto& client : kept.clients()) clients_.push_back({client.id(), client.last_command(), client.guest()});
  state_.last_interval_id = kept.last_interval_id();
  if (kept.state().dataset().empty()) {
    // Nothing but appearance; what cannot be restored is left at its default.
    restore_state(state_, kept.state(), kept.last_interval_id(), {});
  } else {
    asleep_ = kept.state();
    state_.scene.dataset = kept.state().dataset();
  }
  state_.scene.revision = std::max<std::uint64_t>(kept.state().revision(), 1);
  worked_on_ = state_.scene.revision > 2;  // nothing, and a first look
  left_ = kept.left() ||
          unix_ms_now() - kept.written_unix_ms() > std::chrono::duration_cast<std::chrono::milliseconds>(kComesBack).count();
}

journal::Entry Session::entry() const {
  journal::Entry entry;
  entry.set_session(id_);
  for (const std::string& hash : resume_hashes_) entry.add_resume_hashes(hash);
  *entry.mutable_state() = wire_state();
  entry.set_last_interval_id(state_.last_interval_id);
  for (const Invitation& invitation : invitations_.all()) {
    journal::Invitation& to = *entry.add_invitations();
    to.set_id(invitation.id);
    to.set_token_hash(invitation.token_hash);
    to.set_role(invitation.role);
    to.set_expires_unix_ms(invitation.expires);
    to.set_name(invitation.name);
    to.set_made_by(invitation.made_by);
  }
  for (const Client& client : clients_) {
    entry.add_clients()->set_id(client.id);
    entry.mutable_clients()->rbegin()->set_last_command(settled_command(client));
    entry.mutable_clients()->rbegin()->set_guest(client.guest);
  }
  entry.set_left(left_);
  entry.set_written_unix_ms(unix_ms_now());
  return entry;
}

bool Session::resume(const std::string& token) {
  const std::string hash = secret_hash(token);
  std::size_t found = resume_hashes_.size();
  for (std::size_t i = 0; i < resume_hashes_.size(); ++i)
    if (equal_in_constant_time(resume_hashes_[i], hash)) found = i;
  if (found == resume_hashes_.size()) return false;
  const auto at = resume_hashes_.begin() + static_cast<std::ptrdiff_t>(found);
  std::rotate(resume_hashes_.begin(), at, at + 1);
  resume_token_ = token;
  return true;
}

void Session::wake(TimePoint now) {
  if (!asleep_ || opening_) return;
  open(asleep_->dataset(), nullptr, now, [this](std::optional<v1::Error> error) {
    if (!error) return;
    // It stays as it was kept, and the next who comes tries again.
    error->set_message("the session's dataset cannot be opened again: " + error->message());
    broadcast(error_message(std::move(*error)));
  });
}

void Session::woken(const DatasetFacts& facts, TimePoint now) {
  const v1::State saved = *std::exchange(asleep_, std::nullopt);
  auto error = restore_state(state_, saved, state_.last_interval_id, context());
  broadcast(dataset_message(facts));
  if (error) {
    // Another file under the same name.
    open_in_scene(state_, facts);
    changed(now);
    return broadcast(
        error_message(wire_error("bad_data", "dataset '" + facts.id + "' is not what it was when this session was kept (" +
                                                 error->message() + "); it is shown as if opened for the first time")));
  }
  // Nothing has changed: everyone has been told this state already.
  engine_.post(SceneUpdate{key_, drawn()});
  for (auto& [key, viewer] : viewers_) viewer->frames.scene_changed(state_.scene.revision, drawable(), now);
  pump(now);
}

}  // namespace isostrata
