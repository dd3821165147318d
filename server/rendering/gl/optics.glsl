// Colour, extinction and their integral over a segment; a style is STYLE_TEXELS texels.
layout(binding = UNIT_STYLES) uniform samplerBuffer styles;
layout(binding = UNIT_MAPS) uniform sampler2D maps;
#ifdef TABLE_2D
layout(binding = UNIT_TABLES) uniform sampler2DArray tables;
#endif

// NaN becomes 0.
float saturate(float v) { return v > 0.0 ? min(v, 1.0) : 0.0; }

vec3 map_color(float row, float u) {
  vec2 size = vec2(textureSize(maps, 0));
  return textureLod(maps, vec2((saturate(u) * (size.x - 1.0) + 0.5) / size.x, (row + 0.5) / size.y), 0.0).rgb;
}

// Of the interval at u, the color-by value's place in the style's range.
vec3 color_at(vec4 rgb_extinction, vec4 map, float u) { return map.x < 0.0 ? rgb_extinction.rgb : map_color(map.x, u); }

// 1 - exp(-tau); by its series where the subtraction would lose the digits that many thin layers need.
float opacity_of(float tau) {
  return tau < 0.1 ? tau * (1.0 - tau * (0.5 - tau * (1.0 / 6.0 - tau * (1.0 / 24.0 - tau * (1.0 / 120.0))))) : 1.0 - exp(-tau);
}

// Where in a segment of this opacity the light that leaves it comes from on average, as a share of its length: 1 / tau - (1 - alpha) / alpha.
float middle_of_light(float alpha) {
  return alpha < 0.05 ? 0.5 - alpha * (1.0 / 12.0 + alpha / 24.0) : -1.0 / log(max(1.0 - alpha, 1e-7)) - (1.0 - alpha) / alpha;
}

vec4 constant_light(vec4 rgb_extinction, float path) {
  float alpha = opacity_of(rgb_extinction.a * path);
  return vec4(rgb_extinction.rgb * alpha, alpha);
}

#ifdef LINEAR_COLOR
#ifdef LINEAR_EXTINCTION
// Over a part of the segment in which extinction is linear from e0 to e1. The light is the integral of the colour over the opacity
// reached so far, from 0 to alpha: with w = that share, the place s(w) in the segment is known in closed form (the optical depth is
// quadratic in s), so the exponential is exact and Gauss-Legendre only has to meet color(s(w)). s(w) rises like a logarithm towards
// w = 1 in thick segments, so the points are those of w = 1 - (1 - x)^2; and where extinction is constant they are moved by the
// factor that makes their mean the true mean of s, so that a linear colour is met exactly.
vec4 linear_part(vec4 rgb_extinction, vec4 map, float path, float u0, float u1) {
  float e0 = mix(rgb_extinction.a, map.w, saturate(u0)), e1 = mix(rgb_extinction.a, map.w, saturate(u1));
  float tau = 0.5 * (e0 + e1) * path;
  float alpha = opacity_of(tau);
  if (map.x < 0.0) return vec4(rgb_extinction.rgb * alpha, alpha);
  const vec3 x = vec3(0.112701665379258, 0.5, 0.887298334620742);
  const vec3 share = 1.0 - (1.0 - x) * (1.0 - x);
  const vec3 weight = 2.0 * (1.0 - x) * vec3(5.0, 8.0, 5.0) / 18.0;
  float slope = e1 - e0;
  vec3 s = share;
  if (e0 + e1 > 0.0) {
    for (int i = 0; i < 3; ++i) {
      float reached = share[i] * alpha;
      float depth = share[i] * tau;  // optical depth there: -log(1 - reached)
      if (tau > 1e-4) depth = reached < 0.02 ? reached * (1.0 + reached * (0.5 + reached * (1.0 / 3.0 + reached * 0.25))) : -log(1.0 - reached);
      depth = min(depth, tau) / tau * 0.5 * (e0 + e1);
      s[i] = tau > 0.0 ? 2.0 * depth / (e0 + sqrt(max(e0 * e0 + 2.0 * slope * depth, 0.0))) : share[i];
    }
    if (slope == 0.0 && tau > 1e-4) {
      float mean = tau < 0.1 ? 0.5 - tau * (1.0 / 12.0 - tau * tau / 720.0) : 1.0 / tau - (1.0 - alpha) / alpha;
      s *= mean / dot(weight, s);
    }
  }
  vec3 rgb = vec3(0.0);
  for (int i = 0; i < 3; ++i) rgb += weight[i] * map_color(map.x, mix(u0, u1, clamp(s[i], 0.0, 1.0)));
  return vec4(rgb * alpha, alpha);
}
#else
// Over a part of the segment, extinction constant and colour linear from u0 to u1: in closed form.
vec4 linear_part(vec4 rgb_extinction, vec4 map, float path, float u0, float u1) {
  float tau = rgb_extinction.a * path;
  float alpha = opacity_of(tau);
  float back_weight = tau < 0.1 ? tau * (0.5 - tau * (1.0 / 3.0 - tau * (1.0 / 8.0 - tau * (1.0 / 30.0)))) : alpha / tau - (1.0 - alpha);
  return vec4(color_at(rgb_extinction, map, u0) * (alpha - back_weight) + color_at(rgb_extinction, map, u1) * back_weight, alpha);
}
#endif

// Color-by values from front to back over a segment of this length.
vec4 linear_light(int style, vec4 rgb_extinction, vec4 map, float path, float front, float back) {
  float u0 = front * map.y + map.z, u1 = back * map.y + map.z;
  if (isnan(u0)) u0 = 0.0;
  if (isnan(u1)) u1 = 0.0;
#ifdef TABLE_2D
  float layer = texelFetch(styles, STYLE_TEXELS * style + 4).w;
  if (layer < 0.0) return constant_light(rgb_extinction, path);
  vec2 size = vec2(textureSize(tables, 0).xy);
  vec2 at = vec2(path / (path + frame.table.x), saturate(0.5 * (front + back) * map.y + map.z));
  return textureLod(tables, vec3((at * (size - 1.0) + 0.5) / size, layer), 0.0);
#else
  if (map.x < 0.0 && rgb_extinction.a == map.w) return constant_light(rgb_extinction, path);
  // Colour and extinction stand still outside the range, so a segment that passes an end of it has parts; and one that runs over much
  // of a colour map is cut as finely as the map is.
  float low = min(u0, u1), high = max(u0, u1);
  vec2 inside = vec2(0.0, 1.0);  // the shares of the segment where u enters and leaves [0, 1]
  if (high > low && (low < 0.0 || high > 1.0)) {
    vec2 ends = clamp((vec2(0.0, 1.0) - u0) / (u1 - u0), 0.0, 1.0);
    inside = vec2(min(ends.x, ends.y), max(ends.x, ends.y));
    if (high <= 0.0 || low >= 1.0) inside = vec2(0.0, 1.0);
  }
  float width = inside.y - inside.x;
#ifdef LINEAR_EXTINCTION
  float fineness = 16.0;
#else
  float fineness = 51.0;  // the built-in maps' own samples: between them colour is linear
#endif
  int parts = map.x < 0.0 ? 1 : 1 + int(min(fineness * abs(saturate(mix(u0, u1, inside.y)) - saturate(mix(u0, u1, inside.x))), 47.0));
  // One loop for all parts: llvmpipe runs both sides of an if, but leaves a loop.
  vec4 sum = vec4(0.0);
  int last = inside.y < 1.0 ? parts : parts - 1;
  for (int part = inside.x > 0.0 ? -1 : 0; part <= last; ++part) {
    float from = part < 0 ? 0.0 : inside.x + width * (float(part) / float(parts));
    float to = part == parts ? 1.0 : inside.x + width * (float(part + 1) / float(parts));
    sum += (1.0 - sum.a) * linear_part(rgb_extinction, map, path * (to - from), mix(u0, u1, from), mix(u0, u1, to));
  }
  return sum;
#endif
}
#endif
