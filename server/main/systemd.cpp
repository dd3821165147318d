#include "main/systemd.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "base/error.h"

namespace isostrata {
namespace {

constexpr int kFirstPassed = 3;  // SD_LISTEN_FDS_START

/// The variable's value, which is then gone; empty if there is none.
std::string take(const char* name) {
  const char* value = std::getenv(name);
  std::string text = value ? value : "";
  unsetenv(name);
  return text;
}

std::optional<long long> number(const std::string& text) {
  long long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

bool option_is(int descriptor, int option, int expected) {
  int value = 0;
  socklen_t size = sizeof value;
  return getsockopt(descriptor, SOL_SOCKET, option, &value, &size) == 0 && value == expected;
}

/// Where it is bound.
PassedSocket describe(int descriptor) {
  const auto refuse = [](const std::string& why) {
    return Error(ErrorCode::invalid_argument, "the socket that the service manager passes ($LISTEN_FDS) " + why);
  };
  if (!option_is(descriptor, SO_TYPE, SOCK_STREAM) || !option_is(descriptor, SO_ACCEPTCONN, 1))
    throw refuse("is not a stream socket that listens; expected one ListenStream");
  PassedSocket socket{.descriptor = descriptor};
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  if (getsockname(descriptor, reinterpret_cast<sockaddr*>(&bound), &size) != 0) throw refuse(std::strerror(errno));
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (bound.ss_family == AF_INET) {
    const auto& address = reinterpret_cast<const sockaddr_in&>(bound);
    socket.host = inet_ntop(AF_INET, &address.sin_addr, text.data(), text.size());
    socket.port = ntohs(address.sin_port);
  } else if (bound.ss_family == AF_INET6) {
    const auto& address = reinterpret_cast<const sockaddr_in6&>(bound);
    socket.host = inet_ntop(AF_INET6, &address.sin6_addr, text.data(), text.size());
    socket.port = ntohs(address.sin6_port);
  } else if (bound.ss_family == AF_UNIX) {
    const auto& address = reinterpret_cast<const sockaddr_un&>(bound);
    socket.path = std::string(address.sun_path, strnlen(address.sun_path, size - offsetof(sockaddr_un, sun_path)));
    if (socket.path.empty()) throw refuse("has no path in the file system");
  } else {
    throw refuse("is neither of TCP nor a Unix socket");
  }
  return socket;
}

}  // namespace

std::optional<PassedSocket> passed_socket() {
  const std::string process = take("LISTEN_PID"), count = take("LISTEN_FDS");
  take("LISTEN_FDNAMES");
  if (number(process) != getpid() || count.empty() || count == "0") return std::nullopt;
  if (number(count) != 1)
    throw Error(ErrorCode::invalid_argument, "the service manager passes '" + count + "' sockets ($LISTEN_FDS); expected 1");
  fcntl(kFirstPassed, F_SETFD, FD_CLOEXEC);
  return describe(kFirstPassed);
}

namespace {

/// A datagram socket that is connected to a path, or to an abstract name that is written with @; -1 if nobody is there.
int connected_to(const std::string& address) {
  sockaddr_un to{};
  if (address.empty() || address.size() >= sizeof to.sun_path || (address[0] != '/' && address[0] != '@')) return -1;
  to.sun_family = AF_UNIX;
  std::memcpy(to.sun_path, address.data(), address.size());
  if (address[0] == '@') to.sun_path[0] = 0;
  const int line = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address.size());
  if (line >= 0 && connect(line, reinterpret_cast<const sockaddr*>(&to), size) == 0) return line;
  if (line >= 0) close(line);
  return -1;
}

}  // namespace

ServiceManager::ServiceManager() : line_(connected_to(take("NOTIFY_SOCKET"))) {
  const std::string microseconds = take("WATCHDOG_USEC"), process = take("WATCHDOG_PID");
  const std::optional<long long> waits = number(microseconds);
  if (line_ >= 0 && waits && *waits > 0 && (process.empty() || number(process) == getpid()))
    pulse_ = std::chrono::milliseconds(std::max(*waits / 2000, 1ll));
}

ServiceManager::~ServiceManager() {
  if (line_ >= 0) close(line_);
}

void ServiceManager::tell(const std::string& state) const {
  // Nobody else can be told if it does not listen.
  if (line_ >= 0) [[maybe_unused]] const ssize_t sent = send(line_, state.data(), state.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

}  // namespace isostrata
