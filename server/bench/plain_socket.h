// A WebSocket, and HTTP, over plain sockets: the bytes are ours to choose, and they cost a measurement next to nothing.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "isostrata/v1/isostrata.pb.h"

namespace isostrata {

/// One WebSocket to this machine.
class PlainSocket {
 public:
  PlainSocket(unsigned short port, const std::string& token, int receive_buffer = 0)
      : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    if (receive_buffer > 0) setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    const int one = 1;
    setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) return;
    const std::string head = "GET /ws?token=" + token +
                             " HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                             "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                             "Sec-WebSocket-Protocol: isostrata.v1\r\n\r\n";
    if (!send(head)) return;
    while (received_.find("\r\n\r\n") == std::string::npos)
      if (!receive(4096, 5000)) return;
    open_ = received_.find(" 101 ") != std::string::npos;
    received_.erase(0, received_.find("\r\n\r\n") + 4);
  }
  ~PlainSocket() { ::close(fd_); }
  PlainSocket(const PlainSocket&) = delete;
  PlainSocket& operator=(const PlainSocket&) = delete;

  bool open() const { return open_; }

  /// Returns the number that it gave the message.
  std::uint64_t add(v1::ClientMessage message) {
    message.set_seq(++seq_);
    add_bytes(message.SerializeAsString());
    return seq_;
  }
  // One masked frame with the mask 0, so its payload goes as it is.
  void add_bytes(const std::string& payload) {
    sending_ += '\x82';
    if (payload.size() < 126) {
      sending_ += static_cast<char>(0x80 | payload.size());
    } else {
      sending_ += static_cast<char>(0x80 | 126);
      sending_ += static_cast<char>(payload.size() >> 8);
      sending_ += static_cast<char>(payload.size());
    }
    sending_ += std::string(4, '\0') + payload;
  }
  /// What has been added, for at most that long; the rest waits for the next time. False once closed.
  bool flush(int timeout_ms = 0) {
    while (open_ && !sending_.empty()) {
      const auto n = ::send(fd_, sending_.data(), sending_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (n > 0) {
        sending_.erase(0, static_cast<std::size_t>(n));
        continue;
      }
      if (errno != EAGAIN && errno != EWOULDBLOCK) open_ = false;
      pollfd poll_fd{fd_, POLLOUT, 0};
      if (!open_ || poll(&poll_fd, 1, timeout_ms) != 1) break;
    }
    return open_;
  }
  std::size_t waiting() const { return sending_.size(); }

  /// False once closed or where nothing comes in time.
  bool receive(std::size_t most, int timeout_ms) {
    pollfd poll_fd{fd_, POLLIN, 0};
    if (poll(&poll_fd, 1, timeout_ms) != 1) return false;
    std::array<char, 65536> buffer{};
    const auto n = recv(fd_, buffer.data(), std::min(most, buffer.size()), 0);
    if (n <= 0) {
      open_ = false;
      return false;
    }
    received_.append(buffer.data(), static_cast<std::size_t>(n));
    return true;
  }
  /// The next whole message that has come, without waiting. A frame of another kind, as a ping, is an empty one.
  std::optional<std::string> next() {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(received_[i]); };
    if (received_.size() < 2) return std::nullopt;
    const std::size_t size_bytes = (byte(1) & 127) == 127 ? 8 : (byte(1) & 127) == 126 ? 2 : 0;
    if (received_.size() < 2 + size_bytes) return std::nullopt;
    std::size_t size = size_bytes == 0 ? byte(1) & 127u : 0;
    for (std::size_t i = 0; i < size_bytes; ++i) size = size << 8 | byte(2 + i);
    if (received_.size() < 2 + size_bytes + size) return std::nullopt;
    const int kind = byte(0) & 15;
    const bool whole = (byte(0) & 128) != 0;
    std::string payload = received_.substr(2 + size_bytes, size);
    received_.erase(0, 2 + size_bytes + size);
    if (kind == 9) pong(payload);
    if (kind == 8) open_ = false;
    if (kind > 2) return "";
    message_ += payload;
    return whole ? std::exchange(message_, "") : "";
  }

 private:
  bool send(const std::string& bytes) { return ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL) > 0; }
  void pong(const std::string& payload) {
    sending_ += '\x8a';
    sending_ += static_cast<char>(0x80 | payload.size());
    sending_ += std::string(4, '\0') + payload;
  }

  const int fd_;
  bool open_ = false;
  std::uint64_t seq_ = 0;
  std::string sending_, received_, message_;
};

struct PlainAnswer {
  int status = 0;  // 0: none came
  std::string body;
};

/// One HTTP request to this machine on a connection of its own, which is closed once `stop`. reads: else the answer is left unread
/// until then.
PlainAnswer plain_request(unsigned short port, const std::string& token, const std::string& method, const std::string& target,
                          const std::string& body, const std::atomic<bool>& stop, bool reads = true);

}  // namespace isostrata
