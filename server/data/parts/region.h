// A box of a structured grid, and every n-th point of it, in place of the whole.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "base/task.h"
#include "data/dataset/dataset.h"

namespace isostrata {

/// Points first, first + stride, ... up to last along each axis; a last beyond the grid's is the grid's.
struct Region {
  std::array<std::int64_t, 3> first{0, 0, 0};
  std::array<std::int64_t, 3> last{std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::max(),
                                   std::numeric_limits<std::int64_t>::max()};
  std::array<std::int64_t, 3> stride{1, 1, 1};

  bool operator==(const Region&) const = default;
};

/// "FIRST:LAST,FIRST:LAST,FIRST:LAST", points along x, y, z counted from 0, both included; what is left out is the grid's end ("100:200,:,:63").
/// Throws invalid_argument saying what was expected.
void set_box(Region& region, std::string_view text);
/// "N" or "NX,NY,NZ", each 1 or more. Throws as set_box.
void set_stride(Region& region, std::string_view text);

/// The shortest text that set_box and set_stride read, with what is between them: "0:31,:,:*2", ":,:,:" of the whole.
std::string to_string(const Region& region);
/// What to_string wrote. Throws as set_box.
Region region_of(std::string_view text);

/// The part of the dataset: values and positions as they are there, copied; ranges, bounds and cells are the part's own. A cell of the part that
/// spans several is hidden where one of them is. Values outside are not read. Throws invalid_argument (nothing of the grid is in it, naming both),
/// unsupported (an unstructured grid), too_large, cancelled. Parallel.
std::shared_ptr<const Dataset> part_of(const Dataset& whole, const Region& region, std::uint64_t max_bytes, const Task& task);

/// Every n-th point along each axis, for a first look: the arrays of these names alone, with the ranges and the bounds of the whole, so that it is drawn
/// in its colours and place. What is read of an array that was imported into the cache is kept there (kept_facts.h). Precondition: a structured grid.
/// Throws not_found (an array that is not there), cancelled. Parallel.
std::shared_ptr<const Dataset> coarser(const Dataset& whole, const std::array<std::int64_t, 3>& stride, std::span<const std::string> arrays, const Task& task);

/// open_dataset, but nobody looks at values that are mapped where they lie in the file (source_mapping.h), not even for their range: for whoever wants
/// a part of the dataset. Throws what open_dataset throws.
std::shared_ptr<const Dataset> open_unread(std::string_view name, const OpenOptions& options, const Task& task);
/// Whether the array's range is not known yet: lower > upper, and nan_count is -1.
inline bool is_unread(const PointArray& array) { return array.nan_count < 0; }

/// open_dataset and part_of it. Where the whole is not known yet from the import cache, nobody looks at values outside, not even for their range; a
/// file whose values can be mapped in place is not read elsewhere either. Throws what both throw.
std::shared_ptr<const Dataset> open_part(std::string_view name, const OpenOptions& options, const Region& region, const Task& task);

}  // namespace isostrata
