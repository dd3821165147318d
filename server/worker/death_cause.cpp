#include "worker/death_cause.h"

#include <algorithm>
#include <fstream>

namespace isostrata {

long killed_for_memory() {
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (!line.starts_with("0::")) continue;
    std::ifstream events("/sys/fs/cgroup" + line.substr(3) + "/memory.events");
    long count = 0;
    for (std::string name; events >> name >> count;)
      if (name == "oom_kill") return count;
  }
  return 0;
}

std::string stages_of(const std::vector<ActivityFacts>& at) {
  std::vector<Stage> stages;
  for (const ActivityFacts& of : at)
    if (of.stage != Stage::idle && std::find(stages.begin(), stages.end(), of.stage) == stages.end()) stages.push_back(of.stage);
  if (stages.empty()) return "idle";
  std::string text;
  for (std::size_t i = 0; i < stages.size(); ++i)
    text += (i == 0 ? "" : i + 1 == stages.size() ? " and " : ", ") + to_string(stages[i]);
  return text;
}

}  // namespace isostrata
