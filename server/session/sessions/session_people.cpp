// Of a session: who is in it, who may change what is shown, and whom they invite.
#include <algorithm>
#include <iterator>
#include <utility>

#include "session/sessions/session.h"
#include "session/wire/limits.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

constexpr std::size_t kMaxClients = 32;  // whose newest command is remembered; of guests as many again

}  // namespace

// What changes the scene or concerns others; everything else is about one's own pictures. Who has the server's token may do all; a
// controller who was invited may do nothing to those whom it has not invited itself.
std::optional<std::string> Session::forbidden(const Viewer& viewer, const v1::ClientMessage& message) const {
  const bool owner = viewer.invitation.empty(), controls = viewer.role == v1::ROLE_CONTROLLER;
  const std::string only_looks = "this connection may only look; a controller of the session changes what is shown";
  switch (message.body_case()) {
    case v1::ClientMessage::kRevokeInvitation:
      if (controls && !owner && !invitations_.descends(message.revoke_invitation().id(), viewer.invitation))
        return "who was invited may take back those invitations alone that they have made";
      break;
    case v1::ClientMessage::kSetRole: {
      const auto it = viewers_.find(message.set_role().participant());
      const bool oneself = message.set_role().participant() == 0 || message.set_role().participant() == viewer.key;
      if (oneself) return owner || controls ? std::nullopt : std::optional(only_looks);  // down is always free
      if (controls && !owner && it != viewers_.end() &&
          (it->second->invitation.empty() || !invitations_.descends(it->second->invitation, viewer.invitation)))
        return "who was invited may change the roles of those alone whom they have invited";
      break;
    }
    case v1::ClientMessage::kOpenDataset:
    case v1::ClientMessage::kReloadDataset:
    case v1::ClientMessage::kCancel:
    case v1::ClientMessage::kCreateInvitation:
    case v1::ClientMessage::kListInvitations:
      break;
    default:
      if (!is_scene_command(message)) return std::nullopt;
  }
  return controls ? std::nullopt : std::optional(only_looks);
}

bool Session::done_before(const Viewer& viewer, const v1::ClientMessage& message) {
  if (message.command() == 0 || viewer.client_id.empty()) return false;
  auto it = std::find_if(clients_.begin(), clients_.end(), [&](const Client& c) { return c.id == viewer.client_id; });
  if (it != clients_.end() && message.command() <= it->last_command) return true;
  Client client{viewer.client_id, message.command(), !viewer.invitation.empty()};
  if (it != clients_.end()) clients_.erase(it);
  // Guests, who may call themselves what they like, make each other forgotten and nobody else.
  const auto alike = [&](const Client& c) { return c.guest == client.guest; };
  if (static_cast<std::size_t>(std::count_if(clients_.begin(), clients_.end(), alike)) >= kMaxClients)
    clients_.erase(std::prev(std::find_if(clients_.rbegin(), clients_.rend(), alike).base()));
  clients_.push_front(std::move(client));
  return false;
}

// The newest whose effect is in the scene, with all before it. What waits for a dataset dies with the server, so the journal
// leaves it to its client to send that again.
std::uint64_t Session::settled_command(const Client& client) const {
  std::uint64_t settled = client.last_command;
  const auto waits = [&](const std::string& id, std::uint64_t command) {
    if (command != 0 && id == client.id) settled = std::min(settled, command - 1);
  };
  if (opening_) waits(opening_->client, opening_->command);
  for (const Deferred& of : deferred_) waits(of.client, of.command);
  return settled;
}

// The client on a connection that it has made since; null where there is none.
Viewer* Session::back_again(const std::string& client_id) {
  if (client_id.empty()) return nullptr;
  const auto of = [&](const auto& entry) { return entry.second->client_id == client_id; };
  const auto newest = std::find_if(viewers_.rbegin(), viewers_.rend(), of);
  return newest == viewers_.rend() ? nullptr : newest->second;
}

std::uint64_t Session::last_command(const std::string& client_id) const {
  if (!client_id.empty())
    for (const Client& client : clients_)
      if (client.id == client_id) return client.last_command;
  return 0;
}

// The answer may be lost with its connection; the client hears of it when it comes back.
void Session::note_refused(const std::string& client_id, std::uint64_t command, const v1::Error& error) {
  for (Client& client : clients_)
    if (!client_id.empty() && client.id == client_id && client.last_command == command) client.error = error;
}

const v1::Error* Session::last_command_error(const std::string& client_id) const {
  if (!client_id.empty())
    for (const Client& client : clients_)
      if (client.id == client_id) return client.error ? &*client.error : nullptr;
  return nullptr;
}

v1::Participants Session::participants() const {
  v1::Participants all;
  for (const auto& [key, viewer] : viewers_) {
    v1::Participant& one = *all.add_participants();
    one.set_id(key);
    one.set_name(viewer->name);
    one.set_role(viewer->role);
    one.set_invited(!viewer->invitation.empty());
    one.set_client(viewer->client);
  }
  return all;
}

void Session::people_changed() {
  engine_.people_changed(*this);
  if (viewers_.empty()) return;
  v1::ServerMessage message;
  *message.mutable_participants() = participants();
  broadcast(message);
}

void Session::set_role(Viewer& viewer, const v1::SetRole& wanted, const Reply& reply) {
  if (wanted.role() != v1::ROLE_CONTROLLER && wanted.role() != v1::ROLE_VIEWER)
    return reply(wire_error("invalid_argument",
                            "role is " + std::to_string(wanted.role()) + "; expected ROLE_CONTROLLER (1) or ROLE_VIEWER (2)",
                            "role"));
  Viewer* of = wanted.participant() == 0 ? &viewer : living(wanted.participant());
  if (!of)
    return reply(wire_error("not_found", "participant " + std::to_string(wanted.participant()) + " is not in this session",
                            "participant"));
  if (of->role == wanted.role()) {
    v1::ServerMessage answer;
    *answer.mutable_participants() = participants();
    viewer.outbox->send(std::move(answer));
    return reply(std::nullopt);
  }
  const auto controllers =
      std::count_if(viewers_.begin(), viewers_.end(), [](const auto& v) { return v.second->role == v1::ROLE_CONTROLLER; });
  if (wanted.role() == v1::ROLE_VIEWER && controllers <= 1)
    return reply(
        wire_error("invalid_argument", "this is the session's last controller; make somebody else a controller first", "role"));
  of->role = wanted.role();
  if (of->viewport.width() > 0) set_viewport(*of, v1::Viewport(of->viewport), last_use_);
  people_changed();
  reply(std::nullopt);
}

Invitations::Made Session::invite(const v1::CreateInvitation& wanted, const std::string& made_by) {
  expire_invitations(unix_ms_now());
  Invitations::Made made = invitations_.make(wanted, unix_ms_now(), made_by);
  if (!made.error) engine_.session_changed(*this, true);
  return made;
}

bool Session::revoke(const std::string& invitation) {
  const auto over = invitations_.revoke(invitation);
  if (over.empty()) return false;
  engine_.session_changed(*this, true);
  for (const std::string& one : over) engine_.invitation_ended(*this, one);
  return true;
}

void Session::expire_invitations(UnixMs now) {
  const auto over = invitations_.expire(now);
  if (!over.empty()) engine_.session_changed(*this, true);
  for (const std::string& invitation : over) engine_.invitation_ended(*this, invitation);
}

v1::Invitation Session::to_wire_invitation(const Invitation& invitation) const {
  v1::Invitation out;
  out.set_id(invitation.id);
  out.set_role(invitation.role);
  out.set_expires_unix_ms(static_cast<double>(invitation.expires));
  out.set_name(invitation.name);
  out.set_present(static_cast<std::uint32_t>(
      std::count_if(viewers_.begin(), viewers_.end(), [&](const auto& v) { return v.second->invitation == invitation.id; })));
  return out;
}

bool Session::answer_people(Viewer& viewer, const v1::ClientMessage& message, const Reply& reply) {
  const auto list = [&] {
    v1::ServerMessage answer;
    answer.mutable_invitations();
    for (const Invitation& invitation : invitations_.all())
      if (invitations_.descends(invitation.id, viewer.invitation))
        *answer.mutable_invitations()->add_invitations() = to_wire_invitation(invitation);
    viewer.outbox->send(std::move(answer));
  };
  switch (message.body_case()) {
    case v1::ClientMessage::kSetRole:
      set_role(viewer, message.set_role(), reply);
      return true;
    case v1::ClientMessage::kCreateInvitation: {
      Invitations::Made made = invite(message.create_invitation(), viewer.invitation);
      if (made.error) {
        reply(std::move(made.error));
        return true;
      }
      v1::ServerMessage answer;
      *answer.mutable_invitation() = to_wire_invitation(*made.invitation);
      answer.mutable_invitation()->set_token(std::move(made.token));
      viewer.outbox->send(std::move(answer));
      return true;
    }
    case v1::ClientMessage::kRevokeInvitation:
      if (!revoke(message.revoke_invitation().id()))
        reply(wire_error("not_found", "this session has no invitation of this id; it may be over or revoked already", "id"));
      else
        list();
      return true;
    case v1::ClientMessage::kListInvitations:
      list();
      return true;
    default:
      return false;
  }
}

}  // namespace isostrata
