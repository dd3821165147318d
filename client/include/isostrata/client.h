// A thin client of an Isostrata server: connect, send commands, receive state and frames. Messages are those of the protocol
// (isostrata/v1/isostrata.pb.h); nothing of the server is needed.
//
//   isostrata::client::Client client({.url = "http://127.0.0.1:8080/?token=..."});
//   client.open_dataset(client.welcome().datasets(0).id());
//   const auto frame = client.lossless_frame();             // PNG bytes in frame.payload()
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "isostrata/v1/isostrata.pb.h"

namespace isostrata::client {

/// What went wrong: code is the server's ("not_found", "invalid_argument", ...) or one of ours: "bad_url", "connection",
/// "unauthorized", "timeout", "closed", "protocol", "bad_image".
class ClientError : public std::runtime_error {
 public:
  ClientError(std::string code, const std::string& message) : std::runtime_error(message), code_(std::move(code)) {}
  const std::string& code() const { return code_; }

 private:
  std::string code_;
};

struct Options {
  std::string url;           // as the server prints it, http://HOST:PORT/BASE/?token=TOKEN
  std::string token;         // where the url has none
  std::string resume_token;  // of an earlier Welcome: joins that session
  std::string name = "isostrata-client";
  int width = 800, height = 600;  // of the viewport, pixels; width 0: none, no frames are sent and no dataset is opened unasked
  std::vector<std::string> moving_formats{"jpeg"};  // of Hello: what is decoded of frames in motion
  std::chrono::milliseconds timeout{60000};         // of every wait that has no timeout of its own
};

/// One connection. Not thread-safe: everything happens on the caller's thread, inside the calls.
class Client {
 public:
  /// Connects, says Hello and waits for Welcome. Throws ClientError.
  explicit Client(const Options& options);
  ~Client();
  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;

  const v1::Welcome& welcome() const;
  /// The newest that the server has told.
  const v1::State& state() const;
  /// Of state().dataset(); empty where none is open.
  const v1::DatasetInfo& dataset() const;

  /// Sends a command; its seq is filled in and returned. Does not wait for an answer.
  std::uint64_t send(v1::ClientMessage message);
  /// The next message of the server, or nothing after the timeout. Frames are acknowledged here, at once. Throws ClientError
  /// "closed".
  std::optional<v1::ServerMessage> receive(std::chrono::milliseconds timeout);
  /// Sends and waits until the server has surely done it or refused it. Throws ClientError with the server's code.
  void command(v1::ClientMessage message);

  /// Waits until the dataset is open. Throws ClientError.
  void open_dataset(const std::string& id);
  /// The next lossless frame of at least the newest revision known here. Throws ClientError.
  v1::Frame lossless_frame();

  void close();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// A decoded picture, 8 bits a channel, row 0 at the top.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // [height][width][3]
};

/// JPEG, or PNG of 8-bit RGB or RGBA without interlacing, which is what servers send. Throws ClientError "bad_image".
Picture decode(const std::string& bytes);

/// GET below the server's base URL ("api/v1/sessions"), with its token; the body. Throws ClientError, for a status of 400 or more
/// with the problem document's code and detail.
std::string http_get(const Options& options, const std::string& path);

}  // namespace isostrata::client
