// Cells, with VTK's ids and VTK's vertex order. A voxel is stored as a hexahedron (its vertices 2,3 and 6,7 swapped on import).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

namespace isostrata {

enum class CellType : std::uint8_t { triangle = 5, quadrilateral = 9, tetrahedron = 10, hexahedron = 12, wedge = 13, pyramid = 14 };

inline constexpr std::array kCellTypes{CellType::tetrahedron, CellType::pyramid, CellType::wedge, CellType::hexahedron};
inline constexpr std::array kFlatCellTypes{CellType::triangle, CellType::quadrilateral};  // these have an area and no volume
constexpr bool is_flat(CellType type) { return type == CellType::triangle || type == CellType::quadrilateral; }
inline constexpr int kMaxCellVertices = 8;

/// By a cell's type as a file may say it: how many points it has; 0 for what is none of the above.
inline constexpr std::array<std::uint8_t, 256> kPointsOfType = [] {
  std::array<std::uint8_t, 256> points{};
  for (const auto& [type, count] : {std::pair{CellType::triangle, 3}, {CellType::quadrilateral, 4}, {CellType::tetrahedron, 4},
                                    {CellType::pyramid, 5}, {CellType::wedge, 6}, {CellType::hexahedron, 8}})
    points[static_cast<std::size_t>(type)] = static_cast<std::uint8_t>(count);
  return points;
}();

/// Whether it is one of kCellTypes.
constexpr bool holds_volume(std::uint8_t type) { return kPointsOfType[type] > 0 && !is_flat(static_cast<CellType>(type)); }

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
