#include "engine/messages/operation.h"

#include "base/pulse.h"

namespace isostrata {

constexpr double kAnnounceEveryMs = 100;

Operation::Operation(SessionKey session, RequestId request, std::uint64_t id, Announce announce)
    : session_(session),
      request_(request),
      id_(id),
      announce_(std::move(announce)),
      task_([this](double fraction, std::string_view stage) { progress(fraction, stage); }) {}

void Operation::supersede(double grace_ms) {
  grace_ms_ = grace_ms;
  if (elapsed_ms() >= grace_ms) task_.cancel();
}

void Operation::progress(double fraction, std::string_view stage) {
  pulse();
  const double now_ms = watch_.elapsed_ms();
  if (const double grace = grace_ms_; grace >= 0 && now_ms >= grace) task_.cancel();
  std::lock_guard lock(mutex_);
  if (finished_ || now_ms - last_announced_ms_ < kAnnounceEveryMs) return;
  last_announced_ms_ = now_ms;
  announced_ = true;
  announce_(OperationProgress{session_, id_, part_stage_.empty() ? std::string(stage) : part_stage_,
                              part_begin_ + (part_end_ - part_begin_) * fraction, request_});
}

void Operation::report_part(double begin, double end, std::string stage) {
  std::lock_guard lock(mutex_);
  part_begin_ = begin;
  part_end_ = end;
  part_stage_ = std::move(stage);
}

void Operation::finish() {
  std::lock_guard lock(mutex_);
  if (finished_) return;
  finished_ = true;
  if (announced_) announce_(OperationDone{session_, id_, task_.cancelled(), request_, task_.cancelled() && superseded()});
}

}  // namespace isostrata
