// HDF5 that follows no convention of its own (h5py, MATLAB 7.3, instruments): its largest arrays as numbers on a grid, by the netCDF library, which reads all of HDF5.
#include <netcdf.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <tuple>

#include "import/appended_file.h"
#include "import/netcdf_file.h"
#include "import/place_image.h"
#include "import/read_own.h"
#include "import/read_vtk.h"

namespace isostrata {
namespace {

struct HdfArray {
  int group = 0, variable = 0;
  std::string name;  // with its groups: "run/density"
  ScalarType type = ScalarType::float32;
  std::vector<std::size_t> shape;
  bool placed = false;  // each of its axes has an array of places

  std::size_t values() const { return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>()); }
};

class HdfFile {
 public:
  explicit HdfFile(const ReadRequest& request) : name_(request.file.filename().string()) {
    if (const int error = nc_open(request.file.c_str(), NC_NOWRITE, &file_); error != NC_NOERR) throw Error(ErrorCode::bad_data, name_ + ": is damaged or cut off, or not read: " + nc_strerror(error));
    open_ = true;
    walk(file_, "", 0);
  }
  ~HdfFile() {
    if (open_) nc_close(file_);
  }
  HdfFile(const HdfFile&) = delete;
  HdfFile& operator=(const HdfFile&) = delete;

  const std::vector<HdfArray>& arrays() const { return arrays_; }
  bool has_group(const char* name) const {
    int group = 0;
    return nc_inq_ncid(file_, name, &group) == NC_NOERR;
  }

  /// Part of one along each of its axes, in the machine's byte order.
  void read(const HdfArray& array, const std::vector<std::size_t>& from, const std::vector<std::size_t>& count, std::span<std::byte> to) const {
    if (const int error = nc_get_vara(array.group, array.variable, from.data(), count.data(), to.data()); error != NC_NOERR)
      throw Error(ErrorCode::bad_data, name_ + ": '" + array.name + "' cannot be read: " + nc_strerror(error));
  }
  /// Whether it says that other values are meant than those that are stored.
  bool is_packed(const HdfArray& array) const {
    return std::ranges::any_of(std::array{"scale_factor", "add_offset", "_FillValue"}, [&](const char* name) { return nc_inq_att(array.group, array.variable, name, nullptr, nullptr) == NC_NOERR; });
  }
  /// Along its axis `a`; 1 if it is not in chunks.
  std::size_t chunk(const HdfArray& array, std::size_t a) const {
    int storage = NC_CONTIGUOUS;
    std::vector<std::size_t> sizes(array.shape.size(), 1);
    if (nc_inq_var_chunking(array.group, array.variable, &storage, sizes.data()) != NC_NOERR || storage != NC_CHUNKED) return 1;
    return std::max<std::size_t>(sizes[a], 1);
  }

 private:
  void walk(int group, const std::string& prefix, int depth) {
    constexpr std::size_t kMost = 10'000;
    int count = 0;
    if (nc_inq_nvars(group, &count) != NC_NOERR) return;
    for (int v = 0; v < count && arrays_.size() < kMost; ++v) take(group, v, prefix);
    if (depth >= 16 || nc_inq_grps(group, &count, nullptr) != NC_NOERR || count < 1) return;
    std::vector<int> groups(static_cast<std::size_t>(count));
    nc_inq_grps(group, nullptr, groups.data());
    for (const int one : groups)
      if (char name[NC_MAX_NAME + 1] = {}; nc_inq_grpname(one, name) == NC_NOERR && name[0] != '#') walk(one, prefix + name + "/", depth + 1);  // MATLAB's own: "#refs#"
  }
  void take(int group, int variable, const std::string& prefix) {
    char name[NC_MAX_NAME + 1] = {};
    int axes = 0, dimensions[NC_MAX_VAR_DIMS] = {};
    nc_type stored = NC_NAT;
    if (nc_inq_var(group, variable, name, &stored, &axes, dimensions, nullptr) != NC_NOERR || stored == NC_CHAR || axes < 1) return;
    const std::optional<ScalarType> type = netcdf_type(group, stored);
    if (!type) return;
    HdfArray array{group, variable, prefix + name, *type, {}};
    array.placed = true;
    for (int a = 0; a < axes; ++a) {
      std::size_t length = 0;
      char axis[NC_MAX_NAME + 1] = {};
      int places = 0;
      if (nc_inq_dim(group, dimensions[a], axis, &length) != NC_NOERR) return;
      array.placed = array.placed && nc_inq_varid(group, axis, &places) == NC_NOERR;
      array.shape.push_back(length);
    }
    arrays_.push_back(std::move(array));
  }

  std::string name_;
  int file_ = 0;
  bool open_ = false;
  std::vector<HdfArray> arrays_;
};

/// Which of an array's axes are which: of those of more than one point the last three are space, but for a fourth at the end that holds components (not in netCDF), and
/// one before them counts steps.
struct HdfAxes {
  std::vector<std::size_t> space;  // axes, x last
  std::size_t steps = ~std::size_t{0}, components = ~std::size_t{0};
};

std::optional<HdfAxes> hdf_axes(const std::vector<std::size_t>& shape, bool components) {
  HdfAxes axes;
  for (std::size_t a = 0; a < shape.size(); ++a)
    if (shape[a] > 1) axes.space.push_back(a);
  if (components && axes.space.size() > 3 && shape[axes.space.back()] <= 16) {
    axes.components = axes.space.back();
    axes.space.pop_back();
  }
  if (axes.space.size() > 3) {
    axes.steps = axes.space.front();
    axes.space.erase(axes.space.begin());
  }
  return axes.space.size() == 2 || axes.space.size() == 3 ? std::optional(axes) : std::nullopt;
}

std::string shown(const std::vector<std::size_t>& shape) {
  std::string out;
  for (const std::size_t size : shape) out += (out.empty() ? "" : " x ") + std::to_string(size);
  return out;
}

FileArray read_array(const HdfFile& file, const HdfArray& array, const HdfAxes& axes, const ReadRequest& request, std::size_t number) {
  constexpr std::size_t kAtOnce = std::size_t{64} << 20;
  FileArray out;
  out.name = array.name;
  out.type = array.type;
  out.components = axes.components < array.shape.size() ? static_cast<int>(array.shape[axes.components]) : 1;
  std::vector<std::size_t> from(array.shape.size()), count = array.shape;
  if (axes.steps < array.shape.size()) from[axes.steps] = static_cast<std::size_t>(request.step), count[axes.steps] = 1;
  const std::size_t slow = axes.space.front(), all = array.shape[slow];
  count[slow] = 1;
  const std::size_t sheet = std::accumulate(count.begin(), count.end(), size_of(out.type), std::multiplies<>()), chunk = file.chunk(array, slow);
  const std::size_t thick = std::max<std::size_t>(kAtOnce / std::max<std::size_t>(sheet, 1) / chunk, 1) * chunk;
  AppendedFile<std::byte> file_out(request, "array_" + std::to_string(number) + ".bin");
  std::vector<std::byte> values;
  for (std::size_t at = 0; at < all; at += thick) {
    from[slow] = at;
    count[slow] = std::min(thick, all - at);
    values.resize(sheet * count[slow]);
    file.read(array, from, count, values);
    file_out.add(values);
    request.progress(static_cast<double>(at + count[slow]) / static_cast<double>(all));
  }
  std::tie(out.values, out.storage) = file_out.finish();
  return out;
}

/// The array of most values of those whose axes make sense.
const HdfArray& largest(const HdfFile& file, const std::string& name, bool components) {
  const auto& arrays = file.arrays();
  const auto best = std::max_element(arrays.begin(), arrays.end(), [&](const HdfArray& a, const HdfArray& b) {
    return std::tuple(hdf_axes(a.shape, components).has_value(), a.values()) < std::tuple(hdf_axes(b.shape, components).has_value(), b.values());
  });
  if (best == arrays.end() || !hdf_axes(best->shape, components))
    throw Error(ErrorCode::unsupported, name + ": without an array of two or three axes of numbers" +
                                            (best == arrays.end() ? "" : " (the largest, '" + best->name.substr(0, 80) + "', has " + shown(best->shape) + ")") +
                                            "; save it as VTKHDF, CGNS, netCDF (.nc), or one array as .npy");
  return *best;
}

Imported read_plainly(const HdfFile& file, const ReadRequest& request, bool components) {
  const std::string name = request.file.filename().string();
  const HdfArray& best = largest(file, name, components);
  const HdfAxes axes = *hdf_axes(best.shape, components);
  const auto dim = [&](std::size_t from_last) { return from_last < axes.space.size() ? static_cast<std::int64_t>(best.shape[axes.space[axes.space.size() - 1 - from_last]]) : 1; };
  const std::size_t steps = axes.steps < best.shape.size() ? best.shape[axes.steps] : 1;
  Imported imported;
  imported.times.resize(steps);
  std::iota(imported.times.begin(), imported.times.end(), 0.0);
  check_step(request, steps);
  if (request.times_only) return imported;
  std::uint64_t bytes = 0;
  for (const HdfArray& array : file.arrays())
    if (array.shape == best.shape) check_bytes(request, bytes += static_cast<std::uint64_t>(checked_product({static_cast<std::int64_t>(array.values() / steps), static_cast<std::int64_t>(size_of(array.type))}, name)), name);
  Block& block = imported.blocks.emplace_back();
  place_image(block, {dim(0), dim(1), dim(2)}, {0, 0, 0}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, name);
  std::string packed;
  for (const HdfArray& array : file.arrays()) {
    if (array.shape != best.shape) continue;
    block.arrays.push_back(read_array(file, array, axes, request, block.arrays.size()));
    if (file.is_packed(array)) packed += (packed.empty() ? "'" : ", '") + array.name + "'";
  }
  imported.notes.push_back("arrays of " + shown(best.shape) + " values: the last axis is x, points 1 apart" + (steps > 1 ? "; the first counts steps" : ""));
  if (const std::size_t others = file.arrays().size() - block.arrays.size(); others > 0) imported.notes.push_back(std::to_string(others) + " arrays of other shapes skipped");
  if (!packed.empty()) imported.notes.push_back("values are as they are stored, not scaled, fill values too: " + packed);
  return imported;
}

}  // namespace

Imported read_netcdf_plainly(const ReadRequest& request) { return read_plainly(HdfFile(request), request, false); }

Imported read_hdf5(const ReadRequest& request) {
#ifdef ISOSTRATA_READS_EXODUS
  if (NetcdfFile(request.file).is_exodus()) return read_exodus(request);
#endif
  {
    const HdfFile file(request);
#ifdef ISOSTRATA_READS_VTKHDF
    if (file.has_group("VTKHDF")) return read_vtkhdf(request);
#endif
    if (!largest(file, request.file.filename().string(), true).placed) return read_plainly(file, request, true);
  }
  return read_netcdf(request);
}

}  // namespace isostrata
