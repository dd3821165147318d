#include "bench/plain_socket.h"

#include <charconv>

namespace isostrata {
namespace {

struct Connected {
  explicit Connected(unsigned short port) : fd(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ok = fd >= 0 && connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }
  ~Connected() {
    if (fd >= 0) ::close(fd);
  }
  Connected(const Connected&) = delete;
  Connected& operator=(const Connected&) = delete;
  const int fd;
  bool ok = false;
};

/// Of the head; nothing if it is not whole or says none.
std::optional<std::size_t> whole_size(const std::string& received) {
  const auto end = received.find("\r\n\r\n");
  const auto length = received.find("Content-Length: ");
  if (end == std::string::npos) return std::nullopt;
  std::size_t bytes = 0;
  if (length < end) std::from_chars(received.data() + length + 16, received.data() + end, bytes);
  return end + 4 + bytes;
}

}  // namespace

PlainAnswer plain_request(unsigned short port, const std::string& token, const std::string& method, const std::string& target,
                          const std::string& body, const std::atomic<bool>& stop, bool reads) {
  const Connected to(port);
  if (!to.ok) return {};
  std::string request = method + " " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nAuthorization: Bearer " +
                        token + "\r\n";
  if (!body.empty()) request += "Content-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) + "\r\n";
  request += "\r\n" + body;
  if (::send(to.fd, request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size())) return {};
  std::string received;
  std::array<char, 1 << 16> buffer;
  while (!stop) {
    pollfd waiting{to.fd, static_cast<short>(reads ? POLLIN : 0), 0};
    if (poll(&waiting, 1, 20) != 1 || !reads) continue;
    const auto n = recv(to.fd, buffer.data(), buffer.size(), 0);
    if (n > 0) received.append(buffer.data(), static_cast<std::size_t>(n));
    const auto whole = whole_size(received);
    if (n > 0 && (!whole || received.size() < *whole)) continue;
    PlainAnswer answer;
    if (received.size() > 12) std::from_chars(received.data() + 9, received.data() + 12, answer.status);
    if (whole) answer.body = received.substr(received.find("\r\n\r\n") + 4);
    return answer;
  }
  return {};
}

}  // namespace isostrata
