// Server-sent events on their way to one client.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <string>

namespace isostrata {

/// Filled by whoever has news, emptied by the connection. Bounded: an event whose name is that of the last one that waits
/// replaces it where `latest` says so, and who does not read 64 events is cut off. Not thread-safe: lives on the io thread.
class EventStream {
 public:
  void push(const std::string& event, const std::string& data, bool latest) {
    if (ended_) return;
    std::string text = "event: " + event + "\ndata: " + data + "\n\n";
    if (latest && !waiting_.empty() && waiting_.back().event == event)
      waiting_.back().text = std::move(text);
    else
      waiting_.push_back({event, std::move(text)});
    if (waiting_.size() > kMost) {
      waiting_.clear();
      ended_ = true;
    }
    if (wake) wake();
  }
  /// Nothing comes after what waits.
  void end() {
    ended_ = true;
    if (wake) wake();
  }

  std::optional<std::string> take() {
    if (waiting_.empty()) return std::nullopt;
    std::string text = std::move(waiting_.front().text);
    waiting_.pop_front();
    return text;
  }
  bool ended() const { return ended_ && waiting_.empty(); }

  std::function<void()> wake;  // set by the connection

 private:
  static constexpr std::size_t kMost = 64;
  struct Event {
    std::string event, text;
  };
  std::deque<Event> waiting_;
  bool ended_ = false;
};

}  // namespace isostrata
