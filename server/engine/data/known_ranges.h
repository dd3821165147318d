// What an engine knows of the ranges of its series: every step that was read for any reason counts.
//
// Kept in memory, not beside the files or in a cache folder: a file like that would have to vouch for every file of the series (a .pvd
// does not change when one of its steps does) and be cleaned up by somebody, to save a reading that nobody waits for.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "data/derived/series_ranges.h"

namespace isostrata {

/// Any thread may call any function. Lock: mutex_.
class KnownRanges {
 public:
  /// Counts a step that was read. More steps than were known follow at the end; a dataset that knows of fewer was read before they came. source: names one version
  /// of a dataset (version_id).
  void add(const std::string& source, const Dataset& step);
  /// Of a step that cannot be read.
  void skip(const std::string& source, int step, const std::string& why);

  struct Known {
    SeriesRanges ranges;
    std::vector<std::string> notes;  // which steps the ranges leave out
    std::vector<double> times;       // of all steps, as far as anybody has seen
    std::vector<std::string> said;   // Dataset::notes of the step that knew of so many
  };
  /// Nothing if no step of the source was read.
  std::optional<Known> find(const std::string& source) const;
  /// The first step that is not known; -1 if all are. Nothing if no step of the source was read.
  std::optional<int> next(const std::string& source) const;

 private:
  static constexpr std::size_t kMostNotes = 5;

  mutable std::mutex mutex_;
  std::map<std::string, Known> series_;
};

}  // namespace isostrata
