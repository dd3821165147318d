// The people of a session: who is in it, who may change what is shown, and whom they invite.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "session/people/invitations.h"
#include "session/people/viewer.h"

namespace isostrata {

/// Of one session. Not thread-safe: lives on the io thread.
///
/// Who has the server's token may do all. A controller who was invited may do nothing to those whom it has not invited itself. Who may only
/// look changes neither the scene nor what concerns others.
class Participants {
 public:
  using Reply = std::function<void(std::optional<v1::Error> error)>;  // none: done

  struct Ports {
    std::function<void()> people_changed;       // who is there, or what one of them may do; before everyone is told
    std::function<void()> kept_changed;    // invitations, or how large pictures may be: to be kept before anybody is told
    /// Whoever came by it is to be cut off; not called back from within.
    std::function<void(const std::string& invitation)> invitation_ended;
  };
  explicit Participants(Ports ports) : ports_(std::move(ports)) {}

  // ---- who is there ----

  /// The viewer must live until remove(). Neither tells anybody: changed() does.
  void add(Viewer& viewer);
  void remove(const Viewer& viewer) { viewers_.erase(viewer.key); }
  const std::map<ViewerKey, Viewer*>& viewers() const { return viewers_; }
  bool empty() const { return viewers_.empty(); }
  std::size_t size() const { return viewers_.size(); }
  /// Null: it is not there.
  Viewer* find(ViewerKey key) const;
  /// The client on its newest connection; null if it has none.
  Viewer* find_client(const std::string& client_id) const;
  void tell(const v1::ServerMessage& message) const;
  /// Tells everyone who is there, and in which role.
  void changed() const;
  v1::Participants to_wire() const;

  // ---- who may do what ----

  /// Why the viewer may not do what the message asks for; nothing if it may.
  std::optional<std::string> forbidden(const Viewer& viewer, const v1::ClientMessage& message) const;
  /// If the message is about people, which it must not be forbidden(), does what it asks for, and answers the viewer or the reply.
  bool answer(Viewer& viewer, const v1::ClientMessage& message, TimePoint now, const Reply& reply);

  // ---- how large the pictures of those who may only look may be ----

  const v1::SetViewerSize& viewer_size() const { return viewer_size_; }
  void restore(const v1::SetViewerSize& viewer_size);
  /// Tells everyone. Returns why not.
  std::optional<v1::Error> set_viewer_size(const v1::SetViewerSize& wanted, TimePoint now);

  // ---- invitations ----

  const Invitations& invitations() const { return invitations_; }
  void restore(std::vector<Invitation> invitations) { invitations_.restore(std::move(invitations)); }
  /// made_by: as Invitation's.
  Invitations::Made invite(const v1::CreateInvitation& wanted, const std::string& made_by = {});
  /// Cuts off whoever came by it. False if there is none of this id.
  bool revoke(const std::string& invitation);
  void expire(UnixMs now);
  v1::Invitation to_wire(const Invitation& invitation) const;

 private:
  void set_role(Viewer& viewer, const v1::SetRole& wanted, TimePoint now, const Reply& reply);
  void list_invitations(const Viewer& viewer) const;

  const Ports ports_;
  std::map<ViewerKey, Viewer*> viewers_;
  Invitations invitations_;
  v1::SetViewerSize viewer_size_;
};

}  // namespace isostrata
