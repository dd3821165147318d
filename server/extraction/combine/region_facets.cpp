#include "extraction/combine/region_facets.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <tuple>

#include "base/parallel.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/mesh/keyed_lists.h"
#include "extraction/mesh/memory_budget.h"

namespace isostrata {
namespace {

constexpr std::int64_t kTetrahedraPerBlock = 8192;

/// A facet under its smallest point.
struct FacetUse {
  std::uint32_t middle, largest;
  std::uint32_t tetrahedron;
  std::uint16_t label;
  std::uint8_t facet;
  bool odd;  // the points, counter-clockwise from outside, are an odd permutation of their sorted order
};

FacetUse facet_use(const RegionMesh& mesh, std::int64_t t, int i, std::uint32_t& smallest) {
  std::array<std::uint32_t, 3> p;
  for (int k = 0; k < 3; ++k) p[k] = mesh.tetrahedra[t][kTetrahedronFacets[i][k]];
  bool odd = false;
  const auto order = [&](int a, int b) {
    if (p[a] > p[b]) {
      std::swap(p[a], p[b]);
      odd = !odd;
    }
  };
  order(0, 1);
  order(1, 2);
  order(0, 1);
  smallest = p[0];
  return {p[1], p[2], static_cast<std::uint32_t>(t), mesh.labels[t], static_cast<std::uint8_t>(i), odd};
}

/// [nt] bit i: facet i has no partner of its label.
std::vector<std::uint8_t> find_single_facets(const RegionMesh& mesh, std::uint64_t max_bytes, const Task& task) {
  std::vector<std::uint8_t> single(mesh.tetrahedra.size());
  auto uses = list_by_key<FacetUse>(mesh.points(), mesh.count(), kTetrahedraPerBlock, "the facets of the mesh", max_bytes,
                                    [&](std::int64_t begin, std::int64_t end, const auto& emit) {
                                      task.check();
                                      for (std::int64_t t = begin; t < end; ++t)
                                        for (int i = 0; i < 4; ++i) {
                                          std::uint32_t smallest;
                                          const FacetUse use = facet_use(mesh, t, i, smallest);
                                          emit(smallest, use);
                                        }
                                    });
  parallel_for(uses.keys(), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t key = begin; key < end; ++key) {
      const auto list = uses.of(key);
      std::sort(list.begin(), list.end(), [](const FacetUse& a, const FacetUse& b) {
        return std::tie(a.middle, a.largest, a.label, a.tetrahedron) < std::tie(b.middle, b.largest, b.label, b.tetrahedron);
      });
      for (std::size_t i = 0; i < list.size();) {
        std::size_t next = i + 1;
        const FacetUse& use = list[i];
        while (next < list.size() && list[next].middle == use.middle && list[next].largest == use.largest &&
               list[next].label == use.label)
          ++next;
        const bool meets = next == i + 2 && list[i].odd != list[i + 1].odd;
        for (; i < next; ++i)
          if (!meets)
            std::atomic_ref(single[list[i].tetrahedron])
                .fetch_or(static_cast<std::uint8_t>(1u << list[i].facet), std::memory_order_relaxed);
      }
    }
  });
  return single;
}

struct Place {
  FacetLabel label = FacetLabel::domain;
  std::uint16_t range = 0;
};

/// Finds the range on whose end a facet lies.
class EndFinder {
 public:
  EndFinder(const RegionMesh& mesh, std::span<const RangeOfField> ranges) : mesh_(mesh), ranges_(ranges) {
    // Those of field 0 may be many (the intervals): found by value. The terms' few are tried one by one.
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const auto range = static_cast<std::uint16_t>(i);
      if (ranges[i].field != 0) {
        others_.push_back(range);
        continue;
      }
      ends_.push_back({ranges[i].range.lower, {FacetLabel::lower, range}});
      ends_.push_back({ranges[i].range.upper, {FacetLabel::upper, range}});
    }
    std::stable_sort(ends_.begin(), ends_.end(), [](const End& a, const End& b) { return a.value < b.value; });
  }

  std::optional<Place> find(const std::array<std::uint32_t, 3>& p, std::uint16_t own) const {
    if (const auto place = on(p, own)) return place;
    if (const auto value = common(p, 0)) {
      const auto at =
          std::lower_bound(ends_.begin(), ends_.end(), *value, [](const End& end, double v) { return end.value < v; });
      if (at != ends_.end() && at->value == *value) return at->place;
    }
    for (const std::uint16_t range : others_)
      if (const auto place = on(p, range)) return place;
    return std::nullopt;
  }

 private:
  struct End {
    double value = 0;
    Place place;
  };

  std::optional<double> common(const std::array<std::uint32_t, 3>& p, int field) const {
    const auto& f = mesh_.fields[field];
    if (f[p[0]] == f[p[1]] && f[p[0]] == f[p[2]]) return f[p[0]];
    return std::nullopt;
  }
  std::optional<Place> on(const std::array<std::uint32_t, 3>& p, std::uint16_t range) const {
    const auto value = common(p, ranges_[range].field);
    if (!value) return std::nullopt;
    if (*value == ranges_[range].range.lower) return Place{FacetLabel::lower, range};
    if (*value == ranges_[range].range.upper) return Place{FacetLabel::upper, range};
    return std::nullopt;
  }

  const RegionMesh& mesh_;
  std::span<const RangeOfField> ranges_;
  std::vector<End> ends_;              // of the ranges of field 0, by value
  std::vector<std::uint16_t> others_;  // ranges of other fields
};

}  // namespace

Buffer<BoundaryFacet> region_facets(const RegionMesh& mesh, std::span<const RangeOfField> ranges,
                                         std::span<const std::uint16_t> own, std::uint64_t max_bytes, const Task& task) {
  task.report(0.9, "facets");
  const std::vector<std::uint8_t> single = find_single_facets(mesh, max_bytes, task);
  const EndFinder ends(mesh, ranges);
  const std::int64_t blocks = (mesh.count() + kTetrahedraPerBlock - 1) / kTetrahedraPerBlock;
  std::vector<Buffer<BoundaryFacet>> found(blocks);
  std::atomic<std::uint64_t> total{0};
  parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t b = begin; b < end; ++b) {
      task.check();
      const std::int64_t last = std::min(mesh.count(), (b + 1) * kTetrahedraPerBlock);
      for (std::int64_t t = b * kTetrahedraPerBlock; t < last; ++t) {
        if (!single[t] && !(mesh.domain_facets[t] & 0xf)) continue;
        for (int i = 0; i < 4; ++i) {
          const std::uint16_t label = mesh.labels[t];
          const auto& v = kTetrahedronFacets[i];
          const std::array<std::uint32_t, 3> points{mesh.tetrahedra[t][v[0]], mesh.tetrahedra[t][v[1]], mesh.tetrahedra[t][v[2]]};
          std::optional<Place> place;
          if (mesh.domain_facets[t] >> i & 1) {
            place = Place{FacetLabel::domain, label};
          } else if (single[t] >> i & 1) {
            place = ends.find(points, own[label]);
            if (!place && (mesh.domain_facets[t] >> (4 + i) & 1)) place = Place{FacetLabel::domain, label};
          }
          if (place) found[b].push_back({points, static_cast<std::uint32_t>(t), label, place->label, place->range});
        }
      }
      const std::uint64_t so_far = total.fetch_add(found[b].size()) + found[b].size();
      check_budget(std::to_string(so_far) + " boundary facets", 2 * so_far * sizeof(BoundaryFacet), max_bytes);
    }
  });
  Buffer<BoundaryFacet> facets;
  facets.reserve(total.load());
  for (auto& some : found) {
    facets.insert(facets.end(), some.begin(), some.end());
    some = {};
  }
  return facets;
}

}  // namespace isostrata
