// One batch of one tile a work group: the light of its tetrahedra, nearest first, and what they let through, for each pixel. Over is
// associative, so batches need not wait for one another.
//
// A chunk of 256 tetrahedra at a time. First each invocation has a tetrahedron: it makes its four planes and marks the pixels whose rays
// meet it, a bit in each pixel's mask. Then each has a pixel and goes through the bits of its mask, which are in order whoever set them.
// So the work is that of the fragments, however small the tetrahedra are.
//
// A plane is affine in the pixel: perspective with u = 1 / z, orthographic with u = -z, so that u falls along the ray. The ray is inside
// from the least u of the faces that are turned to the eye to the greatest of the others; a face is turned to the eye, or not, for all
// pixels alike, also where it reaches behind the eye. All u are counted from the tetrahedron's farthest point, and pixels too, so that
// what is small stays exact however far the eye is.
layout(local_size_x = TILE_GROUP) in;
layout(location = TILE_UNIFORM_SLICES) uniform uint slices;
layout(location = TILE_UNIFORM_SLICE) uniform uint slice;
layout(std430, binding = TILE_PAIRS) readonly restrict buffer PairBuffer { uvec2 pairs[]; };
layout(std430, binding = TILE_RANGES) readonly restrict buffer RangeBuffer { uvec2 ranges[]; };
layout(std430, binding = TILE_BATCHES) readonly restrict buffer BatchBuffer { uint batches[]; };
layout(std430, binding = TILE_LIGHT) writeonly restrict buffer LightBuffer { vec4 light[]; };
#ifdef MEAN_DEPTH
layout(std430, binding = TILE_NEAREST) writeonly restrict buffer NearestBuffer { vec2 nearest[]; };
#elif defined NEAREST_DEPTH
layout(std430, binding = TILE_NEAREST) writeonly restrict buffer NearestBuffer { float nearest[]; };
#endif
#ifdef LINEAR_COLOR
layout(std430, binding = TILE_VALUES) readonly restrict buffer ValueBuffer { float values[]; };
#endif
#ifdef WITH_NORMALS
layout(std430, binding = TILE_NORMALS) readonly restrict buffer NormalBuffer { float normals[]; };
#endif
#ifdef BODY_SHADING
layout(std430, binding = TILE_SHADES) readonly restrict buffer ShadeBuffer { float shades[]; };
#endif
#ifdef WITH_TEXTURE
layout(std430, binding = TILE_TEXTURE) readonly restrict buffer TextureBuffer { float textured[]; };
#endif

const float kFar = 1e30;

shared vec4 plane_x[TILE_GROUP], plane_y[TILE_GROUP];  // of four faces: the slopes of u
shared vec4 reference[TILE_GROUP];                     // the farthest point: on the screen, its u; u of face 0 there, less that
shared float highest[TILE_GROUP];                      // u of the nearest point, less the reference's
shared uint flags[TILE_GROUP];                         // bits 0-3: faces turned to the eye; 4: reaches behind the eye; 5-6: which point is
                                                       // farthest; 8-15: labels of the faces; 16-31: interval
#define BEHIND 16u
#ifdef LINEAR_COLOR
shared vec4 scalar_of[TILE_GROUP];  // the color-by value's place in its range at the reference, its slopes
#ifdef BODY_SHADING
shared uint scalar_range[TILE_GROUP];  // two halves, a little too wide: all has to fit into 32 KiB
#else
shared vec2 scalar_range[TILE_GROUP];
#endif
#endif
#ifdef BODY_SHADING
shared vec4 shade_of[TILE_GROUP];  // of the light that is left at the reference, its slopes
#endif
shared uint masks[8 * TILE_GROUP];  // [tetrahedron / 32][pixel]
shared uvec3 batch;                 // tile, first pair, end
shared uint unfilled;               // whether some pixel is not yet full
shared uint fragments, late;

vec3 ray_of(vec2 at) { return perspective() ? vec3(at * frame.lens.y, 1.0) : vec3(0.0, 0.0, 1.0); }

// What camera and clip planes leave of a pixel's ray: greatest and least u.
vec2 range_of(vec2 at) {
  vec2 range = perspective() ? vec2(1.0 / frame.limits.x, 0.0) : vec2(kFar, -kFar);
  const vec2 nothing = vec2(-kFar, kFar);
  for (uint i = 0u; i < frame.keys.w; ++i) {
    vec4 plane = clip_planes[i];
    if (perspective()) {
      float along = dot(plane.xyz, ray_of(at));
      if (plane.w > 0.0) {
        if (along <= 0.0) return nothing;
        range.x = min(range.x, along / plane.w);
      } else if (along < 0.0) {
        if (plane.w == 0.0) return nothing;
        range.y = max(range.y, along / plane.w);
      }
    } else {
      float rest = plane.w - dot(plane.xy, at * frame.lens.y);
      if (plane.z > 0.0) range.x = min(range.x, -rest / plane.z);
      if (plane.z < 0.0) range.y = max(range.y, -rest / plane.z);
      if (plane.z == 0.0 && rest > 0.0) return nothing;
    }
  }
  return range;
}

vec4 planes_at(uint j, vec2 at) {
  vec2 d = at - reference[j].xy;
  vec4 u = plane_x[j] * d.x + plane_y[j] * d.y;
  u.x += reference[j].w;
  return u;
}
vec4 front_planes(uint j, vec4 u) {
  return mix(vec4(kFar), u, notEqual(uvec4(flags[j]) & uvec4(1u, 2u, 4u, 8u), uvec4(0u)));
}
vec4 back_planes(uint j, vec4 u) {
  return mix(u, vec4(-kFar), notEqual(uvec4(flags[j]) & uvec4(1u, 2u, 4u, 8u), uvec4(0u)));
}
float least_of(vec4 v) { return min(min(v.x, v.y), min(v.z, v.w)); }
float greatest_of(vec4 v) { return max(max(v.x, v.y), max(v.z, v.w)); }

// From which u to which the ray is inside, less the reference's; whatever cuts the ray. False if it misses.
bool meets(uint j, vec2 at, vec2 range, out vec4 u, out float enter, out float leave) {
  u = planes_at(j, at);
  float from = reference[j].z;
  enter = min(min(highest[j], range.x - from), least_of(front_planes(j, u)));
  leave = max(max((flags[j] & BEHIND) != 0u ? -kFar : 0.0, range.y - from), greatest_of(back_planes(j, u)));
  return enter > leave;
}

#if defined LINEAR_COLOR || defined BODY_SHADING
// What is linear in a tetrahedron and has these values at its points: the value at the first, the slopes in the pixel and against u.
vec4 in_screen(vec4 s, vec3 p0, vec3 e1, vec3 e2, vec3 e3, float six_volumes) {
  vec3 gradient = cross(e2, e3) * (s.y - s.x) + cross(e3, e1) * (s.z - s.x) + cross(e1, e2) * (s.w - s.x);
  gradient *= six_volumes != 0.0 ? 1.0 / six_volumes : 0.0;
  return vec4(s.x, gradient.xy * frame.lens.y, perspective() ? dot(gradient, p0) : gradient.z);
}
// Where the ray is at u, less the reference's.
float on_ray(uint j, vec4 s, vec2 at, float u) {
  vec2 d = at - reference[j].xy;
  float change = s.y * d.x + s.z * d.y - s.w * u;
  return s.x + (perspective() ? change / (reference[j].z + u) : change);
}
#endif
#ifdef LINEAR_COLOR
#ifdef BODY_SHADING
void keep_range(uint j, vec2 range) { scalar_range[j] = packHalf2x16(range + vec2(-1e-3, 1e-3) * (1.0 + abs(range))); }
vec2 range_kept(uint j) { return unpackHalf2x16(scalar_range[j]); }
#else
void keep_range(uint j, vec2 range) { scalar_range[j] = range; }
vec2 range_kept(uint j) { return scalar_range[j]; }
#endif
#endif

// Makes place j of the chunk from a tetrahedron. box: the part's pixels that it may cover.
bool load(uint j, uint id, out ivec4 box) {
  uvec4 given = tetrahedra[id];
  uint point[4] = uint[4](given.x, given.y, given.z, given.w);
  vec3 r[4] = vec3[4](turned(given.x), turned(given.y), turned(given.z), turned(given.w));
  uint info = infos[id], interval = info & TILE_INFO_INTERVAL, labels = info >> TILE_INFO_LABELS & 0xffu;
  uint far = 0u;
  float far_z = r[0].z;
  for (uint v = 1u; v < 4u; ++v)
    if (r[v].z > far_z) {
      far = v;
      far_z = r[v].z;
    }
  float turn = (info & TILE_INFO_TURNED) != 0u ? -1.0 : 1.0;
  for (uint v = 1u; v < 4u; ++v)
    if (far == v) {
      vec3 other = r[0];
      r[0] = r[v];
      r[v] = other;
      uint other_point = point[0];
      point[0] = point[v];
      point[v] = other_point;
      turn = -turn;
      uint swapped = (labels ^ labels >> 2u * v) & 3u;
      labels ^= swapped | swapped << 2u * v;
    }
  vec3 origin = view_origin(), p0 = r[0] + origin;
  vec3 e1 = r[1] - r[0], e2 = r[2] - r[0], e3 = r[3] - r[0];
  vec3 c23 = cross(e2, e3);
  // Normals outwards, of faces opposite points 0 to 3.
  vec3 n[4] = vec3[4](cross(e2 - e1, e3 - e1) * turn, -turn * c23, -turn * cross(e3, e1), -turn * cross(e1, e2));
  float six_volumes = max(dot(c23, e1) * turn, 0.0);
  float nearest_z = min(min(r[1].z, r[2].z), r[3].z) + origin.z;
  bool behind = perspective() && nearest_z < frame.limits.x;
  vec4 divisor = perspective() ? vec4(dot(n[0], p0 + e1), dot(n[1], p0), dot(n[2], p0), dot(n[3], p0))
                               : vec4(n[0].z, n[1].z, n[2].z, n[3].z);
  // A face seen edge-on is as steep as its digits allow.
  vec4 size = vec4(length(n[0]), length(n[1]), length(n[2]), length(n[3])) * (perspective() ? length(p0) : 1.0);
  divisor = mix(vec4(1.0), vec4(-1.0), lessThan(divisor, vec4(0.0))) * max(abs(divisor), size * 1e-7 + 1e-30);
  uvec4 front = mix(uvec4(0u), uvec4(1u, 2u, 4u, 8u), lessThan(divisor, vec4(0.0)));
  vec4 slope = frame.lens.y / divisor;
  plane_x[j] = vec4(n[0].x, n[1].x, n[2].x, n[3].x) * slope;
  plane_y[j] = vec4(n[0].y, n[1].y, n[2].y, n[3].y) * slope;
  float u0 = perspective() ? 1.0 / p0.z : -p0.z;
  reference[j] = vec4(on_screen(p0), u0, -six_volumes / divisor.x * (perspective() ? u0 : 1.0));
  highest[j] = behind ? kFar : perspective() ? (far_z - (nearest_z - origin.z)) * u0 / nearest_z : p0.z - nearest_z;
  flags[j] = front.x | front.y | front.z | front.w | (behind ? BEHIND : 0u) | far << 5u | labels << 8u | interval << 16u;
#ifdef LINEAR_COLOR
  vec4 range = style_row(interval, TILE_STYLE_RANGE);
  vec4 s = vec4(values[point[0]], values[point[1]], values[point[2]], values[point[3]]);
  s = (s - range.x) * range.y;
  s = mix(s, vec4(0.0), isnan(s));
  scalar_of[j] = in_screen(s, p0, e1, e2, e3, six_volumes * turn);
  keep_range(j, vec2(least_of(s), greatest_of(s)));
#endif
#ifdef BODY_SHADING
  shade_of[j] = in_screen(vec4(shades[point[0]], shades[point[1]], shades[point[2]], shades[point[3]]), p0, e1, e2, e3, six_volumes * turn);
#endif
  vec3 p[4] = vec3[4](p0, r[1] + origin, r[2] + origin, r[3] + origin);
  return covered_box(p, box);
}

// 1 - exp(-tau), by its series where the subtraction would lose the digits that many thin layers need.
float absorbed(float tau) {
  return tau < 0.1 ? tau * (1.0 - tau * (0.5 - tau * (1.0 / 6.0 - tau * (1.0 / 24.0 - tau * (1.0 / 120.0))))) : 1.0 - exp(-tau);
}

vec3 map_color(float first, float steps, float place) {
  float at = clamp(place, 0.0, 1.0) * steps, low = min(floor(at), steps - 1.0);
  uint i = uint(first + low);
  return mix(styles[i].rgb, styles[i + 1u].rgb, at - low);
}
vec3 interval_color(uint interval, float place) {
  vec4 row = style_row(interval, TILE_STYLE_LIGHT);
  return row.y < 0.0 ? style_row(interval, TILE_STYLE_COLOR).rgb : map_color(row.y, row.z, place);
}

#ifdef LINEAR_COLOR
// The color-by value's place in its range where the ray is at u, less the reference's.
float place_at(uint j, vec2 at, float u) {
  vec2 range = range_kept(j);
  return clamp(on_ray(j, scalar_of[j], at, u), range.x, range.y);
}

// Colour and extinction linear along the ray between the map's colours: Gauss-Legendre with three points in pieces of optical depth of at
// most 1 and few colours; the colours' weights are scaled to what is absorbed, which is known exactly.
vec4 segment_light(uint interval, float path, float front, float back) {
  vec4 color = style_row(interval, TILE_STYLE_COLOR), row = style_row(interval, TILE_STYLE_LIGHT);
  if (row.y < 0.0 && color.a == row.x) {
    float alpha = absorbed(color.a * path);
    return vec4(color.rgb * alpha, alpha);
  }
#ifdef TABLE_2D
  float mean = clamp(0.5 * (front + back), 0.0, 1.0), alpha = absorbed(mix(color.a, row.x, mean) * path);
  return vec4((row.y < 0.0 ? color.rgb : map_color(row.y, row.z, mean)) * alpha, alpha);
#else
  float pieces = clamp(ceil(max(max(color.a, row.x) * path, abs(back - front) * row.z * 0.25)), 1.0, 64.0), length = path / pieces;
  vec3 sum = vec3(0.0);
  float through = 1.0;
  for (float i = 0.0; i < pieces && through > 1e-7; i += 1.0) {
    float a = mix(front, back, i / pieces), b = mix(front, back, (i + 1.0) / pieces);
    float from = mix(color.a, row.x, clamp(a, 0.0, 1.0)), to = mix(color.a, row.x, clamp(b, 0.0, 1.0));
    const vec3 kPoint = vec3(0.1127016653792583, 0.5, 0.8872983346207417), kWeight = vec3(5.0, 8.0, 5.0);
    vec3 tau = length * kPoint * (from + 0.5 * kPoint * (to - from));
    vec3 weight = kWeight * (from + kPoint * (to - from)) * exp(-tau);
    float alpha = absorbed(0.5 * length * (from + to)), all = weight.x + weight.y + weight.z;
    weight *= all > 0.0 ? through * alpha / all : 0.0;
    if (row.y < 0.0)
      sum += color.rgb * (weight.x + weight.y + weight.z);
    else
      for (int k = 0; k < 3; ++k) sum += map_color(row.y, row.z, mix(a, b, kPoint[k])) * weight[k];
    through *= 1.0 - alpha;
  }
  return vec4(sum, pieces == 1.0 ? absorbed(0.5 * length * (mix(color.a, row.x, clamp(front, 0.0, 1.0)) + mix(color.a, row.x, clamp(back, 0.0, 1.0))))
                                 : 1.0 - through);
#endif
}
#else
vec4 segment_light(uint interval, float path, float front, float back) {
  vec4 color = style_row(interval, TILE_STYLE_COLOR);
  float alpha = absorbed(color.a * path);
  return vec4(color.rgb * alpha, alpha);
}
#endif

#ifdef SURFACES
// shade_surface of surface_shading.h, line by line.
vec4 shade_surface(uint interval, vec3 base, vec3 normal, vec3 facet, vec3 view, float texture_value) {
  vec4 own = style_row(interval, TILE_STYLE_SURFACE), shading = style_row(interval, TILE_STYLE_SHADING),
       look = style_row(interval, TILE_STYLE_TEXTURE), pattern = style_row(interval, TILE_STYLE_TEXTURED);
  vec3 color = look.y > 0.5 ? own.rgb : base;
  float periods = pattern.x * texture_value + pattern.y;
  if (look.z > 0.5 && abs(periods) < 1e6) {
    if (look.z > 1.5) {
      float s = periods - 2.0 * floor(0.5 * periods);
      color = map_color(look.w, pattern.z, 1.0 - abs(1.0 - s));
    } else {
      float s = periods - floor(periods);
      color *= 1.0 - 0.8 * clamp(0.5 + 16.0 * (0.25 - abs(s - 0.5)), 0.0, 1.0);
    }
  }
  float nn = dot(normal, normal);
  float trust = clamp((nn - 0.0625) * (1.0 / 0.1875), 0.0, 1.0);
  float carried = trust > 0.0 ? abs(dot(normal, view)) / sqrt(nn) : 0.0;
  float facing = dot(facet, facet) > 0.25 ? abs(dot(facet, view)) : 1.0;
  float c = clamp(trust * carried + (1.0 - trust) * facing, 0.0, 1.0);
  float lit = shading.x + shading.y * c;
  float glint = shading.z > 0.0 ? shading.z * (c > 0.0 ? pow(c, shading.w) : (shading.w > 0.0 ? 0.0 : 1.0)) : 0.0;
  float e = (1.0 - c) * (1.0 - c), edge = look.x * e * e;
  float alpha = own.a + (1.0 - own.a) * edge, keep = alpha * (1.0 - edge);
  return vec4(clamp(keep, 0.0, 1.0) * clamp(color * lit + glint, 0.0, 1.0), clamp(alpha, 0.0, 1.0));
}

bool draws_surface(uint j, uint face) {
  uint label = flags[j] >> (8u + 2u * face) & 3u;
  return label != 0u && (uint(style_row(flags[j] >> 16, TILE_STYLE_RANGE).w) >> (label - 1u) & 1u) != 0u;
}

// The surface on a face of tetrahedron `id`, which is at place j, where the ray is at u, less the reference's.
vec4 surface_light(uint j, uint id, uint face, vec2 at, float u) {
  uvec4 given = tetrahedra[id];
  uint point[4] = uint[4](given.x, given.y, given.z, given.w), far = flags[j] >> 5u & 3u, interval = flags[j] >> 16;
  uint first = point[0];  // as load() swapped them
  point[0] = point[far];
  point[far] = first;
  uint a = point[face == 0u ? 1 : 0], b = point[face <= 1u ? 2 : 1], c = point[face == 3u ? 2 : 3];
  vec3 from = turned(a), e1 = turned(b) - from, e2 = turned(c) - from, normal = cross(e1, e2);
  float whole = u + reference[j].z;
  vec3 direction = ray_of(at), place = perspective() ? direction / whole : vec3(at * frame.lens.y, -whole);
  vec3 q = place - view_origin() - from;
  vec3 weight;
  weight.y = dot(cross(q, e2), normal) / dot(normal, normal);
  weight.z = dot(cross(e1, q), normal) / dot(normal, normal);
  weight.yz = clamp(weight.yz, 0.0, 1.0);
  weight.x = max(1.0 - weight.y - weight.z, 0.0);
  normal = normalize(normal);
  vec3 facet = normal;
#ifdef WITH_NORMALS
  vec3 world = weight.x * vec3(normals[3u * a], normals[3u * a + 1u], normals[3u * a + 2u]) +
               weight.y * vec3(normals[3u * b], normals[3u * b + 1u], normals[3u * b + 2u]) +
               weight.z * vec3(normals[3u * c], normals[3u * c + 1u], normals[3u * c + 2u]);
  normal = vec3(dot(frame.right.xyz, world), dot(frame.down.xyz, world), dot(frame.forward.xyz, world));
#endif
  float texture_value = 0.0;
#ifdef WITH_TEXTURE
  texture_value = dot(weight, vec3(textured[a], textured[b], textured[c]));
#endif
  float along = 0.0;
#ifdef LINEAR_COLOR
  vec4 range = style_row(interval, TILE_STYLE_RANGE);
  along = (dot(weight, vec3(values[a], values[b], values[c])) - range.x) * range.y;
  if (isnan(along)) along = 0.0;
#endif
  return shade_surface(interval, interval_color(interval, along), normal, facet, -normalize(direction), texture_value);
}
#endif

// ---- one pixel -------------------------------------------------------------------------------------------------------------------------

vec3 sum = vec3(0.0);
float through = 1.0, nearest_u = -kFar;
#if defined MEAN_DEPTH || defined BODY_SHADING
// Where in a segment of this opacity its light comes from on average, of its length: 1 / tau - (1 - alpha) / alpha.
float middle_of_light(float alpha) {
  return alpha < 0.05 ? 0.5 - alpha * (1.0 / 12.0 + alpha / 24.0) : -1.0 / log(max(1.0 - alpha, 1e-7)) - (1.0 - alpha) / alpha;
}
#endif
#ifdef MEAN_DEPTH
float depth_sum = 0.0;

// The depth of the light of a segment of this opacity.
float depth_of_light(float enter, float leave, float alpha) {
  vec2 depths = perspective() ? 1.0 / max(vec2(enter, leave), vec2(1e-9)) : -vec2(enter, leave);
  return mix(depths.x, depths.y, middle_of_light(alpha));
}
#endif
#ifdef ONE_COLOR
float depth = 0.0;  // optical
#endif

// depth: where on average it comes from.
void blend(vec4 color, float depth) {
  sum += through * color.rgb;
#ifdef MEAN_DEPTH
  depth_sum += through * color.a * depth;
#endif
  through *= 1.0 - color.a;
}

#if WINDOW > 0
// The last WINDOW fragments wait here, farthest first, for one that is late and lies before them.
float waiting_u[WINDOW];
vec4 waiting[WINDOW];
float waiting_depth[WINDOW];
#endif
float last_u = kFar;
uint came_late = 0u;

void blend_in_turn(float u, vec4 color, float depth) {
  if (u > last_u + 4e-6 * abs(u)) ++came_late;
  last_u = u;
  blend(color, depth);
}
void flush() {
#if WINDOW > 0
  for (int i = WINDOW - 1; i >= 0; --i) {
    if (waiting_u[i] < kFar) blend_in_turn(waiting_u[i], waiting[i], waiting_depth[i]);
    waiting_u[i] = kFar;
    waiting[i] = vec4(0.0);
    waiting_depth[i] = 0.0;
  }
#endif
}
void put(float u, vec4 color, float depth) {
#if WINDOW > 0
  for (int i = 0; i < WINDOW; ++i)
    if (u <= waiting_u[i]) {
      float other_u = waiting_u[i];
      vec4 other = waiting[i];
      float other_depth = waiting_depth[i];
      waiting_u[i] = u;
      waiting[i] = color;
      waiting_depth[i] = depth;
      u = other_u;
      color = other;
      depth = other_depth;
    }
  if (u < kFar) blend_in_turn(u, color, depth);
#else
  blend_in_turn(u, color, depth);
#endif
}

// Batches end where a cell does, so that the window has all of it.
uint end_of_cell(uint at, uvec2 range) {
  if (at <= range.x || at >= range.y) return min(at, range.y);
  while (at < range.y && runs[pairs[at].y] == runs[pairs[at - 1u].y]) ++at;
  return at;
}

void main() {
  uint t = gl_LocalInvocationIndex, all = batches[frame.part.z * frame.part.w], each = (all + slices - 1u) / slices;
  uint index = slice * each + work_group();
  bool any = work_group() < each && index < all;
  if (t == 0u) {
    uint low = 0u, high = frame.part.z * frame.part.w;  // the last tile whose batches begin at or before this one
    while (high - low > 1u) {
      uint middle = (low + high) / 2u;
      if (batches[middle] <= index)
        low = middle;
      else
        high = middle;
    }
    uvec2 range = ranges[low];
    uint first = range.x + (index - batches[low]) * frame.room.w, end = min(first + frame.room.w, range.y);
    if (frame.keys.x == TILE_ORDER_INDEX && any) {
      first = end_of_cell(first, range);
      end = end_of_cell(end, range);
    }
    batch = any ? uvec3(low, first, end) : uvec3(0u);
    unfilled = any ? 1u : 0u;
    fragments = late = 0u;
  }
  barrier();
  uint tile = batch.x, begin = batch.y, end = batch.z;
  ivec2 corner = ivec2(tile % frame.part.z, tile / frame.part.z) << TILE_SIDE_SHIFT;
  ivec2 pixel = corner + ivec2(t & 15u, t >> 4);
  bool inside = pixel.x < int(frame.part.x) && pixel.y < int(frame.part.y);
  vec2 at = sample_of(pixel), range = range_of(at);
  float length_of_ray = length(ray_of(at));
  uint met = 0u, group = 0u;
#if WINDOW > 0
  for (int i = 0; i < WINDOW; ++i) {
    waiting_u[i] = kFar;
    waiting[i] = vec4(0.0);
    waiting_depth[i] = 0.0;
  }
#endif

  for (uint chunk = begin; chunk < end && unfilled != 0u; chunk += TILE_GROUP) {
    for (uint w = 0u; w < 8u; ++w) masks[w * TILE_GROUP + t] = 0u;
    ivec4 box = ivec4(0, 0, -1, -1);
    if (chunk + t < end && !load(t, pairs[chunk + t].y, box)) box = ivec4(0, 0, -1, -1);
    barrier();
    if (t == 0u) unfilled = 0u;
    box = ivec4(max(box.xy - corner, ivec2(0)), min(box.zw - corner, ivec2(15)));
    for (int y = box.y; y <= box.w; ++y)
      for (int x = box.x; x <= box.z; ++x) {
        vec4 u;
        float enter, leave;
        if (meets(t, sample_of(corner + ivec2(x, y)), vec2(kFar, perspective() ? 0.0 : -kFar), u, enter, leave))
          atomicOr(masks[(t >> 5u) * TILE_GROUP + uint(y * 16 + x)], 1u << (t & 31u));
      }
    barrier();
    for (uint w = 0u; w < 8u; ++w) {
      uint bits = inside ? masks[w * TILE_GROUP + t] : 0u;
      while (bits != 0u && through > frame.limits.y) {
        uint j = w * 32u + uint(findLSB(bits));
        bits &= bits - 1u;
        vec4 u;
        float enter, leave;
        if (!meets(j, at, range, u, enter, leave)) continue;
        ++met;
        uint interval = flags[j] >> 16;
        float from = reference[j].z;
        float path = enter - leave;
        if (perspective()) path *= length_of_ray / (max(from + enter, 1e-9) * max(from + leave, 1e-9));
#ifdef ONE_COLOR
        depth += style_row(interval, TILE_STYLE_COLOR).a * path;
        through = exp(-depth);
#ifdef NEAREST_DEPTH
        nearest_u = max(nearest_u, from + enter);
#endif
#else
        uint its_group = uint(style_row(interval, TILE_STYLE_LIGHT).w);
        if (its_group != group) {
          flush();
          last_u = kFar;
          group = its_group;
        }
        float front = 0.0, back = 0.0;
#ifdef LINEAR_COLOR
        front = place_at(j, at, enter);
        back = place_at(j, at, leave);
#endif
        vec4 color = segment_light(interval, path, front, back);
#ifdef BODY_SHADING
        vec2 shade = clamp(vec2(on_ray(j, shade_of[j], at, enter), on_ray(j, shade_of[j], at, leave)), 0.0, 1.0);
        color.rgb *= mix(shade.x, shade.y, middle_of_light(color.a));
#endif
        float middle = 0.0;
#ifdef MEAN_DEPTH
        middle = depth_of_light(from + enter, from + leave, color.a);
#endif
#ifdef SURFACES
        // The surface that is entered through, the segment, the surface that is left through. Of two surfaces at one place the one through
        // which the ray leaves comes first, however their u are rounded.
        vec4 fronts = front_planes(j, u), backs = back_planes(j, u);
        float first = least_of(fronts), last = greatest_of(backs), aside = min(2e-6 * abs(from + enter), 0.25 * (enter - leave));
        uint entered = fronts.x == first ? 0u : fronts.y == first ? 1u : fronts.z == first ? 2u : 3u;
        uint left = backs.x == last ? 0u : backs.y == last ? 1u : backs.z == last ? 2u : 3u;
        bvec2 drawn = bvec2(first < range.x - from && first < kFar && draws_surface(j, entered),
                            last > range.y - from && last > -kFar && draws_surface(j, left));
        for (int step = drawn.x ? 0 : 1; step < (drawn.y ? 3 : 2); ++step) {
          float place = step == 2 ? leave : enter;
          vec4 shown = step == 1 ? color : surface_light(j, pairs[chunk + j].y, step == 0 ? entered : left, at, place);
          float depth = step == 1 ? middle : perspective() ? 1.0 / max(from + place, 1e-9) : -(from + place);
          put(from + (step == 0 ? enter - aside : step == 1 ? 0.5 * (enter + leave) : leave + aside), shown, depth);
#ifdef NEAREST_DEPTH
          if (shown.a > 0.0) nearest_u = max(nearest_u, from + place);
#endif
        }
#else
        put(from + 0.5 * (enter + leave), color, middle);
#ifdef NEAREST_DEPTH
        if (color.a > 0.0) nearest_u = max(nearest_u, from + enter);
#endif
#endif
#endif
      }
    }
    if (inside && through > frame.limits.y) atomicOr(unfilled, 1u);
    barrier();
  }

#ifdef ONE_COLOR
  uint first_interval = uint(frame.background.w) >> 1u;
  float alpha = absorbed(depth);
  sum = style_row(first_interval, TILE_STYLE_COLOR).rgb * alpha;
  through = 1.0 - alpha;
#else
  flush();
#endif
  if (any) {
    light[index * TILE_GROUP + t] = vec4(sum, through);
#ifdef MEAN_DEPTH
    nearest[index * TILE_GROUP + t] = vec2(nearest_u, depth_sum);
#elif defined NEAREST_DEPTH
    nearest[index * TILE_GROUP + t] = nearest_u;
#endif
  }
  if (frame.limits.w > 0.5 && met > 0u) atomicAdd(fragments, met);
  if (came_late > 0u) atomicAdd(late, came_late);
  barrier();
  if (t == 0u) {
    if (late > 0u) atomicAdd(counters[TILE_COUNT_LATE], late);
    if (fragments > 0u) {
      uint before = atomicAdd(counters[TILE_COUNT_FRAGMENTS], fragments);
      if (before + fragments < before) atomicAdd(counters[TILE_COUNT_FRAGMENTS + 1], 1u);
    }
  }
}
