#include "rendering/crossings/crossing_light.h"

#include <algorithm>

namespace isostrata {
namespace {

Vec3f single(Vec3d v) { return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; }

/// Where the ray crosses the facet's plane: what each corner counts. Beside the facet, by rounding, the nearest place of it.
std::array<double, 3> weights_of(Vec3d a, Vec3d b, Vec3d c, Vec3d origin, Vec3d direction) {
  const Vec3d p = a - origin, q = b - origin, r = c - origin;
  const double w[3] = {dot(direction, cross(q, r)), dot(direction, cross(r, p)), dot(direction, cross(p, q))};
  const double sum = w[0] + w[1] + w[2];
  if (sum == 0) return {1.0 / 3, 1.0 / 3, 1.0 / 3};
  const auto share = [&](double of) { return std::clamp(of / sum, 0.0, 1.0); };
  return {share(w[0]), share(w[1]), share(w[2])};
}

/// A number for each interval, so chosen that sums of a few of them, with signs, are 0 only if each is added as often as it is
/// taken away.
std::int32_t signature(std::size_t interval) {
  std::uint64_t x = (interval + 1) * 0x9e3779b97f4a7c15u;  // SplitMix64
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(x >> 32));
}

}  // namespace

SurfaceColor shade_crossing(const CrossingFrame& frame, std::uint32_t facet, int x, int y) {
  const DrawInput& input = frame.input;
  const auto& points = frame.set.points[facet];
  const std::uint16_t interval = interval_of(frame.set.parts[facet]);
  const Vec3d a = input.mesh->positions[points[0]], b = input.mesh->positions[points[1]], c = input.mesh->positions[points[2]];
  // The ray in world space. view_from_world's rows are the camera's axes.
  const auto& m = frame.transform.view_from_world.m;
  const auto to_world = [&](Vec3d v) {
    return Vec3d{m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z, m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
                 m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
  };
  const ViewPoint ray = frame.transform.ray(x + 0.5, y + 0.5);
  Vec3d origin = input.camera.eye, direction;
  if (frame.transform.orthographic) {
    origin = origin + to_world({ray.x, ray.y, 0}) * frame.transform.scale;
    direction = to_world({0, 0, -1});
  } else {
    direction = normalized(to_world({ray.x, ray.y, -1}));
  }
  std::array<double, 3> weight{};
  if (input.normals || input.texture_values) weight = weights_of(a, b, c, origin, direction);
  const Vec3d across = cross(b - a, c - a);
  const double size = length(across);
  const Vec3d own_normal = size > 0 ? across / size : Vec3d{};
  Vec3d normal = own_normal;
  if (input.normals) {
    normal = {};
    for (std::size_t v = 0; v < 3; ++v) {
      const Vec3f n = (*input.normals)[points[v]];
      normal = normal + Vec3d{n.x, n.y, n.z} * weight[v];
    }
  }
  double value = 0;
  if (input.texture_values)
    for (std::size_t v = 0; v < 3; ++v) value += weight[v] * (*input.texture_values)[points[v]];
  return shade_surface(*frame.materials[interval], input.styles[interval].color, single(normal), single(own_normal),
                       single(direction * -1.0), static_cast<float>(value));
}

RayTables make_ray_tables(const CrossingFrame& frame) {
  RayTables tables;
  const std::size_t intervals = frame.input.styles.size();
  for (std::vector<float>* of :
       {&tables.extinction, &tables.mixed[0], &tables.mixed[1], &tables.mixed[2], &tables.opacity, &tables.base[0],
        &tables.base[1], &tables.base[2], &tables.mean[0], &tables.mean[1], &tables.mean[2], &tables.ambient, &tables.diffuse,
        &tables.specular, &tables.shininess, &tables.silhouette})
    of->assign(intervals + RayTables::kPadding, 0);
  tables.signature.assign(intervals + RayTables::kPadding, 0);
  tables.surfaces.assign(intervals + RayTables::kPadding, 0);
  for (std::size_t i = 0; i < intervals; ++i) {
    const IntervalStyle& style = frame.input.styles[i];
    tables.extinction[i] = frame.extinction[i];
    tables.signature[i] = signature(i);
    for (std::size_t c = 0; c < 3; ++c) tables.mixed[c][i] = frame.extinction[i] * style.color[c];
    if (!frame.materials[i]) continue;
    const SurfaceMaterial& m = *frame.materials[i];
    tables.any_surface = true;
    tables.surfaces[i] = (style.surface.lower ? 1 << static_cast<int>(FacetLabel::lower) : 0) |
                         (style.surface.upper ? 1 << static_cast<int>(FacetLabel::upper) : 0) |
                         (style.surface.domain ? 1 << static_cast<int>(FacetLabel::domain) : 0);
    if (m.silhouette > 0) tables.surfaces[i] |= RayTables::kOpacityVaries;
    if (m.texture != SurfaceMaterial::Texture::none) tables.surfaces[i] |= RayTables::kOneByOne;
    tables.opacity[i] = m.opacity;
    tables.ambient[i] = m.ambient;
    tables.diffuse[i] = m.diffuse;
    tables.specular[i] = m.specular;
    tables.shininess[i] = m.shininess;
    tables.silhouette[i] = m.silhouette;
    const Rgb& color = m.own_color ? m.color : style.color;
    for (std::size_t c = 0; c < 3; ++c) {
      tables.base[c][i] = color[c];
      const float darkest = saturate(color[c] * std::min(m.ambient, m.ambient + m.diffuse) + std::min(m.specular, 0.0f)),
                  brightest = saturate(color[c] * std::max(m.ambient, m.ambient + m.diffuse) + std::max(m.specular, 0.0f));
      tables.mean[c][i] = m.texture == SurfaceMaterial::Texture::none ? 0.5f * (darkest + brightest) : 0.5f;
    }
  }
  return tables;
}

}  // namespace isostrata
