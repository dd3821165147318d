// One end of the line between the server and a worker process: whole messages over a Unix stream socket. A message is a header of
// fixed size, its body, and its picture: behind the body if it is small, else in an anonymous memory file whose descriptor
// travels with the header, so that the socket's buffer does not set the pace.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

#include "base/pass_descriptors.h"
#include "worker/message_bytes.h"

namespace isostrata {

/// One thread at a time may receive; any thread may send and shut_down. Lock: send_mutex_.
class MessageChannel {
 public:
  static constexpr std::uint64_t kMaxBody = 512ull << 20;  // a picture in bands is in the body
  static constexpr std::uint64_t kMaxPicture = 2ull << 30;
  static constexpr std::uint64_t kMaxInline = 256ull << 10;  // of a picture; longer ones go by memory file

  explicit MessageChannel(Descriptor socket) : socket_(std::move(socket)) {}
  /// Both ends, closed on exec. Throws unavailable.
  static std::pair<Descriptor, Descriptor> make_pair();

  /// Waits until the message is on its way. Throws unavailable if the other side is gone, too_large.
  void send(const MessageBytes& message);
  /// Waits for a message; nothing once the other side is gone. Throws bad_data (what comes is not a message), unavailable.
  std::optional<MessageBytes> receive();
  /// Ends both directions: a send or receive that waits returns.
  void shut_down();

 private:
  bool read_all(void* to, std::size_t size, Descriptor* passed);
  void write_all(const void* from, std::size_t size, int pass);

  Descriptor socket_;
  std::mutex send_mutex_;
};

/// Memory that can be mapped by whoever gets the descriptor. Throws unavailable.
Descriptor make_memory_file(const char* name, std::uint64_t bytes);

}  // namespace isostrata
