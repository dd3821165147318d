// In which order the tile renderer goes through the tetrahedra.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "rendering/compute/tile_styles.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

struct TileOrder {
  std::uint32_t kind = 0;                   // TILE_ORDER_...
  std::array<std::uint32_t, 3> eye_cell{};  // of TILE_ORDER_INDEX
  std::uint32_t depth_bits = 0;             // of the keys; the device makes them
  std::vector<std::uint32_t> list;          // of TILE_ORDER_LIST: tetrahedra, nearest first
  bool list_exact = false;
  std::string method;  // as DrawFacts::order begins; of a list all of it
};

/// Rectilinear grids: the index distance of the cells, whose keys the device makes and sorts; what is left to order inside a cell
/// is sorted per pixel. Others, and where keys of more than key_bits would be needed: order_groups, on the CPU. Nothing where
/// nothing needs order.
TileOrder tile_order(const DrawInput& input, const TileStyles& styles, std::uint32_t key_bits);

}  // namespace isostrata
