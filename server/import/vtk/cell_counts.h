// What became of a file's cells, by VTK's number of their type.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace isostrata {

struct CellCounts {
  struct Pieces {
    std::int64_t cells = 0, pieces = 0;
  };
  std::map<int, std::int64_t> skipped, open, linearised, whole;
  std::map<int, Pieces> split, fans, divided;
  std::int64_t overlapping = 0;  // polyhedra whose pieces do

  /// No cell was left out or became several.
  bool each_is_one() const { return skipped.empty() && open.empty() && split.empty() && fans.empty() && divided.empty(); }
  /// Adds a note for each kind. flat: no cell of the file has a volume, so those with an area were kept.
  void note(bool flat, std::vector<std::string>& notes) const;
};

/// "VTK_QUADRATIC_TETRA" is what people search for; VTK calls it "vtkQuadraticTetra".
std::string vtk_name(int type);

}  // namespace isostrata
