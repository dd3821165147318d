// The heavy things that a session can ask for, as its neighbours know them: for `isostrata bench neighbours`.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace isostrata {

/// A session of the server under test.
struct HeavySession {
  unsigned short port = 0;
  std::string token;
  std::string id;  // of the session

  /// Throws unavailable if the answer is an error.
  std::string ask(const std::string& method, const std::string& path, const std::string& body = {}) const;
};

struct NeighbourWork {
  std::string name;
  std::string dataset;          // as the catalogue has it
  bool ends = true;             // by itself: then it can be timed
  /// Makes the session what the work needs.
  std::function<void(const HeavySession&)> prepare;
  /// Until it is done, or soon after `stop`. False if it failed.
  std::function<bool(const HeavySession&, const std::atomic<bool>& stop)> work;
};

/// What `serve` is started with for them; files among it are written into `folder`, which is made.
std::vector<std::string> neighbour_data(const std::filesystem::path& folder);
std::vector<NeighbourWork> neighbour_works();

}  // namespace isostrata
