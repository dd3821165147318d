#include "rendering/raster/projected_tetrahedra.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "base/parallel.h"
#include "rendering/picture/clip_tetrahedron.h"
#include "rendering/picture/pixel_grid.h"

namespace isostrata {
namespace {

/// A vertex of a tetrahedron on the screen.
struct Corner {
  double x, y, q;
  double scalar_q;  // linear on the screen over every plane, like q: the scalar times q, or itself where rays are parallel
  double shade_q = 0;  // the same of the shade
};

template <class Vertex>
constexpr bool kLinear = std::is_base_of_v<LinearVertex, Vertex>;
template <class Vertex>
constexpr bool kShaded = std::is_same_v<ShadedVertex, Vertex>;

constexpr double kSnap = 1.0 / 128;  // pixels: rasterizers move vertices to a grid of 1/256
// Where a corner has less than this share of the thick vertex, the side across from it is a face seen edge-on: the tent does not
// fall to 0 there but ends in a wall. Its function is then D everywhere, so that a pixel whose middle lies on the wall (common:
// straight views of regular grids) gets the full length from whichever tetrahedron the rasterizer's edge rule gives it to.
constexpr double kWallShare = 1e-6;

/// Whether [low, high] holds a pixel centre. Pixel centres lie at whole numbers plus `phase`.
bool holds_center(double low, double high, double phase) {
  return std::floor(high + kSnap - phase) >= std::ceil(low - kSnap - phase);
}

struct Emitter {
  double phase_x, phase_y;  // of pixel centres, seen from the middle of the picture
  double half_width, half_height;

  explicit Emitter(const Projection& projection)
      : phase_x(projection.width % 2 ? 0.0 : 0.5),
        phase_y(projection.height % 2 ? 0.0 : 0.5),
        half_width(0.5 * projection.width),
        half_height(0.5 * projection.height) {}

  bool covers_pixel(const Corner& a, const Corner& b, const Corner& c) const {
    const auto [x_low, x_high] = std::minmax({a.x, b.x, c.x});
    const auto [y_low, y_high] = std::minmax({a.y, b.y, c.y});
    return x_low < half_width && x_high > -half_width && y_low < half_height && y_high > -half_height &&
           holds_center(x_low, x_high, phase_x) && holds_center(y_low, y_high, phase_y);
  }
};

template <class Vertex>
Vertex make_vertex(const Corner& corner, double tent0, double tent1, double tent2, double q_min, std::uint32_t style_kind,
                   double slope, double shade_slope) {
  Vertex v;
  v.x = static_cast<float>(corner.x);
  v.y = static_cast<float>(corner.y);
  v.q = static_cast<float>(corner.q);
  v.tent[0] = static_cast<float>(tent0);
  v.tent[1] = static_cast<float>(tent1);
  v.tent[2] = static_cast<float>(tent2);
  v.q_min = static_cast<float>(q_min);
  v.style_kind = style_kind;
  if constexpr (kLinear<Vertex>) {
    v.scalar_q = static_cast<float>(corner.scalar_q);
    v.slope = static_cast<float>(slope);
  }
  if constexpr (kShaded<Vertex>) {
    v.shade_q = static_cast<float>(corner.shade_q);
    v.shade_slope = static_cast<float>(shade_slope);
  }
  return v;
}

/// Twice the signed area.
double area(const Corner& a, const Corner& b, const Corner& c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

template <class Vertex>
void emit(const std::array<Corner, 4>& corner, std::uint32_t style, const Emitter& emitter, std::vector<Vertex>& out) {
  // The affine dependence of the four points on the screen: sum of lambda = 0, sum of lambda * (x, y) = 0.
  const std::array<double, 4> lambda{area(corner[1], corner[2], corner[3]), -area(corner[0], corner[2], corner[3]),
                                     area(corner[0], corner[1], corner[3]), -area(corner[0], corner[1], corner[2])};
  std::array<std::size_t, 4> plus{}, minus{};
  std::size_t np = 0, nm = 0;
  double weight = 0;
  for (std::size_t v = 0; v < 4; ++v) {
    if (lambda[v] > 0)
      plus[np++] = v, weight += lambda[v];
    else
      minus[nm++] = v;
  }
  if (np == 0 || nm == 0 || !(weight > 0) || !std::isfinite(weight)) return;  // seen edge-on: covers nothing

  // At the thick vertex: what the points of each sign say about q and the scalar there.
  double q_plus = 0, q_minus = 0, s_plus = 0, s_minus = 0, shade_plus = 0, shade_minus = 0;
  double q_min = corner[0].q, q_max = corner[0].q;
  for (std::size_t v = 0; v < 4; ++v) {
    const double share = std::abs(lambda[v]) / weight;
    (lambda[v] > 0 ? q_plus : q_minus) += share * corner[v].q;
    (lambda[v] > 0 ? s_plus : s_minus) += share * corner[v].scalar_q;
    (lambda[v] > 0 ? shade_plus : shade_minus) += share * corner[v].shade_q;
    q_min = std::min(q_min, corner[v].q);
    q_max = std::max(q_max, corner[v].q);
  }
  const double thick = std::min(std::abs(q_plus - q_minus), q_max - q_min);  // D
  if (!(thick > 0)) return;
  const double slope = (s_plus - s_minus) / (q_plus - q_minus), shade_slope = (shade_plus - shade_minus) / (q_plus - q_minus);
  // The function of the side across from corner v: 0 on the side and D at the thick vertex, so D over v's share of it at v.
  struct Side {
    double at_corner, elsewhere;
  };
  const auto side_of = [&](std::size_t v) -> Side {
    const double share = std::abs(lambda[v]) / weight;
    if (share < kWallShare) return {thick, thick};
    return {thick / share, 0};
  };
  const auto put = [&](std::size_t v, double t0, double t1, double t2, std::uint32_t at_back) {
    out.push_back(make_vertex<Vertex>(corner[v], t0, t1, t2, q_min, style << KIND_BITS | at_back, slope, shade_slope));
  };

  if (np != 2) {  // class 1: the single one projects into the triangle of the others, which is drawn
    const auto& three = np == 1 ? minus : plus;
    const std::size_t a = three[0], b = three[1], c = three[2];
    if (!emitter.covers_pixel(corner[a], corner[b], corner[c])) return;
    const double q_three = np == 1 ? q_minus : q_plus, q_single = np == 1 ? q_plus : q_minus;
    const std::uint32_t at_back = q_three > q_single ? 0 : 1;
    const Side across_a = side_of(a), across_b = side_of(b), across_c = side_of(c);
    put(a, across_a.at_corner, across_b.elsewhere, across_c.elsewhere, at_back);
    put(b, across_a.elsewhere, across_b.at_corner, across_c.elsewhere, at_back);
    put(c, across_a.elsewhere, across_b.elsewhere, across_c.at_corner, at_back);
    return;
  }
  // Class 2: the two faces at the nearer diagonal. The third function, D, bounds what is extrapolated beyond the diagonal.
  const auto& near_pair = q_plus > q_minus ? plus : minus;
  const auto& far_pair = q_plus > q_minus ? minus : plus;
  const std::size_t a = near_pair[0], c = near_pair[1];
  const Side across_a = side_of(a), across_c = side_of(c);
  for (const std::size_t b : {far_pair[0], far_pair[1]}) {
    if (!emitter.covers_pixel(corner[a], corner[b], corner[c])) continue;
    put(a, across_a.at_corner, across_c.elsewhere, thick, 0);
    put(b, across_a.elsewhere, across_c.elsewhere, thick, 0);
    put(c, across_a.elsewhere, across_c.at_corner, thick, 0);
  }
}

Corner corner_of(const ClipVertex& v, const Projection& projection) {
  if (projection.orthographic)
    return {v.position.x * projection.focal + projection.axis_x, v.position.y * projection.focal + projection.axis_y,
            projection.nearness(v.position.z), v.scalar, v.shade};
  const double q = 1 / v.position.z;
  return {v.position.x * projection.focal * q + projection.axis_x, v.position.y * projection.focal * q + projection.axis_y, q,
          v.scalar * q, v.shade * q};
}

void slice_by_depth(std::vector<ClipTetrahedron>& pieces, double near_depth) {
  std::vector<ClipTetrahedron> slices;
  double farthest = 0;
  for (const ClipTetrahedron& piece : pieces)
    for (const ClipVertex& v : piece) farthest = std::max(farthest, v.position.z);
  for (double z = near_depth; z < farthest; z *= kLargestDepthRatio) {
    std::vector<ClipTetrahedron> slice = pieces;
    clip_tetrahedra(slice, {0, 0, 1}, z);
    clip_tetrahedra(slice, {0, 0, -1}, -z * kLargestDepthRatio);
    slices.insert(slices.end(), slice.begin(), slice.end());
  }
  pieces.swap(slices);
}

Vec3d view_of_point(const IntervalMesh& mesh, std::uint32_t point, const Projection& projection) {
  const Vec3d p = mesh.positions[point];
  const auto view = projection.view_from_world * std::array<double, 4>{p.x, p.y, p.z, 1};
  return Vec3d{view[0], view[1], -view[2]} / projection.scale;
}

/// Tetrahedra that reach too near the eye or far beyond the picture are cut there, in view space. Those that reach over a wide
/// range of depths are sliced, because the difference of two inverse depths loses the digits by which they differ in size.
template <class Vertex>
void emit_clipped(const TetrahedraSource& source, std::uint32_t id, std::uint32_t style, const Emitter& emitter,
                  std::vector<Vertex>& out) {
  const Projection& projection = *source.projection;
  ClipTetrahedron whole;
  for (std::size_t v = 0; v < 4; ++v) {
    const std::uint32_t point = source.mesh->tetrahedra[id][v];
    whole[v].position = view_of_point(*source.mesh, point, projection);
    if constexpr (kLinear<Vertex>)
      if (source.color_values) whole[v].scalar = (*source.color_values)[point];
    if constexpr (kShaded<Vertex>) whole[v].shade = source.shades[point];
  }
  std::vector<ClipTetrahedron> pieces{whole};
  const auto slope_x = [&](double sign) { return (projection.guard() + sign * projection.axis_x) / projection.focal; };
  const auto slope_y = [&](double sign) { return (projection.guard() + sign * projection.axis_y) / projection.focal; };
  if (projection.orthographic) {
    for (const double sign : {1.0, -1.0}) {
      clip_tetrahedra(pieces, {sign, 0, 0}, -slope_x(sign));
      clip_tetrahedra(pieces, {0, sign, 0}, -slope_y(sign));
    }
  } else {
    clip_tetrahedra(pieces, {0, 0, 1}, projection.near_depth);
    for (const double sign : {1.0, -1.0}) {
      clip_tetrahedra(pieces, {sign, 0, slope_x(sign)}, 0);
      clip_tetrahedra(pieces, {0, sign, slope_y(sign)}, 0);
    }
    slice_by_depth(pieces, projection.near_depth);
  }
  const auto distance = [&](const ClipTetrahedron& t) {
    const Vec3d sum = t[0].position + t[1].position + t[2].position + t[3].position;
    return projection.orthographic ? sum.z : length(sum);
  };
  std::sort(pieces.begin(), pieces.end(),
            [&](const ClipTetrahedron& a, const ClipTetrahedron& b) { return distance(a) > distance(b); });
  for (const ClipTetrahedron& piece : pieces)
    emit<Vertex>({corner_of(piece[0], projection), corner_of(piece[1], projection), corner_of(piece[2], projection),
                  corner_of(piece[3], projection)},
                 style, emitter, out);
}

/// The triangle of a facet. What it looks like is found for each fragment; here only where it lies.
template <class Vertex>
void emit_facet(const TetrahedraSource& source, std::uint32_t index, const BoundaryFacet& facet, const Emitter& emitter,
                std::vector<Vertex>& out) {
  std::uint32_t all = ~0u, any = 0;
  std::array<Corner, 3> corner;
  for (std::size_t v = 0; v < 3; ++v) {
    const ScreenPoint& p = source.points[facet.points[v]];
    all &= p.outside;
    any |= p.outside;
    corner[v] = {p.x, p.y, p.q, 0};
  }
  if (all & (kTooNear | kLeft | kRight | kBelow | kAbove)) return;
  const bool homogeneous = any & (kTooNear | kBeyondGuard);
  if (!homogeneous && !emitter.covers_pixel(corner[0], corner[1], corner[2])) return;
  const std::uint32_t kind = KIND_SURFACE | (homogeneous ? KIND_HOMOGENEOUS : 0);
  for (std::size_t v = 0; v < 3; ++v) {
    if (homogeneous) {
      const Vec3d view = view_of_point(*source.mesh, facet.points[v], *source.projection);
      const Projection& to = *source.projection;
      const double w = to.orthographic ? 1.0 : view.z;
      corner[v] = {view.x * to.focal + to.axis_x * w, view.y * to.focal + to.axis_y * w, w, 0};
    }
    Vertex vertex = make_vertex<Vertex>(corner[v], 0, 0, 0, 0, std::uint32_t{facet.interval} << KIND_BITS | kind, 0, 0);
    vertex.tent[0] = std::bit_cast<float>(index);
    out.push_back(vertex);
  }
}

/// The facets of a tetrahedron that are drawn and face the eye, or do not.
template <class Vertex>
void emit_facets(const TetrahedraSource& source, std::uint32_t id, std::uint32_t parts, bool facing, const Emitter& emitter,
                 std::vector<Vertex>& out) {
  const SurfaceFacets& facets = *source.facets;
  for (std::uint32_t i = facets.first_of[id]; i < facets.facets.size(); ++i) {
    const BoundaryFacet& facet = source.mesh->facets[facets.facets[i]];
    if (facet.tetrahedron != id) return;
    if (!(parts & DRAW_LABEL << static_cast<std::uint32_t>(facet.label))) continue;
    Vec3d p[3];
    for (std::size_t v = 0; v < 3; ++v) p[v] = view_of_point(*source.mesh, facet.points[v], *source.projection);
    const Vec3d outwards = cross(p[2] - p[0], p[1] - p[0]);  // view space is left-handed
    const double away = source.projection->orthographic ? outwards.z : dot(outwards, p[0]);
    if ((away < 0) == facing) emit_facet(source, i, facet, emitter, out);
  }
}

template <class Vertex>
void emit_all(const TetrahedraSource& source, std::span<const std::uint32_t> tetrahedra, std::vector<Vertex>& out) {
  const Emitter emitter(*source.projection);
  const bool perspective = !source.projection->orthographic;
  for (const std::uint32_t id : tetrahedra) {
    const auto& ids = source.mesh->tetrahedra[id];
    const std::uint32_t style = source.mesh->tetrahedron_interval[id];
    std::uint32_t all = ~0u, any = 0;
    std::array<Corner, 4> corner;
    for (std::size_t v = 0; v < 4; ++v) {
      const ScreenPoint& p = source.points[ids[v]];
      all &= p.outside;
      any |= p.outside;
      corner[v] = {p.x, p.y, p.q, 0};
      if constexpr (kLinear<Vertex>)
        if (source.color_values) corner[v].scalar_q = static_cast<double>((*source.color_values)[ids[v]]) * (perspective ? p.q : 1.0);
      if constexpr (kShaded<Vertex>) corner[v].shade_q = static_cast<double>(source.shades[ids[v]]) * (perspective ? p.q : 1.0);
    }
    if (all & (kTooNear | kLeft | kRight | kBelow | kAbove))
      continue;  // wholly on the far side of one plane of the pyramid of view
    const std::uint32_t parts = source.parts.empty() ? DRAW_VOLUME : source.parts[style];
    const bool with_facets = source.facets && source.facets->first_of[id] != kNoFacet && (parts & ~DRAW_VOLUME);
    if (with_facets) emit_facets(source, id, parts, false, emitter, out);
    if (parts & DRAW_VOLUME) {
      const auto [q_low, q_high] = std::minmax({corner[0].q, corner[1].q, corner[2].q, corner[3].q});
      if (any & (kTooNear | kBeyondGuard) || (perspective && q_high > kLargestDepthRatio * q_low))
        emit_clipped(source, id, style, emitter, out);
      else
        emit(corner, style, emitter, out);
    }
    if (with_facets) emit_facets(source, id, parts, true, emitter, out);
  }
}

}  // namespace

// The viewport is as large as the guard, so that OpenGL itself has nothing to clip: Mesa 22.3 interpolates noperspective values
// across its clipped edges with errors of 1e-3 (seen in the law of the slab), and a viewport may be 16384 pixels wide everywhere.
int Projection::guard() const { return std::min(2 * std::max(width, height), 8192); }

Projection make_projection(const Camera& camera, const Box3d& bounds, int width, int height) {
  Projection projection;
  projection.view_from_world = view_from_world(camera);
  const double distance = length(camera.at - camera.eye), diagonal = bounds.diagonal();
  projection.scale = diagonal > 0 ? diagonal : distance;
  projection.focal = 0.5 * height / std::tan(camera.fov_deg * std::numbers::pi / 360);
  projection.near_depth = 1e-4 * std::min(1.0, distance / projection.scale);
  if (camera.orthographic) {
    projection.orthographic = true;
    projection.focal = 0.5 * height / half_height(camera) * projection.scale;
    const Vec3d centre = bounds.empty() ? camera.at : bounds.center();
    const auto view = projection.view_from_world * std::array<double, 4>{centre.x, centre.y, centre.z, 1};
    projection.base = -view[2] / projection.scale + 2;  // the bounds lie within half a unit of their centre
  }
  projection.width = width;
  projection.height = height;
  return projection;
}

Projection make_projection(const DrawInput& input) {
  const PixelGrid grid = pixel_grid(input);
  Projection projection = make_projection(input.camera, input.bounds, input.width, input.height);
  projection.focal = input.camera.orthographic ? grid.per_unit * projection.scale : grid.focal;
  projection.axis_x = grid.axis_x - 0.5 * input.width;
  projection.axis_y = 0.5 * input.height - grid.axis_y;
  return projection;
}

std::vector<ScreenPoint> project_points(const IntervalMesh& mesh, const Projection& projection) {
  std::vector<ScreenPoint> points(mesh.positions.size());
  const double inverse_scale = 1 / projection.scale, half_width = 0.5 * projection.width, half_height = 0.5 * projection.height;
  const auto& m = projection.view_from_world.m;
  parallel_for(static_cast<std::int64_t>(points.size()), 4096, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const Vec3d w = mesh.positions[i];
      const auto row = [&](std::size_t r) { return (m[0][r] * w.x + m[1][r] * w.y + m[2][r] * w.z + m[3][r]) * inverse_scale; };
      const double z = -row(2), away = projection.orthographic ? 1 : z;
      const double x = row(0) * projection.focal + projection.axis_x * away,
                   y = row(1) * projection.focal + projection.axis_y * away;
      ScreenPoint& p = points[i];
      if (projection.orthographic) {
        p.outside = (x < -half_width ? kLeft : 0) | (x > half_width ? kRight : 0) | (y < -half_height ? kBelow : 0) |
                    (y > half_height ? kAbove : 0);
        p.q = projection.nearness(z);
        p.x = x;
        p.y = y;
        if (!(std::max(std::abs(p.x), std::abs(p.y)) <= projection.guard())) p.outside |= kBeyondGuard;
        continue;
      }
      // Against the pyramid of view, whose sides pass through the eye: right for points behind it too.
      p.outside = (z < projection.near_depth ? kTooNear : 0) | (x < -half_width * z ? kLeft : 0) |
                  (x > half_width * z ? kRight : 0) | (y < -half_height * z ? kBelow : 0) | (y > half_height * z ? kAbove : 0);
      if (p.outside & kTooNear) continue;
      p.q = 1 / z;
      p.x = x * p.q;
      p.y = y * p.q;
      if (!(std::max(std::abs(p.x), std::abs(p.y)) <= projection.guard())) p.outside |= kBeyondGuard;
    }
  });
  return points;
}

void emit_tetrahedra(const TetrahedraSource& source, std::span<const std::uint32_t> tetrahedra,
                     std::vector<ConstantVertex>& out) {
  emit_all(source, tetrahedra, out);
}
void emit_tetrahedra(const TetrahedraSource& source, std::span<const std::uint32_t> tetrahedra, std::vector<LinearVertex>& out) {
  emit_all(source, tetrahedra, out);
}
void emit_tetrahedra(const TetrahedraSource& source, std::span<const std::uint32_t> tetrahedra, std::vector<ShadedVertex>& out) {
  emit_all(source, tetrahedra, out);
}

}  // namespace isostrata
