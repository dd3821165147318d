// What several benchmarks make of what they measure.
#pragma once

#include <sys/types.h>

#include <algorithm>
#include <boost/json/object.hpp>
#include <cstdint>
#include <vector>

namespace isostrata {

/// 0 of nothing; of an even number the upper one.
inline double median(std::vector<double> of) {
  std::sort(of.begin(), of.end());
  return of.empty() ? 0 : of[of.size() / 2];
}

/// Of times or other values, in their unit.
struct Spread {
  double min = 0, median = 0, max = 0;
};

/// Of at least one value.
Spread spread_of(std::vector<double> values);

boost::json::object to_json(const Spread& spread);

/// Memory of a process that is not a file's: RssAnon of /proc. 0 if there is no such process.
std::uint64_t anonymous_bytes(pid_t process);

}  // namespace isostrata
