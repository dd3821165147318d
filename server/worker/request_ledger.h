// What has been asked of a worker and not been answered, and the newest scene of each session: all that another worker needs to
// go on where one has died. Pure bookkeeping; nothing here waits or sends.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/messages/activity.h"
#include "engine/messages/messages.h"

namespace isostrata {

/// Not thread-safe.
///
/// Every request is answered once, whatever becomes of the workers: answers to requests that are not open are dropped, and so is
/// a FrameStarted for a frame that had begun in an earlier life. Operations have numbers of their own in every life, so that one
/// of the past is not taken for one of today.
class RequestLedger {
 public:
  static constexpr int kMostDeaths = 2;       // of workers while they were at one request; then it is answered with the cause
  static constexpr int kMostSceneDeaths = 3;  // while they were at one session's scene; then it is withheld
  static constexpr std::uint64_t kWatchdog = 0xffffffff;  // the operation of a life by which a watchdog speaks

  /// What there is to send and to say at once.
  struct Outcome {
    std::optional<EngineRequest> request;
    std::optional<EngineEvent> event;
    bool give_up_worker = false;  // somebody cancelled the watchdog's operation
  };
  Outcome ask(EngineRequest request);

  /// The event as viewers may see it.
  std::optional<EngineEvent> hear(EngineEvent event);

  /// Of an answered request that was posted and not sent yet: whether it is still wanted.
  bool open(RequestId request) const { return requests_.contains(request); }

  /// Begins the next life; gives all that its worker must be told, in order.
  std::vector<EngineRequest> begin_life();
  /// The worker is dead; `at` says what it was doing. Gives what viewers must hear. may_withhold: scenes that killed workers
  /// again and again are kept from the next ones until they change.
  std::vector<EngineEvent> end_life(const std::vector<ActivityFacts>& at, const std::string& cause, bool may_withhold);
  /// Nobody is to blame any more: another renderer draws from now on.
  void forgive();
  /// Whether nobody waits for anything.
  bool idle() const { return requests_.empty() && operations_.empty(); }
  /// No worker can draw: answers to everything that is open.
  std::vector<EngineEvent> give_up(const std::string& cause);

  /// Something that viewers with open requests should see, as the progress of the watchdog's operation.
  std::vector<EngineEvent> announce(const std::string& text, double fraction);
  /// Ends what was announced.
  std::vector<EngineEvent> unannounce();

  std::size_t open_requests() const { return requests_.size(); }

 private:
  struct Open {
    EngineRequest request;
    SessionKey session = 0;
    std::uint64_t order = 0;
    bool started = false;  // FrameStarted has been passed on
    int deaths = 0;
  };
  struct Session {
    std::optional<Scene> scene;
    bool rests = false;    // as RestScene says
    int deaths = 0;        // in a row, of workers that were at its scene
    std::string withheld;  // why; empty: it is not
  };

  std::uint64_t wire(std::uint64_t operation) const { return (life_ << 32) | (operation & 0xffffffff); }
  RequestFailed failure(SessionKey session, RequestId request, const std::string& why) const;

  std::map<RequestId, Open> requests_;
  std::map<SessionKey, Session> sessions_;
  std::set<std::pair<SessionKey, std::uint64_t>> operations_;  // announced and not done
  std::set<SessionKey> announced_;                             // to whom the watchdog speaks
  std::uint64_t life_ = 0;
  std::uint64_t orders_ = 0;
};

/// request_of those requests that are answered once; 0 for others.
RequestId answered_request_of(const EngineRequest& request);

}  // namespace isostrata
