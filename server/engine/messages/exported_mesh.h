// What became of a scene's layers as a mesh file.
#pragma once

#include <cstdint>

namespace isostrata {

struct ExportedMesh {
  std::uint64_t bytes = 0;  // of the file
  std::int64_t tetrahedra = 0, points = 0, facets = 0;
};

}  // namespace isostrata
