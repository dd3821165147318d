// How a server is reached, and what goes wrong.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "isostrata/v1/isostrata.pb.h"

namespace isostrata::client {

/// What went wrong: code is the server's ("not_found", "invalid_argument", "bad_data", ...) or one of ours: "bad_url",
/// "connection", "tls" (a certificate that is not trusted), "unauthorized", "timeout", "closed", "session_lost" (the server came
/// back without the session), "interrupted" (work of the server that a lost connection took with it), "cancelled", "protocol",
/// "bad_image", "bad_argument". field names the member of the command that the server refused, where it named one.
class ClientError : public std::runtime_error {
 public:
  ClientError(std::string code, const std::string& message, std::string field = "")
      : std::runtime_error(message), code_(std::move(code)), field_(std::move(field)) {}
  const std::string& code() const { return code_; }
  const std::string& field() const { return field_; }

 private:
  std::string code_, field_;
};

/// What has become of a connection. It is lost, and then either restored or given up; what waits goes on waiting meanwhile.
struct ConnectionEvent {
  enum class Kind { lost, restored, given_up };
  Kind kind = Kind::lost;
  std::string reason;        // of lost and given_up
  std::size_t resent = 0;    // of restored: commands that the server had not done, and was sent again
  bool new_session = false;  // of restored: the server no longer had the session; what it showed was brought to a new one
};

struct Options {
  std::string url = "";           // as the server prints it, http://HOST:PORT/BASE/?token=TOKEN, or https://
  std::string token = "";         // where the url has none
  std::string resume_token = "";  // of an earlier Welcome: joins that session
  std::string session = "";       // its id, if that is what is known: joins that session, and fails if it is not there
  std::string name = "isostrata-client";
  int width = 800, height = 600;  // of the viewport, pixels; width 0: none, no frames are sent and no dataset is opened unasked
  std::vector<std::string> moving_formats{"jpeg"};  // of Hello: what is decoded of frames in motion
  std::string moving_format = "";  // always this one of them; empty: the server chooses by measured times
  bool hidden = false;  // the viewport is there (views fit it), but no frames are sent: for who asks for stills
  std::chrono::milliseconds timeout{60000};  // of every wait that has no timeout of its own; progress starts it anew
  /// Set from anywhere, a signal handler too: what waits asks the server to cancel its work and throws "cancelled".
  const std::atomic<bool>* stop = nullptr;
  /// Called inside waits with each report on reading, extracting and so on.
  std::function<void(const v1::Progress&)> on_progress = nullptr;
  std::string ca_file = "";  // of https: certificates in PEM that are trusted in place of the system's
  bool insecure = false;     // of https: any certificate will do, so anybody may listen
  /// How long a lost connection is tried again before "closed" is thrown; 0: not at all. A server that ends for good, takes an
  /// invitation back or refuses the token is not asked again.
  std::chrono::milliseconds reconnect_for{30000};
  /// Called inside waits.
  std::function<void(const ConnectionEvent&)> on_connection = nullptr;
  bool lossless_bands = false;  // lossless frames come in pieces, which FrameDecoder puts together
};

}  // namespace isostrata::client
