#include "session/people/invitations.h"

#include <algorithm>
#include <cmath>

#include "session/wire/limits.h"
#include "session/wire/random_token.h"
#include "session/wire/wire.h"

namespace isostrata {

Invitations::Made Invitations::make(const v1::CreateInvitation& wanted, UnixMs now, const std::string& made_by) {
  const auto refused = [](const char* code, const std::string& message, const char* field) {
    return Made{wire_error(code, message, field), nullptr, {}};
  };
  if (wanted.role() != v1::ROLE_CONTROLLER && wanted.role() != v1::ROLE_VIEWER)
    return refused("invalid_argument",
                   "role is " + std::to_string(wanted.role()) + "; expected ROLE_CONTROLLER (1) or ROLE_VIEWER (2)", "role");
  const double seconds = wanted.seconds() == 0 ? kDefaultSeconds : wanted.seconds();
  if (!(seconds >= kMinSeconds && seconds <= kMaxSeconds))
    return refused("invalid_argument", "seconds is " + std::to_string(seconds) + "; expected 1 to 31536000, or 0 for a day",
                   "seconds");
  if (wanted.name().size() > kMaxPersonBytes)
    return refused(
        "invalid_argument",
        "name has " + std::to_string(wanted.name().size()) + " bytes; expected at most " + std::to_string(kMaxPersonBytes),
        "name");
  if (all_.size() >= kMaxInvitations)
    return refused("unavailable",
                   "this session has its " + std::to_string(kMaxInvitations) + " invitations (max_invitations); revoke one first",
                   "");
  UnixMs expires = now + std::llround(seconds * 1000);
  if (!made_by.empty()) {
    const Invitation* own = find_id(made_by);
    if (!own) return refused("forbidden", "the invitation is over or was taken back", "");
    if (own->role != v1::ROLE_CONTROLLER && wanted.role() == v1::ROLE_CONTROLLER)
      return refused("forbidden", "who was invited to look may invite others to look, and not to control", "role");
    expires = std::min(expires, own->expires);
    if (std::count_if(all_.begin(), all_.end(), [&](const Invitation& i) { return i.made_by == made_by; }) >=
        static_cast<std::ptrdiff_t>(kMaxByGuest))
      return refused("unavailable", "who was invited may have made " + std::to_string(kMaxByGuest) + " invitations; revoke one first", "");
  }
  std::string token = random_token(192);
  all_.push_back({random_token(64), secret_hash(token), wanted.role(), expires, wanted.name(), made_by});
  return {std::nullopt, &all_.back(), std::move(token)};
}

std::vector<std::string> Invitations::revoke(const std::string& id) {
  if (!find_id(id)) return {};
  std::vector<std::string> over;
  for (const Invitation& invitation : all_)
    if (invitation.id == id || descends(invitation.id, id)) over.push_back(invitation.id);
  std::erase_if(all_, [&](const Invitation& i) { return std::find(over.begin(), over.end(), i.id) != over.end(); });
  return over;
}

bool Invitations::descends(const std::string& id, const std::string& from) const {
  // A maker stands before what it made, so the way up ends.
  for (const Invitation* at = find_id(id); at; at = find_id(at->made_by))
    if (at->made_by == from) return true;
  return from.empty();
}

std::vector<std::string> Invitations::expire(UnixMs now) {
  std::vector<std::string> over;
  for (const Invitation& invitation : all_)
    if (invitation.expires <= now) over.push_back(invitation.id);
  std::erase_if(all_, [&](const Invitation& i) { return i.expires <= now; });
  return over;
}

const Invitation* Invitations::find(const std::string& token_hash, UnixMs now) const {
  const Invitation* found = nullptr;
  for (const Invitation& invitation : all_)
    if (equal_in_constant_time(invitation.token_hash, token_hash) && invitation.expires > now) found = &invitation;
  return found;
}

const Invitation* Invitations::find(const std::string& text, const std::string& proof, UnixMs now) const {
  const Invitation* found = nullptr;
  for (const Invitation& invitation : all_)
    if (invitation.expires > now && equal_in_constant_time(proof_of(invitation.token_hash, text), proof)) found = &invitation;
  return found;
}

const Invitation* Invitations::find_id(const std::string& id) const {
  const auto it = std::find_if(all_.begin(), all_.end(), [&](const Invitation& i) { return i.id == id; });
  return it == all_.end() ? nullptr : &*it;
}

}  // namespace isostrata
