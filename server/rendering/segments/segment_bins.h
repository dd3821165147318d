// Which tiles of the picture a mesh's tetrahedra and facets reach.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/buffer.h"
#include "rendering/segments/segment_optics.h"
#include "rendering/segments/segment_points.h"

namespace isostrata {

struct SegmentEntry {
  std::uint32_t id;
  float nearness;  // as in PlacedTetrahedron
};

/// The entries of tile t (row by row) are [first[t], first[t + 1]), in the order in which they were placed.
struct TileBins {
  std::vector<std::uint32_t> first;
  Buffer<SegmentEntry> entries;

  std::span<const SegmentEntry> of(std::size_t tile) const {
    return first.empty() ? std::span<const SegmentEntry>{}
                         : std::span(entries).subspan(first[tile], first[tile + 1] - first[tile]);
  }
};

/// Counts, then fills: the same for any number of threads. Parallel over the chunks. Throws too_large beyond 2^32 entries.
void fill_bins(const std::vector<std::span<const PlacedTetrahedron>>& chunks, int tiles_x, int tiles_y, TileBins& bins);

/// A piece of a tetrahedron that was cut at the eye or far outside the picture.
struct CutTetrahedron {
  std::array<SegmentVertex, 4> vertex;
  std::array<float, 4> shade;  // 1 if bodies are not shaded
  std::uint32_t interval;
};

/// A tetrahedron of DrawInput::base and an interval that it reaches into.
struct ReachedTetrahedron {
  std::array<std::uint32_t, 4> points;
  std::uint32_t interval;
};

/// The drawn tetrahedra on the screen. ids from first_piece on are pieces. Memory is kept from frame to frame.
struct PlacedMesh {
  Buffer<SegmentVertex> points;        // [np]; where intervals are cut, only blocks of points that anything reached uses
  Buffer<float> shades;                // [np], see body_shading.h; empty if bodies are not shaded
  Buffer<ReachedTetrahedron> reached;  // ids are of these where intervals are cut, else of the mesh's tetrahedra
  Buffer<CutTetrahedron> pieces;
  std::size_t first_piece = 0;
  TileBins bins;
  std::int64_t drawn = 0;  // tetrahedra of drawn intervals, whether they cover a pixel or not
  int tiles_x = 0, tiles_y = 0;

  Buffer<PlacedTetrahedron> placed;  // [tetrahedra], of each chunk from its first tetrahedron on
};

void place_mesh(const DrawInput& input, const SegmentView& view, const SegmentOptics& optics, PlacedMesh& out);

}  // namespace isostrata
