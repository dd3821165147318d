// The way to an engine that answers when the test says so, without sessions behind it.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "session/datasets/engine_door.h"

namespace isostrata {

struct AskedEngine : EngineDoor {
  void post(EngineRequest request) override { posted.push_back(std::move(request)); }
  RequestId ask(EngineRequest request, Listener listener) override {
    asked.push_back(std::move(request));
    listeners[++last] = std::move(listener);
    return last;
  }
  void forget(RequestId request) override { listeners.erase(request); }

  /// The last word about a request.
  void answer(RequestId request, const EngineEvent& event, TimePoint now = {}) {
    const auto node = listeners.extract(request);
    ASSERT_FALSE(node.empty()) << "nobody waits";
    node.mapped()(event, now);
  }

  std::vector<EngineRequest> posted, asked;  // asked[i] has the number i + 1
  std::map<RequestId, Listener> listeners;
  RequestId last = 0;
};

}  // namespace isostrata
