// How a boundary surface is lit: the reference that every renderer follows line by line, in shaders and in vectors.
//
// Source: J. F. Blinn, "Models of Light Reflection for Computer Synthesized Pictures", 1977, with one light at the eye, so that
// the light's, the eye's and the halfway direction are one and the whole formula hangs on c = |n . v|. Silhouettes: P. Rheingans
// and D. Ebert, "Volume Illustration", 2001, equation 4, with an exponent of 4.
//
// Everything here is continuous in all its inputs except across a colour map's own samples' slopes, so that two renderers which
// differ in the last bits of a normal or of a texture value differ in the last bits of the colour, too.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/vec.h"
#include "scene/style.h"

namespace isostrata {

/// What of a SurfaceStyle shading needs, looked up once.
struct SurfaceMaterial {
  enum class Texture { none, stripes, map };

  bool own_color = false;
  Rgb color{1, 1, 1};
  float opacity = 1, ambient = 0.25f, diffuse = 0.75f, specular = 0.3f, shininess = 30, silhouette = 0;
  Texture texture = Texture::none;
  float texture_scale = 1, texture_offset = 0;  // periods = scale * value + offset
  std::optional<ColorMap> map;                  // of Texture::map
};

/// Throws not_found if the texture is neither "stripes" nor a colour map.
inline SurfaceMaterial surface_material(const SurfaceStyle& style) {
  SurfaceMaterial m;
  m.own_color = style.own_color;
  m.color = style.color;
  m.opacity = static_cast<float>(style.opacity);
  m.ambient = static_cast<float>(style.ambient);
  m.diffuse = static_cast<float>(style.diffuse);
  m.specular = static_cast<float>(style.specular);
  m.shininess = static_cast<float>(style.shininess);
  m.silhouette = static_cast<float>(style.silhouette);
  if (style.texture.empty()) return m;
  m.texture = style.texture == kStripes ? SurfaceMaterial::Texture::stripes : SurfaceMaterial::Texture::map;
  if (m.texture == SurfaceMaterial::Texture::map) m.map = color_map(style.texture);
  const double range = style.texture_upper - style.texture_lower;  // an empty range shows the texture's beginning
  const double scale = range != 0 ? style.texture_repeat / range : 0;
  m.texture_scale = static_cast<float>(scale);
  m.texture_offset = static_cast<float>(-style.texture_lower * scale);
  return m;
}

/// Premultiplied: color <= alpha in each channel, all in [0, 1], never NaN.
struct SurfaceColor {
  Rgb color{};
  float alpha = 0;
};

/// NaN becomes 0: a comparison with NaN is false.
inline float saturate(float v) { return v > 0 ? (v < 1 ? v : 1.0f) : 0.0f; }

/// Where `periods` stands in a colour map that runs to and fro (as GL_MIRRORED_REPEAT): 0 to 1 in the first period, 1 to 0 in
/// the second, and so on, also below 0. Mirrored, because a map that jumps back to its beginning draws an edge that is not in
/// the data.
inline float mirrored(float periods) {
  const float s = periods - 2.0f * std::floor(0.5f * periods);  // [0, 2)
  return 1.0f - std::fabs(1.0f - s);
}

/// How dark "stripes" are there, in [0, 1]: wrapped, one dark stripe in the middle half of each period, with soft edges a
/// sixteenth of a period wide.
inline float stripe(float periods) {
  const float s = periods - std::floor(periods);  // [0, 1)
  return saturate(0.5f + 16.0f * (0.25f - std::fabs(s - 0.5f)));
}

/// The surface seen from where `view` points.
/// base: the interval's colour at that point, constant or mapped; straight display values.
/// normal: unit, of either sign, or what interpolation made of such ones: shorter.
/// facet: the facet's own normal, unit, of either sign. It takes over where interpolated normals cancel: a surface that folds within
/// a facet has opposite ones at its corners, and what is left between them points anywhere. Zero or NaN of both counts as facing
/// the eye, so that a flat field's surface is not black.
/// view: unit, from the surface towards the eye; with an orthographic camera against the rays.
/// texture_value: DrawInput::texture_values there; NaN shows no texture. Values outside the texture's range go on repeating.
inline SurfaceColor shade_surface(const SurfaceMaterial& m, const Rgb& base, Vec3f normal, Vec3f facet, Vec3f view,
                                  float texture_value) {
  Rgb color = m.own_color ? m.color : base;
  if (m.texture != SurfaceMaterial::Texture::none) {
    const float periods = m.texture_scale * texture_value + m.texture_offset;
    if (std::fabs(periods) < 1e6f) {  // false for NaN; beyond, single precision holds no fraction of a period
      if (m.texture == SurfaceMaterial::Texture::map)
        color = sample(*m.map, mirrored(periods));
      else
        for (float& channel : color) channel *= 1.0f - 0.8f * stripe(periods);
    }
  }

  const float nn = dot(normal, normal);
  const float trust = saturate((nn - 0.0625f) * (1.0f / 0.1875f));  // from a length of a quarter to a half
  const float carried = trust > 0 ? std::fabs(dot(normal, view)) / std::sqrt(nn) : 0.0f;
  const float own = dot(facet, facet) > 0.25f ? std::fabs(dot(facet, view)) : 1.0f;
  const float c = saturate(trust * carried + (1.0f - trust) * own);
  const float lit = m.ambient + m.diffuse * c;
  const float glint = m.specular > 0 ? m.specular * std::pow(c, m.shininess) : 0.0f;

  const float e = (1.0f - c) * (1.0f - c);
  const float edge = m.silhouette * e * e;                    // 1 if seen edge-on
  const float alpha = m.opacity + (1.0f - m.opacity) * edge;  // towards opaque
  const float keep = alpha * (1.0f - edge);                   // and towards black
  SurfaceColor out;
  out.alpha = saturate(alpha);
  for (std::size_t i = 0; i < 3; ++i) out.color[i] = saturate(keep) * saturate(color[i] * lit + glint);
  return out;
}

}  // namespace isostrata
