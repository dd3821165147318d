#include "import/adaptive/leaf_block.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>

#include "import/adaptive/leaf_cells.h"
#include "import/adaptive/level_weights.h"

namespace isostrata {
namespace {

/// "3 levels, refined by 2 and 4: 100, 800 and 51200 leaves"
std::string words_of(const LevelLattice& lattice, const LeafCells& leaves) {
  const std::size_t levels = lattice.levels.size();
  std::vector<std::int64_t> of_level(levels, 0);
  for (const std::uint8_t level : leaves.level) ++of_level[level];
  const auto listed = [](std::size_t count, const auto& of) {
    std::string out;
    for (std::size_t i = 0; i < count; ++i) out += (i == 0 ? "" : i + 1 == count ? " and " : ", ") + std::to_string(of(i));
    return out;
  };
  const auto ratio = [&](std::size_t i) { return lattice.levels[i].ratio; };
  bool one_ratio = true;
  for (std::size_t i = 1; i + 1 < levels; ++i) one_ratio = one_ratio && ratio(i) == ratio(0);
  return (levels == 1 ? "one level" : std::to_string(levels) + " levels, refined by " + listed(one_ratio ? 1 : levels - 1, ratio)) + ": " +
         listed(levels, [&](std::size_t i) { return of_level[i]; }) + " cells that no finer one covers";
}

void hide(std::span<const std::uint8_t> cells, LeafCells& leaves) {
  for (const std::int64_t cell : leaves.in_file) leaves.hidden_leaves.push_back(cells[static_cast<std::size_t>(cell)]);
  for (const std::int64_t leaf : leaves.source) leaves.hidden.push_back(leaves.hidden_leaves[static_cast<std::size_t>(leaf)]);
}

}  // namespace

LeafBlock::LeafBlock(const LevelBoxes& levels, const ReadRequest& request, std::vector<std::string>& notes, std::span<const std::uint8_t> hidden) : request_(request) {
  const LevelLattice lattice = lattice_of(levels, request.file.filename().string());
  const auto leaves = std::make_shared<LeafCells>(leaf_cells(lattice, request));
  notes.push_back(words_of(lattice, *leaves));
  if (leaves->split > 0)
    notes.push_back(std::to_string(leaves->split) + " cells beside finer ones, cut into " + std::to_string(leaves->pieces) + " pieces that fit these");
  if (!hidden.empty()) hide(hidden, *leaves);
  block_.weights = level_weights(lattice, *leaves);
  for (std::size_t leaf = 0; leaf < leaves->in_file.size(); ++leaf) {
    const std::int64_t cell = leaves->in_file[leaf];
    if (runs_.empty() || cell < lattice.first_cell[runs_.back().box] || cell >= lattice.first_cell[runs_.back().box + 1])
      runs_.push_back({static_cast<std::size_t>(std::upper_bound(lattice.first_cell.begin(), lattice.first_cell.end(), cell) - lattice.first_cell.begin()) - 1, leaf, leaf});
    runs_.back().last = leaf + 1;
    in_box_.push_back(cell - lattice.first_cell[runs_.back().box]);
  }
  for (std::size_t cell = 0; cell < leaves->source.size(); ++cell)
    if (cell == 0 || leaves->source[cell] != leaves->source[cell - 1]) first_cell_.push_back(cell);
  first_cell_.push_back(leaves->source.size());
  if (leaves->split > 0) block_.source = std::move(leaves->source);
  leaves->in_file = {};
  leaves->level = {};
  block_.grid.shape = UnstructuredGrid{std::span<const Vec3d>(leaves->points), leaves->types, leaves->offsets, leaves->connectivity};
  block_.grid.hidden_cells = leaves->hidden;
  block_.grid.storage = leaves;
}

void LeafBlock::add(const FileArray& like, const ValuesOfBox& values) {
  FileArray array = like;
  const std::size_t tuple = size_of(like.type) * static_cast<std::size_t>(like.components);
  bytes_ += static_cast<std::uint64_t>(first_cell_.back()) * tuple;
  check_bytes(request_, bytes_, request_.file.filename().string() + ": its values");
  auto [storage, bytes] = allocate<std::byte>(first_cell_.back() * tuple);
  for (std::size_t r = 0; r < runs_.size(); ++r) {
    const std::span<const std::byte> of_box = values(runs_[r].box);
    for (std::size_t leaf = runs_[r].first; leaf < runs_[r].last; ++leaf) {
      const std::byte* const from = of_box.data() + static_cast<std::size_t>(in_box_[leaf]) * tuple;
      for (std::size_t cell = first_cell_[leaf]; cell < first_cell_[leaf + 1]; ++cell) std::memcpy(bytes.data() + cell * tuple, from, tuple);
    }
    request_.progress(0.5 * static_cast<double>(r + 1) / static_cast<double>(runs_.size()));
  }
  array.on_cells = true;
  array.values = bytes;
  array.storage = storage;
  block_.arrays.push_back(std::move(array));
}

}  // namespace isostrata
