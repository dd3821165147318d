// Clients with bad manners, for measuring what the others notice of them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace isostrata {

/// One of hostile_manners(), in a thread of its own, with a session of its own that shows `dataset` in a viewport of 160x120:
///   polite        turns its camera 60 times a second and acknowledges its frames: what any neighbour costs
///   flood         turns it 10,000 times a second, on a page that shows
///   flood-hidden  the same on a hidden page, for which nothing is drawn
///   reader        asks for pictures and reads a byte a second
///   vanish        connects, says Hello, opens the dataset and is gone, 50 times a second
///   garbage       sends 10,000 messages a second of which each has a field out of range, and now and then one that is none at
///   all
class HostileClient {
 public:
  /// Connects once before it returns. Throws unavailable, invalid_argument.
  HostileClient(unsigned short port, std::string token, std::string dataset, const std::string& manners);
  ~HostileClient();
  HostileClient(const HostileClient&) = delete;
  HostileClient& operator=(const HostileClient&) = delete;

  /// What it has done so far.
  std::uint64_t messages() const;
  std::uint64_t connections() const;
  double cpu_seconds() const;  // of its thread, to tell its own cost from the server's

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

const std::vector<std::string>& hostile_manners();

}  // namespace isostrata
