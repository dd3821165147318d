// The places of one server for connections, and who has to give one back when all are taken: a crowd of connections that say
// nothing must not keep out whoever has the token.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <string>

namespace isostrata {

/// What a connection has shown so far, from the one that loses its place first to the one that loses it last.
enum class Caller { stranger, guest, owner };  // no token; an invitation's; the server's, or none is asked for

/// Not thread-safe: lives on the io thread.
class Places {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Places(std::size_t most) : most_(most) {}
  std::size_t taken() const { return taken_.size(); }
  /// Whether another guest may enter a session: a quarter of the places is for others, whoever was invited.
  bool guests_may_settle() const;

  /// Whether there is a place for one who comes. Where all are taken, a stranger loses his: of the address that has most of
  /// them, the one who has waited the longest. Where there is none, a guest who is in no session, then a connection of the
  /// owner's that waits between two requests.
  bool make_room();
  /// Ends every connection.
  void close_all();

 private:
  struct Taken {
    std::string address;
    std::function<void()> close;
    Caller caller = Caller::stranger;
    bool idle = true;      // between two requests
    bool settled = false;  // in a session
    Clock::time_point since = Clock::now();
  };

 public:
  /// One connection's, as long as it lives. What is done with one that was taken away does nothing.
  class Place {
   public:
    /// close: ends the connection; called at most once.
    Place(Places& places, std::string address, std::function<void()> close);
    ~Place() { places_.taken_.erase(id_); }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

    void set_close(std::function<void()> close);
    /// Never less than before.
    void show(Caller caller);
    Caller caller() const { return caller_; }
    void be_idle(bool idle);
    void settle();

   private:
    Places& places_;
    const std::size_t id_;
    Caller caller_ = Caller::stranger;
  };

 private:
  const std::size_t most_;
  std::size_t last_ = 0;
  std::map<std::size_t, Taken> taken_;
};

}  // namespace isostrata
