// The door to isostrata-import, the child process that parses foreign files. A broken or hostile file can end the child and
// nothing else: whatever it writes is checked before any other code reads it.
//
// The child gets: FILE DIRECTORY STEP MAX-BYTES CPU-SECONDS SANDBOX [LIKE] (the step that the caller has), an environment of at most six variables,
// a process group of its own, and takes its own rights away before it looks at the file (SECURITY.md). DIRECTORY is new, private (0700), below $TMPDIR or /tmp, and removed
// before open_import returns or throws. Into it the child writes raw little-endian files and, last, manifest.json:
//
//   {"format":1, "grid":"uniform"|"rectilinear"|"curvilinear"|"unstructured"|"like", "dims":[ni,nj,nk] (structured grids),
//    "points":["float32"|"float64", count] (curvilinear, unstructured), "cells":n, "connectivity":n (unstructured),
//    "hidden_cells":bool, "axes":[{"name":..., "unit":..., "downward":bool}, two more], "arrays":[{"name":..., "association":"point"|"cell_averaged", "components":n, "component":...,
//    "unit":..., "type":...[, "in_file":..., "offset":n][, "cell_type":...[, "cells":{"in_file":..., "offset":n}]]}],
//    "times":n, "step":n, "notes":[...]}
//
//   placement.bin       float64[6]: origin, spacing (uniform)
//   axis_x.bin, ...     float64[dims] each (rectilinear)
//   points.bin          [points][3]
//   types.bin           uint8[cells], offsets.bin int64[cells + 1], connectivity.bin int64[connectivity]
//   hidden.bin          uint8[cells]
//   array_N.bin         [points] of the N-th array's type; not there where its bytes lie in a file as they are
//   cells_N.bin         [cells] of its cell_type, if it is cell_averaged; likewise
//   times.bin           float64[times]
//
// The grid "like" is that of step LIKE, and no file holds it. File names are fixed, and "in_file" leads to a regular file beside the one that was asked
// for, or below, which the child may read anyhow: so the manifest cannot name anything else. Files are mapped read-only and unlinked; they live as long as the Dataset. What is mapped in place
// (source_mapping.h) stays where it is.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "base/vec.h"
#include "data/dataset/dataset.h"
#include "data/files/recognise.h"

namespace isostrata {

struct ImportOptions : OpenOptions {
  /// like: another step of the same file that is in memory, or null: of one that lies on the same mesh a reader then brings the values alone.
  ImportOptions(OpenOptions options = {}, std::shared_ptr<const Dataset> like = nullptr) : OpenOptions(std::move(options)), like(std::move(like)) {}
  std::shared_ptr<const Dataset> like;
  std::optional<ReaderNeeds> needs{};  // of the file, if it was recognised already
};

/// Arrays of this many bytes are mapped in place if they can be: below, a copy is cheap, and does not change under those who look at it.
inline constexpr std::uint64_t kLeastInPlace = std::uint64_t{64} << 20;
/// Whether a file of this name may hold such arrays.
bool may_lie_in_place(const std::filesystem::path& file);

/// In a folder that is kept: which files it was read from, and when. It is written last, so a folder without it is not finished.
inline constexpr const char* kOriginFile = "origin.txt";

/// Runs the child on `file`. Throws not_found, bad_data (also if the child crashed, ran out of time, or wrote something
/// inconsistent), unsupported, too_large, cancelled, unavailable (no isostrata-import, no room for temporary files). Any thread.
std::shared_ptr<const Dataset> open_import(const std::filesystem::path& file, const ImportOptions& options, const Task& task);

/// As open_import, but the child's files stay below `keep`, as long as the dataset lives in this process, or for whoever comes
/// after a process that was killed: there the same file and step is mapped at once and no child runs. `keep` is a private
/// directory on the file system of $TMPDIR, and somebody else removes it in the end. A file that was changed is another one.
std::shared_ptr<const Dataset> open_import_keeping(const std::filesystem::path& file, const ImportOptions& options,
                                                   const std::filesystem::path& keep, const Task& task);

/// Whether there is a `file` to read, which does not lead out of what is served. Throws not_found.
void check_source(const std::filesystem::path& file, const OpenOptions& options);

/// The first half on its own: has a child read `file` into `directory`, which is the caller's, new and empty, after
/// check_source. Throws as open_import does.
void import_into(const std::filesystem::path& directory, const std::filesystem::path& file, const ImportOptions& options, const Task& task);

/// Whether it shares no grid with options.like: what does has none in its own files.
bool has_own_grid(const Dataset& dataset, const ImportOptions& options);

enum class ImportFiles { unlinked, left };

/// What takes a look at every value and every cell to know.
struct ImportMeasures {
  struct Range {
    double lower = 0, upper = 0;
    std::int64_t nan_count = 0;
    auto as_tuple() const { return std::tuple(lower, upper, nan_count); }
  };
  std::vector<Range> arrays, cells;  // cells: of those that have cell values, in the order of the arrays
  Box3d bounds;
  std::map<std::string, std::int64_t> cell_types;
};
ImportMeasures measures_of(const Dataset& dataset);

enum class ImportValues { measured, unseen };

/// The second half on its own: checks and maps a directory that a child wrote. `file` is what it was read from. With `known` it does not look
/// at the values: only for files of our own that were checked when they were written. Unseen values have no range yet; cells and points are checked
/// all the same. Throws bad_data, too_large.
std::shared_ptr<Dataset> map_import(const std::filesystem::path& directory, const std::filesystem::path& file, const ImportOptions& options,
                                    ImportFiles files = ImportFiles::unlinked, const ImportMeasures* known = nullptr,
                                    ImportValues values = ImportValues::measured);

/// isostrata-import beside this executable, or isostrata-import-all for what needs all readers (recognise.h). Throws unavailable if it is not there.
std::filesystem::path default_importer(bool all_readers);

}  // namespace isostrata
