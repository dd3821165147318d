// Work that may end the process in which it is done, such as loading a driver: done in a process of its own.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>

namespace isostrata {

struct ChildRun {
  std::string said;   // all that the work has said before its process ended
  std::string ended;  // how, if the work did not come to its end: "signal 11 (Segmentation fault)"; else empty
};

using Say = std::function<void(std::string_view)>;

/// Runs `work` in a copy of this process that has this thread alone, and waits for it; after `limit` it is killed. The copy has the confinement
/// of this process, no file of it is written there by the C library, and its death leaves no core. A lock that another thread holds now is never
/// freed there, unless it is the C library's. What `work` throws ends it silently. Any thread.
ChildRun run_in_child(const std::function<void(const Say& say)>& work, std::chrono::milliseconds limit);

}  // namespace isostrata
