// A long thin line to a server, made of a loopback one: a TCP proxy that hands bytes on late and no faster than a rate. For
// measurements and tests on machines whose kernel has no netem.
//
// Each direction is a bottleneck with a queue and a delay behind it: a segment leaves when those before it have left and its own
// bits have passed at the rate, and arrives half a round trip later. The queue holds up to 2 MiB, as an ssh tunnel's does, and
// then stops reading, so that a sender that trusts the socket's word fills it with seconds of stale frames. Nothing is lost.
#pragma once

#include <chrono>
#include <memory>

namespace isostrata {

struct LinkShape {
  std::chrono::microseconds round_trip{0};
  double bits_per_second = 0;  // each way; 0: no limit
};

class ShapedLink {
 public:
  /// Listens on a free port of 127.0.0.1 and joins each connection with 127.0.0.1:target_port, in a thread of its own. Throws
  /// unavailable.
  ShapedLink(unsigned short target_port, const LinkShape& shape);
  ~ShapedLink();
  ShapedLink(const ShapedLink&) = delete;
  ShapedLink& operator=(const ShapedLink&) = delete;

  unsigned short port() const;
  /// From now on, for open connections too. Any thread.
  void reshape(const LinkShape& shape);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isostrata
