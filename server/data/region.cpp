#include "data/region.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <vector>

#include "base/parallel.h"
#include "base/temporary_directory.h"
#include "data/analytic.h"
#include "data/child_process.h"
#include "data/import_cache.h"
#include "data/import_door.h"

namespace isostrata {
namespace {

using Index = std::array<std::int64_t, 3>;

std::optional<std::int64_t> number(std::string_view text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() && value >= 0 ? std::optional(value) : std::nullopt;
}

std::vector<std::string_view> split(std::string_view text, char by) {
  std::vector<std::string_view> parts;
  for (;;) {
    const auto at = text.find(by);
    parts.push_back(text.substr(0, at));
    if (at == std::string_view::npos) return parts;
    text.remove_prefix(at + 1);
  }
}

/// Which points of the whole the part has.
struct Part {
  Index dims, from, step, of;  // points of the part, its first point, its stride, points of the whole

  std::int64_t count() const { return dims[0] * dims[1] * dims[2]; }
  std::int64_t point(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return from[0] + i * step[0] + of[0] * (from[1] + j * step[1] + of[1] * (from[2] + k * step[2]));
  }
};

Part find_part(const Dataset& whole, const Region& region) {
  if (!whole.grid.structured())
    throw Error(ErrorCode::unsupported, whole.name + ": a region and a stride are of structured grids; this one is unstructured");
  Part part;
  part.of = whole.grid.dims();
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t last = std::min(region.last[a], part.of[a] - 1);
    if (region.first[a] > last)
      throw Error(ErrorCode::invalid_argument, whole.name + ": the region holds no point along " + "xyz"[a] + ": from " + std::to_string(region.first[a]) + " to " +
                                                   std::to_string(last) + "; the grid has points 0 to " + std::to_string(part.of[a] - 1));
    part.from[a] = region.first[a];
    part.step[a] = region.stride[a];
    part.dims[a] = (last - region.first[a]) / region.stride[a] + 1;
  }
  return part;
}

/// Those of the part, rows side by side.
template <class T>
std::pair<std::span<const T>, std::shared_ptr<const void>> take(std::span<const T> all, const Part& part, const Task& task) {
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

/// [cells of the part] 1: the cell spans one that is hidden.
std::vector<std::uint8_t> hidden_in(const Grid& whole, const Part& part) {
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

Grid grid_of(const Grid& whole, const Part& part, const Task& task) {
  Grid grid;
  std::shared_ptr<const void> points;
  if (const auto* uniform = std::get_if<UniformGrid>(&whole.shape)) {
    UniformGrid shape{part.dims, uniform->origin, uniform->spacing};
    for (std::size_t a = 0; a < 3; ++a) {
      const int axis = static_cast<int>(a);
      shape.origin[axis] += static_cast<double>(part.from[a]) * uniform->spacing[axis];
      shape.spacing[axis] *= static_cast<double>(part.step[a]);
    }
    grid.shape = shape;
  } else if (const auto* rectilinear = std::get_if<RectilinearGrid>(&whole.shape)) {
    RectilinearGrid shape;
    shape.dims = part.dims;
    for (std::size_t a = 0; a < 3; ++a)
      for (std::int64_t i = 0; i < part.dims[a]; ++i) shape.axes[a].push_back(rectilinear->axes[a][static_cast<std::size_t>(part.from[a] + i * part.step[a])]);
    grid.shape = std::move(shape);
  } else {
    CurvilinearGrid shape{part.dims, {}};
    std::visit(
        [&](auto all) {
          auto [taken, storage] = take(all, part, task);
          shape.points = taken;
          points = storage;
        },
        std::get<CurvilinearGrid>(whole.shape).points);
    grid.shape = shape;
  }
  grid.storage = points;
  if (!whole.hidden_cells.empty() && grid.cell_count() > 0) {
    auto kept = std::make_shared<std::pair<std::shared_ptr<const void>, std::vector<std::uint8_t>>>(points, hidden_in(whole, part));
    grid.hidden_cells = kept->second;
    grid.storage = kept;
  }
  return grid;
}

/// The whole as the import child leaves it, without a look at its values.
std::shared_ptr<const Dataset> open_unmeasured(const std::filesystem::path& file, const OpenOptions& options, const Task& task) {
  if (import_cache())
    if (auto kept = find_import_cached(file, options, *import_cache())) return kept;
  check_source(file, options);
  const TemporaryDirectory directory(temporary_base(), "isostrata-import-");
  import_into(directory.path(), file, options, task);
  return map_import(directory.path(), file, options, ImportFiles::unlinked, nullptr, ImportValues::unseen);
}

}  // namespace

void set_box(Region& region, std::string_view text) {
  const auto refuse = [&] {
    throw Error(ErrorCode::invalid_argument, "region '" + std::string(text) + "': expected FIRST:LAST,FIRST:LAST,FIRST:LAST, points along x, y, z counted from 0, " +
                                                 "FIRST at most LAST; what is left out is the grid's end");
  };
  const auto axes = split(text, ',');
  if (axes.size() != 3) refuse();
  for (std::size_t a = 0; a < 3; ++a) {
    const auto ends = split(axes[a], ':');
    if (ends.size() != 2) refuse();
    const auto first = ends[0].empty() ? std::optional<std::int64_t>(0) : number(ends[0]);
    const auto last = ends[1].empty() ? std::optional(std::numeric_limits<std::int64_t>::max()) : number(ends[1]);
    if (!first || !last || *first > *last) refuse();
    region.first[a] = *first;
    region.last[a] = *last;
  }
}

void set_stride(Region& region, std::string_view text) {
  const auto parts = split(text, ',');
  for (std::size_t a = 0; a < 3; ++a) {
    const auto value = parts.size() == 1 || parts.size() == 3 ? number(parts[parts.size() == 1 ? 0 : a]) : std::nullopt;
    if (!value || *value < 1)
      throw Error(ErrorCode::invalid_argument, "stride '" + std::string(text) + "': expected N, or NX,NY,NZ, each 1 or more");
    region.stride[a] = *value;
  }
}

std::shared_ptr<const Dataset> part_of(const Dataset& whole, const Region& region, std::uint64_t max_bytes, const Task& task) {
  const Part part = find_part(whole, region);
  std::uint64_t bytes = 0;
  for (const PointArray& array : whole.arrays) bytes += static_cast<std::uint64_t>(part.count()) * size_of(array.type);
  if (bytes > max_bytes)
    throw Error(ErrorCode::too_large, whole.name + ": the region needs " + std::to_string(bytes) + " bytes; the limit is " + std::to_string(max_bytes) +
                                          ": take a smaller one, or a larger stride");
  auto dataset = std::make_shared<Dataset>();
  dataset->name = whole.name;
  dataset->times = whole.times;
  dataset->step = whole.step;
  dataset->notes = whole.notes;
  dataset->grid = grid_of(whole.grid, part, task);
  dataset->bounds = dataset->grid.bounds();
  dataset->cell_types = count_cell_types(dataset->grid);
  for (const PointArray& of : whole.arrays) {
    PointArray array = of;
    std::visit(
        [&](auto all) {
          auto [taken, storage] = take(all, part, task);
          array.values = taken;
          array.storage = storage;
        },
        of.values);
    measure_range(array);
    dataset->arrays.push_back(std::move(array));
  }
  return dataset;
}

std::shared_ptr<const Dataset> open_part(std::string_view name, const OpenOptions& options, const Region& region, const Task& task) {
  if (region == Region{}) return open_dataset(name, options, task);
  const auto whole = is_analytic(name) ? make_analytic(name, options, task) : open_unmeasured(std::filesystem::path(name), options, task);
  return part_of(*whole, region, options.max_bytes, task);
}

}  // namespace isostrata
