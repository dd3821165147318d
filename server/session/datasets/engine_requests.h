// The engine as all sessions of a server see it: datasets have the names that clients know, and each answer finds who waits for it.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "session/datasets/dataset_versions.h"
#include "session/datasets/engine_door.h"
#include "session/datasets/pending_requests.h"

namespace isostrata {

/// Not thread-safe: lives on the io thread.
class EngineRequests final : public EngineDoor {
 public:
  struct Ports {
    std::function<void(EngineRequest)> post;        // Engine::post
    std::function<std::string(SessionKey)> shown;  // the version that the session shows, by the engine's id; empty: none
  };
  /// The rest is as DatasetVersions has it.
  EngineRequests(Ports ports, std::shared_ptr<const Catalogue> catalogue, std::string watching, bool follows_files);

  DatasetVersions& versions() { return versions_; }
  const DatasetVersions& versions() const { return versions_; }

  void post(EngineRequest request) override;
  RequestId ask(EngineRequest request, Listener listener) override;
  void forget(RequestId request) override { pending_.forget(request); }
  const CatalogueEntry* entry(const std::string& dataset) const override { return versions_.entry(dataset); }
  std::string newest(const std::string& dataset) override { return versions_.newest(dataset); }
  /// Nobody wants the answer any more: the listener will not be called, and the work ends. One that was answered is ignored.
  void give_up(RequestId request);

  /// Tells whoever waits for it; the event is about a request, and has clients' names (DatasetVersions::name_for_clients).
  void answer(const EngineEvent& event, TimePoint now) { pending_.answer(event, now); }
  /// Whoever waits for an answer of this session hears that it has ended.
  void end(SessionKey session, TimePoint now) { pending_.end(session, now); }
  /// Nobody waits any more.
  void clear() { pending_.clear(); }

 private:
  const Ports ports_;
  DatasetVersions versions_;
  PendingRequests pending_;
};

}  // namespace isostrata
