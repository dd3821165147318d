#include "import/average_cells.h"

#include <cmath>
#include <limits>
#include <span>

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
  if (!grid.flat()) {  // as cell_points, without its divisions
    const auto dims = grid.dims();
    std::array<std::int64_t, 8> corners{};
    for (std::size_t v = 0; v < 8; ++v) corners[v] = kHexahedronCorners[v][0] + dims[0] * (kHexahedronCorners[v][1] + dims[1] * kHexahedronCorners[v][2]);
    std::int64_t cell = 0;
    for (std::int64_t k = 0; k + 1 < dims[2]; ++k)
      for (std::int64_t j = 0; j + 1 < dims[1]; ++j)
        for (std::int64_t i = 0; i + 1 < dims[0]; ++i, ++cell) {
          if (grid.hidden(cell)) continue;
          const std::int64_t first = i + dims[0] * (j + dims[1] * k);
          for (std::size_t v = 0; v < 8; ++v) ids[v] = first + corners[v];
          use(cell, std::span<const std::int64_t>(ids).first(8));
        }
    return;
  }
  for (std::int64_t cell = 0; cell < cells; ++cell)
    if (!grid.hidden(cell)) use(cell, std::span<const std::int64_t>(ids).first(static_cast<std::size_t>(grid.cell_points(cell, ids))));
}

template <class Out>
FileArray mean_over_cells(const Block& block, const FileArray& array) {
  const Grid& grid = block.grid;
  const auto points = static_cast<std::size_t>(grid.point_count());
  const auto components = static_cast<std::size_t>(array.components);
  const bool seams = has_seams(block);
  const std::size_t stride = components + 1;  // a point's sums, and how many cells are in them
  std::vector<double> sums(points * stride, 0.0);
  // A cell that was split counts once at each of its points, however many of its pieces meet there.
  std::vector<std::int64_t> counted(block.source.empty() ? 0 : points, -1);
  std::visit(
      [&](auto values) {
        for_each_cell(grid, [&](std::int64_t cell, std::span<const std::int64_t> ids) {
          if (array.partial && std::isnan(static_cast<double>(values[static_cast<std::size_t>(cell) * components]))) return;  // no value
          for (const std::int64_t id : ids) {
            const auto point = static_cast<std::size_t>(seams ? without_seams(block, id) : id);
            if (!counted.empty()) {
              const std::int64_t source = block.source[static_cast<std::size_t>(cell)];
              if (counted[point] == source) continue;
              counted[point] = source;
            }
            double* const of_point = &sums[point * stride];
            for (std::size_t c = 0; c < components; ++c) of_point[c] += static_cast<double>(values[static_cast<std::size_t>(cell) * components + c]);
            ++of_point[components];
          }
        });
      },
      scalar_span(array.type, array.values));

  auto [storage, means] = allocate<Out>(points * components);
  for (std::size_t p = 0; p < points; ++p) {
    const auto from = seams ? static_cast<std::size_t>(without_seams(block, static_cast<std::int64_t>(p))) : p;
    const double* const of_point = &sums[from * stride];
    const double uses = of_point[components];
    for (std::size_t c = 0; c < components; ++c)
      means[p * components + c] = uses > 0 ? static_cast<Out>(of_point[c] / uses) : std::numeric_limits<Out>::quiet_NaN();
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
