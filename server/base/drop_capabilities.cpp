#include "base/drop_capabilities.h"

#include <linux/capability.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>

namespace isostrata {

void drop_capabilities_but(std::uint32_t mask) {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> sets{};
  if (syscall(SYS_capget, &header, sets.data()) != 0) return;
  for (auto& set : sets) {
    set.permitted &= &set == sets.data() ? mask : 0;
    set.effective = set.permitted;
    set.inheritable = 0;
  }
  syscall(SYS_capset, &header, sets.data());
}

}  // namespace isostrata
