// A client with bad manners: bytes exactly as a test wants them, HTTP or WebSocket, over a plain socket.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

namespace isostrata {

class RawSocket {
 public:
  explicit RawSocket(unsigned short port, int receive_buffer = 0) : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    if (receive_buffer > 0) setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error("the server does not accept");
  }
  ~RawSocket() { ::close(fd_); }
  /// What closes it sends no goodbye but a reset, as a machine that has lost its way.
  void reset() {
    const linger at_once{1, 0};
    setsockopt(fd_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  }
  RawSocket(const RawSocket&) = delete;
  RawSocket& operator=(const RawSocket&) = delete;

  /// False once the server has closed, or where it takes nothing for the time.
  bool send(const std::string& bytes, int timeout_ms = 5000) {
    for (std::size_t at = 0; at < bytes.size();) {
      pollfd poll_fd{fd_, POLLOUT, 0};
      if (poll(&poll_fd, 1, timeout_ms) != 1) return false;
      const auto n = ::send(fd_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (n <= 0) return false;
      at += static_cast<std::size_t>(n);
    }
    return true;
  }
  /// Everything until the server closes; `closed` tells whether it did within the time.
  std::string read_all(bool* closed = nullptr, int timeout_ms = 8000) {
    std::string all;
    while (const int n = read_some(all, timeout_ms)) {
      if (n < 0) {
        if (closed) *closed = true;
        return all;
      }
    }
    if (closed) *closed = false;
    return all;
  }
  /// What comes next; empty: the server has closed, or nothing came in the time.
  std::string read_piece(int timeout_ms = 8000) {
    std::string piece;
    read_some(piece, timeout_ms);
    return piece;
  }
  /// A whole HTTP response with a Content-Length, or what came before the end.
  std::string read_response() {
    std::string all;
    for (;;) {
      const auto head = all.find("\r\n\r\n");
      if (head != std::string::npos) {
        const auto at = all.find("Content-Length: ");
        const std::size_t length = at < head ? std::stoul(all.substr(at + 16)) : 0;
        if (all.size() >= head + 4 + length) return all;
      }
      if (read_some(all, 8000) <= 0) return all;
    }
  }

  /// Upgrades; the response's head.
  std::string open_websocket(const std::string& target, const std::string& headers = "", const std::string& host = "localhost",
                             const std::string& protocol = "isostrata.v1") {
    return upgrade("GET " + target + " HTTP/1.1\r\nHost: " + host +
                   "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n" +
                   "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: " + protocol + "\r\n" + headers + "\r\n");
  }
  /// With bytes behind the upgrade, in the same segment.
  std::string open_websocket_with(const std::string& target, const std::string& early) {
    return upgrade("GET " + target +
                   " HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                   "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: isostrata.v1\r\n\r\n" +
                   early);
  }
  struct Frame {
    bool last;
    int opcode;
    std::string payload;
  };
  /// The next WebSocket frame of the server; nothing after the time or at the end.
  std::optional<Frame> read_frame(int timeout_ms = 8000) {
    const auto filled = [&](std::size_t size) {
      while (kept_.size() < size)
        if (read_some(kept_, timeout_ms) <= 0) return false;
      return true;
    };
    if (!filled(2)) return std::nullopt;
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(kept_[i]); };
    const std::size_t size_bytes = (byte(1) & 127) == 127 ? 8 : (byte(1) & 127) == 126 ? 2 : 0;
    if (!filled(2 + size_bytes)) return std::nullopt;
    std::size_t size = size_bytes == 0 ? byte(1) & 127 : 0;
    for (std::size_t i = 0; i < size_bytes; ++i) size = size << 8 | byte(2 + i);
    if (!filled(2 + size_bytes + size)) return std::nullopt;
    Frame frame{(byte(0) & 128) != 0, byte(0) & 15, kept_.substr(2 + size_bytes, size)};
    kept_.erase(0, 2 + size_bytes + size);
    return frame;
  }
  /// What has come, up to a size; 0 after the time or at the end.
  std::size_t read_at_most(std::size_t size, int timeout_ms = 5000) {
    pollfd poll_fd{fd_, POLLIN, 0};
    if (poll(&poll_fd, 1, timeout_ms) != 1) return 0;
    std::string buffer(size, '\0');
    return static_cast<std::size_t>(std::max<ssize_t>(0, recv(fd_, buffer.data(), size, 0)));
  }
  /// One masked frame with the mask 0, so its payload goes as it is.
  bool send_frame(const std::string& payload, int opcode = 2) {
    std::string frame(1, static_cast<char>(0x80 | opcode));
    if (payload.size() < 126) {
      frame += static_cast<char>(0x80 | payload.size());
    } else if (payload.size() < 65536) {  // the shortest form is the only one allowed
      frame += static_cast<char>(0x80 | 126);
      frame += static_cast<char>(payload.size() >> 8);
      frame += static_cast<char>(payload.size());
    } else {
      frame += static_cast<char>(0x80 | 127);
      for (int shift = 56; shift >= 0; shift -= 8)
        frame += static_cast<char>(static_cast<std::uint64_t>(payload.size()) >> shift);
    }
    return send(frame + std::string(4, '\0') + payload);
  }

 private:
  std::string upgrade(const std::string& request) {
    send(request);
    std::string head;
    while (head.find("\r\n\r\n") == std::string::npos)
      if (read_some(head, 8000) <= 0) return head;
    kept_ = head.substr(head.find("\r\n\r\n") + 4);
    return head;
  }
  // 1: some came; 0: nothing for the time; -1: closed.
  int read_some(std::string& to, int timeout_ms) {
    pollfd poll_fd{fd_, POLLIN, 0};
    if (poll(&poll_fd, 1, timeout_ms) != 1) return 0;
    char buffer[65536];
    const auto n = recv(fd_, buffer, sizeof buffer, 0);
    if (n <= 0) return -1;
    to.append(buffer, static_cast<std::size_t>(n));
    return 1;
  }
  const int fd_;
  std::string kept_;  // read and not yet taken by read_frame
};

}  // namespace isostrata
