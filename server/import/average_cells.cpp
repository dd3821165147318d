#include "import/average_cells.h"

#include <cmath>
#include <limits>

#include "import/close_seams.h"

namespace isostrata {
namespace {

template <class Out>
FileArray mean_over_cells(const Block& block, const FileArray& array) {
  const Grid& grid = block.grid;
  const auto points = static_cast<std::size_t>(grid.point_count());
  const auto components = static_cast<std::size_t>(array.components);
  std::vector<double> sums(points * components, 0.0);
  std::vector<std::uint32_t> uses(points, 0);
  // A cell that was split counts once at each of its points, however many of its pieces meet there.
  std::vector<std::int64_t> counted(block.source.empty() ? 0 : points, -1);
  std::visit(
      [&](auto values) {
        std::array<std::int64_t, kMaxCellVertices> ids{};
        const std::int64_t cells = grid.cell_count();
        for (std::int64_t cell = 0; cell < cells; ++cell) {
          if (grid.hidden(cell)) continue;
          if (array.partial && std::isnan(static_cast<double>(values[static_cast<std::size_t>(cell) * components]))) continue;  // no value
          const int n = grid.cell_points(cell, ids);
          for (int v = 0; v < n; ++v) {
            const auto point = static_cast<std::size_t>(without_seams(block, ids[static_cast<std::size_t>(v)]));
            if (!counted.empty()) {
              const std::int64_t source = block.source[static_cast<std::size_t>(cell)];
              if (counted[point] == source) continue;
              counted[point] = source;
            }
            ++uses[point];
            for (std::size_t c = 0; c < components; ++c)
              sums[point * components + c] += static_cast<double>(values[static_cast<std::size_t>(cell) * components + c]);
          }
        }
      },
      scalar_span(array.type, array.values));

  auto [storage, means] = allocate<Out>(points * components);
  for (std::size_t p = 0; p < points; ++p) {
    const auto from = static_cast<std::size_t>(without_seams(block, static_cast<std::int64_t>(p)));
    for (std::size_t c = 0; c < components; ++c)
      means[p * components + c] =
          uses[from] ? static_cast<Out>(sums[from * components + c] / uses[from]) : std::numeric_limits<Out>::quiet_NaN();
  }
  FileArray out = array;
  out.type = sizeof(Out) == 4 ? ScalarType::float32 : ScalarType::float64;
  out.values = std::as_bytes(means);
  out.storage = storage;
  return out;
}

}  // namespace

FileArray average_cells(const Block& block, const FileArray& array) {
  const bool single = array.type == ScalarType::float32 || size_of(array.type) <= 2;
  return single ? mean_over_cells<float>(block, array) : mean_over_cells<double>(block, array);
}

}  // namespace isostrata
