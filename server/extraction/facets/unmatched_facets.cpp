// Checks that the facets of an interval mesh meet. A facet lies with its smallest point: of a tetrahedron with points
// a < b < c < d three facets are at a and one is at b. Tetrahedra are listed by the ranges of points that a and b are in, which
// is one range for most, and each range is then matched by itself.
#include <algorithm>
#include <array>
#include <atomic>

#include "base/parallel.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/mesh/match_table.h"
#include "extraction/mesh/partitioned_items.h"

namespace isostrata {
namespace {

/// The points of a tetrahedron in increasing order. Without branches: which way they would go cannot be predicted.
struct SortedPoints {
  std::array<std::uint64_t, 4> keys;  // the point, and in the two lowest bits the vertex that it is
  bool odd = false;                   // the order is an odd permutation of the tetrahedron's

  explicit SortedPoints(const std::array<std::uint32_t, 4>& tetrahedron) {
    for (unsigned v = 0; v < 4; ++v) keys[v] = std::uint64_t{tetrahedron[v]} << 2 | v;
    const auto order = [&](int i, int j) {
      odd ^= keys[j] < keys[i];
      const std::uint64_t lower = std::min(keys[i], keys[j]), upper = std::max(keys[i], keys[j]);
      keys[i] = lower;
      keys[j] = upper;
    };
    order(0, 1);
    order(2, 3);
    order(0, 2);
    order(1, 3);
    order(1, 2);
  }
  std::uint32_t point(int i) const { return static_cast<std::uint32_t>(keys[i] >> 2); }
  int vertex(int i) const { return static_cast<int>(keys[i] & 3); }
};

/// Three points and an interval.
struct MeetingKey {
  std::uint64_t larger = 0;    // the middle point, then the largest
  std::uint32_t smallest = 0;  // the smallest point's place in its range, then the interval

  bool operator==(const MeetingKey& other) const { return larger == other.larger && smallest == other.smallest; }
  std::uint64_t hash() const { return mixed_hash(larger, std::uint64_t{smallest} << 28); }
};

/// The facets of one key, in 16 bytes.
struct FacetMeeting {
  std::uint64_t larger = 0;
  std::uint32_t smallest = 0;
  // Bits 0-1: facets that are not in mesh.facets, up to 3; bits 2-3: those of them whose points, counter-clockwise from outside,
  // are an odd permutation; the rest: facets that are in mesh.facets.
  std::uint32_t state = 0;

  MeetingKey key() const { return {larger, smallest}; }
  void set_key(const MeetingKey& key) {
    larger = key.larger;
    smallest = key.smallest;
  }
  bool used() const { return state != 0; }
  /// Returns how many are unmatched for that beside those of unmatched().
  std::int64_t add(bool is_boundary, bool is_odd) {
    if ((state & kInside) == kInside && !is_boundary) return 1;
    state += is_boundary ? kOneBoundary : 1u + (is_odd ? kOneOdd : 0u);
    return 0;
  }
  /// All, but where all bound, or where two meet from both sides. Boundary facets may coincide where the grid itself does not
  /// conform (a tetrahedron standing on half of a hexahedron's face). Without branches, which could not be predicted.
  std::int64_t unmatched() const {
    const std::uint32_t inside = state & kInside;
    return std::int64_t{inside + state / kOneBoundary} * ((inside != 0) & (state != 2 + kOneOdd));
  }

 private:
  static constexpr std::uint32_t kInside = 3, kOneOdd = 4, kOneBoundary = 16;
};
static_assert(sizeof(FacetMeeting) == 16);

std::vector<std::uint8_t> listed_facets(const IntervalMesh& mesh, const Task& task) {
  std::vector<std::uint8_t> listed(mesh.tetrahedra.size());  // bit i: facet i, opposite vertex i, is in mesh.facets
  parallel_for(static_cast<std::int64_t>(mesh.facets.size()), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t f = begin; f < end; ++f) {
      const BoundaryFacet& facet = mesh.facets[f];
      const auto& points = mesh.tetrahedra[facet.tetrahedron];
      std::uint8_t bits = 0;
      for (int i = 0; i < 4; ++i)
        if (points[i] != facet.points[0] && points[i] != facet.points[1] && points[i] != facet.points[2])
          bits = static_cast<std::uint8_t>(bits | 1u << i);
      std::atomic_ref(listed[facet.tetrahedron]).fetch_or(bits, std::memory_order_relaxed);
    }
  });
  return listed;
}

}  // namespace

std::int64_t count_unmatched_facets(const IntervalMesh& mesh, const Task& task) {
  if (mesh.tetrahedra.empty()) return 0;  // of a flat grid facets are areas, and bound nothing
  const std::vector<std::uint8_t> listed = listed_facets(mesh, task);

  const auto count = static_cast<std::int64_t>(mesh.tetrahedra.size());
  const KeyRanges ranges = KeyRanges::of(static_cast<std::int64_t>(mesh.positions.size()), count);
  const auto at_range =
      partition_items<std::uint32_t>(ranges.parts, count, "the facets of the mesh", ~std::uint64_t{0}, task,
                                     [&](std::int64_t begin, std::int64_t end, const auto& emit) {
                                       for (std::int64_t t = begin; t < end; ++t) {
                                         const auto& p = mesh.tetrahedra[t];
                                         const std::uint32_t low = std::min(p[0], p[1]), high = std::max(p[0], p[1]);
                                         const std::uint32_t low2 = std::min(p[2], p[3]), high2 = std::max(p[2], p[3]);
                                         const std::int64_t first = ranges.part(std::min(low, low2));
                                         const std::int64_t second = ranges.part(std::min({std::max(low, low2), high, high2}));
                                         emit(first, static_cast<std::uint32_t>(t));
                                         if (second != first) emit(second, static_cast<std::uint32_t>(t));
                                       }
                                     });

  std::atomic<std::int64_t> unmatched{0};
  parallel_for(at_range.parts(), 1, [&](std::int64_t begin, std::int64_t end) {
    MatchTable<FacetMeeting> table;
    std::int64_t own = 0;
    for (std::int64_t part = begin; part < end; ++part) {
      task.check();
      table.start(5 * at_range.of(part).size() / 4);  // four facets each, and most meet another
      const auto first = static_cast<std::uint32_t>(part << ranges.shift);
      std::size_t done = 0;
      for (const std::uint32_t t : at_range.of(part)) {
        if (++done % 4096 == 0) task.check();
        const SortedPoints sorted(mesh.tetrahedra[t]);
        const auto facet = [&](int i, int smallest, int middle, int largest) {  // without the i-th point by size
          const std::uint32_t local = sorted.point(smallest) - first;
          if (local >= ranges.width()) return;  // with another range
          const MeetingKey key{std::uint64_t{sorted.point(middle)} << 32 | sorted.point(largest),
                             local << 16 | mesh.tetrahedron_interval[t]};
          // Of a positive tetrahedron the facet (1 2 3) is counter-clockwise from outside, (0 2 3) is not, and so on in turn.
          own += table.at(key).add(listed[t] >> sorted.vertex(i) & 1, sorted.odd != (i % 2 != 0));
        };
        facet(0, 1, 2, 3);
        facet(1, 0, 2, 3);
        facet(2, 0, 1, 3);
        facet(3, 0, 1, 2);
      }
      for (const FacetMeeting& meeting : table.entries()) own += meeting.unmatched();  // 0 if unused
    }
    unmatched.fetch_add(own, std::memory_order_relaxed);
  });
  return unmatched.load();
}

}  // namespace isostrata
