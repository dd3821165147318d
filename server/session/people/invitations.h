// Links that let others into one session. What is kept of an invitation's token is its hash.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/unix_time.h"
#include "isostrata/v1/isostrata.pb.h"

namespace isostrata {

struct Invitation {
  std::string id;
  std::string token_hash;  // 32 bytes
  v1::Role role = v1::ROLE_VIEWER;
  UnixMs expires = 0;
  std::string name;
  std::string made_by;  // the id of the invitation by which its maker came; empty: somebody with the server's token
};

/// Of one session. Not thread-safe: lives on the io thread.
class Invitations {
 public:
  static constexpr std::size_t kMaxInvitations = 64;
  static constexpr double kDefaultSeconds = 86400, kMinSeconds = 1, kMaxSeconds = 31536000;

  struct Made {
    std::optional<v1::Error> error;
    const Invitation* invitation = nullptr;
    std::string token;  // the only time that it is known
  };
  static constexpr std::size_t kMaxByGuest = 8;
  /// made_by: as Invitation's. What one who was invited makes is over when that one's own is, at the latest.
  Made make(const v1::CreateInvitation& wanted, UnixMs now, const std::string& made_by = {});
  /// Takes it out, with those that were made by it, by these, and so on; their ids. None if there is none of this id.
  std::vector<std::string> revoke(const std::string& id);
  /// Whether it was made by that one, or by one that was. One without an id has made them all.
  bool descends(const std::string& id, const std::string& from) const;
  /// Takes out those whose time is over; their ids.
  std::vector<std::string> expire(UnixMs now);

  /// The one whose token has this hash, if its time is not over. Takes as long for every token.
  const Invitation* find(const std::string& token_hash, UnixMs now) const;
  /// The one by which proof_of(secret_hash(token), text) is this proof, if its time is not over.
  const Invitation* find(const std::string& text, const std::string& proof, UnixMs now) const;
  const Invitation* find_id(const std::string& id) const;
  const std::vector<Invitation>& all() const { return all_; }  // the oldest first
  void restore(std::vector<Invitation> all) { all_ = std::move(all); }

 private:
  std::vector<Invitation> all_;
};

}  // namespace isostrata
