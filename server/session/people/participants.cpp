#include "session/people/participants.h"

#include <algorithm>
#include <utility>

#include "session/commands/apply_command.h"
#include "session/wire/limits.h"
#include "session/wire/wire.h"

namespace isostrata {
namespace {

constexpr std::uint32_t kLeastViewerSide = 64;

// 0: as many as the server allows.
std::int64_t pixels_of(const v1::SetViewerSize& size) { return std::int64_t{size.width()} * size.height(); }

bool is_viewer_size(const v1::SetViewerSize& size) {
  const auto fits = [](std::uint32_t side) { return side >= kLeastViewerSide && side <= static_cast<std::uint32_t>(kMaxSide); };
  return (size.width() == 0 && size.height() == 0) || (fits(size.width()) && fits(size.height()));
}

}  // namespace

void Participants::add(Viewer& viewer) {
  viewers_[viewer.key] = &viewer;
  viewer.session_pixels = pixels_of(viewer_size_);
}

Viewer* Participants::find(ViewerKey key) const {
  const auto it = viewers_.find(key);
  return it == viewers_.end() ? nullptr : it->second;
}

Viewer* Participants::find_client(const std::string& client_id) const {
  if (client_id.empty()) return nullptr;
  const auto newest = std::find_if(viewers_.rbegin(), viewers_.rend(), [&](const auto& entry) { return entry.second->client_id == client_id; });
  return newest == viewers_.rend() ? nullptr : newest->second;
}

void Participants::tell(const v1::ServerMessage& message) const {
  for (const auto& [key, viewer] : viewers_) viewer->outbox->send(message);
}

void Participants::changed() const {
  ports_.people_changed();
  if (viewers_.empty()) return;
  v1::ServerMessage message;
  *message.mutable_participants() = to_wire();
  tell(message);
}

v1::Participants Participants::to_wire() const {
  v1::Participants all;
  for (const auto& [key, viewer] : viewers_) {
    v1::Participant& one = *all.add_participants();
    one.set_id(key);
    one.set_name(viewer->name);
    one.set_role(viewer->role);
    one.set_invited(!viewer->invitation.empty());
    one.set_client(viewer->client);
  }
  all.set_viewer_width(viewer_size_.width());
  all.set_viewer_height(viewer_size_.height());
  return all;
}

// What changes the scene or concerns others; everything else is about one's own pictures.
std::optional<std::string> Participants::forbidden(const Viewer& viewer, const v1::ClientMessage& message) const {
  const bool owner = viewer.invitation.empty(), controls = viewer.role == v1::ROLE_CONTROLLER;
  const std::string only_looks = "this connection may only look; a controller of the session changes what is shown";
  switch (message.body_case()) {
    case v1::ClientMessage::kRevokeInvitation:
      if (controls && !owner && !invitations_.descends(message.revoke_invitation().id(), viewer.invitation))
        return "who was invited may take back those invitations alone that they have made";
      break;
    case v1::ClientMessage::kSetRole: {
      const Viewer* of = find(message.set_role().participant());
      const bool oneself = message.set_role().participant() == 0 || message.set_role().participant() == viewer.key;
      if (oneself) return owner || controls ? std::nullopt : std::optional(only_looks);  // down is always free
      if (controls && !owner && of && (of->invitation.empty() || !invitations_.descends(of->invitation, viewer.invitation)))
        return "who was invited may change the roles of those alone whom they have invited";
      break;
    }
    case v1::ClientMessage::kSetViewerSize:
      if (controls && !owner) return "who was invited may not change how large others' pictures are";
      break;
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

bool Participants::answer(Viewer& viewer, const v1::ClientMessage& message, TimePoint now, const Reply& reply) {
  switch (message.body_case()) {
    case v1::ClientMessage::kSetRole:
      set_role(viewer, message.set_role(), now, reply);
      return true;
    case v1::ClientMessage::kSetViewerSize:
      reply(set_viewer_size(message.set_viewer_size(), now));
      return true;
    case v1::ClientMessage::kCreateInvitation: {
      Invitations::Made made = invite(message.create_invitation(), viewer.invitation);
      if (made.error) {
        reply(std::move(made.error));
        return true;
      }
      v1::ServerMessage answer;
      *answer.mutable_invitation() = to_wire(*made.invitation);
      answer.mutable_invitation()->set_token(std::move(made.token));
      viewer.outbox->send(std::move(answer));
      return true;
    }
    case v1::ClientMessage::kRevokeInvitation:
      if (!revoke(message.revoke_invitation().id()))
        reply(wire_error("not_found", "this session has no invitation of this id; it may be over or revoked already", "id"));
      else
        list_invitations(viewer);
      return true;
    case v1::ClientMessage::kListInvitations:
      list_invitations(viewer);
      return true;
    default:
      return false;
  }
}

void Participants::restore(const v1::SetViewerSize& viewer_size) {
  if (is_viewer_size(viewer_size)) viewer_size_ = viewer_size;
}

std::optional<v1::Error> Participants::set_viewer_size(const v1::SetViewerSize& wanted, TimePoint now) {
  if (!is_viewer_size(wanted)) {
    const std::string least = std::to_string(kLeastViewerSide), most = std::to_string(kMaxSide);
    return wire_error("invalid_argument",
                      "the size is " + std::to_string(wanted.width()) + "x" + std::to_string(wanted.height()) + "; expected " + least + "x" + least + " to " +
                          most + "x" + most + ", or 0x0 for as large as the server allows",
                      "width");
  }
  viewer_size_ = wanted;
  ports_.kept_changed();
  for (const auto& [key, viewer] : viewers_) {
    viewer->session_pixels = pixels_of(viewer_size_);
    if (viewer->viewport.width() > 0) viewer->set_viewport(v1::Viewport(viewer->viewport), now);
  }
  changed();
  return std::nullopt;
}

void Participants::set_role(Viewer& viewer, const v1::SetRole& wanted, TimePoint now, const Reply& reply) {
  if (wanted.role() != v1::ROLE_CONTROLLER && wanted.role() != v1::ROLE_VIEWER)
    return reply(wire_error("invalid_argument",
                            "role is " + std::to_string(wanted.role()) + "; expected ROLE_CONTROLLER (1) or ROLE_VIEWER (2)",
                            "role"));
  Viewer* of = wanted.participant() == 0 ? &viewer : find(wanted.participant());
  if (!of)
    return reply(wire_error("not_found", "participant " + std::to_string(wanted.participant()) + " is not in this session",
                            "participant"));
  if (of->role == wanted.role()) {
    v1::ServerMessage answer;
    *answer.mutable_participants() = to_wire();
    viewer.outbox->send(std::move(answer));
    return reply(std::nullopt);
  }
  const auto controllers = std::ranges::count_if(viewers_, [](const auto& v) { return v.second->role == v1::ROLE_CONTROLLER; });
  if (wanted.role() == v1::ROLE_VIEWER && controllers <= 1)
    return reply(
        wire_error("invalid_argument", "this is the session's last controller; make somebody else a controller first", "role"));
  of->role = wanted.role();
  if (of->viewport.width() > 0) of->set_viewport(v1::Viewport(of->viewport), now);
  changed();
  reply(std::nullopt);
}

Invitations::Made Participants::invite(const v1::CreateInvitation& wanted, const std::string& made_by) {
  expire(unix_ms_now());
  Invitations::Made made = invitations_.make(wanted, unix_ms_now(), made_by);
  if (!made.error) ports_.kept_changed();
  return made;
}

bool Participants::revoke(const std::string& invitation) {
  const auto over = invitations_.revoke(invitation);
  if (over.empty()) return false;
  ports_.kept_changed();
  for (const std::string& one : over) ports_.invitation_ended(one);
  return true;
}

void Participants::expire(UnixMs now) {
  const auto over = invitations_.expire(now);
  if (!over.empty()) ports_.kept_changed();
  for (const std::string& invitation : over) ports_.invitation_ended(invitation);
}

v1::Invitation Participants::to_wire(const Invitation& invitation) const {
  v1::Invitation out;
  out.set_id(invitation.id);
  out.set_role(invitation.role);
  out.set_expires_unix_ms(static_cast<double>(invitation.expires));
  out.set_name(invitation.name);
  out.set_present(static_cast<std::uint32_t>(
      std::ranges::count_if(viewers_, [&](const auto& v) { return v.second->invitation == invitation.id; })));
  return out;
}

// Those that the viewer may take back.
void Participants::list_invitations(const Viewer& viewer) const {
  v1::ServerMessage answer;
  answer.mutable_invitations();
  for (const Invitation& invitation : invitations_.all())
    if (invitations_.descends(invitation.id, viewer.invitation)) *answer.mutable_invitations()->add_invitations() = to_wire(invitation);
  viewer.outbox->send(std::move(answer));
}

}  // namespace isostrata
