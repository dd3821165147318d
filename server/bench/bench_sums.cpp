#include "bench/bench_sums.h"

#include <cstdlib>
#include <fstream>
#include <string>

namespace isostrata {

std::uint64_t anonymous_bytes(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("RssAnon:")) return std::strtoull(line.c_str() + 8, nullptr, 10) << 10;
  return 0;
}

}  // namespace isostrata
