// Which tetrahedra of a laid out grid the intervals meet, and on which of its points and edges the mesh has points: all that is
// known before a number is written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/buffer.h"
#include "base/task.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/mesh/list_pool.h"
#include "extraction/unstructured/ordered_tetrahedra.h"

namespace isostrata {

/// One interval in one active tetrahedron.
struct OrderedCut {
  std::uint32_t tetrahedron;
  std::uint16_t interval;
  std::uint8_t case_index;  // of the rows
};

/// A point of the grid that is one of the mesh (edge == kKept), or an edge that carries some.
struct OrderedSite {
  static constexpr std::uint32_t kKept = ~std::uint32_t{0};
  std::uint32_t point, edge;
};

/// The cells are looked at in chunks, and so are the points. Of each chunk the mesh's numbers begin where those of the chunks
/// before it end.
struct OrderedCuts {
  Buffer<std::uint8_t> bin;                         // [points of the grid] how many isovalues its value reaches
  std::vector<std::span<const OrderedCut>> cuts;    // [chunks] tetrahedron after tetrahedron
  std::vector<std::span<const OrderedSite>> sites;  // [chunks of points] with the edges that begin there
  std::vector<std::uint64_t> tetrahedra_before, runs_before,
      points_before;              // [chunks + 1] of the mesh, active cells, of the mesh
  bool usually_negative = false;  // more of the active cells are left-handed than right-handed
  std::uint64_t list_bytes = 0;   // of cuts and sites
  ListPool<OrderedCut> cut_pool;  // what they lie in
  ListPool<OrderedSite> site_pool;
};

/// rules: of at most kMostOrderedEnds isovalues. Throws too_large, cancelled. Any thread.
std::unique_ptr<const OrderedCuts> find_ordered_cuts(const OrderedTetrahedra& tetrahedra, const OrderedArray& values,
                                                     const IsoRules& rules, std::uint64_t max_bytes, const Task& task);
inline constexpr std::size_t kMostOrderedEnds = 255;

}  // namespace isostrata
