#include "data/derived/nearest_points.h"

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "data/grids/subdivide_cells.h"

namespace isostrata {
namespace {

void check_bytes(const Dataset& whole, std::uint64_t bytes, std::uint64_t max_bytes) {
  if (bytes > max_bytes)
    throw Error(ErrorCode::too_large, whole.name + ": cells of the nearest points need " + std::to_string(bytes) + " bytes; the limit is " +
                                          std::to_string(max_bytes));
}

/// The ends, and the middles between neighbours; of one value that value.
std::vector<double> middles(const std::vector<double>& axis) {
  if (axis.size() == 1) return axis;
  std::vector<double> out{axis.front()};
  for (std::size_t i = 1; i < axis.size(); ++i) out.push_back(axis[i - 1] + (axis[i] - axis[i - 1]) / 2);
  out.push_back(axis.back());
  return out;
}

/// A box of one cell around each point, ended by the domain.
Grid boxes_around(const Grid& whole) {
  RectilinearGrid out;
  const auto dims = whole.dims();
  const auto* uniform = std::get_if<UniformGrid>(&whole.shape);
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    std::vector<double> points;
    if (uniform)
      for (std::int64_t i = 0; i < dims[axis]; ++i) points.push_back(uniform->origin[a] + static_cast<double>(i) * uniform->spacing[a]);
    else
      points = std::get<RectilinearGrid>(whole.shape).axes[axis];
    out.axes[axis] = middles(points);
    out.dims[axis] = static_cast<std::int64_t>(out.axes[axis].size());
  }
  Grid grid;
  grid.shape = std::move(out);
  return grid;
}

/// The same of a curvilinear grid: each new point is the mean of the old ones around it.
Grid cells_around(const Grid& whole, const Task& task) {
  const auto dims = whole.dims();
  std::array<std::int64_t, 3> made{};
  for (std::size_t a = 0; a < 3; ++a) made[a] = dims[a] == 1 ? 1 : dims[a] + 1;
  auto storage = std::make_shared<std::vector<Vec3d>>(static_cast<std::size_t>(made[0] * made[1] * made[2]));
  // Along an axis new point i lies between the old ones i - 1 and i; the first and the last lie on the domain's end.
  const auto around = [&](std::size_t a, std::int64_t i) {
    return dims[a] == 1 ? std::array<std::int64_t, 2>{0, 0} : std::array<std::int64_t, 2>{std::max<std::int64_t>(i - 1, 0), std::min(i, dims[a] - 1)};
  };
  parallel_for(made[1] * made[2], 16, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t row = begin; row < end; ++row) {
      const auto js = around(1, row % made[1]), ks = around(2, row / made[1]);
      for (std::int64_t i = 0; i < made[0]; ++i) {
        Vec3d sum{};
        for (const std::int64_t k : ks)
          for (const std::int64_t j : js)
            for (const std::int64_t of : around(0, i)) sum = sum + whole.point(of + dims[0] * (j + dims[1] * k));
        (*storage)[static_cast<std::size_t>(row * made[0] + i)] = sum * 0.125;
      }
    }
  });
  Grid grid;
  grid.shape = CurvilinearGrid{made, std::span<const Vec3d>(*storage)};
  grid.storage = storage;
  return grid;
}

bool any_hidden(const Grid& grid) {
  return std::any_of(grid.hidden_cells.begin(), grid.hidden_cells.end(), [](std::uint8_t hidden) { return hidden != 0; });
}

/// point_of: empty if cell i belongs to point i.
CellValues values_of(const PointArray& array, const std::vector<std::int64_t>& point_of) {
  CellValues out{array.type, array.values, array.lower, array.upper, array.nan_count, array.storage};
  if (point_of.empty()) return out;
  std::visit(
      [&](auto values) {
        using T = std::remove_const_t<typename decltype(values)::element_type>;
        auto taken = std::make_shared<std::vector<T>>(point_of.size());
        for (std::size_t c = 0; c < taken->size(); ++c) (*taken)[c] = values[static_cast<std::size_t>(point_of[c])];
        out.values = std::span<const T>(*taken);
        out.storage = std::move(taken);
      },
      array.values);
  return out;
}

std::shared_ptr<const Dataset> make(const Dataset& whole, std::span<const std::string> arrays, std::uint64_t max_bytes, const Task& task) {
  auto made = described_as(whole);
  std::vector<std::int64_t> point_of;
  if (whole.grid.structured() && whole.grid.cell_count() > 0 && !any_hidden(whole.grid)) {
    if (!whole.grid.rectilinear()) check_bytes(whole, static_cast<std::uint64_t>(whole.grid.point_count()) * sizeof(Vec3d), max_bytes);
    made->grid = whole.grid.rectilinear() ? boxes_around(whole.grid) : cells_around(whole.grid, task);
  } else {
    SubdividedCells cells = subdivide_cells(whole.grid, whole.name, max_bytes, task);
    made->grid = std::move(cells.grid);
    point_of = std::move(cells.point_of);
    std::uint64_t bytes = 0;
    for (const std::string& name : arrays) bytes += point_of.size() * size_of(whole.array(name).type);
    check_bytes(whole, bytes, max_bytes);
  }
  made->cell_types = count_cell_types(made->grid);
  for (const std::string& name : arrays) {
    PointArray array = whole.array(name);
    array.cells = std::make_shared<const CellValues>(values_of(array, point_of));
    array.values = std::visit([](auto values) -> ScalarSpan { return decltype(values){}; }, array.values);
    made->arrays.push_back(std::move(array));
  }
  return made;
}

struct Lent {
  std::weak_ptr<const Dataset> whole, made;
  std::vector<std::string> arrays;
};
std::mutex lent_mutex;  // guards `lent`
std::vector<Lent>& lent() {
  static auto* const all = new std::vector<Lent>;
  return *all;
}

}  // namespace

std::shared_ptr<const Dataset> nearest_point_cells(const std::shared_ptr<const Dataset>& whole, std::span<const std::string> names, std::uint64_t max_bytes,
                                                   const Task& task) {
  std::vector<std::string> arrays;
  for (const std::string& name : names)
    if (std::find(arrays.begin(), arrays.end(), name) == arrays.end()) arrays.push_back(name);
  {
    const std::lock_guard lock(lent_mutex);
    std::erase_if(lent(), [](const Lent& of) { return of.made.expired(); });
    for (const Lent& of : lent())
      if (of.whole.lock() == whole && of.arrays == arrays)
        if (auto made = of.made.lock()) return made;
  }
  auto made = make(*whole, arrays, max_bytes, task);
  const std::lock_guard lock(lent_mutex);
  lent().push_back({whole, made, std::move(arrays)});
  return made;
}

}  // namespace isostrata
