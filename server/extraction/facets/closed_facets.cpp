// In two steps. Most facets meet their partner in the same cell, whose tetrahedra stand together: those are found by comparing
// within the cell. The rest lie with the range of points that their smallest point is in, and each range is matched by itself.
#include "extraction/facets/closed_facets.h"

#include <algorithm>
#include <array>

#include "base/parallel.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/mesh/match_table.h"
#include "extraction/mesh/partitioned_items.h"

namespace isostrata {
namespace {

constexpr std::int64_t kTetrahedraPerBlock = 1 << 14;
constexpr std::uint32_t kGroup = 16;  // tetrahedra that are compared with each other; many have one cell

/// A facet that has not met another: tetrahedron * 4 + facet.
using FacetName = std::uint64_t;

struct SortedFacet {
  std::array<std::uint32_t, 3> points;  // increasing
  bool odd;                             // an odd permutation of counter-clockwise from outside
};

SortedFacet sorted_facet(const std::array<std::uint32_t, 4>& t, int facet) {
  const auto& v = kTetrahedronFacets[facet];
  SortedFacet s{{t[v[0]], t[v[1]], t[v[2]]}, false};
  const auto order = [&](int i, int j) {
    s.odd ^= s.points[j] < s.points[i];
    const std::uint32_t low = std::min(s.points[i], s.points[j]), high = std::max(s.points[i], s.points[j]);
    s.points[i] = low;
    s.points[j] = high;
  };
  order(0, 1);
  order(1, 2);
  order(0, 1);
  return s;
}

struct FacetKey {
  std::uint64_t larger = 0;
  std::uint32_t smallest = 0;
  std::uint16_t interval = 0;

  bool operator==(const FacetKey&) const = default;
  std::uint64_t hash() const { return mixed_hash(larger, std::uint64_t{smallest} << 16 | interval); }
};

/// Facets of one key that have met none of the other orientation. A second one of the same orientation stays for itself.
struct OpenFacet {
  FacetKey of;
  bool used_ = false, waiting = false, odd = false;
  FacetName name = 0;

  const FacetKey& key() const { return of; }
  void set_key(const FacetKey& key) { of = key; }
  bool used() const { return used_; }
};

/// Of each group of neighbouring tetrahedra, which facets meet none in the group: bit i for facet i.
std::vector<std::uint8_t> open_in_group(const IntervalMesh& mesh, const Task& task) {
  const auto count = static_cast<std::int64_t>(mesh.tetrahedra.size());
  std::vector<std::uint8_t> open(mesh.tetrahedra.size());
  parallel_for(count, kTetrahedraPerBlock, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    // A facet's partner has the same sum of points; so only equal sums are compared in full.
    constexpr std::size_t kSlots = 256;
    struct Slot {
      std::uint32_t stamp = 0;
      std::uint32_t facet = 0;  // 4 * the tetrahedron's place in the group + facet
    };
    std::array<Slot, kSlots> slots{};
    std::uint32_t stamp = 0;
    for (std::int64_t from = begin; from < end; from += kGroup) {
      const std::int64_t to = std::min<std::int64_t>(from + kGroup, end);
      ++stamp;
      for (std::int64_t t = from; t < to; ++t) {
        const auto& points = mesh.tetrahedra[t];
        std::uint8_t bits = 0;
        for (int f = 0; f < 4; ++f) {
          const SortedFacet own = sorted_facet(points, f);
          std::size_t at = static_cast<std::size_t>(
              (own.points[0] * 0x9e3779b1u + own.points[1] * 0x85ebca6bu + own.points[2] * 0xc2b2ae35u) >> 24);
          bool met = false;
          for (; slots[at].stamp == stamp; at = (at + 1) % kSlots) {
            const std::int64_t other = from + slots[at].facet / 4;
            const int other_facet = static_cast<int>(slots[at].facet % 4);
            if (!((other == t ? bits : open[other]) >> other_facet & 1) ||
                mesh.tetrahedron_interval[other] != mesh.tetrahedron_interval[t])
              continue;
            const SortedFacet theirs = sorted_facet(mesh.tetrahedra[other], other_facet);
            if (theirs.points != own.points || theirs.odd == own.odd) continue;
            (other == t ? bits : open[other]) &= static_cast<std::uint8_t>(~(1u << other_facet));
            met = true;
            break;
          }
          if (met) continue;
          while (slots[at].stamp == stamp) at = (at + 1) % kSlots;
          slots[at] = {stamp, static_cast<std::uint32_t>(4 * (t - from) + f)};
          bits = static_cast<std::uint8_t>(bits | 1u << f);
        }
        open[t] = bits;
      }
    }
  });
  return open;
}

}  // namespace

Buffer<BoundaryFacet> find_closed_facets(const IntervalMesh& mesh, const Task& task) {
  std::vector<std::uint8_t> open = open_in_group(mesh, task);
  const auto count = static_cast<std::int64_t>(mesh.tetrahedra.size());
  const KeyRanges ranges = KeyRanges::of(static_cast<std::int64_t>(mesh.positions.size()), count);
  const auto at_range = partition_items<FacetName>(
      ranges.parts, count, "the facets of the mesh", ~std::uint64_t{0}, task,
      [&](std::int64_t begin, std::int64_t end, const auto& emit) {
        for (std::int64_t t = begin; t < end; ++t)
          for (int f = 0; f < 4; ++f) {
            if (!(open[t] >> f & 1)) continue;
            const auto& points = mesh.tetrahedra[t];
            const auto& v = kTetrahedronFacets[f];
            emit(ranges.part(std::min({points[v[0]], points[v[1]], points[v[2]]})), static_cast<FacetName>(4 * t + f));
          }
      });
  std::vector<std::vector<FacetName>> left(at_range.parts());
  parallel_for(at_range.parts(), 1, [&](std::int64_t begin, std::int64_t end) {
    MatchTable<OpenFacet> table;
    for (std::int64_t part = begin; part < end; ++part) {
      task.check();
      table.start(at_range.of(part).size());
      for (const FacetName name : at_range.of(part)) {
        const SortedFacet facet = sorted_facet(mesh.tetrahedra[name / 4], static_cast<int>(name % 4));
        OpenFacet& entry = table.at(FacetKey{std::uint64_t{facet.points[1]} << 32 | facet.points[2], facet.points[0],
                                             mesh.tetrahedron_interval[name / 4]});
        entry.used_ = true;
        if (entry.waiting && entry.odd != facet.odd) {
          entry.waiting = false;
        } else {
          if (entry.waiting) left[part].push_back(entry.name);
          entry.waiting = true;
          entry.odd = facet.odd;
          entry.name = name;
        }
      }
      for (const OpenFacet& entry : table.entries())
        if (entry.waiting) left[part].push_back(entry.name);
    }
  });
  // Back into the order of the tetrahedra, whatever the hashes: bits again.
  std::fill(open.begin(), open.end(), std::uint8_t{0});
  std::size_t total = 0;
  for (const auto& part : left) {
    total += part.size();
    for (const FacetName name : part) open[name / 4] = static_cast<std::uint8_t>(open[name / 4] | 1u << (name % 4));
  }
  Buffer<BoundaryFacet> facets;
  facets.reserve(total);
  for (std::int64_t t = 0; t < count; ++t)
    for (int f = 0; open[t] != 0 && f < 4; ++f) {
      if (!(open[t] >> f & 1)) continue;
      const auto& points = mesh.tetrahedra[t];
      const auto& v = kTetrahedronFacets[f];
      const std::uint16_t interval = mesh.tetrahedron_interval[t];
      facets.push_back(
          {{points[v[0]], points[v[1]], points[v[2]]}, static_cast<std::uint32_t>(t), interval, FacetLabel::domain, interval});
    }
  return facets;
}

}  // namespace isostrata
