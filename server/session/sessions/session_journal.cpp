// Of a session: what a journal keeps of it, and how it is made of that again.
#include <utility>
#include <vector>

#include "session/sessions/session.h"

namespace isostrata {

Session::Session(SessionKey key, EngineDoor& engine, SessionKeeper& keeper, const journal::Entry& kept)
    : Session(key, engine, keeper, kept.session(), ResumeTokens(std::vector<std::string>(kept.resume_hashes().begin(), kept.resume_hashes().end()))) {
  std::vector<Invitation> invitations;
  for (const auto& i : kept.invitations())
    if (invitations.size() < Invitations::kMaxInvitations)
      invitations.push_back({i.id(), i.token_hash(), i.role() == v1::ROLE_CONTROLLER ? v1::ROLE_CONTROLLER : v1::ROLE_VIEWER,
                             i.expires_unix_ms(), i.name(), i.made_by()});
  people_.restore(std::move(invitations));
  people_.restore(kept.viewer_size());
  for (const auto& client : kept.clients()) commands_.restore({{client.id(), client.last_command()}, client.guest()});
  scene_.restore(kept.state(), kept.last_interval_id());
  const bool worked_on = state_.scene.revision > 2;  // nothing, and a first look
  const UnixMs unseen = unix_ms_now() - kept.written_unix_ms();
  use_.restore(worked_on, kept.left() || unseen > std::chrono::duration_cast<std::chrono::milliseconds>(SessionUse::kComesBack).count());
}

journal::Entry Session::entry() const {
  journal::Entry entry;
  entry.set_session(id_);
  for (const std::string& hash : resume_.hashes()) entry.add_resume_hashes(hash);
  *entry.mutable_state() = wire_state();
  entry.set_last_interval_id(state_.last_interval_id);
  for (const Invitation& invitation : people_.invitations().all()) {
    journal::Invitation& to = *entry.add_invitations();
    to.set_id(invitation.id);
    to.set_token_hash(invitation.token_hash);
    to.set_role(invitation.role);
    to.set_expires_unix_ms(invitation.expires);
    to.set_name(invitation.name);
    to.set_made_by(invitation.made_by);
  }
  *entry.mutable_viewer_size() = people_.viewer_size();
  for (const ClientCommands::Newest& newest : commands_.all()) {
    const auto& [client, number] = newest.command;
    journal::Client& to = *entry.add_clients();
    to.set_id(client);
    // The newest whose effect is in the scene, with all before it. What waits for a dataset dies with the server, so it is left to its
    // client to send that again.
    to.set_last_command(CommandQueue::before(dataset_.opening_command(), client, queue_.settled(client, number)));
    to.set_guest(newest.guest);
  }
  entry.set_left(use_.abandoned());
  entry.set_written_unix_ms(unix_ms_now());
  return entry;
}

}  // namespace isostrata
