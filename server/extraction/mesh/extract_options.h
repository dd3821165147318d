// What an extraction is asked to give beside the tetrahedra, and what it may use.
#pragma once

#include <cstdint>

namespace isostrata {

class BrickMemory;
class FaceMemory;
class OrderedMemory;

struct ExtractOptions {
  bool facets = false;                     // fill IntervalMesh::facets
  bool values = true;                      // fill IntervalMesh::values
  bool tetrahedra = true;                  // false, with facets: whole cells and structured grids fill facets alone and count the tetrahedra
  bool measure = true;                     // sum the volumes of the summaries and count what is inverted
  bool complement = false;                 // also what is below, between and above the intervals, as further intervals after them
  bool strict = false;                     // leave no tetrahedron turned against its cell (strict_triangulation.h)
  std::uint64_t max_bytes = 16ull << 30;   // throws too_large, with the numbers, if the mesh would need more
  BrickMemory* bricks = nullptr;           // keeps what the next extraction of the same field can use: structured grids only
  OrderedMemory* ordered = nullptr;        // used if it has the grid: grids of tetrahedra only
  FaceMemory* faces = nullptr;             // used if it has the grid: unstructured grids only
};

}  // namespace isostrata
