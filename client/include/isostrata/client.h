// A thin C++ client of an Isostrata server: one WebSocket, the messages of protocol/isostrata/v1/isostrata.proto, blocking calls.
//
//   auto connection = isostrata::client::Connection::open("http://127.0.0.1:8080/?token=...", {.width = 800, .height = 600});
//   isostrata::v1::ClientMessage open;
//   open.mutable_open_dataset()->set_id(connection.welcome().datasets(0).id());
//   const auto seq = connection.send(open);
//   isostrata::v1::ClientMessage still;
//   still.mutable_request_still();
//   connection.send(still);
//   const auto frame = connection.wait_for_frame(seq, /*lossless=*/true, std::chrono::seconds(30));   // frame.payload() is a PNG
//
// A Connection belongs to one thread at a time. Everything that can fail throws client::Error.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "isostrata/v1/isostrata.pb.h"

namespace isostrata::client {

/// code: one of the server's codes ("not_found", ...), or "connection", "timeout", "address", "refused" (HTTP status in the message).
class Error : public std::runtime_error {
 public:
  Error(std::string code, const std::string& message) : std::runtime_error(message), code_(std::move(code)) {}
  const std::string& code() const { return code_; }

 private:
  std::string code_;
};

/// What a server prints: http://HOST:PORT/BASE/?token=TOKEN.
struct Address {
  std::string host;
  std::string port;
  std::string base = "/";  // begins and ends with a slash
  std::string token;       // empty: none
};
Address parse_address(std::string_view url);

struct Options {
  std::uint32_t width = 800, height = 600;  // of the frames, in pixels
  std::string resume_token;                 // of an earlier welcome(); empty: a new session
  std::chrono::milliseconds connect_timeout{10'000};
};

class Connection {
 public:
  /// Connects, says Hello and waits for Welcome.
  static Connection open(std::string_view url, const Options& options);
  Connection(Connection&&) noexcept;
  Connection& operator=(Connection&&) noexcept;
  ~Connection();  // closes without waiting

  const v1::Welcome& welcome() const;

  /// Sends a command; seq is filled in and returned.
  std::uint64_t send(v1::ClientMessage message);

  /// The next message from the server, or nothing after the timeout. A Frame must be acknowledged, or no more follow.
  std::optional<v1::ServerMessage> receive(std::chrono::milliseconds timeout);

  /// Tells the server that a frame was decoded; it sends the next only then. decode_ms is for the server's statistics.
  void acknowledge(const v1::Frame& frame, double decode_ms);

  /// Receives until a Frame contains the state-changing command `seq` (its input_seq is at least that), acknowledging every frame on the way. Throws the
  /// server's Error where it answers one to a command of this connection, and "timeout".
  v1::Frame wait_for_frame(std::uint64_t seq, bool lossless, std::chrono::milliseconds timeout);

  /// Receives until the dataset with this id is open and described. Throws like wait_for_frame.
  v1::DatasetInfo wait_for_dataset(std::string_view id, std::chrono::milliseconds timeout);

  /// The newest State and DatasetInfo received so far.
  const v1::State& state() const;
  const v1::DatasetInfo& dataset_info() const;

 private:
  struct Socket;
  explicit Connection(std::unique_ptr<Socket> socket);
  std::unique_ptr<Socket> socket_;
};

/// GET BASE + path over HTTP with the token. Throws "refused" with the server's explanation where the status is not 200.
std::string http_get(const Address& address, std::string_view path, std::chrono::milliseconds timeout);

/// Width, height and RGB of a JPEG frame.
struct DecodedImage {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // [height][width][3], row 0 on top
};
DecodedImage decode_jpeg(std::string_view bytes);

}  // namespace isostrata::client
