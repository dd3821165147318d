// The way to one session, which is made anew if it is lost: the newest token joins the session again, and commands that the
// server has not judged are sent again. Two things make that exact. Commands have numbers of this client's own over all its
// connections, and Welcome says the newest that was judged. And messages have numbers towards the caller that grow over all
// connections, too: what the server says of a message of one connection is translated, so that whoever waits for a frame of
// some input waits for the same number before and after.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "web_socket.h"

namespace isostrata::client {

class Connection {
 public:
  /// Connects, says Hello, and has received Welcome. Throws ClientError.
  explicit Connection(Options options);

  /// Its number. Commands get their number here. Does not wait.
  std::uint64_t send(v1::ClientMessage message);
  /// The next message; of a connection made anew its Welcome, and then what follows. Throws ClientError: "closed", "cancelled",
  /// "session_lost", and what a server may refuse a connection with.
  std::optional<v1::ServerMessage> receive_until(Steady::time_point deadline);
  /// Keeps the connection alive without taking messages, until then.
  void keep_until(Steady::time_point deadline);
  void close();
  /// What decoding a frame took: the next acknowledgement tells the server, which chooses formats by it among others.
  void note_decoded(std::uint64_t frame, double ms) {
    decoded_frame_ = frame;
    decoded_ms_ = ms;
  }

  const Options& options() const { return options_; }
  const std::string& session() const { return session_; }
  /// How often it has been made.
  int made() const { return made_; }
  /// The number that the newest command has.
  std::uint64_t last_command() const { return last_command_; }

 private:
  struct Sent {
    std::uint64_t number, command;
    v1::ClientMessage message;
    Steady::time_point at;
    std::size_t bytes;
    bool judged = false;
  };
  struct Mark {
    double client_time_ms;
    std::uint64_t number;  // of its Ping
    bool ours;
  };

  void open(Steady::time_point deadline);
  void arrived(const void* data, std::size_t size);
  void note(v1::ServerMessage& message);
  void judged_until(std::uint64_t number);
  void forget_old();
  void write(v1::ClientMessage& message);
  void acknowledge(std::uint64_t frame);
  void run(Steady::time_point deadline);
  bool lost() const { return !socket_ || socket_->failed(); }  // none: a stop was seen while it was being made
  std::string why_lost() const;
  [[noreturn]] void stop();
  [[noreturn]] void give_up(const std::string& code, const std::string& why);
  void recover();
  void wait_for_welcome(Steady::time_point deadline);
  void wait_for_dataset(Steady::time_point deadline);
  std::size_t send_again(const v1::Welcome& welcome, bool same_session, std::uint64_t known_revision);
  void bring_state_back(const std::string& session, const v1::State& known);
  void tell(const ConnectionEvent& event) const {
    if (options_.on_connection) options_.on_connection(event);
  }
  std::uint64_t own_number(std::uint64_t wire) const;
  std::uint64_t exact_number(std::uint64_t wire) const;

  Options options_;
  ServerAddress address_;
  bool joined_ = false;  // somebody else's session: without it there is nothing to go on with
  std::string client_id_, session_;
  std::unique_ptr<WebSocket> socket_;
  int made_ = 0;
  std::optional<std::pair<std::string, std::string>> ended_;  // code and why, once it has been given up

  std::uint64_t last_number_ = 0, last_command_ = 0;
  std::size_t log_bytes_ = 0;
  std::deque<Sent> log_;    // commands, oldest first: those not judged, and for a while those that were
  std::deque<Mark> marks_;  // pings without an answer
  std::size_t since_mark_ = 0;
  bool interacting_ = false;

  // Of this connection: the numbers that messages have on the wire, and here.
  std::uint64_t last_wire_ = 0, contained_ = 0;
  std::deque<std::pair<std::uint64_t, std::uint64_t>> numbers_;

  std::deque<v1::ServerMessage> incoming_;
  std::size_t frames_waiting_ = 0;   // among them
  std::uint64_t decoded_frame_ = 0;  // whose decoding has not been told; 0: none
  double decoded_ms_ = 0;
  v1::State newest_state_;
  std::string last_words_;
  bool ends_for_good_ = false;   // the server has said so
  std::uint64_t operation_ = 0;  // the newest that has told of its progress and has not ended
};

}  // namespace isostrata::client
