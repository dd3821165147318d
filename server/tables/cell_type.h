// Cells, with VTK's ids and VTK's vertex order. A voxel is stored as a hexahedron (its vertices 2,3 and 6,7 swapped on import).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace isostrata {

enum class CellType : std::uint8_t { triangle = 5, quadrilateral = 9, tetrahedron = 10, hexahedron = 12, wedge = 13, pyramid = 14 };

inline constexpr std::array kCellTypes{CellType::tetrahedron, CellType::pyramid, CellType::wedge, CellType::hexahedron};
inline constexpr std::array kFlatCellTypes{CellType::triangle, CellType::quadrilateral};  // these have an area and no volume
constexpr bool is_flat(CellType type) { return type == CellType::triangle || type == CellType::quadrilateral; }
inline constexpr int kMaxCellVertices = 8;

struct CellFace {
  int size = 0;                 // 3 or 4
  std::array<int, 4> vertex{};  // counter-clockwise seen from outside (for a right-handed cell)
};

/// The combinatorics of a cell type: nothing about positions.
struct CellTopology {
  CellType type;
  std::string_view name;  // "tetrahedron", ...
  int vertex_count;
  std::span<const std::array<int, 2>> edges;  // lower local vertex first, in lexicographic order
  std::span<const CellFace> faces;            // empty for flat types
};

const CellTopology& topology(CellType type);

}  // namespace isostrata
