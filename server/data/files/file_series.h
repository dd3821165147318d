// Files that differ by numbers in their names are the steps of one series. It is named by its pattern: "plume_*.vtu" in the folder of the files, where
// each * stands for a number. Gaps do not matter, nor how many digits a number has.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace isostrata {

struct SeriesFile {
  std::filesystem::path path;
  std::vector<std::uint64_t> numbers;  // at the pattern's stars; of a decimal its two parts
};

/// The name has a * and there is no file of that name.
bool is_series_pattern(const std::filesystem::path& path);

/// Pictures by their extension: numbered ones are the slices of a volume, not steps.
bool names_pictures(const std::filesystem::path& path);

/// The files of a pattern, in the order of their numbers; for Exodus restarts, "x.e-s*", "x.e" is the first. Throws not_found if there are none,
/// and where one of a pattern below a root (beneath.h) is a link that leads out of it; too_large above 100000.
std::vector<SeriesFile> series_files(const std::filesystem::path& pattern);

/// Numbers that count in equal steps, as those in the names of most series do: wave_0100, wave_0200.
struct EqualSteps {
  std::uint64_t first = 0, stride = 0;  // stride 0: the numbers do not, or there are several in a name
  int digits = 0;                       // of the shortest; a number of fewer has zeros before it

  /// Which of so many files has the number, from 0; -1: none.
  int place_of(std::uint64_t number, int files) const;
};
/// Of the names of a pattern's files in their order.
EqualSteps equal_steps(const std::string& pattern, const std::vector<std::string>& names);

struct NameGroup {
  std::string name;                  // of the file, or the pattern of several
  std::vector<std::string> members;  // one or more, in the order of their numbers
};

/// Groups the names of one folder. Where several numbers differ the last (of a date and time of day all) counts steps and those before it keep series apart, as in run1_0001 ..., run2_0001
/// ...; where no two names would then be left together, they count as one: step_0001_time_0.5.
std::vector<NameGroup> group_by_number(std::vector<std::string> names);

/// When the newest of the files that make up `source` was changed, and the bytes of all: of a file itself, of a pattern's files, of a folder's own entries and
/// those of the folders in it. Two zeros where nothing is there.
struct SourceStamp {
  std::uint64_t bytes = 0;
  std::int64_t changed = 0;  // in units of the file system's clock
  bool operator==(const SourceStamp&) const = default;
  std::int64_t changed_unix_ms() const;
};
SourceStamp stamp_of(const std::filesystem::path& source);

}  // namespace isostrata
