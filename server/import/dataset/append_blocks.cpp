#include "import/dataset/append_blocks.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>

#include "import/dataset/close_seams.h"
#include "import/dataset/join_pieces.h"

namespace isostrata {
namespace {

bool has_double_points(const Grid& grid) {
  if (const auto* curvilinear = std::get_if<CurvilinearGrid>(&grid.shape)) return curvilinear->points.index() == 1;
  if (const auto* unstructured = std::get_if<UnstructuredGrid>(&grid.shape)) return unstructured->points.index() == 1;
  return true;
}

struct Cells {
  std::vector<std::uint8_t> types;
  std::vector<std::int64_t> offsets{0};
  std::vector<std::int64_t> connectivity;
  std::vector<std::uint8_t> hidden;
  std::vector<Vec3f> single_points;
  std::vector<Vec3d> double_points;
};

const FileArray* find(const Block& block, const FileArray& like) {
  const auto at = std::find_if(block.arrays.begin(), block.arrays.end(),
                               [&](const FileArray& a) { return a.name == like.name && a.on_cells == like.on_cells; });
  return at != block.arrays.end() && at->components == like.components ? &*at : nullptr;
}

std::int64_t file_points(const Block& block) { return block.grid.point_count() - block.added_points; }

/// Whether all blocks are unstructured over one and the same list of points, but for those that were added.
bool share_points(const std::vector<Block>& blocks) {
  const auto bytes = [](const Block& block) -> std::span<const std::byte> {
    const auto* grid = std::get_if<UnstructuredGrid>(&block.grid.shape);
    const auto count = static_cast<std::size_t>(file_points(block));
    return grid ? std::visit([&](auto span) { return std::as_bytes(span.first(count)); }, grid->points)
                : std::span<const std::byte>{};
  };
  const auto first = bytes(blocks.front());
  return !first.empty() && std::all_of(blocks.begin(), blocks.end(), [&](const Block& block) {
    const auto other = bytes(block);
    return other.size() == first.size() && has_double_points(block.grid) == has_double_points(blocks.front().grid) &&
           (other.data() == first.data() || std::memcmp(other.data(), first.data(), first.size()) == 0);
  });
}

/// The last `tuples` tuples of an array.
FileArray last_tuples(FileArray array, std::int64_t tuples) {
  array.values = array.values.last(static_cast<std::size_t>(tuples * array.components) * size_of(array.type));
  return array;
}

/// Only the tuples of these cells.
FileArray of_cells(const FileArray& all, const std::vector<std::int64_t>& kept) {
  FileArray out = all;
  const std::size_t tuple = size_of(all.type) * static_cast<std::size_t>(all.components);
  auto [storage, bytes] = allocate<std::byte>(tuple * kept.size());
  for (std::size_t c = 0; c < kept.size(); ++c) std::memcpy(bytes.data() + c * tuple, all.values.data() + static_cast<std::size_t>(kept[c]) * tuple, tuple);
  out.values = bytes;
  out.storage = storage;
  return out;
}

/// The numbers that points have in the whole, where all blocks say them.
std::vector<std::int64_t> global_points(const std::vector<Block>& blocks) {
  std::vector<std::int64_t> out;
  for (const Block& block : blocks) {
    if (block.global_points.values.size() != static_cast<std::size_t>(block.grid.point_count()) * sizeof(std::int64_t)) return {};
    const auto numbers = std::get<std::span<const std::int64_t>>(scalar_span(ScalarType::int64, block.global_points.values));
    out.insert(out.end(), numbers.begin(), numbers.end());
  }
  return out;
}

/// What stands for an array in a block that has none of its name: NaN.
FileArray no_values(const FileArray& like, std::int64_t tuples) {
  FileArray out = like;
  out.type = like.type == ScalarType::float32 ? ScalarType::float32 : ScalarType::float64;
  const auto n = static_cast<std::size_t>(tuples * like.components);
  const auto fill = [&](auto nan) {
    auto [storage, values] = allocate<decltype(nan)>(n);
    std::fill(values.begin(), values.end(), nan);
    out.values = std::as_bytes(values);
    out.storage = storage;
  };
  if (out.type == ScalarType::float32)
    fill(std::numeric_limits<float>::quiet_NaN());
  else
    fill(std::numeric_limits<double>::quiet_NaN());
  return out;
}

/// "blocks: fluid, solid", where the file names them.
void note_names(Imported& imported) {
  std::string names;
  for (const Block& block : imported.blocks) {
    if (block.name.empty()) return;
    if (names.size() < 300) names += (names.empty() ? "" : ", ") + block.name;
  }
  imported.notes.push_back("blocks: " + names);
}

FileArray concatenate(const std::vector<const FileArray*>& parts) {
  FileArray out = *parts.front();
  const bool same = std::all_of(parts.begin(), parts.end(), [&](const FileArray* part) { return part->type == out.type; });
  if (!same) out.type = ScalarType::float64;
  std::size_t count = 0;
  for (const FileArray* part : parts) count += part->values.size() / size_of(part->type);
  auto [storage, bytes] = allocate<std::byte>(count * size_of(out.type));
  std::size_t at = 0;
  for (const FileArray* part : parts) {
    if (same) {
      if (!part->values.empty()) std::memcpy(bytes.data() + at, part->values.data(), part->values.size());
      at += part->values.size();
      continue;
    }
    std::visit(
        [&](auto values) {
          for (const auto value : values) {
            const auto wide = static_cast<double>(value);
            std::memcpy(bytes.data() + at, &wide, sizeof wide);
            at += sizeof wide;
          }
        },
        scalar_span(part->type, part->values));
  }
  out.values = bytes;
  out.storage = storage;
  return out;
}

/// A grid is flat as a whole or not at all: beside cells with a volume, blocks of shells are left out.
void leave_out_flat(Imported& imported) {
  const auto has_volume = [](const Block& block) { return block.grid.cell_count() > 0 && !block.grid.flat(); };
  if (std::none_of(imported.blocks.begin(), imported.blocks.end(), has_volume)) return;
  std::int64_t cells = 0;
  const auto flat = std::stable_partition(imported.blocks.begin(), imported.blocks.end(), [](const Block& b) { return !b.grid.flat(); });
  for (auto block = flat; block != imported.blocks.end(); ++block) cells += block->grid.cell_count();
  imported.blocks.erase(flat, imported.blocks.end());
  if (cells > 0) imported.notes.push_back(std::to_string(cells) + " flat cells skipped: other blocks have cells with a volume");
}

/// The cells of all blocks as one grid, without arrays.
struct JoinedCells {
  Block block;
  bool split = false;                     // a block has added points
  std::vector<std::int64_t> first_points, first_cells;  // of each block
  std::vector<std::int64_t> kept;         // of all blocks' cells, one after the other: those that are not ghosts
  std::int64_t all_cells = 0;
};

/// shared: as share_points has it.
JoinedCells join_cells(const std::vector<Block>& blocks, bool shared) {
  const bool doubles = std::any_of(blocks.begin(), blocks.end(), [](const Block& b) { return has_double_points(b.grid); });
  const auto cells = std::make_shared<Cells>();
  JoinedCells out;
  bool any_hidden = false;
  std::vector<std::int64_t> source;
  std::int64_t first_source = 0;
  std::array<std::int64_t, kMaxCellVertices> ids{};
  for (const Block& block : blocks) {
    out.first_cells.push_back(static_cast<std::int64_t>(cells->types.size()));
    const auto points_before = static_cast<std::int64_t>(doubles ? cells->double_points.size() : cells->single_points.size());
    out.first_points.push_back(points_before);
    const bool whole = !shared || &block == &blocks.front();
    const std::int64_t common = whole ? 0 : file_points(block);  // these are there already
    const bool seams = has_seams(block) && !block.jumps;
    const auto number = [&](std::int64_t id) {
      if (seams) id = without_seams(block, id);
      return id < common ? id : points_before + id - common;
    };
    for (std::int64_t p = common; p < block.grid.point_count(); ++p) {
      const Vec3d at = block.grid.point(p);
      if (doubles)
        cells->double_points.push_back(at);
      else
        cells->single_points.push_back({static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)});
    }
    for (std::int64_t c = 0; c < block.grid.cell_count(); ++c) {
      const std::int64_t number_of_all = out.all_cells++;
      if (!block.grid.hidden_cells.empty() && block.grid.hidden_cells[static_cast<std::size_t>(c)] == kGhostCell) continue;
      out.kept.push_back(number_of_all);
      const int n = block.grid.cell_points(c, ids);
      for (int v = 0; v < n; ++v) cells->connectivity.push_back(number(ids[static_cast<std::size_t>(v)]));
      cells->offsets.push_back(static_cast<std::int64_t>(cells->connectivity.size()));
      cells->types.push_back(static_cast<std::uint8_t>(block.grid.cell_type(c)));
      cells->hidden.push_back(block.grid.hidden(c));
      any_hidden = any_hidden || block.grid.hidden(c);
      source.push_back(first_source + (block.source.empty() ? c : block.source[static_cast<std::size_t>(c)]));
    }
    if (!source.empty()) first_source = source.back() + 1;
    out.split = out.split || block.added_points > 0;
  }
  UnstructuredGrid grid;
  if (doubles)
    grid.points = std::span<const Vec3d>(cells->double_points);
  else
    grid.points = std::span<const Vec3f>(cells->single_points);
  grid.types = cells->types;
  grid.offsets = cells->offsets;
  grid.connectivity = cells->connectivity;
  out.block.grid.shape = grid;
  if (any_hidden) out.block.grid.hidden_cells = cells->hidden;
  out.block.grid.storage = cells;
  if (out.split) out.block.source = std::move(source);
  return out;
}

/// Each array of any block, over all of them; notes those that some lack.
void join_arrays(JoinedCells& joined, Imported& imported, bool shared) {
  Block& all = joined.block;
  std::map<std::string, std::size_t> lacking;  // in how many blocks an array has no values
  for (const Block& block : imported.blocks)
    for (const FileArray& array : block.arrays) {
      if (find(all, array)) continue;
      std::vector<const FileArray*> parts;
      std::vector<FileArray> made;  // parts that are not an array of a block as it is
      made.reserve(imported.blocks.size());
      std::size_t without = 0;
      for (const Block& other : imported.blocks) {
        // Of blocks over common points all but the first have only the points that each added.
        const bool common = shared && !array.on_cells && &other != &imported.blocks.front();
        const FileArray* part = find(other, array);
        if (!part) {
          const std::int64_t tuples = array.on_cells ? other.grid.cell_count() : common ? other.added_points : other.grid.point_count();
          if (tuples > 0) ++without, parts.push_back(&made.emplace_back(no_values(array, tuples)));
        } else {
          parts.push_back(common ? &made.emplace_back(last_tuples(*part, other.added_points)) : part);
        }
      }
      if (shared && !array.on_cells && !joined.split) {
        all.arrays.push_back(array);  // it belongs to the common points
        continue;
      }
      all.arrays.push_back(concatenate(parts));
      if (array.on_cells && std::ssize(joined.kept) < joined.all_cells) all.arrays.back() = of_cells(all.arrays.back(), joined.kept);
      all.arrays.back().partial = without > 0;
      if (without > 0) lacking[array.name] = without;
    }
  for (const auto& [array, blocks] : lacking)
    imported.notes.push_back("array '" + array + "' has no values in " + std::to_string(blocks) + " of " + std::to_string(imported.blocks.size()) + " blocks");
}

}  // namespace

Block append_blocks(Imported& imported, const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  if (imported.blocks.empty()) throw Error(ErrorCode::bad_data, name + ": holds no grid");
  leave_out_flat(imported);
  for (Block& block : imported.blocks) close_seams(block);
  if (imported.blocks.size() == 1) return std::move(imported.blocks.front());

  std::uint64_t bytes = 0;
  for (const Block& block : imported.blocks)
    bytes += static_cast<std::uint64_t>(block.grid.cell_count()) * 81 + static_cast<std::uint64_t>(block.grid.point_count()) * 12;
  check_bytes(request, bytes, name + ": its blocks as one unstructured grid");

  const bool shared = share_points(imported.blocks);
  JoinedCells joined = join_cells(imported.blocks, shared);
  join_arrays(joined, imported, shared);
  if (const std::int64_t ghosts = joined.all_cells - std::ssize(joined.kept); ghosts > 0)
    imported.notes.push_back(std::to_string(ghosts) + " ghost cells left out: other pieces have them as their own");
  note_names(imported);
  imported.notes.push_back(std::to_string(imported.blocks.size()) + (shared ? " blocks over the same points as one unstructured grid" : " blocks as one unstructured grid"));
  if (!shared) join_pieces(joined.block, joined.first_points, joined.first_cells, global_points(imported.blocks), imported.notes);
  return std::move(joined.block);
}

}  // namespace isostrata
