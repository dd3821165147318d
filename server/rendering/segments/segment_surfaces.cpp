#include "rendering/segments/segment_surfaces.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/parallel.h"

namespace isostrata {
namespace {

constexpr std::size_t kFacetChunk = 4096;  // facets

bool asks_for(const SurfaceStyle& style, FacetLabel label) {
  return label == FacetLabel::lower ? style.lower : label == FacetLabel::upper ? style.upper : style.domain;
}

struct Corner {
  Vec3d seen;
  double weight[3];
};

/// Sutherland and Hodgman's cut of a convex polygon: keeps dot(normal, seen) >= offset.
void cut(std::vector<Corner>& polygon, Vec3d normal, double offset) {
  std::vector<Corner> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Corner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = dot(normal, a.seen) - offset, db = dot(normal, b.seen) - offset;
    if (da >= 0) kept.push_back(a);
    if ((da >= 0) == (db >= 0)) continue;
    const double t = da / (da - db);
    Corner c{lerp(a.seen, b.seen, t), {}};
    for (std::size_t k = 0; k < 3; ++k) c.weight[k] = a.weight[k] + t * (b.weight[k] - a.weight[k]);
    kept.push_back(c);
  }
  polygon.swap(kept);
}

/// Twice the signed area.
double area(const SurfaceTriangle& t) { return (t.x[1] - t.x[0]) * (t.y[2] - t.y[0]) - (t.y[1] - t.y[0]) * (t.x[2] - t.x[0]); }

struct PixelBox {
  int x0, y0, x1, y1;  // both ends included
};

PixelBox box_of(const SurfaceTriangle& t, int x0, int y0, int x1, int y1) {
  const auto [x_low, x_high] = std::minmax({t.x[0], t.x[1], t.x[2]});
  const auto [y_low, y_high] = std::minmax({t.y[0], t.y[1], t.y[2]});
  return {std::max(x0, static_cast<int>(std::ceil(x_low))), std::max(y0, static_cast<int>(std::ceil(y_low))),
          std::min(x1, static_cast<int>(std::floor(x_high))), std::min(y1, static_cast<int>(std::floor(y_high)))};
}

}  // namespace

SegmentSurfaces::SegmentSurfaces(const DrawInput& input, const SegmentView& view, const SegmentOptics& optics, int tiles_x,
                                 int tiles_y)
    : input_(input), view_(view), optics_(optics) {
  bool any = false;
  for (const IntervalStyle& style : input.styles) {
    materials_.emplace_back();
    if (!style.visible || !style.surface.drawn()) continue;
    materials_.back() = surface_material(style.surface);
    any = true;
  }
  const auto& facets = input.mesh->facets;
  if (!any || facets.empty()) return;
  const std::size_t chunk_count = (facets.size() + kFacetChunk - 1) / kFacetChunk;
  std::vector<std::vector<SurfaceTriangle>> chunks(chunk_count);
  parallel_for(static_cast<std::int64_t>(chunk_count), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c)
      for (std::size_t f = c * kFacetChunk; f < std::min(facets.size(), (c + 1) * kFacetChunk); ++f)
        if (materials_[facets[f].interval] && asks_for(input.styles[facets[f].interval].surface, facets[f].label))
          place(static_cast<std::uint32_t>(f), chunks[c]);
  });
  std::vector<PlacedTetrahedron> placed;
  for (const auto& chunk : chunks)
    for (const SurfaceTriangle& t : chunk) {
      const PixelBox box = box_of(t, 0, 0, view.width - 1, view.height - 1);
      if (box.x0 > box.x1 || box.y0 > box.y1) continue;
      const auto tile = [](int pixel) { return static_cast<std::uint16_t>(pixel / kTileSize); };
      placed.push_back({static_cast<std::uint32_t>(triangles_.size()), static_cast<float>(t.q[0] + t.q[1] + t.q[2]), tile(box.x0),
                        tile(box.y0), tile(box.x1), tile(box.y1)});
      triangles_.push_back(t);
    }
  if (!triangles_.empty()) fill_bins({std::span<const PlacedTetrahedron>(placed)}, tiles_x, tiles_y, bins_);
}

void SegmentSurfaces::place(std::uint32_t facet, std::vector<SurfaceTriangle>& out) const {
  // The points in the order of their numbers: facets on the same three points then lie at the same q to the last bit, whichever
  // interval they bound.
  const auto& points = input_.mesh->facets[facet].points;
  std::array<std::size_t, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return points[a] < points[b]; });
  const bool odd = (order[0] > order[1]) != ((order[1] > order[2]) != (order[0] > order[2]));
  std::vector<Corner> polygon(3);
  bool whole = true;
  for (std::size_t v = 0; v < 3; ++v) {
    polygon[v].seen = view_.seen(input_.mesh->positions[points[order[v]]]);
    for (std::size_t k = 0; k < 3; ++k) polygon[v].weight[k] = k == order[v] ? 1 : 0;
    whole = whole && view_.screen(polygon[v].seen, 0).q > 0;
  }
  if (!whole && !view_.orthographic) {
    cut(polygon, {0, 0, 1}, view_.near_depth * 1.001);
    const double side = 0.999 * view_.guard / view_.focal;
    for (const double sign : {1.0, -1.0}) {
      cut(polygon, {sign, 0, side}, 0);
      cut(polygon, {0, sign, side}, 0);
    }
  }
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    SurfaceTriangle t;
    t.facet = facet;
    const Corner* const corner[3] = {&polygon[0], &polygon[i - 1], &polygon[i]};
    for (std::size_t v = 0; v < 3; ++v) {
      const Vec3d p = corner[v]->seen;
      const double w = view_.orthographic ? 1 : 1 / p.z;
      t.x[v] = view_.center_x + view_.focal * p.x * w;
      t.y[v] = view_.center_y - view_.focal * p.y * w;
      t.q[v] = view_.orthographic ? view_.zero_q_depth - p.z : w;
      std::copy_n(corner[v]->weight, 3, t.weight[v]);
    }
    const double twice = area(t);
    if (twice == 0 || !std::isfinite(twice)) continue;
    t.entering = (twice < 0) != odd;  // counter-clockwise with y down
    out.push_back(t);
  }
}

std::uint16_t SegmentSurfaces::interval(std::uint32_t triangle) const {
  return input_.mesh->facets[triangles_[triangle].facet].interval;
}

std::size_t SegmentSurfaces::room(std::uint32_t triangle, const CoverInput& part) const {
  const PixelBox box =
      box_of(triangles_[triangle], part.tile_x + part.x0, part.tile_y + part.y0, part.tile_x + part.x1, part.tile_y + part.y1);
  if (box.x0 > box.x1 || box.y0 > box.y1) return 0;
  return static_cast<std::size_t>(box.x1 - box.x0 + 1) * static_cast<std::size_t>(box.y1 - box.y0 + 1);
}

void SegmentSurfaces::add(std::uint32_t triangle, const CoverInput& part, FragmentStore& store) const {
  const SurfaceTriangle& t = triangles_[triangle];
  const BoundaryFacet& facet = input_.mesh->facets[t.facet];
  const IntervalMesh& mesh = *input_.mesh;
  const SurfaceMaterial& material = *materials_[facet.interval];
  const PixelBox box = box_of(t, part.tile_x + part.x0, part.tile_y + part.y0, part.tile_x + part.x1, part.tile_y + part.y1);
  const double over_area = 1 / area(t);
  const auto to_float = [](Vec3d v) { return Vec3f{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; };
  const Vec3d n = cross(mesh.positions[facet.points[1]] - mesh.positions[facet.points[0]],
                        mesh.positions[facet.points[2]] - mesh.positions[facet.points[0]]);
  const double l = length(n);
  const Vec3f own_normal = l > 0 ? to_float(n / l) : Vec3f{};
  for (int y = box.y0; y <= box.y1; ++y)
    for (int x = box.x0; x <= box.x1; ++x) {
      const auto side = [&](std::size_t a, std::size_t b) {
        return ((t.x[a] - x) * (t.y[b] - y) - (t.y[a] - y) * (t.x[b] - x)) * over_area;
      };
      double share[3] = {side(1, 2), side(2, 0), side(0, 1)};
      if (share[0] < 0 || share[1] < 0 || share[2] < 0) continue;
      const double q = share[0] * t.q[0] + share[1] * t.q[1] + share[2] * t.q[2];
      const int pixel = (y - part.tile_y) * kTileSize + (x - part.tile_x);
      if (part.q_low && !(q >= double{part.q_low[pixel]} && q <= double{part.q_high[pixel]})) continue;
      double weight[3] = {};
      for (std::size_t v = 0; v < 3; ++v) {
        const double there = view_.orthographic ? share[v] : share[v] * t.q[v] / q;
        for (std::size_t k = 0; k < 3; ++k) weight[k] += there * t.weight[v][k];
      }
      const auto at_point = [&](const std::vector<float>& values) {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) sum += weight[k] * double{values[facet.points[k]]};
        return sum;
      };
      Vec3f normal = own_normal;
      if (input_.normals) {
        Vec3d sum;
        for (std::size_t k = 0; k < 3; ++k) {
          const Vec3f n = (*input_.normals)[facet.points[k]];
          sum = sum + Vec3d{n.x, n.y, n.z} * weight[k];
        }
        normal = to_float(sum);
      }
      const Vec3d ray = view_.orthographic ? view_.forward
                                           : view_.forward + view_.right * ((x - view_.center_x) / view_.focal) -
                                                 view_.up * ((y - view_.center_y) / view_.focal);
      const float u = input_.color_values ? (static_cast<float>(at_point(*input_.color_values)) - optics_.lower[facet.interval]) *
                                                optics_.inverse_range[facet.interval]
                                          : 0.0f;
      const SurfaceColor light =
          shade_surface(material, optics_.color(facet.interval, u), normal, own_normal, to_float(normalized(ray) * -1.0),
                        input_.texture_values ? static_cast<float>(at_point(*input_.texture_values)) : 0.0f);
      float* const out = store.light + 4 * store.count;
      std::copy(light.color.begin(), light.color.end(), out);
      out[3] = -light.alpha;
      // At the same place the interval that is left is nearer.
      store.far_key[store.count] = ~std::bit_cast<std::uint32_t>(static_cast<float>(2 * q)) + (t.entering ? 1u : ~0u);
      store.pixel[store.count] = static_cast<std::uint16_t>(pixel);
      if (store.q_in) store.q_in[store.count] = light.alpha > 0 ? static_cast<float>(q) : -1e30f;
      ++store.count;
    }
}

}  // namespace isostrata
