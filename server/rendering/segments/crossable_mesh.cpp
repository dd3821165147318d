#include "rendering/segments/crossable_mesh.h"

#include <algorithm>
#include <atomic>
#include <mutex>

#include "base/parallel.h"
#include "extraction/facets/closed_facets.h"

namespace isostrata {

CrossableMesh make_crossable(const IntervalMesh& mesh) {
  CrossableMesh out;
  Buffer<BoundaryFacet> found;
  if (mesh.facets.empty()) found = find_closed_facets(mesh, Task());
  const Buffer<BoundaryFacet>& facets = mesh.facets.empty() ? found : mesh.facets;
  // Rays that leave and enter all the time, thin layers, have more crossings than tetrahedra are worth.
  constexpr std::size_t kTetrahedraPerFacet = 2;
  if (facets.size() * kTetrahedraPerFacet > mesh.tetrahedra.size()) return out;
  constexpr double kFew = 0.01;  // of the volume; where more is turned over the tetrahedra are drawn one by one
  double positive = 0, negative = 0;
  std::mutex mutex;
  out.surface.resize(mesh.tetrahedra.size());
  parallel_for(static_cast<std::int64_t>(mesh.tetrahedra.size()), 32768, [&](std::int64_t begin, std::int64_t end) {
    double sums[2] = {};
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      out.surface[t] = 0;
      const auto& p = mesh.tetrahedra[t];
      const Vec3d a = mesh.positions[p[0]];
      const double volume = dot(mesh.positions[p[1]] - a, cross(mesh.positions[p[2]] - a, mesh.positions[p[3]] - a));
      sums[volume < 0] += volume;
    }
    const std::lock_guard lock(mutex);
    positive += sums[0];
    negative -= sums[1];
  });
  out.mirrored = negative > positive;
  if (!(std::min(positive, negative) <= kFew * std::max(positive, negative))) return out;

  // Facets of one tetrahedron may lie far from one another.
  std::atomic<bool> fits = true;
  parallel_for(static_cast<std::int64_t>(facets.size()), 32768, [&](std::int64_t begin, std::int64_t end) {
    for (auto f = static_cast<std::size_t>(begin); f < static_cast<std::size_t>(end); ++f) {
      const BoundaryFacet& facet = facets[f];
      if (facet.tetrahedron >= mesh.tetrahedra.size()) {
        fits = false;
        return;
      }
      const auto& p = mesh.tetrahedra[facet.tetrahedron];
      unsigned opposite = 0;
      for (unsigned v = 0; v < 4; ++v)
        if (std::find(facet.points.begin(), facet.points.end(), p[v]) == facet.points.end()) opposite |= 1u << v;
      if ((opposite & (opposite - 1)) != 0 || opposite == 0) {
        fits = false;
        return;
      }
      std::atomic_ref(out.surface[facet.tetrahedron]).fetch_or(static_cast<std::uint8_t>(opposite), std::memory_order_relaxed);
    }
  });
  out.crossable = fits;
  return out;
}

}  // namespace isostrata
