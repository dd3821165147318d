#include "engine/picture/ray_hit.h"

#include <algorithm>
#include <cmath>

namespace isostrata {
namespace {

/// Of a tetrahedron along the ray: corner v counts at[v] + t * along[v], and inside none is negative.
struct Segment {
  double enter = 0, leave = 0;
  std::size_t through = 4;  // the corner across from the face that the ray enters by; 4: it begins inside
  std::array<double, 4> at{}, along{};
};

/// Nothing if it is missed or only touched, or has no volume: its faces' normals are noise.
std::optional<Segment> segment_of(const IntervalMesh& mesh, const std::array<std::uint32_t, 4>& ids, const ViewRay& ray) {
  std::array<Vec3d, 4> p;
  for (std::size_t v = 0; v < 4; ++v) p[v] = mesh.positions[ids[v]] - ray.origin;
  double longest2 = 0;
  for (std::size_t v = 1; v < 4; ++v) longest2 = std::max(longest2, dot(p[v] - p[0], p[v] - p[0]));
  const double volume = orient3d(p[0], p[1], p[2], p[3]);
  if (!(volume * volume > 1e-20 * longest2 * longest2 * longest2)) return std::nullopt;
  Segment of{ray.first, ray.last};
  for (std::size_t v = 0; v < 4; ++v) {
    const Vec3d a = p[(v + 1) % 4], b = p[(v + 2) % 4], c = p[(v + 3) % 4];
    const Vec3d normal = cross(b - a, c - a);
    const double height = dot(normal, p[v] - a);
    of.at[v] = -dot(normal, a) / height;
    of.along[v] = dot(normal, ray.direction) / height;
    if (of.along[v] == 0) {
      if (of.at[v] < 0) return std::nullopt;
      continue;
    }
    const double t = -of.at[v] / of.along[v];
    if (of.along[v] > 0 && t > of.enter) {
      of.enter = t;
      of.through = v;
    } else if (of.along[v] < 0) {
      of.leave = std::min(of.leave, t);
    }
  }
  if (!(of.leave > of.enter) || !std::isfinite(of.leave - of.enter)) return std::nullopt;
  return of;
}

/// Where the ray crosses the facet, and how much each of its points counts there.
struct Crossing {
  double at = 0;
  std::array<double, 4> weights{};
};
std::optional<Crossing> crossing_of(const IntervalMesh& mesh, const std::array<std::uint32_t, 3>& ids, const ViewRay& ray) {
  const Vec3d a = mesh.positions[ids[0]] - ray.origin, b = mesh.positions[ids[1]] - ray.origin, c = mesh.positions[ids[2]] - ray.origin;
  const double bc = dot(ray.direction, cross(b, c)), ca = dot(ray.direction, cross(c, a)), ab = dot(ray.direction, cross(a, b));
  const double sum = bc + ca + ab;
  if (sum == 0 || bc / sum < 0 || ca / sum < 0 || ab / sum < 0) return std::nullopt;
  const Crossing of{dot(cross(b - a, c - a), a) / sum, {bc / sum, ca / sum, ab / sum, 0}};
  if (!(of.at >= ray.first && of.at <= ray.last)) return std::nullopt;
  return of;
}


bool draws(const SurfaceStyle& surface, FacetLabel label) {
  return surface.drawn() && (label == FacetLabel::lower ? surface.lower : label == FacetLabel::upper ? surface.upper : surface.domain);
}

/// The nearest so far, of the highest priority so far.
class Nearest {
 public:
  explicit Nearest(bool by_priority) : by_priority_(by_priority) {}
  bool takes(const IntervalStyle& style, double at) const {
    if (!best_) return true;
    if (by_priority_ && style.priority != priority_) return style.priority > priority_;
    return at < best_->at;
  }
  void set(const IntervalStyle& style, const RayHit& hit) {
    best_ = hit;
    priority_ = style.priority;
  }
  std::optional<RayHit>& best() { return best_; }

 private:
  const bool by_priority_;
  int priority_ = 0;
  std::optional<RayHit> best_;
};

/// The facet of the tetrahedron that has not this corner.
const BoundaryFacet* facet_across(const IntervalMesh& mesh, std::size_t tetrahedron, std::uint32_t corner) {
  for (const BoundaryFacet& facet : mesh.facets)
    if (facet.tetrahedron == tetrahedron && std::find(facet.points.begin(), facet.points.end(), corner) == facet.points.end()) return &facet;
  return nullptr;
}

std::array<double, 4> weights_at(const Segment& of, double t) {
  std::array<double, 4> weights{};
  double sum = 0;
  for (std::size_t v = 0; v < 4; ++v) sum += weights[v] = std::max(of.at[v] + t * of.along[v], 0.0);
  for (double& weight : weights) weight /= sum;
  return weights;
}

}  // namespace

std::optional<RayHit> first_hit(const IntervalMesh& mesh, std::span<const IntervalStyle> styles, bool by_priority, const ViewRay& ray) {
  Nearest nearest(by_priority);
  std::size_t through = 4;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    const std::size_t index = mesh.tetrahedron_interval[t];
    const IntervalStyle& style = styles[index];
    if (!style.visible || !style.has_interior()) continue;
    const auto segment = segment_of(mesh, mesh.tetrahedra[t], ray);
    if (!segment || !nearest.takes(style, segment->enter)) continue;
    nearest.set(style, {segment->enter, segment->leave, index, t, false, mesh.tetrahedra[t], weights_at(*segment, segment->enter)});
    through = segment->through;
  }
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    const BoundaryFacet& facet = mesh.facets[f];
    const IntervalStyle& style = styles[facet.interval];
    const bool area = mesh.tetrahedra.empty();
    if (!style.visible || (style.has_interior() && !area) || !draws(style.surface, facet.label)) continue;
    const auto crossing = crossing_of(mesh, facet.points, ray);
    if (!crossing || !nearest.takes(style, crossing->at)) continue;
    nearest.set(style, {crossing->at, crossing->at, facet.interval, f, true, {facet.points[0], facet.points[1], facet.points[2], facet.points[0]}, crossing->weights, &facet});
  }
  if (nearest.best() && !nearest.best()->surface && through < 4)
    nearest.best()->facet = facet_across(mesh, nearest.best()->item, nearest.best()->points[through]);
  return std::move(nearest.best());
}

bool meets_at(const IntervalMesh& mesh, const ViewRay& ray, double at) {
  for (const auto& ids : mesh.tetrahedra)
    if (const auto segment = segment_of(mesh, ids, ray); segment && segment->enter <= at && at <= segment->leave) return true;
  if (!mesh.tetrahedra.empty()) return false;
  return std::any_of(mesh.facets.begin(), mesh.facets.end(), [&](const BoundaryFacet& facet) { return crossing_of(mesh, facet.points, ray).has_value(); });
}

}  // namespace isostrata
