// Which commands of which client were judged, over all its connections, so that one that is sent again is done once and a verdict that was
// lost with its connection is told with the next welcome.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "isostrata/v1/isostrata.pb.h"

namespace isostrata {

/// Whose command it is and its number, which grows with each of this client; none: {}.
struct CommandNumber {
  std::string client;
  std::uint64_t number = 0;

  bool operator==(const CommandNumber&) const = default;
};

/// Of one session. Not thread-safe: lives on the io thread.
class ClientCommands {
 public:
  static constexpr std::size_t kMostClients = 32;  // whose newest command is remembered; of guests as many again

  struct Newest {
    CommandNumber command;
    bool guest = false;                   // an invitation's
    std::optional<v1::Error> error = {};  // what it was refused with, if that is known
  };

  /// Whether it, or a later one of this client, was judged before; else it is the client's newest from now on. One without a number or a
  /// client never was. A client that is one too many makes the one forgotten that was heard the longest ago: guests, who may call
  /// themselves what they like, make other guests forgotten and nobody else.
  bool done_before(const CommandNumber& command, bool guest);
  /// Nothing if it is not the client's newest any more.
  void note_refused(const CommandNumber& command, const v1::Error& error);

  /// The number of the newest one that was judged; 0: none.
  std::uint64_t last(const std::string& client) const;
  /// What that one was refused with; null: it was done, or it is not known.
  const v1::Error* last_error(const std::string& client) const;

  /// The one that was heard last first.
  const std::deque<Newest>& all() const { return all_; }
  /// One that a journal has kept: in the order of all().
  void restore(Newest newest) { all_.push_back(std::move(newest)); }

 private:
  const Newest* find(const std::string& client) const;

  std::deque<Newest> all_;
};

}  // namespace isostrata
