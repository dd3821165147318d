// HDF5 that follows no convention of its own (h5py, MATLAB 7.3, instruments): its largest arrays as numbers on a grid, by HDF5's own library.
#include <netcdf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <functional>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "data/files/recognise.h"
#include "import/bytes/array_file.h"
#include "import/bytes/mapped_file.h"
#include "import/hdf5/hdf5_file.h"
#include "import/hdf5/read_hdf5_blocks.h"
#include "import/hdf5/read_hdf5_blocks.h"
#include "import/imported/appended_file.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"
#include "import/netcdf/netcdf_file.h"
#include "import/vtk/read_vtk.h"

namespace isostrata {
namespace {

/// netCDF that is not HDF5.
class ClassicArrays : public ArrayFile {
 public:
  explicit ClassicArrays(const std::filesystem::path& file) : file_(file), name_(file.filename().string()) {
    for (int variable = 0; variable < file_.variables(); ++variable) {
      const std::optional<ScalarType> type = file_.type(variable);
      if (!type || file_.dimensions(variable).empty()) continue;
      StoredArray& array = arrays_.emplace_back();
      array.name = file_.name(variable);
      array.type = *type;
      for (const int dimension : file_.dimensions(variable)) array.shape.push_back(file_.length(dimension));
      for (const char* attribute : {"scale_factor", "add_offset", "_FillValue"}) array.packed = array.packed || !file_.numbers(variable, attribute).empty();
    }
  }
  void read(const StoredArray& array, const std::vector<std::size_t>& from, const std::vector<std::size_t>& count, std::span<std::byte> to) const override {
    if (const int error = nc_get_vara(file_.number(), file_.variable(array.name).value(), from.data(), count.data(), to.data()); error != NC_NOERR)
      throw Error(ErrorCode::bad_data, name_ + ": '" + array.name + "' cannot be read: " + nc_strerror(error));
  }
  std::size_t chunk(const StoredArray&, std::size_t) const override { return 1; }

 private:
  NetcdfFile file_;
  std::string name_;
};

/// Which of an array's axes are which: of those of more than one point the last three are space, but for a fourth at the end that holds components (not in netCDF), and
/// one before them counts steps.
struct HdfAxes {
  std::vector<std::size_t> space;  // axes, x last
  std::size_t steps = ~std::size_t{0}, components = ~std::size_t{0};
};

std::optional<HdfAxes> hdf_axes(const std::vector<std::size_t>& shape, bool components) {
  HdfAxes axes;
  if (std::find(shape.begin(), shape.end(), 0u) != shape.end()) return std::nullopt;  // nobody has written into it
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

FileArray read_array(const ArrayFile& file, const StoredArray& array, const HdfAxes& axes, const ReadRequest& request, std::size_t number) {
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

/// A mesh's or particles' own, by its name: the places of points, or the points of cells. As a picture it would be three to eight points wide.
bool is_list(const StoredArray& array) {
  if (array.shape.size() != 2 || array.shape[1] > 8) return false;
  const std::string name = small_letters(array.name);
  static constexpr std::array kWords{"topology", "connectivity", "coord", "geometry", "vertices", "points", "positions", "nodes", "elements", "cells"};
  return std::any_of(kWords.begin(), kWords.end(), [&](const char* word) { return name.find(word) != std::string::npos; });
}

/// The array of most values of those whose axes make sense.
const StoredArray& largest(const ArrayFile& file, const std::string& name, bool components) {
  const auto& arrays = file.arrays();
  const auto order = [&](const StoredArray& array) {
    const bool sense = hdf_axes(array.shape, components).has_value();
    return std::tuple(sense && !is_list(array), sense, array.values());
  };
  const auto best = std::max_element(arrays.begin(), arrays.end(), [&](const StoredArray& a, const StoredArray& b) { return order(a) < order(b); });
  if (best != arrays.end() && std::get<0>(order(*best))) return *best;
  const std::string it = best == arrays.end() ? "" : "'" + best->name.substr(0, 80) + "'";
  if (best != arrays.end() && std::get<1>(order(*best)))
    throw Error(ErrorCode::unsupported, name + ": holds lists of points or cells (" + it + ", " + shown(best->shape) + "), not values on a grid; save it as VTKHDF, CGNS or .vtu (ParaView, or meshio convert)");
  throw Error(ErrorCode::unsupported, name + ": without an array of two or three axes of numbers" + (it.empty() ? "" : " (the largest, " + it + ", has " + shown(best->shape) + ")") +
                                          (components ? "; save it as VTKHDF, CGNS, netCDF (.nc), or one array as .npy"
                                                      : "; expected time and two or three axes of space: take one place along each of the others ('ncks -d AXIS,0 IN OUT')"));
}

Imported read_plainly(const ArrayFile& file, const ReadRequest& request, bool components) {
  const std::string name = request.file.filename().string();
  const StoredArray& best = largest(file, name, components);
  const HdfAxes axes = *hdf_axes(best.shape, components);
  const auto dim = [&](std::size_t from_last) { return from_last < axes.space.size() ? static_cast<std::int64_t>(best.shape[axes.space[axes.space.size() - 1 - from_last]]) : 1; };
  const std::size_t steps = axes.steps < best.shape.size() ? best.shape[axes.steps] : 1;
  Imported imported;
  imported.times.resize(steps);
  std::iota(imported.times.begin(), imported.times.end(), 0.0);
  check_step(request, steps);
  if (request.times_only) return imported;
  std::uint64_t bytes = 0;
  for (const StoredArray& array : file.arrays())
    if (array.shape == best.shape) check_bytes(request, bytes += static_cast<std::uint64_t>(checked_product({static_cast<std::int64_t>(array.values() / steps), static_cast<std::int64_t>(size_of(array.type))}, name)), name);
  Block& block = imported.blocks.emplace_back();
  std::array<double, 3> apart{1, 1, 1};
  const std::vector<double> said = file.micrometres(best);
  const bool placed = std::min(axes.space.size(), std::size_t{3}) <= said.size() && std::all_of(said.begin(), said.end(), [](double of) { return of > 0 && std::isfinite(of); });
  for (std::size_t a = 0; placed && a < axes.space.size(); ++a) apart[a] = said[said.size() - 1 - a];
  if (placed) imported.axes = axes_in("µm");
  place_image(block, {dim(0), dim(1), dim(2)}, {0, 0, 0}, {{{apart[0], 0, 0}, {0, apart[1], 0}, {0, 0, apart[2]}}}, name);
  std::string packed;
  for (const StoredArray& array : file.arrays()) {
    if (array.shape != best.shape) continue;
    block.arrays.push_back(read_array(file, array, axes, request, block.arrays.size()));
    block.arrays.back().unit = file.unit(array);
    if (array.packed) packed += (packed.empty() ? "'" : ", '") + array.name + "'";
  }
  imported.notes.push_back("arrays of " + shown(best.shape) + " values: the last axis is x" + (placed ? ", points apart as element_size_um says" : ", points 1 apart") + (steps > 1 ? "; the first counts steps" : ""));
  if (const std::size_t others = file.arrays().size() - block.arrays.size(); others > 0) imported.notes.push_back(std::to_string(others) + " arrays of other shapes skipped");
  if (!packed.empty()) imported.notes.push_back("values are as they are stored, not scaled, fill values too: " + packed);
  return imported;
}

/// Whether each axis of an array has an array of its places, by netCDF's way.
bool is_placed(const ReadRequest& request, const StoredArray& array) {
  if (!array.placed) return false;
  try {
    const NetcdfFile file(request.file);
    const auto slash = array.name.rfind('/');
    const std::string prefix = slash == std::string::npos ? "" : array.name.substr(0, slash), name = slash == std::string::npos ? array.name : array.name.substr(slash + 1);
    int group = file.number(), variable = 0, count = 0;
    if (!prefix.empty() && nc_inq_grp_full_ncid(file.number(), prefix.c_str(), &group) != NC_NOERR) return false;
    std::array<int, NC_MAX_VAR_DIMS> dimensions{};
    if (nc_inq_varid(group, name.c_str(), &variable) != NC_NOERR || nc_inq_var(group, variable, nullptr, nullptr, &count, dimensions.data(), nullptr) != NC_NOERR) return false;
    return std::all_of(dimensions.begin(), dimensions.begin() + count, [&](int dimension) {
      char axis[NC_MAX_NAME + 1] = {};
      return nc_inq_dimname(group, dimension, axis) == NC_NOERR && nc_inq_varid(group, axis, &variable) == NC_NOERR;
    });
  } catch (const Error&) {
    return false;
  }
}

bool is_classic(const std::filesystem::path& file) {
  const MappedFile mapped(file);
  return mapped.bytes().size() > 3 && std::memcmp(mapped.bytes().data(), "CDF", 3) == 0;
}

}  // namespace

Imported read_netcdf_plainly(const ReadRequest& request) {
  if (is_classic(request.file)) return read_plainly(ClassicArrays(request.file), request, false);
  return read_plainly(Hdf5File(request.file), request, false);
}

Imported read_hdf5(const ReadRequest& request) {
  const Hdf5File file(request.file);
#ifdef ISOSTRATA_READS_VTKHDF
  if (file.has_group("VTKHDF")) return read_vtkhdf(request);
#endif
#ifdef ISOSTRATA_READS_EXODUS
  const auto holds = [&](const char* name) { return file.has(name); };
  if (holds("num_nodes") && holds("num_el_blk")) return read_exodus(request);
#endif
  if (file.has_group("DataSetInfo") && file.has_group("DataSet")) return read_imaris(request);
  if (auto levels = read_flash(file, request)) return std::move(*levels);
  if (auto levels = read_athena(file, request)) return std::move(*levels);
  if (is_placed(request, largest(file, request.file.filename().string(), true))) return read_netcdf(request);
  Imported imported = read_plainly(file, request, true);
  if (file.lost_links() > 0 && !request.times_only) imported.notes.push_back(std::to_string(file.lost_links()) + " links skipped that lead to nothing");
  return imported;
}

}  // namespace isostrata
