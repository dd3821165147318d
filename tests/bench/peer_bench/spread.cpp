#include "spread.h"

#include <sys/resource.h>

#include <algorithm>

namespace isostrata::peers {
namespace {

double cpu_ms() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto ms = [](const timeval& t) { return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_usec) / 1e3; };
  return ms(usage.ru_utime) + ms(usage.ru_stime);
}

}  // namespace

Clock::Clock() : cpu_before_(cpu_ms()) {}

Sample Clock::elapsed() const { return {watch_.elapsed_ms(), cpu_ms() - cpu_before_}; }

Spread spread_of(const std::vector<Sample>& samples) {
  Spread spread;
  if (samples.empty()) return spread;
  std::vector<double> ms, cpu;
  for (const Sample& one : samples) {
    ms.push_back(one.ms);
    cpu.push_back(one.cpu_ms);
  }
  std::sort(ms.begin(), ms.end());
  std::sort(cpu.begin(), cpu.end());
  spread.runs = static_cast<int>(ms.size());
  spread.min = ms.front();
  spread.median = ms[ms.size() / 2];
  spread.max = ms.back();
  spread.cpu_median = cpu[cpu.size() / 2];
  return spread;
}

void sample(const RunLimits& limits, const std::function<void()>& work, const std::function<void()>& after,
            std::vector<Sample>& samples) {
  const Stopwatch whole;
  for (int run = 0; run < limits.least || (run < limits.most && whole.elapsed_ms() < limits.budget_ms); ++run) {
    const Clock clock;
    work();
    samples.push_back(clock.elapsed());
    after();
  }
}

}  // namespace isostrata::peers
