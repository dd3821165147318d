#include "rendering/segment_bins.h"

#include <algorithm>

#include "base/error.h"
#include "base/parallel.h"
#include "rendering/clip_tetrahedron.h"

namespace isostrata {
namespace {

constexpr std::size_t kChunk = 8192;  // tetrahedra

/// Cut where the picture's pyramid of view ends, and sliced by depth: the difference of two inverse depths loses the digits by
/// which they differ in size.
void cut_tetrahedron(const DrawInput& input, const SegmentView& view, std::uint32_t id, std::vector<CutTetrahedron>& out) {
  const IntervalMesh& mesh = *input.mesh;
  ClipTetrahedron whole;
  for (std::size_t v = 0; v < 4; ++v) {
    const std::uint32_t point = mesh.tetrahedra[id][v];
    whole[v] = {view.seen(mesh.positions[point]), input.color_values ? double{(*input.color_values)[point]} : 0.0};
  }
  std::vector<ClipTetrahedron> pieces{whole};
  const double side = 0.999 * view.guard / view.focal;
  const double deep = view.orthographic ? 0 : side, wide = view.orthographic ? -side : 0;
  if (!view.orthographic) clip_tetrahedra(pieces, {0, 0, 1}, view.near_depth * 1.001);
  for (const double sign : {1.0, -1.0}) {
    clip_tetrahedra(pieces, {sign, 0, deep}, wide);
    clip_tetrahedra(pieces, {0, sign, deep}, wide);
  }
  if (!view.orthographic) {
    double farthest = 0;
    for (const ClipTetrahedron& piece : pieces)
      for (const ClipVertex& v : piece) farthest = std::max(farthest, v.position.z);
    constexpr double kSlice = 0.9 * kDepthRatio;
    std::vector<ClipTetrahedron> slices;
    for (double z = view.near_depth; z < farthest; z *= kSlice) {
      std::vector<ClipTetrahedron> slice = pieces;
      clip_tetrahedra(slice, {0, 0, 1}, z);
      clip_tetrahedra(slice, {0, 0, -1}, -z * kSlice);
      slices.insert(slices.end(), slice.begin(), slice.end());
    }
    pieces.swap(slices);
  }
  for (const ClipTetrahedron& piece : pieces) {
    CutTetrahedron cut;
    cut.interval = mesh.tetrahedron_interval[id];
    for (std::size_t v = 0; v < 4; ++v) cut.vertex[v] = view.screen(piece[v].position, piece[v].scalar);
    out.push_back(cut);
  }
}

struct ChunkResult {
  std::size_t placed = 0;
  std::int64_t drawn = 0;
  std::vector<CutTetrahedron> pieces;
};

ChunkResult place_chunk(const DrawInput& input, const SegmentView& view, const SegmentOptics& optics, const ScreenVertex* points,
                        std::size_t begin, std::size_t end, PlacedTetrahedron* placed) {
  const IntervalMesh& mesh = *input.mesh;
  ChunkResult result;
  std::vector<std::uint32_t> to_cut(PlacementBatch::kCapacity);
  PlacementBatch batch;
  const auto flush = [&] {
    std::size_t cuts = 0;
    result.placed += place_tetrahedra(view, batch, placed + result.placed, to_cut.data(), &cuts);
    for (std::size_t c = 0; c < cuts; ++c) cut_tetrahedron(input, view, to_cut[c], result.pieces);
    batch.count = 0;
  };
  for (std::size_t t = begin; t < end; ++t) {
    if (optics.group[mesh.tetrahedron_interval[t]] < 0) continue;
    ++result.drawn;
    const auto& ids = mesh.tetrahedra[t];
    batch.id[batch.count] = static_cast<std::uint32_t>(t);
    for (std::size_t v = 0; v < 4; ++v) batch.vertex[v][batch.count] = points[ids[v]];
    if (++batch.count == PlacementBatch::kCapacity) flush();
  }
  flush();
  return result;
}

/// Pieces are few, so they are one chunk.
std::vector<PlacedTetrahedron> place_pieces(const SegmentView& view, const std::vector<CutTetrahedron>& pieces,
                                            std::size_t first_id) {
  std::vector<PlacedTetrahedron> placed(pieces.size());
  std::vector<std::uint32_t> ignored(PlacementBatch::kCapacity);
  std::size_t count = 0;
  PlacementBatch batch;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    batch.id[batch.count] = static_cast<std::uint32_t>(first_id + i);
    for (std::size_t v = 0; v < 4; ++v) batch.vertex[v][batch.count] = pieces[i].vertex[v];
    if (++batch.count < PlacementBatch::kCapacity && i + 1 < pieces.size()) continue;
    std::size_t cuts = 0;
    count += place_tetrahedra(view, batch, placed.data() + count, ignored.data(), &cuts);
    batch.count = 0;
  }
  placed.resize(count);
  return placed;
}

}  // namespace

void fill_bins(const std::vector<std::span<const PlacedTetrahedron>>& chunks, int tiles_x, int tiles_y, TileBins& bins) {
  const std::size_t tiles = static_cast<std::size_t>(tiles_x) * static_cast<std::size_t>(tiles_y);
  // Fewer, longer chunks where there are many tiles: a count for each chunk and tile.
  const std::size_t groups = std::clamp<std::size_t>((std::size_t{1} << 22) / tiles, 1, std::max<std::size_t>(chunks.size(), 1));
  const auto group_begin = [&](std::size_t g) { return g * chunks.size() / groups; };
  std::vector<std::uint32_t> counts(groups * tiles, 0);
  const auto each_tile = [&](std::size_t group, auto&& body) {
    for (std::size_t c = group_begin(group); c < group_begin(group + 1); ++c)
      for (const PlacedTetrahedron& placed : chunks[c])
        for (std::size_t y = placed.y0; y <= placed.y1; ++y)
          for (std::size_t x = placed.x0; x <= placed.x1; ++x) body(placed, y * static_cast<std::size_t>(tiles_x) + x);
  };
  parallel_for(static_cast<std::int64_t>(groups), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto g = static_cast<std::size_t>(begin); g < static_cast<std::size_t>(end); ++g)
      each_tile(g, [count = counts.data() + g * tiles](const PlacedTetrahedron&, std::size_t tile) { ++count[tile]; });
  });
  bins.first.resize(tiles + 1);
  std::uint64_t sum = 0;
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    bins.first[tile] = static_cast<std::uint32_t>(sum);
    for (std::size_t g = 0; g < groups; ++g) {
      const std::uint32_t here = counts[g * tiles + tile];
      counts[g * tiles + tile] = static_cast<std::uint32_t>(sum);
      sum += here;
    }
    if (sum > 0xffffffffu)
      throw Error(ErrorCode::too_large, "picture: more than 4294967295 tetrahedra in all its tiles together");
  }
  bins.first[tiles] = static_cast<std::uint32_t>(sum);
  bins.entries.resize(sum);
  parallel_for(static_cast<std::int64_t>(groups), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto g = static_cast<std::size_t>(begin); g < static_cast<std::size_t>(end); ++g)
      each_tile(g, [&, at = counts.data() + g * tiles](const PlacedTetrahedron& placed, std::size_t tile) {
        bins.entries[at[tile]++] = {placed.id, placed.nearness};
      });
  });
}

void place_mesh(const DrawInput& input, const SegmentView& view, const SegmentOptics& optics, PlacedMesh& out) {
  const IntervalMesh& mesh = *input.mesh;
  out.tiles_x = (view.width + kTileSize - 1) / kTileSize;
  out.tiles_y = (view.height + kTileSize - 1) / kTileSize;
  out.points.resize(mesh.positions.size());
  const float* const values = input.color_values ? input.color_values->data() : nullptr;
  parallel_for(static_cast<std::int64_t>(mesh.positions.size()), 8192, [&](std::int64_t begin, std::int64_t end) {
    project_vertices(view, mesh.positions.data(), values, static_cast<std::size_t>(begin), static_cast<std::size_t>(end),
                     out.points.data());
  });
  const std::size_t count = mesh.tetrahedra.size(), chunk_count = (count + kChunk - 1) / kChunk;
  out.placed.resize(count);
  std::vector<ChunkResult> results(chunk_count);
  parallel_for(static_cast<std::int64_t>(chunk_count), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c)
      results[c] = place_chunk(input, view, optics, out.points.data(), c * kChunk, std::min(count, (c + 1) * kChunk),
                               out.placed.data() + c * kChunk);
  });
  out.drawn = 0;
  out.pieces.clear();
  std::vector<std::span<const PlacedTetrahedron>> chunks;
  for (std::size_t c = 0; c < chunk_count; ++c) {
    out.drawn += results[c].drawn;
    out.pieces.insert(out.pieces.end(), results[c].pieces.begin(), results[c].pieces.end());
    chunks.push_back(std::span(out.placed).subspan(c * kChunk, results[c].placed));
  }
  const std::vector<PlacedTetrahedron> pieces = place_pieces(view, out.pieces, count);
  chunks.push_back(pieces);
  fill_bins(chunks, out.tiles_x, out.tiles_y, out.bins);
}

}  // namespace isostrata
