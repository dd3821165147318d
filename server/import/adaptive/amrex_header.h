// The text files of a plotfile of AMReX or BoxLib: what it holds, and where.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/vec.h"
#include "import/adaptive/box_tree.h"
#include "import/imported/imported.h"

namespace isostrata {

struct AmrexLevel {
  Vec3d spacing{1, 1, 1};
  std::array<std::int64_t, 3> first{};  // the cell at the lowest corner of the domain
  std::filesystem::path boxes_file;     // Level_0/Cell_H
};

struct AmrexHeader {
  std::vector<std::string> components;
  int dimensions = 3;
  double time = 0;
  Vec3d origin;  // the lowest corner of the domain
  int coordinates = 0;  // 0: x, y, z; 1: r, z; 2: r, theta, phi
  std::vector<AmrexLevel> levels;
};

/// Of the folder's file Header. Throws bad_data, unsupported, not_found.
AmrexHeader read_amrex_header(const std::filesystem::path& folder);

struct AmrexBox {
  CellRange cells;
  std::filesystem::path file;
  std::uint64_t offset = 0;
};

/// The boxes of a level, from its boxes_file. Files lie below its folder.
std::vector<AmrexBox> read_amrex_boxes(const AmrexLevel& level, const AmrexHeader& header);

/// What stands before a box's values.
struct AmrexFab {
  CellRange cells;         // those of the box, and ghost cells around them
  ScalarType type = ScalarType::float64;
  bool swapped = false;    // bytes are in the other order than ours
  std::int64_t components = 0;
  std::size_t length = 0;  // bytes of this text
};

/// From the first bytes of it. `where` is for messages.
AmrexFab read_amrex_fab(std::string_view text, int dimensions, const std::string& where);

}  // namespace isostrata
