// Open files that go from one process to another over a Unix socket, with the bytes of one message: unix(7), SCM_RIGHTS.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <initializer_list>
#include <vector>

#include "base/descriptor.h"

namespace isostrata {

inline constexpr std::size_t kMostPassed = 3;  // with one message

/// sendmsg without SIGPIPE, with copies of at most kMostPassed descriptors; those that are -1 are left out. Tries again after a signal. Returns what
/// sendmsg returns, and sets errno.
ssize_t send_passing(int socket, const void* from, std::size_t size, std::initializer_list<int> descriptors);

/// recvmsg; the descriptors that came, closed on exec, go to the end of `passed`. Tries again after a signal. Returns what recvmsg returns, and sets
/// errno.
ssize_t receive_passed(int socket, void* to, std::size_t size, std::vector<Descriptor>& passed);

}  // namespace isostrata
