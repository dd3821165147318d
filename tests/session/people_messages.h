// What tests of people say: roles and invitations.
#pragma once

#include "session/fake_engine.h"

namespace isostrata {

inline v1::ClientMessage role_of(std::uint64_t participant, v1::Role role) {
  v1::ClientMessage message;
  message.mutable_set_role()->set_participant(participant);
  message.mutable_set_role()->set_role(role);
  return message;
}

inline v1::ClientMessage invite(v1::Role role, double seconds = 0) {
  v1::ClientMessage message;
  message.mutable_create_invitation()->set_role(role);
  message.mutable_create_invitation()->set_seconds(seconds);
  return message;
}

inline v1::ClientMessage revoke(const std::string& id) {
  v1::ClientMessage message;
  message.mutable_revoke_invitation()->set_id(id);
  return message;
}

inline v1::ClientMessage viewer_size(std::uint32_t width, std::uint32_t height) {
  v1::ClientMessage message;
  message.mutable_set_viewer_size()->set_width(width);
  message.mutable_set_viewer_size()->set_height(height);
  return message;
}

inline v1::Invitation invitation_of(const FakeClient& client) {
  return client.outbox.newest([](const auto& m) { return m.has_invitation(); }).invitation();
}

}  // namespace isostrata
