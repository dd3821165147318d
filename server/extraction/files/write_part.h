// The parts of a dataset as the files that VTK reads as one grid: what `isostrata partition` writes.
//
//   uniform       .pvti of .vti     rectilinear   .pvtr of .vtr     curvilinear   .pvts of .vts: pieces that overlap by the cells of their margins,
//                                   of which VTK takes each once; a `vtkGhostType` of cells where the whole hides some
//   unstructured  .pvtu of .vtu: cells of the margin are marked 1 in `vtkGhostType` (DUPLICATECELL), hidden ones 32 (HIDDENCELL); points have the
//                 numbers that they have in the whole (`GlobalPointIds`, the attribute GlobalIds), by which readers join pieces
//
// Values lie raw and aligned, so that they can be mapped where they lie. All arrays are those of points that the dataset has.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/task.h"
#include "data/dataset/dataset.h"
#include "data/parts/take_region.h"

namespace isostrata {

/// ".pvtu" and ".vtu", and so on.
struct PartEndings {
  std::string list, piece;
};
PartEndings part_endings(const Grid& whole);

struct WrittenPart {
  std::string file;                             // its name beside the list
  std::array<std::int64_t, 3> first{}, dims{};  // of a structured grid: where it lies in the whole
};

/// part: what take_region made of the whole, and `origin`. owned: [cells of the part] 1 if a cell is the part's own; looked at for unstructured
/// grids. Throws unavailable, cancelled.
WrittenPart write_part(const std::filesystem::path& path, const Dataset& whole, const Dataset& part, const PartOrigin& origin, std::span<const std::uint8_t> owned,
                       const Task& task);

/// The list of pieces, which lie beside it. Throws unavailable.
void write_part_list(const std::filesystem::path& path, const Dataset& whole, std::span<const WrittenPart> parts);

}  // namespace isostrata
