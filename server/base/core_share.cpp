#include "base/core_share.h"

#include <sched.h>

#include <algorithm>
#include <thread>

namespace isostrata {

std::vector<int> usable_cores() {
  std::vector<int> usable(CPU_SETSIZE, 0);
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof set, &set) == 0)
    for (int core = 0; core < CPU_SETSIZE; ++core) usable[static_cast<std::size_t>(core)] = CPU_ISSET(core, &set) ? 1 : 0;
  else
    std::fill_n(usable.begin(), std::min(std::thread::hardware_concurrency(), static_cast<unsigned>(CPU_SETSIZE)), 1);
  return usable;
}

int core_share(const std::vector<int>& own, const std::vector<int>& users) {
  double share = 0;
  for (std::size_t core = 0; core < own.size() && core < users.size(); ++core)
    if (own[core] != 0) share += 1.0 / std::max(users[core], 1);
  return std::max(1, static_cast<int>(share + 1e-6));  // three thirds are one
}

}  // namespace isostrata
