#include "rendering/segments/segment_bins.h"

#include <algorithm>
#include <atomic>

#include "base/error.h"
#include "base/parallel.h"
#include "rendering/picture/body_shading.h"
#include "rendering/picture/clip_tetrahedron.h"
#include "rendering/segments/reach_tetrahedra.h"

namespace isostrata {
namespace {

constexpr std::size_t kChunk = 8192;  // tetrahedra

/// Cut where the picture's pyramid of view ends, and sliced by depth: the difference of two inverse depths loses the digits by
/// which they differ in size.
void cut_tetrahedron(const DrawInput& input, const SegmentView& view, const PlacedMesh& all, const std::array<std::uint32_t, 4>& points,
                     std::uint32_t interval, std::vector<CutTetrahedron>& out) {
  ClipTetrahedron whole;
  for (std::size_t v = 0; v < 4; ++v) {
    const std::uint32_t point = points[v];
    whole[v] = {view.seen(input.mesh->positions[point]), input.color_values ? double{(*input.color_values)[point]} : 0.0,
                all.shades.empty() ? 1.0 : double{all.shades[point]}};
  }
  std::vector<ClipTetrahedron> pieces{whole};
  if (!view.orthographic) clip_tetrahedra(pieces, {0, 0, 1}, view.near_depth * 1.001);
  // A little within the guard, on each side by another share: pieces meet where the corners are joined, on lines through the
  // picture that must not go through the middles of its pixels.
  const auto cut_side = [&](Vec3d inwards, double share) {
    const double side = share * view.guard / view.focal;
    if (view.orthographic)
      clip_tetrahedra(pieces, inwards, -side);
    else
      clip_tetrahedra(pieces, {inwards.x, inwards.y, side}, 0);
  };
  cut_side({1, 0, 0}, 0.99907);
  cut_side({-1, 0, 0}, 0.98713);
  cut_side({0, 1, 0}, 0.97431);
  cut_side({0, -1, 0}, 0.99171);
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
    cut.interval = interval;
    for (std::size_t v = 0; v < 4; ++v) {
      cut.vertex[v] = view.screen(piece[v].position, piece[v].scalar);
      cut.shade[v] = static_cast<float>(piece[v].shade);
    }
    out.push_back(cut);
  }
}

struct ChunkResult {
  std::size_t placed = 0;
  std::int64_t drawn = 0;
  std::vector<CutTetrahedron> pieces;
  std::vector<PlacedTetrahedron> placed_pieces;  // ids from 0 on
};

void place_chunk(const DrawInput& input, const SegmentView& view, const SegmentOptics& optics, const PlacedMesh& all,
                 std::size_t begin, std::size_t end, PlacedTetrahedron* placed, ChunkResult& result) {
  const IntervalMesh& mesh = *input.mesh;
  const auto points_of = [&](std::size_t t) -> const auto& { return optics.cut ? all.reached[t].points : mesh.tetrahedra[t]; };
  const auto interval_of = [&](std::size_t t) {
    return optics.cut ? all.reached[t].interval : std::uint32_t{mesh.tetrahedron_interval[t]};
  };
  std::vector<std::uint32_t> to_cut(PlacementBatch::kCapacity);
  PlacementBatch batch;
  const auto flush = [&] {
    std::size_t cuts = 0;
    result.placed += place_tetrahedra(view, batch, placed + result.placed, to_cut.data(), &cuts);
    for (std::size_t c = 0; c < cuts; ++c)
      cut_tetrahedron(input, view, all, points_of(to_cut[c]), interval_of(to_cut[c]), result.pieces);
    batch.count = 0;
  };
  for (std::size_t t = begin; t < end; ++t) {
    if (optics.group[interval_of(t)] < 0) continue;
    ++result.drawn;
    const auto& ids = points_of(t);
    batch.id[batch.count] = static_cast<std::uint32_t>(t);
    for (std::size_t v = 0; v < 4; ++v) batch.vertex[v][batch.count] = all.points[ids[v]];
    if (++batch.count == PlacementBatch::kCapacity) flush();
  }
  flush();
}

/// Fills out.reached and projects the points that it uses, by blocks of them. The work is that of what is reached, and a look at
/// each block of tetrahedra.
void reach_and_project(const DrawInput& input, const SegmentView& view, const SegmentOptics& optics, PlacedMesh& out) {
  const IntervalMesh& mesh = *input.mesh;
  std::vector<ReachOf> drawn;
  const std::vector<ValueBounds> bounds = value_bounds(input.cut_intervals);
  for (std::size_t i = 0; i < bounds.size(); ++i)
    if (optics.group[i] >= 0) drawn.push_back({bounds[i], static_cast<std::uint32_t>(i)});
  const std::size_t blocks = input.base->ranges.block_least.size(), chunk_count = (blocks + kReachBlocks - 1) / kReachBlocks;
  std::vector<std::vector<Reach>> reached(chunk_count);
  parallel_for(static_cast<std::int64_t>(chunk_count), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c)
      reach_tetrahedra(input.base->ranges, c * kReachBlocks, std::min(blocks, (c + 1) * kReachBlocks), drawn, reached[c]);
  });
  std::vector<std::size_t> first(chunk_count + 1, 0);
  for (std::size_t c = 0; c < chunk_count; ++c) first[c + 1] = first[c] + reached[c].size();
  if (first.back() > 0xffffffffu)
    throw Error(ErrorCode::too_large, "picture: more than 4294967295 tetrahedra in all its intervals together");
  out.reached.resize(first.back());
  constexpr std::size_t kPoints = 256;  // of a block
  const std::size_t point_blocks = (mesh.positions.size() + kPoints - 1) / kPoints;
  std::vector<std::atomic<bool>> used(point_blocks);
  parallel_for(static_cast<std::int64_t>(chunk_count), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c)
      for (std::size_t i = 0; i < reached[c].size(); ++i) {
        const auto& points = mesh.tetrahedra[reached[c][i].tetrahedron];
        out.reached[first[c] + i] = {points, reached[c][i].interval};
        for (const std::uint32_t point : points) used[point / kPoints].store(true, std::memory_order_relaxed);
      }
  });
  parallel_for(static_cast<std::int64_t>(point_blocks), 32, [&](std::int64_t begin, std::int64_t end) {
    for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b)
      if (used[b].load(std::memory_order_relaxed))
        project_vertices(view, mesh.positions.data(), input.color_values->data(), b * kPoints,
                         std::min(mesh.positions.size(), (b + 1) * kPoints), out.points.data());
  });
}

void place_pieces(const SegmentView& view, ChunkResult& result) {
  const auto& pieces = result.pieces;
  result.placed_pieces.resize(pieces.size());
  std::vector<std::uint32_t> ignored(PlacementBatch::kCapacity);
  std::size_t count = 0;
  PlacementBatch batch;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    batch.id[batch.count] = static_cast<std::uint32_t>(i);
    for (std::size_t v = 0; v < 4; ++v) batch.vertex[v][batch.count] = pieces[i].vertex[v];
    if (++batch.count < PlacementBatch::kCapacity && i + 1 < pieces.size()) continue;
    std::size_t cuts = 0;
    count += place_tetrahedra(view, batch, result.placed_pieces.data() + count, ignored.data(), &cuts);
    batch.count = 0;
  }
  result.placed_pieces.resize(count);
}

}  // namespace

void fill_bins(const std::vector<std::span<const PlacedTetrahedron>>& chunks, int tiles_x, int tiles_y, TileBins& bins) {
  const std::size_t tiles = static_cast<std::size_t>(tiles_x) * static_cast<std::size_t>(tiles_y);
  // Fewer, longer chunks if there are many tiles: a count for each chunk and tile.
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
  out.shades = shades_bodies(input) ? body_shades(input) : Buffer<float>{};
  const float* const values = input.color_values ? input.color_values->data() : nullptr;
  if (optics.cut)
    reach_and_project(input, view, optics, out);
  else
    parallel_for(static_cast<std::int64_t>(mesh.positions.size()), 8192, [&](std::int64_t begin, std::int64_t end) {
      project_vertices(view, mesh.positions.data(), values, static_cast<std::size_t>(begin), static_cast<std::size_t>(end),
                       out.points.data());
    });
  const std::size_t count = optics.cut ? out.reached.size() : mesh.tetrahedra.size(), chunk_count = (count + kChunk - 1) / kChunk;
  out.first_piece = count;
  out.placed.resize(count);
  std::vector<ChunkResult> results(chunk_count);
  parallel_for(static_cast<std::int64_t>(chunk_count), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
      const std::size_t first = c * kChunk, last = std::min(count, first + kChunk);
      place_chunk(input, view, optics, out, first, last, out.placed.data() + first, results[c]);
      place_pieces(view, results[c]);
    }
  });
  out.drawn = 0;
  std::vector<std::size_t> first_piece(chunk_count + 1, 0);
  std::vector<std::span<const PlacedTetrahedron>> chunks;
  for (std::size_t c = 0; c < chunk_count; ++c) {
    out.drawn += results[c].drawn;
    first_piece[c + 1] = first_piece[c] + results[c].pieces.size();
    chunks.push_back(std::span(out.placed).subspan(c * kChunk, results[c].placed));
    chunks.push_back(results[c].placed_pieces);
  }
  if (out.first_piece + first_piece.back() > 0xffffffffu)
    throw Error(ErrorCode::too_large, "picture: more than 4294967295 tetrahedra and pieces of them");
  out.pieces.resize(first_piece.back());
  parallel_for(static_cast<std::int64_t>(chunk_count), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
      std::copy(results[c].pieces.begin(), results[c].pieces.end(),
                out.pieces.begin() + static_cast<std::ptrdiff_t>(first_piece[c]));
      for (PlacedTetrahedron& placed : results[c].placed_pieces)
        placed.id += static_cast<std::uint32_t>(out.first_piece + first_piece[c]);
    }
  });
  fill_bins(chunks, out.tiles_x, out.tiles_y, out.bins);
}

}  // namespace isostrata
