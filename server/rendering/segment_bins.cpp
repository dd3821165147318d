#include "rendering/segment_bins.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "rendering/clip_tetrahedron.h"

namespace isostrata {
namespace {

constexpr std::size_t kChunk = 8192;  // tetrahedra

/// Cut where the picture's pyramid of view ends, and sliced by depth: the difference of two inverse depths loses the digits by
/// which they differ in size.
void cut_tetrahedron(const DrawInput& input, const SegmentView& view, std::uint32_t id, std::uint32_t interval,
                     std::vector<CutTetrahedron>& out) {
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
    cut.interval = interval;
    for (std::size_t v = 0; v < 4; ++v) cut.vertex[v] = view.screen(piece[v].position, piece[v].scalar);
    out.push_back(cut);
  }
}

struct ChunkResult {
  std::size_t placed = 0;
  std::int64_t drawn = 0;
  std::vector<CutTetrahedron> pieces;
  std::vector<PlacedTetrahedron> placed_pieces;  // ids from 0 on
};

void place_chunk(const DrawInput& input, const SegmentView& view, const SegmentOptics& optics, const ScreenVertex* points,
                 std::size_t begin, std::size_t end, PlacedTetrahedron* placed, ChunkResult& result) {
  const IntervalMesh& mesh = *input.mesh;
  std::vector<std::uint32_t> to_cut(PlacementBatch::kCapacity);
  PlacementBatch batch;
  const auto flush = [&] {
    std::size_t cuts = 0;
    result.placed += place_tetrahedra(view, batch, placed + result.placed, to_cut.data(), &cuts);
    for (std::size_t c = 0; c < cuts; ++c)
      cut_tetrahedron(input, view, to_cut[c], mesh.tetrahedron_interval[to_cut[c]], result.pieces);
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
}

/// A piece for each interval that each tetrahedron reaches into.
void reach_into_intervals(const DrawInput& input, const SegmentView& view, const SegmentOptics& optics,
                          std::span<const ValueRange> blocks, const ScreenVertex* points, std::size_t begin, std::size_t end,
                          ChunkResult& result) {
  const std::vector<float>& values = *input.color_values;
  for (std::size_t t = begin; t < end; ++t) {
    const auto reaches = [&](float least, float most, std::size_t i) {
      return optics.group[i] >= 0 && double{most} > input.cut_intervals[i].lower && double{least} < input.cut_intervals[i].upper;
    };
    if (t % kRangeBlock == 0) {
      const ValueRange& block = blocks[t / kRangeBlock];
      bool any = false;
      for (std::size_t i = 0; i < input.cut_intervals.size() && !any; ++i) any = reaches(block.least, block.most, i);
      if (!any) {
        t += kRangeBlock - 1;
        continue;
      }
    }
    const auto& ids = input.mesh->tetrahedra[t];
    const float a = values[ids[0]], b = values[ids[1]], c = values[ids[2]], d = values[ids[3]];
    if (std::isnan(a + b + c + d)) continue;
    const float least = std::min({a, b, c, d}), most = std::max({a, b, c, d});
    for (std::size_t i = 0; i < input.cut_intervals.size(); ++i) {
      if (!reaches(least, most, i)) continue;
      ++result.drawn;
      CutTetrahedron whole;
      whole.interval = static_cast<std::uint32_t>(i);
      bool seen = true;
      int behind = 0;
      float q_least = 1e30f, q_most = -1e30f;
      for (std::size_t v = 0; v < 4; ++v) {
        whole.vertex[v] = points[ids[v]];
        seen = seen && !std::isnan(whole.vertex[v].x);
        behind += std::isnan(whole.vertex[v].x) && whole.vertex[v].y == kTooNearToSee;
        q_least = std::min(q_least, whole.vertex[v].q);
        q_most = std::max(q_most, whole.vertex[v].q);
      }
      if (seen && (view.orthographic || q_most <= kDepthRatio * q_least))
        result.pieces.push_back(whole);
      else if (behind < 4)
        cut_tetrahedron(input, view, static_cast<std::uint32_t>(t), whole.interval, result.pieces);
    }
  }
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

void place_mesh(const DrawInput& input, const SegmentView& view, const SegmentOptics& optics, std::span<const ValueRange> blocks,
                PlacedMesh& out) {
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
  out.first_piece = optics.cut ? 0 : count;
  out.placed.resize(out.first_piece);
  std::vector<ChunkResult> results(chunk_count);
  parallel_for(static_cast<std::int64_t>(chunk_count), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
      const std::size_t first = c * kChunk, last = std::min(count, first + kChunk);
      if (optics.cut)
        reach_into_intervals(input, view, optics, blocks, out.points.data(), first, last, results[c]);
      else
        place_chunk(input, view, optics, out.points.data(), first, last, out.placed.data() + first, results[c]);
      place_pieces(view, results[c]);
    }
  });
  out.drawn = 0;
  std::vector<std::size_t> first_piece(chunk_count + 1, 0);
  std::vector<std::span<const PlacedTetrahedron>> chunks;
  for (std::size_t c = 0; c < chunk_count; ++c) {
    out.drawn += results[c].drawn;
    first_piece[c + 1] = first_piece[c] + results[c].pieces.size();
    if (!optics.cut) chunks.push_back(std::span(out.placed).subspan(c * kChunk, results[c].placed));
    chunks.push_back(results[c].placed_pieces);
  }
  if (out.first_piece + first_piece.back() > 0xffffffffu)
    throw Error(ErrorCode::too_large, "picture: more than 4294967295 tetrahedra and pieces of them");
  out.pieces.resize(first_piece.back());
  parallel_for(static_cast<std::int64_t>(chunk_count), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
      std::copy(results[c].pieces.begin(), results[c].pieces.end(), out.pieces.begin() + static_cast<std::ptrdiff_t>(first_piece[c]));
      for (PlacedTetrahedron& placed : results[c].placed_pieces)
        placed.id += static_cast<std::uint32_t>(out.first_piece + first_piece[c]);
    }
  });
  fill_bins(chunks, out.tiles_x, out.tiles_y, out.bins);
}

}  // namespace isostrata
