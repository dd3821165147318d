#include "data/parts/structured_part.h"

#include <algorithm>
#include <span>
#include <tuple>

#include "base/parallel.h"

namespace isostrata {
namespace {

using Index = std::array<std::int64_t, 3>;

/// Those of the part, rows side by side.
template <class T>
std::pair<std::span<const T>, std::shared_ptr<const void>> take(std::span<const T> all, const StructuredPart& part, const Task& task) {
  auto storage = std::shared_ptr<T[]>(new T[static_cast<std::size_t>(part.count())]);
  parallel_for(part.dims[1] * part.dims[2], 16, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t row = begin; row < end; ++row) {
      const T* from = all.data() + part.point(0, row % part.dims[1], row / part.dims[1]);
      T* const to = storage.get() + row * part.dims[0];
      if (part.step[0] == 1)
        std::copy_n(from, part.dims[0], to);
      else
        for (std::int64_t i = 0; i < part.dims[0]; ++i) to[i] = from[i * part.step[0]];
    }
  });
  return {std::span<const T>(storage.get(), static_cast<std::size_t>(part.count())), storage};
}

/// The part's own, if its cells are cells of the whole.
std::shared_ptr<const CellValues> cells_of(const PointArray& whole, const StructuredPart& part, const Task& task) {
  if (!whole.cells || part.step != Index{1, 1, 1}) return nullptr;
  StructuredPart cells = part;
  for (std::size_t a = 0; a < 3; ++a) {
    cells.dims[a] = std::max<std::int64_t>(part.dims[a] - 1, 1);
    cells.of[a] = std::max<std::int64_t>(part.of[a] - 1, 1);
    cells.from[a] = std::min(part.from[a], cells.of[a] - 1);
    if (part.dims[a] == 1 && part.of[a] > 1) return nullptr;  // a sheet between cells has none of them
  }
  CellValues out = *whole.cells;
  std::visit([&](auto all) { std::tie(out.values, out.storage) = take(all, cells, task); }, whole.cells->values);
  measure_range(out);
  return std::make_shared<const CellValues>(std::move(out));
}

}  // namespace

std::pair<PointSpan, std::shared_ptr<const void>> points_of(const PointSpan& whole, const StructuredPart& part, const Task& task) {
  return std::visit(
      [&](auto all) {
        auto [taken, storage] = take(all, part, task);
        return std::pair<PointSpan, std::shared_ptr<const void>>(taken, storage);
      },
      whole);
}

PointArray array_of(const PointArray& whole, const StructuredPart& part, const Task& task) {
  PointArray array = whole;
  array.cells = cells_of(whole, part, task);
  std::visit(
      [&](auto all) {
        auto [taken, storage] = take(all, part, task);
        array.values = taken;
        array.storage = storage;
      },
      whole.values);
  return array;
}

std::vector<std::uint8_t> hidden_cells_of(const Grid& whole, const StructuredPart& part) {
  if (whole.hidden_cells.empty()) return {};
  Index cells, all;
  for (std::size_t a = 0; a < 3; ++a) {
    cells[a] = std::max<std::int64_t>(part.dims[a] - 1, 1);
    all[a] = std::max<std::int64_t>(part.of[a] - 1, 1);
  }
  std::vector<std::uint8_t> hidden(static_cast<std::size_t>(cells[0] * cells[1] * cells[2]));
  parallel_for(cells[2], 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
      for (std::int64_t j = 0; j < cells[1]; ++j)
        for (std::int64_t i = 0; i < cells[0]; ++i) {
          bool any = false;
          const Index at{i, j, k};
          Index low, high;
          for (std::size_t a = 0; a < 3; ++a) {
            low[a] = std::min(part.from[a] + at[a] * part.step[a], all[a] - 1);
            high[a] = part.dims[a] > 1 ? std::min(low[a] + part.step[a], all[a]) : low[a] + 1;
          }
          for (std::int64_t z = low[2]; z < high[2]; ++z)
            for (std::int64_t y = low[1]; y < high[1]; ++y)
              for (std::int64_t x = low[0]; x < high[0]; ++x) any = any || whole.hidden(x + all[0] * (y + all[1] * z));
          hidden[static_cast<std::size_t>(i + cells[0] * (j + cells[1] * k))] = any;
        }
  });
  return hidden;
}

}  // namespace isostrata
