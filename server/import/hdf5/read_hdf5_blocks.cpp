#include "import/hdf5/read_hdf5_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "import/adaptive/leaf_block.h"

namespace isostrata {
namespace {

std::string shape_of(const StoredArray& array) {
  std::string out;
  for (const std::size_t size : array.shape) out += (out.empty() ? "" : "x") + std::to_string(size);
  return out;
}

/// All of a small array as numbers.
std::vector<double> numbers_of(const Hdf5File& file, const StoredArray& array, const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_bytes(request, static_cast<std::uint64_t>(checked_product({static_cast<std::int64_t>(array.values()), 16}, name)), name + ": '" + array.name + "'");
  std::vector<std::byte> bytes(array.values() * size_of(array.type));
  file.read(array, std::vector<std::size_t>(array.shape.size(), 0), array.shape, bytes);
  std::vector<double> out;
  out.reserve(array.values());
  std::visit([&](auto values) { for (const auto value : values) out.push_back(static_cast<double>(value)); }, scalar_span(array.type, bytes));
  return out;
}

const StoredArray* find(const Hdf5File& file, const char* path) {
  const auto at = std::find_if(file.arrays().begin(), file.arrays().end(), [&](const StoredArray& array) { return array.path == path; });
  return at == file.arrays().end() ? nullptr : &*at;
}

/// A place in an array before the three axes of a block: [component][block] or [block].
using PlaceOfBlock = std::function<std::vector<std::size_t>(std::size_t block)>;

/// Blocks of one number of cells each.
class EqualBlocks {
 public:
  EqualBlocks(const Hdf5File& file, const ReadRequest& request, std::array<std::size_t, 3> cells, Imported& to) : file_(file), request_(request), cells_(cells), to_(to) {}

  /// `lower` and `upper` are its corners. A direction in which all blocks have one cell has none: x and y are then a plane.
  void add(std::size_t block, const Vec3d& lower, const Vec3d& upper) {
    LevelBox box{.origin = lower, .spacing = {1, 1, 1}};
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t cells = cells_[static_cast<std::size_t>(axis)];
      if (cells == 1) box.origin[axis] = 0;
      box.cells[static_cast<std::size_t>(axis)] = cells == 1 ? 0 : static_cast<std::int64_t>(cells);
      if (cells > 1) box.spacing[axis] = (upper[axis] - lower[axis]) / static_cast<double>(cells);
    }
    levels_.boxes.push_back(box);
    blocks_.push_back(block);
  }
  void make() { leaves_.emplace(levels_, request_, to_.notes); }

  void add_array(const StoredArray& array, const std::string& called, const PlaceOfBlock& place) {
    std::vector<std::byte> values(cells_[0] * cells_[1] * cells_[2] * size_of(array.type));
    leaves_->add({.name = called, .type = array.type, .values = {}, .storage = {}}, [&](std::size_t box) {
      std::vector<std::size_t> from = place(blocks_[box]), count(from.size(), 1);
      from.insert(from.end(), 3, 0);
      count.insert(count.end(), {cells_[2], cells_[1], cells_[0]});
      file_.read(array, from, count, values);
      return std::span<const std::byte>(values);
    });
  }
  void finish() { to_.blocks.push_back(leaves_->take()); }

 private:
  const Hdf5File& file_;
  const ReadRequest& request_;
  const std::array<std::size_t, 3> cells_;  // along x, y, z
  Imported& to_;
  LevelBoxes levels_;
  std::vector<std::size_t> blocks_;  // [boxes]
  std::optional<LeafBlock> leaves_;
};

}  // namespace

std::optional<Imported> read_flash(const Hdf5File& file, const ReadRequest& request) {
  const StoredArray *corners = find(file, "bounding box"), *kinds = find(file, "node type");
  if (!corners || !kinds || !find(file, "refine level")) return std::nullopt;
  const std::string name = request.file.filename().string();
  const std::size_t count = corners->shape.front();
  const auto is_variable = [&](const StoredArray& array) { return array.shape.size() == 4 && array.shape[0] == count && array.values() > 0; };
  const auto first = std::find_if(file.arrays().begin(), file.arrays().end(), is_variable);
  if (corners->shape != std::vector<std::size_t>{count, 3, 2} || kinds->shape != std::vector<std::size_t>{count})
    throw Error(ErrorCode::bad_data, name + ": 'bounding box' has " + shape_of(*corners) + " numbers and 'node type' " + shape_of(*kinds) + "; expected 3x2 and one for each block");
  if (first == file.arrays().end()) throw Error(ErrorCode::bad_data, name + ": of FLASH, without an array of the cells of " + std::to_string(count) + " blocks");
  check_step(request, 1);
  Imported imported;
  imported.times = {file.number_beside("real scalars", "time").value_or(0)};
  if (!std::isfinite(imported.times.front())) throw Error(ErrorCode::bad_data, name + ": its time is not a finite number");
  if (request.times_only) return imported;
  EqualBlocks blocks(file, request, {first->shape[3], first->shape[2], first->shape[1]}, imported);
  const std::vector<double> corner = numbers_of(file, *corners, request), kind = numbers_of(file, *kinds, request);
  constexpr double kLeaf = 1;
  for (std::size_t b = 0; b < count; ++b)
    if (const double* at = &corner[b * 6]; kind[b] == kLeaf) blocks.add(b, {at[0], at[2], at[4]}, {at[1], at[3], at[5]});
  blocks.make();
  for (const StoredArray& array : file.arrays())
    if (is_variable(array) && array.shape == first->shape) blocks.add_array(array, array.name, [](std::size_t block) { return std::vector{block}; });
  blocks.finish();
  return imported;
}

std::optional<Imported> read_athena(const Hdf5File& file, const ReadRequest& request) {
  const std::array<const StoredArray*, 3> faces{find(file, "x1f"), find(file, "x2f"), find(file, "x3f")};
  if (!faces[0] || !faces[1] || !faces[2] || !find(file, "Levels")) return std::nullopt;
  const std::string name = request.file.filename().string();
  const std::size_t count = faces[0]->shape.front();
  std::array<std::size_t, 3> cells{};
  std::array<std::vector<double>, 3> places;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (faces[axis]->shape.size() != 2 || faces[axis]->shape[0] != count || faces[axis]->shape[1] < 2)
      throw Error(ErrorCode::bad_data, name + ": '" + faces[axis]->name + "' has " + shape_of(*faces[axis]) + " numbers; expected the faces of the cells of " + std::to_string(count) + " blocks");
    cells[axis] = faces[axis]->shape[1] - 1;
  }
  check_step(request, 1);
  Imported imported;
  if (const std::vector<double> time = file.numbers("Time"); time.size() == 1 && std::isfinite(time.front())) imported.times = time;
  if (request.times_only) return imported;
  for (std::size_t axis = 0; axis < 3; ++axis) places[axis] = numbers_of(file, *faces[axis], request);
  const auto place = [&](std::size_t axis, std::size_t block, std::size_t face) { return places[axis][block * (cells[axis] + 1) + face]; };
  EqualBlocks blocks(file, request, cells, imported);
  for (std::size_t b = 0; b < count; ++b) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t face = 1; face < cells[axis]; ++face) {
        const double step = (place(axis, b, cells[axis]) - place(axis, b, 0)) / static_cast<double>(cells[axis]);
        if (!(std::abs(place(axis, b, face) - place(axis, b, 0) - static_cast<double>(face) * step) < 0.01 * std::abs(step)))
          throw Error(ErrorCode::unsupported, name + ": the cells of block " + std::to_string(b) + " are not of one size along x" + std::to_string(axis + 1) + "; open its .xdmf, of which each block is a grid");
      }
    blocks.add(b, {place(0, b, 0), place(1, b, 0), place(2, b, 0)}, {place(0, b, cells[0]), place(1, b, cells[1]), place(2, b, cells[2])});
  }
  blocks.make();
  // Names of variables stand in one list, for one array of them after the other.
  const std::vector<std::string> names = file.words("VariableNames"), datasets = file.words("DatasetNames");
  std::size_t named = 0;
  for (const std::string& dataset : datasets) {
    const StoredArray* array = find(file, dataset.c_str());
    if (!array || array->shape.size() != 5 || array->shape[1] != count || array->shape[2] != cells[2] || array->shape[3] != cells[1] || array->shape[4] != cells[0])
      throw Error(ErrorCode::bad_data, name + ": '" + dataset + "' has " + (array ? shape_of(*array) : "no") + " numbers; expected one for each variable of each cell of each block");
    for (std::size_t c = 0; c < array->shape[0]; ++c, ++named)
      blocks.add_array(*array, named < names.size() ? names[named] : dataset + " " + std::to_string(c), [c](std::size_t block) { return std::vector{c, block}; });
  }
  if (const std::vector<std::string> coordinates = file.words("Coordinates"); coordinates.size() == 1 && coordinates.front() != "cartesian")
    imported.notes.push_back("its coordinates are '" + coordinates.front() + "'; they are shown as x, y and z");
  blocks.finish();
  return imported;
}

}  // namespace isostrata
