#include "data/parts/region.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <tuple>
#include <vector>

#include "base/temporary_directory.h"
#include "data/dataset/analytic.h"
#include "data/open/child_process.h"
#include "data/open/import_cache.h"
#include "data/open/import_door.h"
#include "data/parts/structured_part.h"
#include "data/values/kept_facts.h"
#include "data/values/source_mapping.h"

namespace isostrata {
namespace {

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

StructuredPart find_part(const Dataset& whole, const Region& region) {
  if (!whole.grid.structured())
    throw Error(ErrorCode::unsupported, whole.name + ": a region and a stride are of structured grids; this one is unstructured");
  StructuredPart part;
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

Grid grid_of(const Grid& whole, const StructuredPart& part, const Task& task) {
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
    std::tie(shape.points, points) = points_of(std::get<CurvilinearGrid>(whole.shape).points, part, task);
    grid.shape = shape;
  }
  grid.storage = points;
  if (!whole.hidden_cells.empty() && grid.cell_count() > 0) {
    auto kept = std::make_shared<std::pair<std::shared_ptr<const void>, std::vector<std::uint8_t>>>(points, hidden_cells_of(whole, part));
    grid.hidden_cells = kept->second;
    grid.storage = kept;
  }
  return grid;
}

/// As array_of, from what is kept if it is.
PointArray kept_array_of(const PointArray& whole, const StructuredPart& part, const Task& task) {
  std::string name = "every";
  for (const auto& numbers : {part.step, part.of})
    for (const std::int64_t n : numbers) name += '-' + std::to_string(n);
  const std::size_t bytes = static_cast<std::size_t>(part.count()) * size_of(whole.type);
  if (auto kept = kept_fact(whole, name); kept && kept->size() == bytes) {
    const auto storage = std::make_shared<const std::vector<std::byte>>(std::move(*kept));
    PointArray array = whole;
    array.cells = nullptr;
    array.values = scalar_span(whole.type, *storage);
    array.storage = storage;
    return array;
  }
  PointArray array = array_of(whole, part, task);
  std::visit([&](auto values) { keep_fact(whole, name, std::as_bytes(values)); }, array.values);
  return array;
}

/// The whole as the import child leaves it, without a look at its values.
std::shared_ptr<Dataset> import_unmeasured(const std::filesystem::path& file, const OpenOptions& options, const Task& task) {
  check_source(file, options);
  const TemporaryDirectory directory(temporary_base(), "isostrata-import-");
  import_into(directory.path(), file, options, task);
  return map_import(directory.path(), file, options, ImportFiles::unlinked, nullptr, ImportValues::unseen);
}

std::shared_ptr<const Dataset> open_unmeasured(const std::filesystem::path& file, const OpenOptions& options, const Task& task) {
  if (import_cache())
    if (auto kept = find_import_cached(file, options, *import_cache())) return kept;
  return import_unmeasured(file, options, task);
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

std::string to_string(const Region& region) {
  std::string text;
  for (std::size_t a = 0; a < 3; ++a) {
    if (a > 0) text += ',';
    if (region.first[a] > 0) text += std::to_string(region.first[a]);
    text += ':';
    if (region.last[a] != Region{}.last[a]) text += std::to_string(region.last[a]);
  }
  const auto& [x, y, z] = region.stride;
  if (region.stride == Region{}.stride) return text;
  return text + '*' + std::to_string(x) + (x == y && y == z ? "" : ',' + std::to_string(y) + ',' + std::to_string(z));
}

Region region_of(std::string_view text) {
  Region region;
  const auto at = text.find('*');
  set_box(region, text.substr(0, at));
  if (at != std::string_view::npos) set_stride(region, text.substr(at + 1));
  return region;
}

std::shared_ptr<const Dataset> part_of(const Dataset& whole, const Region& region, std::uint64_t max_bytes, const Task& task) {
  const StructuredPart part = find_part(whole, region);
  std::uint64_t bytes = 0;
  for (const PointArray& array : whole.arrays) bytes += static_cast<std::uint64_t>(part.count()) * size_of(array.type);
  if (bytes > max_bytes)
    throw Error(ErrorCode::too_large, whole.name + ": the region needs " + std::to_string(bytes) + " bytes; the limit is " + std::to_string(max_bytes) +
                                          ": take a smaller one, or a larger stride");
  auto dataset = described_as(whole);
  dataset->grid = grid_of(whole.grid, part, task);
  dataset->bounds = dataset->grid.bounds();
  dataset->cell_types = count_cell_types(dataset->grid);
  for (const PointArray& of : whole.arrays) {
    PointArray array = array_of(of, part, task);
    measure_range(array);
    dataset->arrays.push_back(std::move(array));
  }
  return dataset;
}

std::shared_ptr<const Dataset> coarser(const Dataset& whole, const std::array<std::int64_t, 3>& stride, std::span<const std::string> arrays, const Task& task) {
  Region region;
  region.stride = stride;
  const StructuredPart part = find_part(whole, region);
  auto dataset = std::make_shared<Dataset>();
  dataset->name = whole.name;
  dataset->times = whole.times;
  dataset->step = whole.step;
  dataset->grid = grid_of(whole.grid, part, task);
  dataset->bounds = whole.bounds;
  dataset->cell_types = count_cell_types(dataset->grid);
  for (const std::string& name : arrays) dataset->arrays.push_back(kept_array_of(whole.array(name), part, task));
  return dataset;
}

std::shared_ptr<const Dataset> open_unread(std::string_view name, const OpenOptions& options, const Task& task) {
  if (is_analytic(name) || !may_lie_in_place(name)) return open_dataset(name, options, task);
  if (import_cache())
    if (auto kept = find_import_cached(name, options, *import_cache())) return kept;
  const std::shared_ptr<Dataset> whole = import_unmeasured(name, options, task);
  const auto in_place = [](const PointArray& array) {
    return std::visit([](auto values) { return !values.empty() && is_in_source(values.data()); }, array.values);
  };
  if (std::none_of(whole->arrays.begin(), whole->arrays.end(), in_place)) return open_dataset(name, options, task);  // which others then find in the cache
  for (PointArray& array : whole->arrays) {
    if (!in_place(array)) {
      measure_range(array);
      continue;
    }
    array.lower = std::numeric_limits<double>::infinity();
    array.upper = -array.lower;
    array.nan_count = -1;
  }
  return whole;
}

std::shared_ptr<const Dataset> open_part(std::string_view name, const OpenOptions& options, const Region& region, const Task& task) {
  if (region == Region{}) return open_dataset(name, options, task);
  const auto whole = is_analytic(name) ? make_analytic(name, options, task) : open_unmeasured(std::filesystem::path(name), options, task);
  return part_of(*whole, region, options.max_bytes, task);
}

}  // namespace isostrata
