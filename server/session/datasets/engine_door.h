// How a session reaches the engine.
#pragma once

#include <functional>
#include <string>

#include "engine/messages/messages.h"
#include "session/pacing/link_model.h"

namespace isostrata {

/// Asked for something, the engine answers to the listener with that request's events, the last of which is DatasetReady, HistogramReady,
/// FrameReady, another ...Ready, or RequestFailed. Not thread-safe: lives on the io thread; no call calls a listener back from within.
class EngineDoor {
 public:
  using Listener = std::function<void(const EngineEvent& event, TimePoint now)>;
  virtual ~EngineDoor() = default;
  virtual void post(EngineRequest request) = 0;
  /// Gives the request its number, posts it, and returns the number.
  virtual RequestId ask(EngineRequest request, Listener listener) = 0;
  /// The listener will not be called any more.
  virtual void forget(RequestId request) = 0;
  /// What the catalogue says of a dataset now; null: nothing, or nothing follows the files.
  virtual const CatalogueEntry* entry(const std::string& /*dataset*/) const { return nullptr; }
  /// The id by which the engine knows the newest version of it (version_id).
  virtual std::string newest(const std::string& dataset) { return dataset; }
};

}  // namespace isostrata
