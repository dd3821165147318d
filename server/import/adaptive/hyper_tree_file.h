// Hyper tree grids in VTK's XML: what such a file says. Version 2 has one list of everything for all trees, version 1 an element for each tree.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "import/imported/imported.h"
#include "import/imported/xml_arrays.h"

namespace isostrata {

struct HyperTrees {
  /// A tree's cells are numbered level by level; the children of the cells that are refined follow each other in the next level.
  struct Tree {
    std::int64_t root = 0;               // on which of the roots it stands
    std::vector<std::uint64_t> cells;    // [levels]
    std::uint64_t first_bit = 0;         // of `refined`: one for each of its cells but those of the last level
    std::uint64_t first_cell = 0;        // of `masked` and of the values
  };

  std::array<std::vector<double>, 3> axes;  // corners of the roots, increasing; one along a flat axis
  unsigned int factor = 2;                  // children of a cell along each axis that is not flat
  bool transposed = false;                  // roots are numbered with z fastest, not x
  std::vector<Tree> trees;
  std::uint64_t cells = 0;  // of all trees
  XmlBits refined, masked;
  std::vector<FileArray> values;  // [cells][components]
};

/// Throws bad_data if the file is damaged, unsupported if it is of another version or packed by LZMA. How many children a tree has it does not check.
HyperTrees read_hyper_trees(const ReadRequest& request, std::vector<std::string>& notes);

}  // namespace isostrata
