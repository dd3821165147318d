// The door to what makes frames of scenes, wherever that runs: Engine in this process, WorkerEngine in one of its own.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include <sys/types.h>

#include "engine/data/catalogue.h"
#include "engine/messages/messages.h"

namespace isostrata {

/// Whose process draws, for people, scripts and tests.
struct EngineFacts {
  std::string device;  // what draws now
  bool device_is_software = false;
  bool own_process = false;
  pid_t process = 0;            // that the engine runs in; 0: it is being replaced
  std::uint64_t processes = 0;  // that were started so far
  std::uint64_t deaths = 0;     // of them, also those that the watchdog ended
  std::string last_death;       // "ended by signal 9 (Killed) while drawing"; empty: none
  std::string fallback;         // why another renderer draws than was asked for; empty: it is the one
  std::string trouble;          // why nothing can be drawn, as long as that lasts; empty: it can
  std::string renderer_trial;   // as renderer_trial_report
  std::string shut_in;          // what keeps its process to its own files; empty: nothing does
};

/// Any thread may call any function but the destructor.
class FrameEngine {
 public:
  /// Called from the engine's threads, one event at a time for one session's frames; must return quickly and not call the engine
  /// back.
  using Sink = std::function<void(EngineEvent event)>;

  virtual ~FrameEngine() = default;
  /// Requests of one session are taken in the order they are posted. Never waits for work.
  virtual void post(EngineRequest request) = 0;
  virtual const Catalogue& catalogue() const = 0;
  virtual std::string device() const = 0;  // "llvmpipe (LLVM 15.0.6, 256 bits), EGL surfaceless"
  virtual EngineFacts facts() const = 0;

  bool device_is_software() const;
};

/// Whether a GL renderer's name is that of one that runs on the CPU.
bool is_software_device(const std::string& device);

}  // namespace isostrata
