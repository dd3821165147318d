#include <algorithm>
#include <cstring>
#include <map>
#include <memory>

#include "import/adaptive/amrex_header.h"
#include "import/adaptive/leaf_block.h"
#include "import/bytes/mapped_file.h"
#include "import/bytes/swap_bytes.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

struct StoredBox {
  CellRange cells;
  const MappedFile* file = nullptr;
  std::size_t values = 0;  // where they begin
  AmrexFab fab;
};

/// The boxes of all levels, and the files that they lie in.
class Plotfile {
 public:
  Plotfile(const AmrexHeader& header, const std::string& name) : header_(header), name_(name) {
    for (const AmrexLevel& level : header.levels)
      for (const AmrexBox& box : read_amrex_boxes(level, header)) add(level, box);
  }

  const LevelBoxes& levels() const { return levels_; }
  ScalarType type() const { return boxes_.front().fab.type; }

  /// One component of a box; good until the next is asked for.
  std::span<const std::byte> values(std::size_t number, std::size_t component) {
    const StoredBox& box = boxes_[number];
    const std::size_t width = size_of(box.fab.type), plane = static_cast<std::size_t>(box.fab.cells.count()) * width;
    const std::span<const std::byte> all = box.file->bytes().subspan(box.values + component * plane, plane);
    if (box.fab.cells.count() == box.cells.count() && !box.fab.swapped) return all;
    own_.clear();
    const auto row = static_cast<std::size_t>(box.cells.extent(0)) * width;
    for (std::int64_t k = box.cells.lower[2]; k < box.cells.upper[2]; ++k)
      for (std::int64_t j = box.cells.lower[1]; j < box.cells.upper[1]; ++j) {
        const CellRange& fab = box.fab.cells;
        const std::int64_t first = box.cells.lower[0] - fab.lower[0] + fab.extent(0) * (j - fab.lower[1] + fab.extent(1) * (k - fab.lower[2]));
        const auto from = all.subspan(static_cast<std::size_t>(first) * width, row);
        own_.insert(own_.end(), from.begin(), from.end());
      }
    if (box.fab.swapped) swap_bytes(own_, width);
    return own_;
  }

 private:
  void add(const AmrexLevel& level, const AmrexBox& box) {
    LevelBox to{.origin = header_.origin, .spacing = level.spacing};
    for (int axis = 0; axis < header_.dimensions; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      to.origin[axis] += static_cast<double>(box.cells.lower[a] - level.first[a]) * level.spacing[axis];
      to.cells[a] = box.cells.extent(a);
    }
    levels_.boxes.push_back(to);
    auto& file = files_[box.file.string()];
    if (!file) file = std::make_unique<MappedFile>(box.file);
    const std::string where = name_ + ": " + box.file.parent_path().filename().string() + "/" + box.file.filename().string() + " at byte " + std::to_string(box.offset);
    const auto bytes = file->bytes();
    if (box.offset >= bytes.size()) throw Error(ErrorCode::bad_data, where + ": the file ends at " + std::to_string(bytes.size()));
    const auto there = bytes.subspan(static_cast<std::size_t>(box.offset));
    StoredBox stored{box.cells, file.get(), 0, read_amrex_fab({reinterpret_cast<const char*>(there.data()), there.size()}, header_.dimensions, where)};
    stored.values = static_cast<std::size_t>(box.offset) + stored.fab.length;
    const CellRange& fab = stored.fab.cells;
    if (intersection(fab, box.cells).count() != checked_product({box.cells.extent(0), box.cells.extent(1), box.cells.extent(2)}, where))
      throw Error(ErrorCode::bad_data, where + ": is not of the cells that Cell_H says");
    if (stored.fab.components < std::ssize(header_.components))
      throw Error(ErrorCode::bad_data, where + ": has " + std::to_string(stored.fab.components) + " components; expected " + std::to_string(header_.components.size()));
    if (!boxes_.empty() && stored.fab.type != type()) throw Error(ErrorCode::unsupported, where + ": numbers are " + std::string(to_string(stored.fab.type)) + ", those of the first box " + to_string(type()));
    const std::int64_t size = checked_product({fab.extent(0), fab.extent(1), fab.extent(2), stored.fab.components, static_cast<std::int64_t>(size_of(stored.fab.type))}, where);
    if (static_cast<std::uint64_t>(size) > bytes.size() - stored.values)
      throw Error(ErrorCode::bad_data, where + ": " + std::to_string(size) + " bytes declared, " + std::to_string(bytes.size() - stored.values) + " present");
    boxes_.push_back(stored);
  }

  const AmrexHeader& header_;
  const std::string& name_;
  LevelBoxes levels_;
  std::vector<StoredBox> boxes_;
  std::map<std::string, std::unique_ptr<MappedFile>> files_;
  std::vector<std::byte> own_;
};

}  // namespace

Imported read_amrex(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_step(request, 1);
  const AmrexHeader header = read_amrex_header(request.file);
  Imported imported;
  imported.times = {header.time};
  if (request.times_only) return imported;
  Plotfile file(header, name);
  LeafBlock leaves(file.levels(), request, imported.notes);
  for (std::size_t c = 0; c < header.components.size(); ++c)
    leaves.add({.name = header.components[c], .type = file.type(), .values = {}, .storage = {}}, [&](std::size_t box) { return file.values(box, c); });
  if (header.coordinates != 0) imported.notes.push_back(std::string("its coordinates are ") + (header.coordinates == 1 ? "r and z" : "r, theta and phi") + "; they are shown as x, y and z");
  imported.blocks.push_back(leaves.take());
  return imported;
}

}  // namespace isostrata
