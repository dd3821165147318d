#include "extraction/surfaces/interval_surfaces.h"

#include <algorithm>
#include <array>

#include "base/parallel.h"

namespace isostrata {
namespace {

/// Where intervals end or begin: between values below `from` and the others.
struct Threshold {
  float from = 0;
  double value = 0;                             // the surface is where the field has this value
  std::vector<std::uint16_t> end_of, begin_of;  // intervals

  bool beyond(float f) const { return f >= from; }
};

std::vector<Threshold> thresholds_of(std::span<const Interval> intervals, std::span<const ValueBounds> bounds) {
  std::vector<Threshold> all;
  const auto at = [&](float from, double value) -> Threshold& {
    for (Threshold& known : all)
      if (known.from == from && known.value == value) return known;
    all.push_back({from, value, {}, {}});
    return all.back();
  };
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    at(bounds[i].begin, intervals[i].lower).begin_of.push_back(static_cast<std::uint16_t>(i));
    at(bounds[i].end, intervals[i].upper).end_of.push_back(static_cast<std::uint16_t>(i));
  }
  return all;
}

struct Piece {
  std::vector<Vec3d> positions;
  std::vector<Vec3f> normals;         // of those, if they are wanted
  std::vector<BoundaryFacet> facets;  // points from 0 on
  std::vector<std::int64_t> active;   // [intervals] cells
};

class Cutter {
 public:
  Cutter(const BaseTetrahedra& base, std::span<const Interval> intervals, const SurfaceNormals* normals)
      : base_(base),
        directions_(normals ? normals->at_base : std::span<const Vec3f>{}),
        intervals_(intervals.begin(), intervals.end()),
        bounds_(value_bounds(intervals)),
        thresholds_(thresholds_of(intervals, bounds_)) {}

  /// With the number of active cells.
  void cut_block(std::size_t block, Piece& out) const {
    const std::size_t first = block * TetrahedronRanges::kBlock,
                      last = std::min(base_.mesh->tetrahedra.size(), first + TetrahedronRanges::kBlock);
    const TetrahedronRanges& ranges = base_.ranges;
    out.active.resize(intervals_.size(), 0);
    for (std::size_t i = 0; i < bounds_.size(); ++i)
      if (ranges.block_reaches(block, bounds_[i]))
        for (std::size_t t = first; t < last; ++t) out.active[i] += ranges.reaches(t, bounds_[i]);
    for (const Threshold& threshold : thresholds_) {
      if (!threshold.beyond(ranges.block_most[block]) || threshold.beyond(ranges.block_least[block])) continue;
      for (std::size_t t = first; t < last; ++t)
        if (threshold.beyond(ranges.most[t]) && !threshold.beyond(ranges.least[t])) cut_tetrahedron(t, threshold, out);
    }
  }

  void cut_facet(const BoundaryFacet& facet, Piece& out) const {
    float f[3];
    for (std::size_t v = 0; v < 3; ++v) f[v] = (*base_.values)[facet.points[v]];
    const float least = std::min({f[0], f[1], f[2]}), most = std::max({f[0], f[1], f[2]});
    for (std::size_t i = 0; i < bounds_.size(); ++i) {
      if (!(most >= bounds_[i].begin && least < bounds_[i].end)) continue;
      // Corners inside stay; along each edge come the points where the interval begins and ends, in the edge's direction.
      const auto point = static_cast<std::uint32_t>(out.positions.size());
      for (std::size_t v = 0; v < 3; ++v) {
        const std::size_t w = (v + 1) % 3;
        const int from = side(f[v], i), to = side(f[w], i);
        if (from == 0) put_point(facet.points[v], out);
        const auto put = [&](double value) { put_crossing(facet.points[v], facet.points[w], value, out); };
        if (from < 0 && to >= 0) put(intervals_[i].lower);
        if (from <= 0 && to > 0) put(intervals_[i].upper);
        if (from > 0 && to <= 0) put(intervals_[i].upper);
        if (from >= 0 && to < 0) put(intervals_[i].lower);
      }
      const auto count = static_cast<std::uint32_t>(out.positions.size()) - point;
      for (std::uint32_t c = 2; c < count; ++c)
        add({point, point + c - 1, point + c}, static_cast<std::uint16_t>(i), FacetLabel::domain, out);
    }
  }

 private:
  /// -1: below interval i, 0: in it, 1: above.
  int side(float f, std::size_t i) const { return f < bounds_[i].begin ? -1 : f < bounds_[i].end ? 0 : 1; }

  void put_point(std::uint32_t p, Piece& out) const {
    out.positions.push_back(base_.mesh->positions[p]);
    if (!directions_.empty()) out.normals.push_back(directions_[p]);
  }

  void put_crossing(std::uint32_t a, std::uint32_t b, double value, Piece& out) const {
    if (a > b) std::swap(a, b);
    const double from = double{(*base_.values)[a]}, to = double{(*base_.values)[b]};
    const double weight = std::clamp((value - from) / (to - from), 0.0, 1.0);
    out.positions.push_back(lerp(base_.mesh->positions[a], base_.mesh->positions[b], weight));
    if (directions_.empty()) return;
    const Vec3f at_a = directions_[a], at_b = directions_[b];
    if (at_a == Vec3f{} || at_b == Vec3f{}) {
      out.normals.push_back(at_a == Vec3f{} ? at_b : at_a);
      return;
    }
    const Vec3f between = lerp(at_a, at_b, static_cast<float>(weight));
    const float size = length(between);
    out.normals.push_back(size > 0 ? between / size : Vec3f{});
  }

  static void add(std::array<std::uint32_t, 3> points, std::uint16_t interval, FacetLabel label, Piece& out) {
    out.facets.push_back({points, 0, interval, label, interval});
  }

  /// Turned towards the values below the threshold.
  void add_surface(const Threshold& threshold, std::array<std::uint32_t, 3> points, Piece& out) const {
    for (const std::uint16_t interval : threshold.begin_of) add(points, interval, FacetLabel::lower, out);
    for (const std::uint16_t interval : threshold.end_of)
      add({points[0], points[2], points[1]}, interval, FacetLabel::upper, out);
  }

  void cut_tetrahedron(std::size_t t, const Threshold& threshold, Piece& out) const {
    const auto& ids = base_.mesh->tetrahedra[t];
    unsigned beyond = 0;
    for (unsigned v = 0; v < 4; ++v) beyond |= unsigned{threshold.beyond((*base_.values)[ids[v]])} << v;
    // As an even permutation (p, q, r, s) of the vertices: p alone on its side, or p and q on theirs.
    static constexpr std::uint8_t kAlone[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 0, 1, 3}, {3, 0, 2, 1}};
    static constexpr std::uint8_t kPairs[3][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}};  // with vertex 0
    const auto point = static_cast<std::uint32_t>(out.positions.size());
    const auto put = [&](unsigned from, unsigned to) { put_crossing(ids[from], ids[to], threshold.value, out); };
    const int count = __builtin_popcount(beyond);
    if (count != 2) {
      const unsigned alone = static_cast<unsigned>(__builtin_ctz(count == 1 ? beyond : ~beyond & 15u));
      const std::uint8_t* const p = kAlone[alone];
      for (int i = 1; i < 4; ++i) put(p[0], p[i]);
      // (pq, pr, ps) of a positive tetrahedron is turned away from p.
      const std::uint32_t turn = count == 1 ? 0 : 1;
      add_surface(threshold, {point, point + 1 + turn, point + 2 - turn}, out);
      return;
    }
    const bool with_0 = beyond & 1u;
    const unsigned pair = with_0 ? beyond : ~beyond & 15u;
    const std::uint8_t* const p = kPairs[pair == 3 ? 0 : pair == 5 ? 1 : 2];
    // Around the quadrilateral, turned away from the edge p-q.
    put(p[0], p[2]);
    put(p[0], p[3]);
    put(p[1], p[3]);
    put(p[1], p[2]);
    const std::uint32_t turn = with_0 ? 0 : 1;
    for (std::uint32_t c = 1; c < 3; ++c) add_surface(threshold, {point, point + c + turn, point + c + 1 - turn}, out);
  }

  const BaseTetrahedra& base_;
  const std::span<const Vec3f> directions_;  // at the base mesh's points; empty if no normals are wanted
  const std::vector<Interval> intervals_;
  const std::vector<ValueBounds> bounds_;
  const std::vector<Threshold> thresholds_;
};

}  // namespace

IntervalMesh interval_surfaces(const BaseTetrahedra& base, std::span<const Interval> intervals, SurfaceNormals* normals) {
  constexpr std::size_t kBlocks = 128, kFacets = 8192;  // of a chunk
  const Cutter cutter(base, intervals, normals);
  const std::size_t blocks = base.ranges.block_least.size(), block_chunks = (blocks + kBlocks - 1) / kBlocks,
                    facets = base.mesh->facets.size(), chunks = block_chunks + (facets + kFacets - 1) / kFacets;
  std::vector<Piece> pieces(chunks);
  parallel_for(static_cast<std::int64_t>(chunks), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
      if (c < block_chunks) {
        for (std::size_t b = c * kBlocks; b < std::min(blocks, (c + 1) * kBlocks); ++b) cutter.cut_block(b, pieces[c]);
        continue;
      }
      const std::size_t first = (c - block_chunks) * kFacets;
      for (std::size_t f = first; f < std::min(facets, first + kFacets); ++f) cutter.cut_facet(base.mesh->facets[f], pieces[c]);
    }
  });
  std::vector<std::size_t> first_point(chunks + 1, 0), first_facet(chunks + 1, 0);
  for (std::size_t c = 0; c < chunks; ++c) {
    first_point[c + 1] = first_point[c] + pieces[c].positions.size();
    first_facet[c + 1] = first_facet[c] + pieces[c].facets.size();
  }
  if (std::max(first_point.back(), first_facet.back()) > 0xffffffffu)
    throw Error(ErrorCode::too_large, "the surfaces of the intervals have more than 4294967295 points or facets");
  IntervalMesh mesh;
  mesh.positions.resize(first_point.back());
  mesh.facets.resize(first_facet.back());
  if (normals) normals->normals.resize(first_point.back());
  parallel_for(static_cast<std::int64_t>(chunks), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
      std::copy(pieces[c].positions.begin(), pieces[c].positions.end(),
                mesh.positions.begin() + static_cast<std::ptrdiff_t>(first_point[c]));
      if (normals)
        std::copy(pieces[c].normals.begin(), pieces[c].normals.end(),
                  normals->normals.begin() + static_cast<std::ptrdiff_t>(first_point[c]));
      for (std::size_t f = 0; f < pieces[c].facets.size(); ++f) {
        BoundaryFacet facet = pieces[c].facets[f];
        for (std::uint32_t& point : facet.points) point += static_cast<std::uint32_t>(first_point[c]);
        mesh.facets[first_facet[c] + f] = facet;
      }
    }
  });
  mesh.cells = base.mesh->cells;
  mesh.summaries.resize(intervals.size());
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    mesh.summaries[i].interval = intervals[i];
    for (std::size_t c = 0; c < block_chunks; ++c) mesh.summaries[i].active_cells += pieces[c].active[i];
    mesh.summaries[i].tetrahedra = mesh.summaries[i].active_cells;
  }
  return mesh;
}

}  // namespace isostrata
