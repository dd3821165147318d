// Layers at a time of a dataset, at a step or between two, in each of the three modes of the paper's section 3.2.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/task.h"
#include "extraction/layers/extract_layers.h"
#include "extraction/space_time/space_time_volume.h"

namespace isostrata {

/// The space-time volume that was asked for last, for whoever slices it at one time after another. Guarded by a lock: any thread;
/// two that ask for the same one make it once, and whoever waits can be cancelled.
class KeptSpaceTime {
 public:
  struct Asked {
    std::shared_ptr<const SpaceTimeVolume> volume;
    double build_ms = 0;  // 0 if it was there
  };
  /// Throws what SpaceTimeVolume throws.
  Asked get(const std::shared_ptr<const Dataset>& first, const std::shared_ptr<const Dataset>& second, const std::string& array,
            const std::vector<Interval>& intervals, bool complement, std::uint64_t max_bytes, const Task& task);
  /// Gives its memory back.
  void forget();

 private:
  std::timed_mutex making_;          // guards what follows
  std::vector<Interval> intervals_;  // that volume_ was asked for with
  std::shared_ptr<const SpaceTimeVolume> volume_;
};

/// The dataset that a request for steps or interpolation is extracted from: the step itself, or the field between two steps with
/// the arrays that the request names. Fills `time`. Throws what extract_layers throws.
std::shared_ptr<const Dataset> dataset_at_time(const LayerRequest& request, const StepSource& steps, LayerTime& time,
                                               const Task& task);

/// The layers of a request for space-time. Where the dataset has one step only, there is no space-time: nothing is returned, and
/// the step is to be extracted as it is. Throws what extract_layers throws.
std::optional<Layers> slice_space_time(const LayerRequest& request, const StepSource& steps, KeptSpaceTime* kept,
                                       const Task& task);

}  // namespace isostrata
