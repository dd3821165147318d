// Server-sent events on their way to one client.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>

namespace isostrata {

/// Filled by whoever has news, emptied by the connection. Bounded: an event whose name is that of the last one that waits
/// replaces it where `latest` says so, one that is written later waits once, and who does not read 64 events is cut off. Not
/// thread-safe: lives on the io thread.
class EventStream {
 public:
  void push(const std::string& event, const std::string& data, bool latest) {
    if (ended_) return;
    if (latest && !waiting_.empty() && waiting_.back().event == event)
      waiting_.back().data = data;
    else
      add({event, data, {}});
    if (wake) wake();
  }
  /// Its data is made when it is read; none: there is no such event. Where one of the name waits already, that one stands for
  /// both.
  void push_later(const std::string& event, std::function<std::string()> make) {
    if (ended_) return;
    for (const Event& waiting : waiting_)
      if (waiting.make && waiting.event == event) return;
    add({event, {}, std::move(make)});
    if (wake) wake();
  }
  /// Nothing comes after what waits.
  void end() {
    ended_ = true;
    if (wake) wake();
  }

  std::optional<std::string> take() {
    while (!waiting_.empty()) {
      const Event event = std::move(waiting_.front());
      waiting_.pop_front();
      const std::string data = event.make ? event.make() : event.data;
      if (!data.empty()) return "event: " + event.event + "\ndata: " + data + "\n\n";
    }
    return std::nullopt;
  }
  bool ended() const { return ended_ && waiting_.empty(); }

  std::function<void()> wake;  // set by the connection

 private:
  static constexpr std::size_t kMost = 64;
  struct Event {
    std::string event, data;
    std::function<std::string()> make;  // in place of data
  };
  void add(Event event) {
    waiting_.push_back(std::move(event));
    if (waiting_.size() <= kMost) return;
    waiting_.clear();
    ended_ = true;
  }
  std::deque<Event> waiting_;
  bool ended_ = false;
};

}  // namespace isostrata
