// Long work as a viewer sees it: an id, progress that is rare enough to send, an end.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "base/stopwatch.h"
#include "base/task.h"
#include "engine/messages/messages.h"

namespace isostrata {

/// One operation of a session. Progress is announced after a tenth of a second and then at most ten times a second.
class Operation {
 public:
  using Announce = std::function<void(EngineEvent)>;

  /// request: that it works for, 0 for a scene's extraction.
  Operation(SessionKey session, RequestId request, std::uint64_t id, Announce announce);

  Task& task() { return task_; }
  SessionKey session() const { return session_; }
  RequestId request() const { return request_; }
  std::uint64_t id() const { return id_; }
  double elapsed_ms() const { return watch_.elapsed_ms(); }

  /// A newer scene has made the result unwanted. The work goes on for `grace_ms` from its start, so that a drag over quick
  /// extractions still shows each of them, and is then cancelled. Its end says so, since nobody has asked for it.
  void supersede(double grace_ms);
  bool superseded() const { return grace_ms_.load() >= 0; }

  /// What the task reports from now on is this part of the whole.
  void report_part(double begin, double end, std::string stage);

  /// Announces the end where progress was announced.
  void finish();

 private:
  void progress(double fraction, std::string_view stage);

  const SessionKey session_;
  const RequestId request_;
  const std::uint64_t id_;
  const Announce announce_;
  Stopwatch watch_;
  std::atomic<double> grace_ms_{-1};
  std::mutex mutex_;  // guards what follows
  double last_announced_ms_ = 0;
  bool announced_ = false;
  bool finished_ = false;
  double part_begin_ = 0, part_end_ = 1;
  std::string part_stage_;  // empty: the task's own
  Task task_;
};

}  // namespace isostrata
