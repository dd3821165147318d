#include "session/people/observed_acts.h"

#include "session/commands/apply_command.h"

namespace isostrata {
namespace {

std::string name_of(v1::Role role) { return role == v1::ROLE_CONTROLLER ? "controller" : role == v1::ROLE_VIEWER ? "viewer" : "no role"; }

}  // namespace

std::optional<ObservedAct> ObservedActs::note(const v1::ClientMessage& message, TimePoint now) {
  const int kind = message.body_case();
  std::string detail;
  switch (kind) {
    case v1::ClientMessage::kOpenDataset:
      detail = message.open_dataset().id();
      for (const std::string& part : {message.open_dataset().region(), message.open_dataset().stride()})
        if (!part.empty()) detail += ' ' + part;
      break;
    case v1::ClientMessage::kSetRole:
      detail = name_of(message.set_role().role()) + (message.set_role().participant() ? " of w" + std::to_string(message.set_role().participant()) : "");
      break;
    case v1::ClientMessage::kSetViewerSize:
      detail = std::to_string(message.set_viewer_size().width()) + "x" + std::to_string(message.set_viewer_size().height());
      break;
    case v1::ClientMessage::kCreateInvitation:
      detail = name_of(message.create_invitation().role());
      break;
    case v1::ClientMessage::kRevokeInvitation:
      detail = message.revoke_invitation().id();
      break;
    case v1::ClientMessage::kCancel:
      break;
    default:
      if (!is_scene_command(message) || (kind_ == kind && now - at_ < kOneDrag)) return std::nullopt;
  }
  kind_ = kind;
  at_ = now;
  const auto* field = message.GetDescriptor()->FindFieldByNumber(kind);
  return ObservedAct{field ? std::string(field->name()) : "", std::move(detail)};
}

}  // namespace isostrata
