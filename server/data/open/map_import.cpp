// Checks what the import child wrote. Nothing in it is believed: every size, index and number that other code relies on is looked
// at here.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <boost/json.hpp>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "data/files/beneath.h"
#include "data/open/import_door.h"
#include "data/values/source_mapping.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;

constexpr std::size_t kMostManifest = 64u << 20, kMostArrays = 20000, kLongestName = 1000, kMostNotes = 1000;
constexpr std::int64_t kMostTimes = 1'000'000;

/// A file of the directory, mapped read-only, then unlinked if it is to be. Its directory belongs to us alone, and the child
/// has ended.
class ImportMapping {
 public:
  ImportMapping(const fs::path& path, std::uint64_t expected_bytes, const std::string& name, ImportFiles files) {
    const std::string file = path.filename().string();
    const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    struct stat status {};
    const bool regular = descriptor >= 0 && fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
    if (!regular || static_cast<std::uint64_t>(status.st_size) != expected_bytes) {
      if (descriptor >= 0) close(descriptor);
      throw Error(ErrorCode::bad_data, name + ": the reader's " + file +
                                           (regular ? " has " + std::to_string(status.st_size) + " bytes" : " is missing") +
                                           "; expected " + std::to_string(expected_bytes) + " bytes");
    }
    size_ = expected_bytes;
    if (size_ > 0) data_ = mmap(nullptr, size_, PROT_READ, MAP_SHARED, descriptor, 0);
    close(descriptor);
    if (data_ == MAP_FAILED) {
      data_ = nullptr;
      throw Error(ErrorCode::unavailable, name + ": cannot map " + std::to_string(size_) + " bytes");
    }
    if (files == ImportFiles::unlinked) unlink(path.c_str());
  }
  ~ImportMapping() {
    if (data_) munmap(data_, size_);
  }
  ImportMapping(const ImportMapping&) = delete;
  ImportMapping& operator=(const ImportMapping&) = delete;
  std::span<const std::byte> bytes() const { return {static_cast<const std::byte*>(data_), size_}; }

 private:
  void* data_ = nullptr;
  std::size_t size_ = 0;
};

/// What was looked at once lets go of the process's memory; whoever needs it finds it in the kernel's cache. Of values that are mapped from a file.
void let_go(std::span<const std::byte> mapped) {
  constexpr std::size_t kLeast = 1u << 22;
  if (mapped.size() < kLeast) return;
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE)), at = reinterpret_cast<std::uintptr_t>(mapped.data()), begin = (at + page - 1) / page * page;
  madvise(reinterpret_cast<void*>(begin), at + mapped.size() - begin, MADV_DONTNEED);
}

template <class Array>
void measure(Array& array) {
  measure_range(array);
  std::visit([](auto values) { let_go(std::as_bytes(values)); }, array.values);
}

class Manifest {
 public:
  Manifest(const fs::path& directory, const fs::path& file, const OpenOptions& options, ImportFiles files, bool checked)
      : directory_(directory), file_(file), name_(file.filename().string()), options_(options), files_(files), checked_(checked) {
    const fs::path path = directory / "manifest.json";
    std::error_code error;
    const auto size = fs::file_size(path, error);
    if (error) refuse("wrote no manifest");
    if (size > kMostManifest)
      refuse("wrote a manifest of " + std::to_string(size) + " bytes; expected at most " + std::to_string(kMostManifest));
    const ImportMapping mapping(path, size, name_, files);
    try {
      json::parse_options strict;
      strict.max_depth = 8;
      const auto value = json::parse({reinterpret_cast<const char*>(mapping.bytes().data()), mapping.bytes().size()}, {}, strict);
      if (!value.is_object()) refuse("wrote a manifest that is not an object");
      root_ = value.get_object();
    } catch (const boost::system::system_error& failure) {
      refuse(std::string("wrote a malformed manifest: ") + failure.what());
    }
  }

  [[noreturn]] void refuse(const std::string& what) const { throw Error(ErrorCode::bad_data, name_ + ": the reader " + what); }

  const json::value& need(const json::object& object, const char* key) const {
    const json::value* value = object.if_contains(key);
    if (!value) refuse(std::string("left '") + key + "' out of its manifest");
    return *value;
  }
  std::int64_t integer(const json::value& value, const char* what, std::int64_t least, std::int64_t most) const {
    const auto number = value.is_int64() ? std::optional(value.get_int64()) : std::nullopt;
    if (!number || *number < least || *number > most)
      refuse(std::string("wrote ") + json::serialize(value).substr(0, 60) + " for " + what + "; expected an integer from " +
             std::to_string(least) + " to " + std::to_string(most));
    return *number;
  }
  std::string text(const json::value& value, const char* what) const {
    if (!value.is_string() || value.get_string().size() > kLongestName)
      refuse(std::string("wrote no text of at most 1000 bytes for ") + what);
    return std::string(value.get_string());
  }
  const json::object& root() const { return root_; }
  bool checked() const { return checked_; }  // before: values and cells are good

  /// Maps `count` elements; counts towards the memory budget.
  std::span<const std::byte> map(const std::string& file, std::int64_t count, std::size_t element,
                                 std::shared_ptr<const void>& storage) {
    std::uint64_t bytes = 0;
    if (__builtin_mul_overflow(static_cast<std::uint64_t>(count), element, &bytes) || bytes > (std::uint64_t{1} << 60))
      refuse("declares " + std::to_string(count) + " elements in " + file);
    total_ += bytes;
    if (total_ > options_.max_bytes)
      throw Error(ErrorCode::too_large,
                  name_ + ": needs more than the limit of " + std::to_string(options_.max_bytes) + " bytes");
    const auto mapping = std::make_shared<const ImportMapping>(directory_ / file, bytes, name_, files_);
    storage = mapping;
    return mapping->bytes();
  }
  /// Maps the elements where `place`, of the manifest, says that they lie: in the file that was read, or in one beside or below it.
  std::span<const std::byte> map_in_place(const json::object& place, std::int64_t count, std::size_t element, std::shared_ptr<const void>& storage) {
    const fs::path in_file = text(need(place, "in_file"), "an array's file");
    const std::int64_t offset = integer(need(place, "offset"), "an array's offset", 0, std::numeric_limits<std::int64_t>::max());
    std::uint64_t bytes = 0;
    if (__builtin_mul_overflow(static_cast<std::uint64_t>(count), element, &bytes) || bytes > (std::uint64_t{1} << 60) ||
        offset % static_cast<std::int64_t>(element) != 0)
      refuse("declares " + std::to_string(count) + " elements at byte " + std::to_string(offset) + " of a file");
    const bool leads_out = in_file.empty() || in_file.is_absolute() || std::find(in_file.begin(), in_file.end(), "..") != in_file.end();
    if (leads_out) refuse("names a file that is not beside the one that was read, nor below");
    int descriptor = -1;
    if (in_file == file_.filename()) {
      descriptor = open_beneath(file_, O_RDONLY | O_NONBLOCK);
    } else {
      const int folder = open_beneath(file_.parent_path().empty() ? fs::path(".") : file_.parent_path(), O_PATH | O_DIRECTORY);
      if (folder >= 0) descriptor = open_beneath(folder, in_file, O_RDONLY | O_NONBLOCK);
      if (descriptor < 0 && (errno == ENOSYS || errno == EPERM))  // a kernel or a sandbox without openat2
        descriptor = open_beneath(beneath(without_mark(file_).parent_path(), in_file), O_RDONLY | O_NONBLOCK);
      if (folder >= 0) close(folder);
    }
    if (descriptor < 0) throw Error(ErrorCode::not_found, in_file.string() + ": cannot be opened; it was read a moment ago");
    try {
      SourceMapping mapped = map_source(descriptor, static_cast<std::uint64_t>(offset), bytes, in_file.string());
      close(descriptor);
      storage = std::move(mapped.storage);
      return mapped.bytes;
    } catch (...) {
      close(descriptor);
      throw;
    }
  }
  template <class T>
  std::span<const T> map(const std::string& file, std::int64_t count, std::vector<std::shared_ptr<const void>>& keep) {
    std::shared_ptr<const void> storage;
    const auto bytes = map(file, count, sizeof(T), storage);
    keep.push_back(storage);
    return {reinterpret_cast<const T*>(bytes.data()), static_cast<std::size_t>(count)};
  }

 private:
  fs::path directory_, file_;
  std::string name_;
  const OpenOptions& options_;
  const ImportFiles files_;
  const bool checked_;
  json::object root_;
  std::uint64_t total_ = 0;
};

using Storages = std::vector<std::shared_ptr<const void>>;
constexpr std::int64_t kMostPoints = std::int64_t{1} << 48;

std::array<std::int64_t, 3> read_dims(const Manifest& manifest) {
  const json::value& value = manifest.need(manifest.root(), "dims");
  if (!value.is_array() || value.get_array().size() != 3) manifest.refuse("wrote no three dimensions");
  std::array<std::int64_t, 3> dims{};
  std::int64_t points = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    dims[a] = manifest.integer(value.get_array()[a], "a dimension", 1, kMostPoints);
    if (__builtin_mul_overflow(points, dims[a], &points) || points > kMostPoints)
      manifest.refuse("wrote dimensions whose product is absurd");
  }
  return dims;
}

PointSpan map_points(Manifest& manifest, Storages& keep, std::optional<std::int64_t> expected) {
  const json::value& value = manifest.need(manifest.root(), "points");
  if (!value.is_array() || value.get_array().size() != 2) manifest.refuse("wrote no type and count of points");
  const std::string type = manifest.text(value.get_array()[0], "the points' type");
  const std::int64_t count = manifest.integer(value.get_array()[1], "the number of points", 0, kMostPoints);
  if (expected && count != *expected)
    manifest.refuse("wrote " + std::to_string(count) + " points; expected " + std::to_string(*expected));
  PointSpan points;
  if (type == "float32")
    points = manifest.map<Vec3f>("points.bin", count, keep);
  else if (type == "float64")
    points = manifest.map<Vec3d>("points.bin", count, keep);
  else
    manifest.refuse("wrote points of type '" + type + "'");
  if (manifest.checked()) return points;
  std::atomic<std::int64_t> broken{-1};
  std::visit(
      [&](auto span) {
        parallel_for(count, 1 << 17, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t p = begin; p < end; ++p) {
            const auto& at = span[static_cast<std::size_t>(p)];
            if (!std::isfinite(at.x) || !std::isfinite(at.y) || !std::isfinite(at.z)) broken = p;
          }
        });
      },
      points);
  if (broken >= 0) manifest.refuse("found point " + std::to_string(broken) + " at a position that is not finite");
  return points;
}

UnstructuredGrid map_unstructured(Manifest& manifest, Storages& keep) {
  UnstructuredGrid grid;
  grid.points = map_points(manifest, keep, std::nullopt);
  const std::int64_t cells = manifest.integer(manifest.need(manifest.root(), "cells"), "the number of cells", 0, kMostPoints);
  const std::int64_t ids =
      manifest.integer(manifest.need(manifest.root(), "connectivity"), "the length of the connectivity", 0, kMostPoints);
  grid.types = manifest.map<std::uint8_t>("types.bin", cells, keep);
  grid.offsets = manifest.map<std::int64_t>("offsets.bin", cells + 1, keep);
  grid.connectivity = manifest.map<std::int64_t>("connectivity.bin", ids, keep);
  if (manifest.checked()) return grid;
  if (grid.offsets.front() != 0 || grid.offsets.back() != ids) manifest.refuse("wrote offsets that do not span the connectivity");

  const auto points = std::visit([](auto span) { return static_cast<std::int64_t>(span.size()); }, grid.points);
  const bool grid_is_flat = cells > 0 && is_flat(static_cast<CellType>(grid.types.front()));
  std::atomic<std::int64_t> bad_cell{-1}, bad_id{-1}, mixed{-1};
  parallel_for(cells, 1 << 16, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
      if (is_flat(static_cast<CellType>(grid.types[c])) != grid_is_flat) mixed = static_cast<std::int64_t>(c);
      const std::int64_t vertices = kPointsOfType[grid.types[c]];
      // Subtraction cannot overflow once both offsets lie within [0, ids].
      const std::int64_t from = grid.offsets[c], to = grid.offsets[c + 1];
      if (vertices == 0 || from < 0 || to > ids || to < from || to - from != vertices) bad_cell = static_cast<std::int64_t>(c);
    }
  });
  if (bad_cell >= 0)
    manifest.refuse("wrote cell " + std::to_string(bad_cell) +
                    " with an unknown type, or a number of points that is not its type's");
  if (mixed >= 0) manifest.refuse("wrote flat cells beside others: cell " + std::to_string(mixed));
  parallel_for(ids, 1 << 17, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const std::int64_t id = grid.connectivity[static_cast<std::size_t>(i)];
      if (id < 0 || id >= points) bad_id = i;
    }
  });
  if (bad_id >= 0) manifest.refuse("wrote a cell that uses a point outside the " + std::to_string(points) + " there are");
  for (const auto bytes : {std::as_bytes(grid.connectivity), std::as_bytes(grid.offsets)}) let_go(bytes);
  return grid;
}

RectilinearGrid map_rectilinear(Manifest& manifest) {
  RectilinearGrid grid;
  grid.dims = read_dims(manifest);
  const char* const names[3] = {"axis_x.bin", "axis_y.bin", "axis_z.bin"};
  for (std::size_t a = 0; a < 3; ++a) {
    Storages keep;
    const auto values = manifest.map<double>(names[a], grid.dims[a], keep);
    grid.axes[a].assign(values.begin(), values.end());
    const auto& axis = grid.axes[a];
    const bool rises = axis.size() < 2 || axis[1] > axis[0];
    for (std::size_t i = 0; i < axis.size(); ++i)
      if (!std::isfinite(axis[i]) || (i > 0 && !(rises ? axis[i] > axis[i - 1] : axis[i] < axis[i - 1])))
        manifest.refuse(std::string("found axis ") + "xyz"[a] + " not strictly monotone and finite at " + std::to_string(i));
  }
  return grid;
}

UniformGrid map_uniform(Manifest& manifest) {
  UniformGrid grid;
  grid.dims = read_dims(manifest);
  Storages keep;
  const auto values = manifest.map<double>("placement.bin", 6, keep);
  for (int a = 0; a < 3; ++a) {
    grid.origin[a] = values[static_cast<std::size_t>(a)];
    grid.spacing[a] = values[static_cast<std::size_t>(a) + 3];
    const double far = grid.origin[a] + grid.spacing[a] * static_cast<double>(grid.dims[static_cast<std::size_t>(a)]);
    if (!std::isfinite(grid.origin[a]) || !std::isfinite(grid.spacing[a]) || !std::isfinite(far) || grid.spacing[a] == 0)
      manifest.refuse(std::string("found an origin or spacing along ") + "xyz"[a] + " that is not finite, or a spacing of 0");
  }
  return grid;
}

Grid map_grid(Manifest& manifest) {
  Grid grid;
  auto keep = std::make_shared<Storages>();
  const std::string kind = manifest.text(manifest.need(manifest.root(), "grid"), "the kind of grid");
  if (kind == "uniform") {
    grid.shape = map_uniform(manifest);
  } else if (kind == "rectilinear") {
    grid.shape = map_rectilinear(manifest);
  } else if (kind == "curvilinear") {
    const auto dims = read_dims(manifest);
    grid.shape = CurvilinearGrid{dims, map_points(manifest, *keep, dims[0] * dims[1] * dims[2])};
  } else if (kind == "unstructured") {
    grid.shape = map_unstructured(manifest, *keep);
  } else {
    manifest.refuse("wrote a grid of kind '" + kind + "'");
  }
  const json::value& hidden = manifest.need(manifest.root(), "hidden_cells");
  if (!hidden.is_bool()) manifest.refuse("wrote no true or false for hidden_cells");
  if (hidden.get_bool()) grid.hidden_cells = manifest.map<std::uint8_t>("hidden.bin", grid.cell_count(), *keep);
  grid.storage = keep;
  return grid;
}

ScalarType read_type(const Manifest& manifest, const json::value& value) {
  const std::string name = manifest.text(value, "an array's type");
  for (const ScalarType type :
       {ScalarType::int8, ScalarType::uint8, ScalarType::int16, ScalarType::uint16, ScalarType::int32, ScalarType::uint32,
        ScalarType::int64, ScalarType::uint64, ScalarType::float32, ScalarType::float64})
    if (name == to_string(type)) return type;
  manifest.refuse("wrote an array of type '" + name + "'");
}

/// What the array's points were averaged from.
std::shared_ptr<CellValues> map_cells(Manifest& manifest, const json::object& fields, std::size_t number, std::int64_t cells, bool measured) {
  auto out = std::make_shared<CellValues>();
  out->type = read_type(manifest, manifest.need(fields, "cell_type"));
  const json::value* const place = fields.if_contains("cells");
  if (place && !place->is_object()) manifest.refuse("wrote no place of an array's cells");
  out->values = scalar_span(out->type, place ? manifest.map_in_place(place->get_object(), cells, size_of(out->type), out->storage)
                                             : manifest.map("cells_" + std::to_string(number) + ".bin", cells, size_of(out->type), out->storage));
  if (measured) measure(*out);
  return out;
}

std::vector<PointArray> map_arrays(Manifest& manifest, const Grid& grid, const ImportMeasures* known, bool measured) {
  const std::int64_t points = grid.point_count();
  std::size_t known_cells = 0;
  const json::value& list = manifest.need(manifest.root(), "arrays");
  if (!list.is_array() || list.get_array().size() > kMostArrays) manifest.refuse("wrote no list of at most 20000 arrays");
  std::vector<PointArray> arrays;
  for (std::size_t i = 0; i < list.get_array().size(); ++i) {
    const json::value& entry = list.get_array()[i];
    if (!entry.is_object()) manifest.refuse("wrote an array that is not an object");
    const json::object& fields = entry.get_object();
    PointArray array;
    array.name = manifest.text(manifest.need(fields, "name"), "an array's name");
    if (array.name.empty()) manifest.refuse("wrote an array without a name");
    if (std::any_of(arrays.begin(), arrays.end(), [&](const PointArray& other) { return other.name == array.name; }))
      manifest.refuse("wrote two arrays '" + array.name + "'");
    const std::string association = manifest.text(manifest.need(fields, "association"), "an array's association");
    if (association != "point" && association != "cell_averaged") manifest.refuse("wrote an array on '" + association + "'");
    array.association = association == "point" ? Association::point : Association::cell_averaged;
    array.components =
        static_cast<int>(manifest.integer(manifest.need(fields, "components"), "an array's components", 1, 1 << 20));
    array.component = manifest.text(manifest.need(fields, "component"), "an array's component");
    array.unit = manifest.text(manifest.need(fields, "unit"), "an array's unit");
    array.type = read_type(manifest, manifest.need(fields, "type"));
    array.values = scalar_span(array.type, fields.contains("in_file")
                                               ? manifest.map_in_place(fields, points, size_of(array.type), array.storage)
                                               : manifest.map("array_" + std::to_string(i) + ".bin", points, size_of(array.type), array.storage));
    if (measured) measure(array);
    if (array.association == Association::cell_averaged) {
      const auto cells = map_cells(manifest, fields, i, grid.cell_count(), !known);
      if (known && known_cells >= known->cells.size()) manifest.refuse("wrote more arrays of cells than were measured");
      if (known) std::tie(cells->lower, cells->upper, cells->nan_count) = known->cells[known_cells++].as_tuple();
      array.cells = cells;
    }
    arrays.push_back(std::move(array));
  }
  return arrays;
}

Axes read_axes(const Manifest& manifest) {
  const json::value& list = manifest.need(manifest.root(), "axes");
  if (!list.is_array() || list.get_array().size() != 3) manifest.refuse("wrote no three axes");
  Axes axes;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const json::value& entry = list.get_array()[a];
    if (!entry.is_object()) manifest.refuse("wrote an axis that is not an object");
    const json::object& fields = entry.get_object();
    const json::value& downward = manifest.need(fields, "downward");
    if (!downward.is_bool()) manifest.refuse("wrote no true or false for an axis that is downward");
    axes[a] = {manifest.text(manifest.need(fields, "name"), "an axis's name"), manifest.text(manifest.need(fields, "unit"), "an axis's unit"), downward.get_bool()};
  }
  return axes;
}

}  // namespace

ImportMeasures measures_of(const Dataset& dataset) {
  ImportMeasures measures;
  for (const PointArray& array : dataset.arrays) {
    measures.arrays.push_back({array.lower, array.upper, array.nan_count});
    if (array.cells) measures.cells.push_back({array.cells->lower, array.cells->upper, array.cells->nan_count});
  }
  measures.bounds = dataset.bounds;
  measures.cell_types = dataset.cell_types;
  return measures;
}

std::shared_ptr<Dataset> map_import(const fs::path& directory, const fs::path& file, const ImportOptions& options, ImportFiles files,
                                    const ImportMeasures* known, ImportValues values_are) {
  Manifest manifest(directory, file, options, files, known != nullptr);
  if (manifest.integer(manifest.need(manifest.root(), "format"), "format", 0, 1 << 20) != 1)
    manifest.refuse("is of another version than this server");
  auto dataset = std::make_shared<Dataset>();
  dataset->name = without_mark(file).string();
  const bool like = options.like && manifest.text(manifest.need(manifest.root(), "grid"), "the kind of grid") == "like";
  dataset->grid = like ? options.like->grid : map_grid(manifest);
  dataset->arrays = map_arrays(manifest, dataset->grid, known, !known && values_are == ImportValues::measured);

  dataset->axes = like ? options.like->axes : read_axes(manifest);

  const std::int64_t times = manifest.integer(manifest.need(manifest.root(), "times"), "the number of time steps", 1, kMostTimes);
  Storages keep;
  const auto values = manifest.map<double>("times.bin", times, keep);
  dataset->times.assign(values.begin(), values.end());
  for (std::size_t t = 0; t < dataset->times.size(); ++t)
    if (!std::isfinite(dataset->times[t]) || (t > 0 && !(dataset->times[t] >= dataset->times[t - 1])))
      manifest.refuse("found time step " + std::to_string(t) + " not finite, or before the one in front of it");
  dataset->step = static_cast<int>(manifest.integer(manifest.need(manifest.root(), "step"), "the step", 0, times - 1));

  const json::value& notes = manifest.need(manifest.root(), "notes");
  if (!notes.is_array() || notes.get_array().size() > kMostNotes) manifest.refuse("wrote no list of at most 1000 notes");
  for (const json::value& note : notes.get_array()) dataset->notes.push_back(manifest.text(note, "a note"));
  if (known && known->arrays.size() != dataset->arrays.size()) manifest.refuse("wrote another number of arrays than was measured");
  for (std::size_t i = 0; known && i < dataset->arrays.size(); ++i) {
    dataset->arrays[i].lower = known->arrays[i].lower;
    dataset->arrays[i].upper = known->arrays[i].upper;
    dataset->arrays[i].nan_count = known->arrays[i].nan_count;
  }
  dataset->bounds = like ? options.like->bounds : known ? known->bounds : dataset->grid.bounds();
  dataset->cell_types = like ? options.like->cell_types : known ? known->cell_types : count_cell_types(dataset->grid);
  return dataset;
}

}  // namespace isostrata
