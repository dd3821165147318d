#include "extraction/unstructured/face_memory.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "base/finite.h"
#include "base/parallel.h"
#include "extraction/facets/boundary_facets.h"

namespace isostrata {
namespace {

/// Whatever its values are.
bool can_be_present(const Grid& grid, std::int64_t cell) {
  if (grid.hidden(cell)) return false;
  std::array<std::int64_t, kMaxCellVertices> ids;
  const auto n = static_cast<std::size_t>(grid.cell_points(cell, ids));
  return std::ranges::all_of(std::span(ids).first(n), [&](std::int64_t id) { return is_finite(grid.point(id)); });
}

}  // namespace

FaceMemory::Entry* FaceMemory::find(const Grid& grid) {
  entries_.remove_if([](const Entry& entry) { return entry.storage.expired(); });
  const GridPlace place = GridPlace::of(grid);
  for (auto it = entries_.begin(); it != entries_.end(); ++it) {
    if (it->place != place) continue;
    entries_.splice(entries_.begin(), entries_, it);
    return &entries_.front();
  }
  return nullptr;
}

std::shared_ptr<const OpenFacesOfCells> FaceMemory::find(const Grid& grid, const PointArray& array) {
  if (grid.structured() || !grid.storage || array.nan_count != 0) return nullptr;
  const std::lock_guard lock(mutex_);
  const Entry* const entry = find(grid);
  return entry ? entry->open : nullptr;
}

bool FaceMemory::knows(const Grid& grid) {
  if (grid.structured() || !grid.storage) return true;  // nobody can tell when it is gone
  const std::lock_guard lock(mutex_);
  return find(grid) != nullptr;
}

void FaceMemory::make(const Grid& grid, const Task& task) {
  if (knows(grid)) return;
  auto open = std::make_shared<OpenFacesOfCells>(static_cast<std::size_t>(grid.cell_count()));
  parallel_for(grid.cell_count(), 1 << 13, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t cell = begin; cell < end; ++cell) (*open)[static_cast<std::size_t>(cell)] = can_be_present(grid, cell);
  });
  std::vector<CellRun> present;
  for (std::int64_t cell = 0; cell < grid.cell_count(); ++cell)
    if (std::exchange((*open)[static_cast<std::size_t>(cell)], std::uint8_t{0}) != 0) present.push_back({cell, 0});
  const std::vector<std::uint8_t> of_present = open_cell_faces(grid, {}, present, max_bytes_, task);
  for (std::size_t i = 0; i < present.size(); ++i) (*open)[static_cast<std::size_t>(present[i].cell)] = of_present[i];
  const std::lock_guard lock(mutex_);
  if (find(grid)) return;
  entries_.push_front({GridPlace::of(grid), grid.storage, std::move(open)});
  std::uint64_t bytes = 0;
  entries_.remove_if([&](const Entry& entry) { return (bytes += entry.open->size()) > max_bytes_; });
}

std::uint64_t FaceMemory::bytes() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t bytes = 0;
  for (const Entry& entry : entries_) bytes += entry.open->size();
  return bytes;
}

}  // namespace isostrata
