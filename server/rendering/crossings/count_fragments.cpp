#include "rendering/crossings/count_fragments.h"

#include <atomic>

#include "base/parallel.h"
#include "rendering/crossings/facet_spans.h"

namespace isostrata {

std::int64_t count_fragments(const IntervalMesh& mesh, std::span<const ScreenVertex> vertices, const ScreenTransform& transform,
                             std::span<const std::uint8_t> drawn) {
  std::atomic<std::int64_t> total{0};
  const PixelRect picture{0, 0, transform.width, transform.height};
  parallel_for(static_cast<std::int64_t>(mesh.tetrahedra.size()), 4096, [&](std::int64_t begin, std::int64_t end) {
    std::int64_t covered = 0;
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      if (!drawn[mesh.tetrahedron_interval[t]]) continue;
      const auto& p = mesh.tetrahedra[t];
      const ScreenVertex v[4] = {vertices[p[0]], vertices[p[1]], vertices[p[2]], vertices[p[3]]};
      if (v[0].q == 0 || v[1].q == 0 || v[2].q == 0 || v[3].q == 0) continue;
      const auto add = [&](int, int first, int last, bool) { covered += last - first; };
      scan_facet(v[1], v[2], v[3], picture, add);
      scan_facet(v[0], v[3], v[2], picture, add);
      scan_facet(v[0], v[1], v[3], picture, add);
      scan_facet(v[0], v[2], v[1], picture, add);
    }
    total.fetch_add(covered, std::memory_order_relaxed);
  });
  return total.load() / 2;
}

}  // namespace isostrata
