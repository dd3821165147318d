// Open files that go from one process to another over a Unix socket, with the bytes of one message: unix(7), SCM_RIGHTS.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <initializer_list>
#include <utility>
#include <vector>

namespace isostrata {

/// A file descriptor that is closed with its owner.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor() { close(); }

  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }
  void close();
  /// The caller closes it.
  int release() { return std::exchange(fd_, -1); }

 private:
  int fd_ = -1;
};

inline constexpr std::size_t kMostPassed = 2;  // with one message

/// sendmsg without SIGPIPE, with copies of at most kMostPassed descriptors; those that are -1 are left out. Tries again after a signal. Returns what
/// sendmsg returns, and sets errno.
ssize_t send_passing(int socket, const void* from, std::size_t size, std::initializer_list<int> descriptors);

/// recvmsg; the descriptors that came, closed on exec, go to the end of `passed`. Tries again after a signal. Returns what recvmsg returns, and sets
/// errno.
ssize_t receive_passed(int socket, void* to, std::size_t size, std::vector<Descriptor>& passed);

}  // namespace isostrata
