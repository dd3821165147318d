#include "rendering/crossings/facet_chunks.h"

#include <algorithm>

#include "base/parallel.h"
#include "extraction/facets/closed_facets.h"

namespace isostrata {
namespace {

constexpr std::uint32_t kFacetsPerChunk = 64;

/// Where each facet goes, so that they stand by interval: counts by blocks, then places.
void place_facets(const Buffer<BoundaryFacet>& facets, std::size_t intervals, FacetSet& set,
                  std::vector<std::uint32_t>& first) {
  constexpr std::int64_t kPerBlock = 1 << 15;
  const auto count = static_cast<std::int64_t>(facets.size());
  const std::int64_t blocks = std::max<std::int64_t>((count + kPerBlock - 1) / kPerBlock, 1);
  std::vector<std::uint32_t> next(static_cast<std::size_t>(blocks) * intervals);  // [blocks][intervals]
  const auto each_block = [&](const auto& visit) {
    parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t b = begin; b < end; ++b) {
        std::uint32_t* const own = next.data() + static_cast<std::size_t>(b) * intervals;
        for (std::int64_t f = b * kPerBlock; f < std::min(count, (b + 1) * kPerBlock); ++f)
          visit(own[facets[static_cast<std::size_t>(f)].interval], facets[static_cast<std::size_t>(f)]);
      }
    });
  };
  each_block([](std::uint32_t& counter, const BoundaryFacet&) { ++counter; });
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < intervals; ++i) {
    first.push_back(sum);
    for (std::size_t b = 0; b < static_cast<std::size_t>(blocks); ++b) {
      const std::uint32_t own = next[b * intervals + i];
      next[b * intervals + i] = sum;
      sum += own;
    }
  }
  first.push_back(sum);
  each_block([&](std::uint32_t& to, const BoundaryFacet& facet) {
    const auto& p = facet.points;
    const std::size_t least = p[0] < p[1] ? (p[0] < p[2] ? 0 : 2) : (p[1] < p[2] ? 1 : 2);
    set.points[to] = {p[least], p[(least + 1) % 3], p[(least + 2) % 3]};
    set.parts[to] = facet_part(facet.interval, facet.label);
    ++to;
  });
}

}  // namespace

FacetSet make_facet_set(const IntervalMesh& mesh, FacetsAre are) {
  FacetSet set;
  const std::size_t intervals = mesh.summaries.size();
  Buffer<BoundaryFacet> found;
  if (mesh.facets.empty() && !mesh.tetrahedra.empty()) found = find_closed_facets(mesh, Task());
  const Buffer<BoundaryFacet>& facets = mesh.facets.empty() ? found : mesh.facets;
  set.points.resize(facets.size());
  set.parts.resize(facets.size());
  std::vector<std::uint32_t> first;
  place_facets(facets, intervals, set, first);

  for (std::size_t i = 0; i < intervals; ++i) {
    set.first_chunk.push_back(static_cast<std::uint32_t>(set.chunks.size()));
    for (std::uint32_t f = first[i]; f < first[i + 1]; f += kFacetsPerChunk)
      set.chunks.push_back({f, std::min(f + kFacetsPerChunk, first[i + 1]), static_cast<std::uint16_t>(i), {}});
  }
  set.first_chunk.push_back(static_cast<std::uint32_t>(set.chunks.size()));

  std::vector<double> volume(set.chunks.size());
  const Vec3d origin = mesh.positions.empty() ? Vec3d{} : mesh.positions[0];
  parallel_for(static_cast<std::int64_t>(set.chunks.size()), 64, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
      FacetChunk& chunk = set.chunks[c];
      for (std::uint32_t f = chunk.first; f < chunk.end; ++f) {
        const Vec3d p = mesh.positions[set.points[f][0]], q = mesh.positions[set.points[f][1]],
                    r = mesh.positions[set.points[f][2]];
        chunk.bounds.include(p);
        chunk.bounds.include(q);
        chunk.bounds.include(r);
        volume[c] += dot(p - origin, cross(q - origin, r - origin));
      }
    }
  });
  for (const FacetChunk& chunk : set.chunks) {
    set.bounds.include(chunk.bounds.lower);
    set.bounds.include(chunk.bounds.upper);
  }
  for (std::size_t i = 0; i < intervals; ++i) {
    double sum = 0;
    for (std::uint32_t c = set.first_chunk[i]; c < set.first_chunk[i + 1]; ++c) sum += volume[c];
    if (!(sum < 0) || are == FacetsAre::part) continue;
    for (std::uint32_t f = first[i]; f < first[i + 1]; ++f) std::swap(set.points[f][1], set.points[f][2]);
  }
  return set;
}

void facet_normals(const FacetSet& set, const IntervalMesh& mesh, Buffer<Vec3f>& normals) {
  normals.resize(set.points.size());
  parallel_for(static_cast<std::int64_t>(set.points.size()), 1 << 13, [&](std::int64_t begin, std::int64_t end) {
    for (auto f = static_cast<std::size_t>(begin); f < static_cast<std::size_t>(end); ++f) normals[f] = facet_normal(set.points[f], mesh);
  });
}

}  // namespace isostrata
