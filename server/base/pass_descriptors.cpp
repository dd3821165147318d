#include "base/pass_descriptors.h"

#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace isostrata {
namespace {

struct alignas(cmsghdr) Control {
  std::array<char, CMSG_SPACE(kMostPassed * sizeof(int))> bytes{};
};

}  // namespace

ssize_t send_passing(int socket, const void* from, std::size_t size, std::initializer_list<int> descriptors) {
  std::array<int, kMostPassed> pass{};
  std::size_t count = 0;
  for (const int descriptor : descriptors)
    if (descriptor >= 0 && count < pass.size()) pass[count++] = descriptor;
  iovec part{const_cast<void*>(from), size};
  Control control;
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  if (count > 0) {
    message.msg_control = control.bytes.data();
    message.msg_controllen = CMSG_SPACE(count * sizeof(int));
    cmsghdr* const of = CMSG_FIRSTHDR(&message);
    of->cmsg_level = SOL_SOCKET;
    of->cmsg_type = SCM_RIGHTS;
    of->cmsg_len = CMSG_LEN(count * sizeof(int));
    std::memcpy(CMSG_DATA(of), pass.data(), count * sizeof(int));
  }
  ssize_t sent = 0;
  while ((sent = sendmsg(socket, &message, MSG_NOSIGNAL)) < 0 && errno == EINTR) {
  }
  return sent;
}

ssize_t receive_passed(int socket, void* to, std::size_t size, std::vector<Descriptor>& passed) {
  iovec part{to, size};
  Control control;
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.bytes.data();
  message.msg_controllen = control.bytes.size();
  ssize_t got = 0;
  while ((got = recvmsg(socket, &message, MSG_CMSG_CLOEXEC)) < 0 && errno == EINTR) {
  }
  for (cmsghdr* of = got > 0 ? CMSG_FIRSTHDR(&message) : nullptr; of; of = CMSG_NXTHDR(&message, of)) {
    if (of->cmsg_level != SOL_SOCKET || of->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t count = (of->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < count; ++i) {
      int descriptor = -1;
      std::memcpy(&descriptor, CMSG_DATA(of) + i * sizeof(int), sizeof descriptor);
      passed.emplace_back(descriptor);
    }
  }
  return got;
}

}  // namespace isostrata
