// A cell's face by its points, for finding the other cell that has it.
#pragma once

#include <array>
#include <cstdint>

#include "extraction/mesh/match_table.h"
#include "tables/cell_type.h"

namespace isostrata {

/// The points of a face in increasing order, without repeats; -1 if it has fewer than four.
struct FaceKey {
  std::array<std::int64_t, 4> points{-1, -1, -1, -1};

  bool operator==(const FaceKey&) const = default;
  bool collapsed() const { return points[2] < 0; }  // to an edge: no facet lies in it
  std::uint64_t hash() const {
    std::uint64_t hash = 0;
    for (const std::int64_t p : points) hash = mixed_hash(hash, static_cast<std::uint64_t>(p));
    return hash;
  }
};

inline FaceKey face_key(const CellFace& face, const std::array<std::int64_t, kMaxCellVertices>& ids) {
  FaceKey key;
  int size = 0;
  for (int i = 0; i < face.size; ++i) {
    const std::int64_t id = ids[face.vertex[i]];
    int to = size;
    while (to > 0 && key.points[to - 1] > id) --to;
    if (to > 0 && key.points[to - 1] == id) continue;
    for (int k = size++; k > to; --k) key.points[k] = key.points[k - 1];
    key.points[to] = id;
  }
  return key;
}

}  // namespace isostrata
