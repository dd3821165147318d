#include "import/average_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "import/close_seams.h"

namespace isostrata {
namespace {

/// use(cell, points) for each cell that is not hidden, in their order.
template <class Use>
void for_each_cell(const Grid& grid, const Use& use) {
  const std::int64_t cells = grid.cell_count();
  if (const auto* mesh = std::get_if<UnstructuredGrid>(&grid.shape)) {
    for (std::int64_t cell = 0; cell < cells; ++cell) {
      const auto at = static_cast<std::size_t>(cell);
      const auto begin = static_cast<std::size_t>(mesh->offsets[at]), end = static_cast<std::size_t>(mesh->offsets[at + 1]);
      if (!grid.hidden(cell)) use(cell, mesh->connectivity.subspan(begin, end - begin));
    }
    return;
  }
  std::array<std::int64_t, kMaxCellVertices> ids{};
  for (std::int64_t cell = 0; cell < cells; ++cell)
    if (!grid.hidden(cell)) use(cell, std::span<const std::int64_t>(ids).first(static_cast<std::size_t>(grid.cell_points(cell, ids))));
}

/// The array as point array of these means.
template <class Out>
FileArray of_points(const FileArray& array, std::span<Out> means, const std::shared_ptr<const void>& storage) {
  FileArray out = array;
  out.type = sizeof(Out) == 4 ? ScalarType::float32 : ScalarType::float64;
  out.values = std::as_bytes(means);
  out.storage = storage;
  return out;
}

bool goes_by_rows(const Block& block, const FileArray& array) {
  const Grid& grid = block.grid;
  return grid.structured() && !grid.flat() && grid.cell_count() > 0 && grid.hidden_cells.empty() && block.source.empty() && !has_seams(block) && !array.partial;
}

/// Of boxes that all count: a row of points is the sum of up to four rows of cells, each once for the cells before the points and once for those after
/// them. Cells are added in their order, as sum_at_points adds them, so the sums are the same to the last bit.
template <class Out>
FileArray mean_by_rows(const Block& block, const FileArray& array) {
  const auto dims = block.grid.dims();
  const auto components = static_cast<std::size_t>(array.components);
  const auto cells = static_cast<std::size_t>(dims[0] - 1) * components;  // numbers of a row
  const std::size_t row = cells + components;
  auto [storage, means] = allocate<Out>(static_cast<std::size_t>(block.grid.point_count()) * components);
  std::vector<double> sums(row);
  std::visit(
      [&](auto values) {
        std::size_t to = 0;
        for (std::int64_t k = 0; k < dims[2]; ++k)
          for (std::int64_t j = 0; j < dims[1]; ++j, to += row) {
            std::fill(sums.begin(), sums.end(), 0.0);
            int rows = 0;
            for (std::int64_t ck = std::max<std::int64_t>(k - 1, 0); ck < std::min(k + 1, dims[2] - 1); ++ck)
              for (std::int64_t cj = std::max<std::int64_t>(j - 1, 0); cj < std::min(j + 1, dims[1] - 1); ++cj, ++rows) {
                const auto of_row = values.subspan(static_cast<std::size_t>(ck * (dims[1] - 1) + cj) * cells, cells);
                for (std::size_t at = 0; at < cells; ++at) sums[at + components] += static_cast<double>(of_row[at]);
                for (std::size_t at = 0; at < cells; ++at) sums[at] += static_cast<double>(of_row[at]);
              }
            for (std::size_t at = 0; at < row; ++at) means[to + at] = static_cast<Out>(sums[at] / (at < components || at >= cells ? rows : 2 * rows));
          }
      },
      scalar_span(array.type, array.values));
  return of_points<Out>(array, means, storage);
}

constexpr std::size_t kNumbersTogether = 7;   // and how many cells are in them: a line of the cache
constexpr std::int64_t kCellsTogether = 4096;  // whose values are looked at together

/// Numbers of some arrays side by side, as doubles. Cells are asked for in their order.
class ValuesOfCells {
 public:
  ValuesOfCells(std::span<const FileArray* const> arrays, std::size_t width, std::int64_t cells)
      : arrays_(arrays), width_(width), cells_(cells), values_(width * kCellsTogether) {}

  const double* of(std::int64_t cell) {
    if (cell >= end_) load(cell);
    return &values_[static_cast<std::size_t>(cell - begin_) * width_];
  }

 private:
  void load(std::int64_t cell) {
    begin_ = cell;
    end_ = std::min(cell + kCellsTogether, cells_);
    std::size_t column = 0;
    for (const FileArray* array : arrays_) {
      const auto components = static_cast<std::size_t>(array->components);
      std::visit(
          [&](auto values) {
            for (std::int64_t of = begin_; of < end_; ++of)
              for (std::size_t c = 0; c < components; ++c)
                values_[static_cast<std::size_t>(of - begin_) * width_ + column + c] = static_cast<double>(values[static_cast<std::size_t>(of) * components + c]);
          },
          scalar_span(array->type, array->values));
      column += components;
    }
  }

  const std::span<const FileArray* const> arrays_;
  const std::size_t width_;
  const std::int64_t cells_;
  std::int64_t begin_ = 0, end_ = 0;
  std::vector<double> values_;
};

std::size_t width_of(std::span<const FileArray* const> arrays) {
  std::size_t width = 0;
  for (const FileArray* array : arrays) width += static_cast<std::size_t>(array->components);
  return width;
}

/// At each point `width` sums, and how many cells are in them. partial: a cell whose first number is NaN has none.
std::vector<double> sum_at_points(const Block& block, std::span<const FileArray* const> arrays, bool partial) {
  const Grid& grid = block.grid;
  const auto points = static_cast<std::size_t>(grid.point_count());
  const std::size_t width = width_of(arrays), stride = width + 1;
  const bool seams = has_seams(block);
  std::vector<double> sums(points * stride, 0.0);
  // A cell that was split counts once at each of its points, however many of its pieces meet there.
  std::vector<std::int64_t> counted(block.source.empty() ? 0 : points, -1);
  ValuesOfCells values(arrays, width, grid.cell_count());
  for_each_cell(grid, [&](std::int64_t cell, std::span<const std::int64_t> ids) {
    const double* const of_cell = values.of(cell);
    if (partial && std::isnan(of_cell[0])) return;
    for (const std::int64_t id : ids) {
      const auto point = static_cast<std::size_t>(seams ? without_seams(block, id) : id);
      if (!counted.empty()) {
        const std::int64_t source = block.source[static_cast<std::size_t>(cell)];
        if (counted[point] == source) continue;
        counted[point] = source;
      }
      double* const of_point = &sums[point * stride];
      for (std::size_t c = 0; c < width; ++c) of_point[c] += of_cell[c];
      ++of_point[width];
    }
  });
  return sums;
}

/// The numbers from `column` on of each point's sums, by how many cells are in them.
template <class Out>
FileArray mean_of(const Block& block, const FileArray& array, const std::vector<double>& sums, std::size_t width, std::size_t column) {
  const auto points = static_cast<std::size_t>(block.grid.point_count());
  const auto components = static_cast<std::size_t>(array.components);
  const bool seams = has_seams(block);
  auto [storage, means] = allocate<Out>(points * components);
  for (std::size_t p = 0; p < points; ++p) {
    const auto from = seams ? static_cast<std::size_t>(without_seams(block, static_cast<std::int64_t>(p))) : p;
    const double* const of_point = &sums[from * (width + 1)];
    const double cells = of_point[width];
    for (std::size_t c = 0; c < components; ++c)
      means[p * components + c] = cells > 0 ? static_cast<Out>(of_point[column + c] / cells) : std::numeric_limits<Out>::quiet_NaN();
  }
  return of_points<Out>(array, means, storage);
}

/// What is float32, and what it holds exactly.
bool is_single(const FileArray& array) { return array.type == ScalarType::float32 || size_of(array.type) <= 2; }

}  // namespace

CellMeans::CellMeans(const Block& block) : block_(block) {
  for (const FileArray& array : block.arrays)
    if (array.on_cells) arrays_.push_back(&array);
}

/// How many of the next ones; one that lacks values somewhere counts other cells.
std::size_t CellMeans::together() const {
  const std::size_t points = static_cast<std::size_t>(std::max<std::int64_t>(block_.grid.point_count(), 1));
  const std::size_t most = std::min(kNumbersTogether, std::max<std::size_t>(kMostSums / (points * sizeof(double)), 1) - 1);
  std::size_t width = 0, count = 0;
  while (at_ + count < arrays_.size()) {
    const FileArray& array = *arrays_[at_ + count];
    width += static_cast<std::size_t>(array.components);
    if (count > 0 && (array.partial || width > most)) break;
    ++count;
    if (array.partial) break;
  }
  return count;
}

FileArray CellMeans::next() {
  if (means_.empty() && goes_by_rows(block_, *arrays_[at_])) {
    const FileArray& array = *arrays_[at_++];
    return is_single(array) ? mean_by_rows<float>(block_, array) : mean_by_rows<double>(block_, array);
  }
  if (means_.empty()) {
    const auto arrays = std::span<const FileArray* const>(arrays_).subspan(at_, together());
    at_ += arrays.size();
    const std::vector<double> sums = sum_at_points(block_, arrays, arrays.front()->partial);
    const std::size_t width = width_of(arrays);
    std::size_t column = 0;
    for (const FileArray* array : arrays) {
      means_.push_back(is_single(*array) ? mean_of<float>(block_, *array, sums, width, column) : mean_of<double>(block_, *array, sums, width, column));
      column += static_cast<std::size_t>(array->components);
    }
  }
  FileArray mean = std::move(means_.front());
  means_.pop_front();
  return mean;
}

}  // namespace isostrata
