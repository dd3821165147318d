#include "import/dataset/average_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include "import/dataset/close_seams.h"
#include "import/imported/appended_file.h"

// Sums along a row go as many at a time as the processor can, each as it would go alone: nothing is fused, and their order is kept. So every level gives the same bits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ISOSTRATA_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define ISOSTRATA_CLONES
#endif

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

/// Numbers in a file, at any address.
template <class T>
struct NumbersAt {
  const std::byte* from = nullptr;
  double operator[](std::size_t at) const {
    T value;
    std::memcpy(&value, from + at * sizeof(T), sizeof value);
    return static_cast<double>(value);
  }
};

/// The mean over `rows` rows of cells, a power of two, at each of their points but the first and the last. A point's cells are added in their order, as
/// sum_at_points adds them, so the means are the same to the last bit.
template <int rows, class T, class Out>
ISOSTRATA_CLONES void mean_inside(const std::array<NumbersAt<T>, 4>& of_rows, std::size_t cells, std::size_t components, Out* means) {
  for (std::size_t at = components; at < cells; ++at) {
    double sum = 0;
    for (int row = 0; row < rows; ++row) sum = (sum + of_rows[row][at - components]) + of_rows[row][at];
    means[at] = static_cast<Out>(sum * (0.5 / rows));
  }
}

/// Of boxes that all count: a row of points has up to four rows of cells.
template <class Out>
FileArray mean_by_rows(const Block& block, const FileArray& array, AppendedFile<Out> file) {
  const auto dims = block.grid.dims();
  const auto components = static_cast<std::size_t>(array.components);
  const auto cells = static_cast<std::size_t>(dims[0] - 1) * components;  // numbers of a row
  std::vector<Out> means(cells + components);
  std::visit(
      [&](auto typed) {
        using T = typename decltype(typed)::value_type;
        std::array<NumbersAt<T>, 4> of_rows{};
        for (std::int64_t k = 0; k < dims[2]; ++k)
          for (std::int64_t j = 0; j < dims[1]; ++j) {
            std::size_t rows = 0;
            for (std::int64_t ck = std::max<std::int64_t>(k - 1, 0); ck < std::min(k + 1, dims[2] - 1); ++ck)
              for (std::int64_t cj = std::max<std::int64_t>(j - 1, 0); cj < std::min(j + 1, dims[1] - 1); ++cj)
                of_rows[rows++].from = array.values.data() + static_cast<std::size_t>(ck * (dims[1] - 1) + cj) * cells * sizeof(T);
            for (std::size_t c = 0; c < components; ++c) {
              double first = 0, last = 0;
              for (std::size_t row = 0; row < rows; ++row) {
                first += of_rows[row][c];
                last += of_rows[row][cells - components + c];
              }
              means[c] = static_cast<Out>(first / static_cast<double>(rows));
              means[cells + c] = static_cast<Out>(last / static_cast<double>(rows));
            }
            if (rows == 4)
              mean_inside<4>(of_rows, cells, components, means.data());
            else if (rows == 2)
              mean_inside<2>(of_rows, cells, components, means.data());
            else
              mean_inside<1>(of_rows, cells, components, means.data());
            file.add(means);
          }
      },
      scalar_span(array.type, {}));
  const auto [written, storage] = file.finish();
  return of_points<const Out>(array, written, storage);
}

constexpr std::size_t kNumbersTogether = 7;   // and how many cells are in them: a line of the cache
constexpr std::int64_t kCellsTogether = 4096;  // whose values are looked at together

/// Numbers of some arrays side by side, as doubles, and a one. Cells are asked for in their order.
class ValuesOfCells {
 public:
  ValuesOfCells(std::span<const FileArray* const> arrays, std::size_t width, std::int64_t cells)
      : arrays_(arrays), stride_(width + 1), cells_(cells), values_(stride_ * kCellsTogether, 1.0) {}

  const double* of(std::int64_t cell) {
    if (cell >= end_) load(cell);
    return &values_[static_cast<std::size_t>(cell - begin_) * stride_];
  }

 private:
  void load(std::int64_t cell) {
    begin_ = cell;
    end_ = std::min(cell + kCellsTogether, cells_);
    std::size_t column = 0;
    for (const FileArray* array : arrays_) {
      const auto components = static_cast<std::size_t>(array->components);
      std::visit(
          [&](auto typed) {
            using T = typename decltype(typed)::value_type;
            const NumbersAt<T> values{array->values.data()};
            for (std::int64_t of = begin_; of < end_; ++of)
              for (std::size_t c = 0; c < components; ++c)
                values_[static_cast<std::size_t>(of - begin_) * stride_ + column + c] = values[static_cast<std::size_t>(of) * components + c];
          },
          scalar_span(array->type, {}));
      column += components;
    }
  }

  const std::span<const FileArray* const> arrays_;
  const std::size_t stride_;
  const std::int64_t cells_;
  std::int64_t begin_ = 0, end_ = 0;
  std::vector<double> values_;
};

std::size_t width_of(std::span<const FileArray* const> arrays) {
  std::size_t width = 0;
  for (const FileArray* array : arrays) width += static_cast<std::size_t>(array->components);
  return width;
}

/// Calls use with the number as a constant, so that its loops are unrolled, if that is small; else with 0.
template <class Use>
void with_constant(std::size_t number, const Use& use) {
  switch (number) {
    case 2: return use(std::integral_constant<std::size_t, 2>());
    case 3: return use(std::integral_constant<std::size_t, 3>());
    case 4: return use(std::integral_constant<std::size_t, 4>());
    case 5: return use(std::integral_constant<std::size_t, 5>());
    case 6: return use(std::integral_constant<std::size_t, 6>());
    case 7: return use(std::integral_constant<std::size_t, 7>());
    case 8: return use(std::integral_constant<std::size_t, 8>());
    default: return use(std::integral_constant<std::size_t, 0>());
  }
}

/// sum_at_points, of cells of a mesh that all count.
template <std::size_t kStride>
void sum_cells(const UnstructuredGrid& mesh, ValuesOfCells& values, std::size_t stride, double* sums) {
  constexpr std::int64_t kAhead = 64;  // ids: their sums lie anywhere
  if constexpr (kStride > 0) stride = kStride;
  const std::int64_t* const ids = mesh.connectivity.data();
  const auto all = static_cast<std::int64_t>(mesh.connectivity.size()), cells = static_cast<std::int64_t>(mesh.types.size());
  std::int64_t at = 0;
  for (std::int64_t cell = 0; cell < cells; ++cell) {
    const double* const of_cell = values.of(cell);
    for (const std::int64_t end = mesh.offsets[static_cast<std::size_t>(cell) + 1]; at < end; ++at) {
      __builtin_prefetch(sums + static_cast<std::size_t>(ids[std::min(at + kAhead, all - 1)]) * stride, 1);
      double* const of_point = sums + static_cast<std::size_t>(ids[at]) * stride;
      for (std::size_t c = 0; c < stride; ++c) of_point[c] += of_cell[c];
    }
  }
}

/// At each point the sums of the arrays' numbers, and how many cells are in them. partial: a cell whose first number is NaN has none.
template <std::size_t kStride>
std::vector<double> sum_at_points(const Block& block, std::span<const FileArray* const> arrays, bool partial) {
  const Grid& grid = block.grid;
  const auto points = static_cast<std::size_t>(grid.point_count());
  const std::size_t width = width_of(arrays), stride = kStride > 0 ? kStride : width + 1;
  const bool seams = has_seams(block);
  std::vector<double> sums(points * stride, 0.0);
  // A cell that was split counts once at each of its points, however many of its pieces meet there.
  std::vector<std::int64_t> counted(block.source.empty() ? 0 : points, -1);
  ValuesOfCells values(arrays, width, grid.cell_count());
  if (const auto* mesh = std::get_if<UnstructuredGrid>(&grid.shape); mesh && !partial && !seams && counted.empty() && grid.hidden_cells.empty()) {
    sum_cells<kStride>(*mesh, values, stride, sums.data());
    return sums;
  }
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
      for (std::size_t c = 0; c < stride; ++c) of_point[c] += of_cell[c];
    }
  });
  return sums;
}

/// The numbers of one array at the points that have weights of their own, asked for in the order of the points.
class WeightedValues {
 public:
  WeightedValues(const PointWeights& weights, const FileArray& array) : weights_(weights), array_(array) {}
  /// Adds the point's numbers to `to`; false if the mean over its cells is its value.
  template <class Out>
  bool add(std::int64_t point, std::vector<Out>& to) {
    if (at_ == weights_.points.size() || weights_.points[at_] != point) return false;
    const auto components = static_cast<std::size_t>(array_.components);
    std::visit(
        [&](auto typed) {
          using T = typename decltype(typed)::value_type;
          const NumbersAt<T> values{array_.values.data()};
          for (std::size_t c = 0; c < components; ++c) {
            double sum = weights_.first[at_] < weights_.first[at_ + 1] ? 0 : std::numeric_limits<double>::quiet_NaN();
            for (std::size_t k = weights_.first[at_]; k < weights_.first[at_ + 1]; ++k)
              sum += weights_.weights[k] * values[static_cast<std::size_t>(weights_.cells[k]) * components + c];
            to.push_back(static_cast<Out>(sum));
          }
        },
        scalar_span(array_.type, {}));
    ++at_;
    return true;
  }

 private:
  const PointWeights& weights_;
  const FileArray& array_;
  std::size_t at_ = 0;
};

/// The numbers from `column` on of each point's sums, by how many cells are in them.
template <class Out>
FileArray mean_of(const Block& block, const FileArray& array, const std::vector<double>& sums, std::size_t width, std::size_t column, AppendedFile<Out> file) {
  constexpr std::size_t kTogether = 4096;  // points
  const auto points = static_cast<std::size_t>(block.grid.point_count());
  const auto components = static_cast<std::size_t>(array.components);
  const bool seams = has_seams(block);
  WeightedValues weighted(block.weights, array);
  std::vector<Out> means;
  for (std::size_t first = 0; first < points; first += kTogether) {
    means.clear();
    for (std::size_t p = first; p < std::min(first + kTogether, points); ++p) {
      if (weighted.add(static_cast<std::int64_t>(p), means)) continue;
      const auto from = seams ? static_cast<std::size_t>(without_seams(block, static_cast<std::int64_t>(p))) : p;
      const double* const of_point = &sums[from * (width + 1)];
      const double cells = of_point[width];
      for (std::size_t c = 0; c < components; ++c)
        means.push_back(cells > 0 ? static_cast<Out>(of_point[column + c] / cells) : std::numeric_limits<Out>::quiet_NaN());
    }
    file.add(means);
  }
  const auto [written, storage] = file.finish();
  return of_points<const Out>(array, written, storage);
}

/// What is float32, and what it holds exactly.
bool is_single(const FileArray& array) { return array.type == ScalarType::float32 || size_of(array.type) <= 2; }

}  // namespace

CellMeans::CellMeans(const Block& block, const ReadRequest& request) : block_(block), request_(request) {
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

FileArray CellMeans::next(const std::string& file) {
  const FileArray& array = *arrays_[at_];
  if (summed_ == 0 && goes_by_rows(block_, array)) {
    ++at_;
    return is_single(array) ? mean_by_rows<float>(block_, array, {request_, file}) : mean_by_rows<double>(block_, array, {request_, file});
  }
  if (summed_ == 0) {
    const auto arrays = std::span<const FileArray* const>(arrays_).subspan(at_, together());
    summed_ = arrays.size();
    width_ = width_of(arrays);
    column_ = 0;
    with_constant(width_ + 1, [&](auto stride) { sums_ = sum_at_points<stride>(block_, arrays, arrays.front()->partial); });
  }
  FileArray mean = is_single(array) ? mean_of<float>(block_, array, sums_, width_, column_, {request_, file})
                                    : mean_of<double>(block_, array, sums_, width_, column_, {request_, file});
  column_ += static_cast<std::size_t>(array.components);
  ++at_;
  if (--summed_ == 0) sums_ = {};
  return mean;
}

}  // namespace isostrata
