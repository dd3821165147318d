// Cores of one machine that several processes share: how many threads each of them should have.
#pragma once

#include <vector>

namespace isostrata {

/// One number for each core that a machine may have: 1 if this process may run on it.
std::vector<int> usable_cores();

/// own: usable_cores(); users: the sum of those of all processes that share the cores. Of a core that N may use each has an Nth. At least 1.
int core_share(const std::vector<int>& own, const std::vector<int>& users);

}  // namespace isostrata
