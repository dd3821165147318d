// Projects tetrahedra and facets, in the order of the list, into the vertices that projected_tetrahedra.cpp makes (projected_tetrahedra.h
// has the method): one invocation a tetrahedron. A work group packs its vertices one after another into its own part of the buffer and
// writes the draw command for them, so that nothing is counted twice and nothing waits for another group.
//
// In single precision what is small must not come from the difference of what is large: edges are turned into view space as differences of
// the mesh's points, and areas and differences of nearness are made of those. Screen positions are made of the point alone, the same way
// for all tetrahedra that share it, so that their sides meet.
layout(local_size_x = PROJECT_GROUP) in;
layout(std430, binding = BUFFER_MESH_POINTS) readonly restrict buffer PointBuffer { vec4 points[]; };
layout(std430, binding = BUFFER_MESH_CELLS) readonly restrict buffer CellBuffer { uvec4 cells[]; };
layout(std430, binding = BUFFER_INTERVALS) readonly restrict buffer IntervalBuffer { uint intervals[]; };
layout(std430, binding = BUFFER_DRAWN_ORDER) readonly restrict buffer OrderBuffer { uint order[]; };
layout(std430, binding = BUFFER_DRAWN_PARTS) readonly restrict buffer PartBuffer { uint parts[]; };
layout(std430, binding = BUFFER_VERTICES) writeonly restrict buffer VertexBuffer { uint vertices[]; };
layout(std430, binding = BUFFER_COMMANDS) writeonly restrict buffer CommandBuffer { DrawCommand commands[]; };
#ifdef SURFACES
layout(std430, binding = BUFFER_FACETS) readonly restrict buffer FacetBuffer { FacetCorner corners[]; };
layout(std430, binding = BUFFER_FACET_OF) readonly restrict buffer FacetOfBuffer { uint facet_of[]; };
layout(std430, binding = BUFFER_FACET_CELLS) readonly restrict buffer FacetCellBuffer { uvec2 facet_cells[]; };
#define MOST_VERTICES (PROJECTED_VERTICES + FACET_VERTICES)
#else
#define MOST_VERTICES PROJECTED_VERTICES
#endif
#ifdef BODY_SHADING
layout(std430, binding = BUFFER_SHADES) readonly restrict buffer ShadeBuffer { float shades[]; };
#define WORDS SHADED_VERTEX_WORDS
#elif defined LINEAR_COLOR
#define WORDS LINEAR_VERTEX_WORDS
#else
#define WORDS VERTEX_WORDS
#endif

const uint kTooNear = 1u, kLeft = 2u, kRight = 4u, kBelow = 8u, kAbove = 16u, kBeyondGuard = 32u;
const uint kUnseen = kTooNear | kLeft | kRight | kBelow | kAbove;
const float kSnap = 1.0 / 128.0;    // pixels
const float kWallShare = 1e-5;      // as in projected_tetrahedra.cpp, with fewer digits

layout(location = UNIFORM_BATCH) uniform uvec4 batch;  // first of the list, how many

shared uint group_sums[PROJECT_GROUP];

struct ScreenPoint {
  vec3 view;
  vec2 xy;  // pixels from the middle of the picture; where outside has kTooNear, times depth
  float q;
  uint outside;
};

ScreenPoint project(vec3 p) {
  ScreenPoint s;
  precise vec3 view = to_view(p);
  s.view = view;
#ifdef ORTHOGRAPHIC
  float w = 1.0;
  s.q = screen.z - view.z;
  s.outside = 0u;
#else
  float w = view.z;
  s.outside = w < screen.y ? kTooNear : 0u;
  s.q = s.outside != 0u ? 0.0 : 1.0 / w;
#endif
  precise vec2 xy = view.xy * screen.x + frame.axis.xy * w;
  s.outside |= (xy.x < -frame.picture.x * w ? kLeft : 0u) | (xy.x > frame.picture.x * w ? kRight : 0u) |
               (xy.y < -frame.picture.y * w ? kBelow : 0u) | (xy.y > frame.picture.y * w ? kAbove : 0u);
#ifndef ORTHOGRAPHIC
  precise vec2 divided = xy / w;
  if ((s.outside & kTooNear) == 0u) xy = divided;
#endif
  s.xy = xy;
  if (!(max(abs(xy.x), abs(xy.y)) <= frame.table.y)) s.outside |= kBeyondGuard;
  return s;
}

bool holds_center(float low, float high, float phase) { return floor(high + kSnap - phase) >= ceil(low - kSnap - phase); }

bool covers_pixel(vec2 a, vec2 b, vec2 c) {
  vec2 low = min(min(a, b), c), high = max(max(a, b), c);
  return all(lessThan(low, frame.picture.xy)) && all(greaterThan(high, -frame.picture.xy)) &&
         holds_center(low.x, high.x, frame.picture.z) && holds_center(low.y, high.y, frame.picture.w);
}

uint next_word = 0u;

void put(vec2 xy, float z, uvec3 tent, float q_min, uint style_kind, vec2 scalar, vec2 shade) {
  vertices[next_word] = floatBitsToUint(xy.x);
  vertices[next_word + 1u] = floatBitsToUint(xy.y);
  vertices[next_word + 2u] = floatBitsToUint(z);
  vertices[next_word + 3u] = tent.x;
  vertices[next_word + 4u] = tent.y;
  vertices[next_word + 5u] = tent.z;
  vertices[next_word + 6u] = floatBitsToUint(q_min);
  vertices[next_word + 7u] = style_kind;
#if defined LINEAR_COLOR || defined BODY_SHADING
  vertices[next_word + 8u] = floatBitsToUint(scalar.x);
  vertices[next_word + 9u] = floatBitsToUint(scalar.y);
#endif
#ifdef BODY_SHADING
  vertices[next_word + 10u] = floatBitsToUint(shade.x);
  vertices[next_word + 11u] = floatBitsToUint(shade.y);
#endif
  next_word += uint(WORDS);
}

void put_homogeneous(vec3 view, uint id, uint style_kind) {
#ifdef ORTHOGRAPHIC
  put(view.xy * screen.x + frame.axis.xy, 1.0, uvec3(id, 0u, 0u), 0.0, style_kind, vec2(0.0), vec2(0.0));
#else
  put(view.xy * screen.x + frame.axis.xy * view.z, view.z, uvec3(id, 0u, 0u), 0.0, style_kind, vec2(0.0), vec2(0.0));
#endif
}

#ifdef SURFACES
// The facets of a tetrahedron that are drawn and face the eye, or do not. Counts their vertices, or writes them.
uint facets(uint tetrahedron, uint style, uint drawn, bool facing, bool write) {
  uint count = 0u;
  uint facet = facet_of[tetrahedron];
  if (facet == NO_FACET) return 0u;
  for (uint end = facet + 4u; facet < end && facet < uint(facet_cells.length()); ++facet) {
    uvec2 of = facet_cells[facet];
    if (of.x != tetrahedron) break;
    if ((drawn & (DRAW_LABEL << (of.y & 3u))) == 0u) continue;
    vec3 p[3] = vec3[3](corners[3u * facet].position_scalar.xyz, corners[3u * facet + 1u].position_scalar.xyz,
                        corners[3u * facet + 2u].position_scalar.xyz);
    ScreenPoint a = project(p[0]), b = project(p[1]), c = project(p[2]);
    vec3 outwards = cross(turn_to_view(p[2] - p[0]), turn_to_view(p[1] - p[0]));  // view space is left-handed
#ifdef ORTHOGRAPHIC
    float away = outwards.z;
#else
    float away = dot(outwards, a.view);
#endif
    if ((away < 0.0) != facing) continue;
    if ((a.outside & b.outside & c.outside & kUnseen) != 0u) continue;
    bool homogeneous = ((a.outside | b.outside | c.outside) & (kTooNear | kBeyondGuard)) != 0u;
    if (!homogeneous && !covers_pixel(a.xy, b.xy, c.xy)) continue;
    count += 3u;
    if (!write) continue;
    uint kind = style << KIND_BITS | uint(KIND_SURFACE) | (homogeneous ? uint(KIND_HOMOGENEOUS) : 0u);
    if (homogeneous) {
      put_homogeneous(a.view, facet, kind);
      put_homogeneous(b.view, facet, kind);
      put_homogeneous(c.view, facet, kind);
    } else {
      put(a.xy, a.q, uvec3(facet, 0u, 0u), 0.0, kind, vec2(0.0), vec2(0.0));
      put(b.xy, b.q, uvec3(facet, 0u, 0u), 0.0, kind, vec2(0.0), vec2(0.0));
      put(c.xy, c.q, uvec3(facet, 0u, 0u), 0.0, kind, vec2(0.0), vec2(0.0));
    }
  }
  return count;
}
#endif

// What is known of a tetrahedron between counting and writing.
struct Volume {
  uint triangles;     // of the tent; or bit v + 8: wide, the face across from v is drawn
  uvec3 corner[2];    // per triangle
  vec2 side[4];       // the function of the side across from a corner: at that corner, elsewhere
  float thick, q_min, slope, shade_slope;
  bool quadrilateral, at_back;
};

float cross2(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

vec2 side_of(float share, float thick) { return share < kWallShare ? vec2(thick) : vec2(thick / share, 0.0); }

Volume classify(in ScreenPoint s[4], in vec3 edge[4], in float scalar[4], in float shade[4]) {
  Volume volume;
  volume.triangles = 0u;
  volume.slope = volume.shade_slope = 0.0;
  // Against the first corner: places on the screen, nearness, scalars in screen-linear form.
  vec2 d[4];
  float dq[4], ds[4], dshade[4];
  d[0] = vec2(0.0);
  dq[0] = ds[0] = dshade[0] = 0.0;
  for (int v = 1; v < 4; ++v) {
#ifdef ORTHOGRAPHIC
    d[v] = edge[v].xy * screen.x;
    dq[v] = -edge[v].z;
    ds[v] = scalar[v] - scalar[0];
    dshade[v] = shade[v] - shade[0];
#else
    // X / z - X0 / z0 = (dX - X0 / z0 * dz) / z, where X contains the axis times z, and 1 / z - 1 / z0 = -dz / (z z0).
    d[v] = (edge[v].xy * screen.x + (frame.axis.xy - s[0].xy) * edge[v].z) * s[v].q;
    dq[v] = -edge[v].z * s[v].q * s[0].q;
    ds[v] = scalar[v] * dq[v] + (scalar[v] - scalar[0]) * s[0].q;
    dshade[v] = shade[v] * dq[v] + (shade[v] - shade[0]) * s[0].q;
#endif
  }
  vec4 lambda;
  lambda.y = cross2(d[2], d[3]);
  lambda.z = -cross2(d[1], d[3]);
  lambda.w = cross2(d[1], d[2]);
  // The affine dependence of the four places: sum lambda = 0. The first from the others' differences, not from their sum.
  lambda.x = -cross2(d[2] - d[1], d[3] - d[1]);
  lambda = -lambda;
  uint plus = 0u, number = 0u;
  float weight = 0.0;
  for (int v = 0; v < 4; ++v)
    if (lambda[v] > 0.0) {
      plus |= 1u << v;
      ++number;
      weight += lambda[v];
    }
  if (number == 0u || number == 4u || !(weight > 0.0) || isinf(weight)) return volume;
  float minus_weight = 0.0;
  for (int v = 0; v < 4; ++v)
    if (!(lambda[v] > 0.0)) minus_weight -= lambda[v];
  if (!(minus_weight > 0.0)) return volume;
  float q_difference = 0.0, s_difference = 0.0, shade_difference = 0.0;  // of the points of sign plus less those of minus, at the thick vertex
  float low = 0.0, high = 0.0;
  vec4 share;
  for (int v = 0; v < 4; ++v) {
    bool positive = (plus >> v & 1u) != 0u;
    share[v] = positive ? lambda[v] / weight : -lambda[v] / minus_weight;
    q_difference += positive ? share[v] * dq[v] : -share[v] * dq[v];
    s_difference += positive ? share[v] * ds[v] : -share[v] * ds[v];
    shade_difference += positive ? share[v] * dshade[v] : -share[v] * dshade[v];
    low = min(low, dq[v]);
    high = max(high, dq[v]);
  }
  float thick = min(abs(q_difference), high - low);
  if (!(thick > 0.0)) return volume;
  volume.thick = thick;
  volume.q_min = s[0].q + low;
  volume.slope = s_difference / q_difference;
  volume.shade_slope = shade_difference / q_difference;
  for (int v = 0; v < 4; ++v) volume.side[v] = side_of(share[v], thick);
  volume.quadrilateral = number == 2u;
  if (number != 2u) {
    uint three = number == 1u ? ~plus & 15u : plus;
    uint single = three == 14u ? 0u : three == 13u ? 1u : three == 11u ? 2u : 3u;
    uvec3 corner = uvec3(single == 0u ? 1u : 0u, single <= 1u ? 2u : 1u, single <= 2u ? 3u : 2u);
    if (!covers_pixel(s[corner.x].xy, s[corner.y].xy, s[corner.z].xy)) return volume;
    volume.at_back = (q_difference > 0.0) == (number == 1u);  // the three are farther than the single one
    volume.corner[0] = corner;
    volume.triangles = 1u;
    return volume;
  }
  uint near_pair = q_difference > 0.0 ? plus : ~plus & 15u, far_pair = ~near_pair & 15u;
  uint a = uint(findLSB(near_pair)), c = uint(findMSB(near_pair));
  volume.at_back = false;
  uvec2 far = uvec2(findLSB(far_pair), findMSB(far_pair));
  for (int i = 0; i < 2; ++i)
    if (covers_pixel(s[a].xy, s[far[i]].xy, s[c].xy)) volume.corner[volume.triangles++] = uvec3(a, far[i], c);
  return volume;
}

// The faces that the rays leave through, of a tetrahedron that OpenGL must clip.
uint back_faces(in ScreenPoint s[4], in vec3 edge[4]) {
  uint faces = 0u;
  for (uint v = 0u; v < 4u; ++v) {
    uint a = (v + 1u) & 3u, b = (v + 2u) & 3u, c = (v + 3u) & 3u;
    vec3 n = cross(edge[b] - edge[a], edge[c] - edge[a]);
    float inside = dot(n, edge[v] - edge[a]);
#ifdef ORTHOGRAPHIC
    float away = n.z;
#else
    float away = dot(n, s[a].view);
#endif
    if (inside != 0.0 && (inside < 0.0) == (away > 0.0)) faces |= 1u << v;
  }
  return faces;
}

void main() {
  uint t = gl_LocalInvocationIndex, group = gl_WorkGroupID.x;
  uint index = group * PROJECT_GROUP + t;
  bool used = index < batch.y;
  uint tetrahedron = used ? order[batch.x + index] : 0u;
  uvec4 ids = used ? cells[tetrahedron] : uvec4(0u);
  uint style = used ? intervals[tetrahedron >> 1] >> 16u * (tetrahedron & 1u) & 0xffffu : 0u;
  uint drawn = used ? parts[style] : 0u;

  ScreenPoint s[4];
  vec3 edge[4];
  float scalar[4], shade[4];
  uint all_outside = ~0u, any_outside = 0u;
  vec4 first = used ? points[ids.x] : vec4(0.0);
  for (int v = 0; v < 4; ++v) {
    vec4 point = used ? points[ids[v]] : vec4(0.0);
    s[v] = project(point.xyz);
    edge[v] = turn_to_view(point.xyz - first.xyz);
    scalar[v] = point.w;
#ifdef BODY_SHADING
    shade[v] = used ? shades[ids[v]] : 1.0;
#else
    shade[v] = 1.0;
#endif
    all_outside &= s[v].outside;
    any_outside |= s[v].outside;
  }
  bool seen = used && (all_outside & kUnseen) == 0u;
  if (!seen) drawn = 0u;

  Volume volume;
  volume.triangles = 0u;
  uint wide = 0u, count = 0u;
  if ((drawn & DRAW_VOLUME) != 0u) {
    bool apart = (any_outside & (kTooNear | kBeyondGuard)) != 0u;
#ifndef ORTHOGRAPHIC
    float q_low = min(min(s[0].q, s[1].q), min(s[2].q, s[3].q)), q_high = max(max(s[0].q, s[1].q), max(s[2].q, s[3].q));
    apart = apart || q_high > frame.table.z * q_low;
#endif
    if (apart)
      wide = back_faces(s, edge);
    else
      volume = classify(s, edge, scalar, shade);
    count = 3u * (volume.triangles + uint(bitCount(wide)));
  }
#ifdef SURFACES
  bool with_facets = (drawn & ~DRAW_VOLUME) != 0u;
  if (with_facets) count += facets(tetrahedron, style, drawn, false, false) + facets(tetrahedron, style, drawn, true, false);
#endif

  // Sums of all before, in the group.
  group_sums[t] = count;
  barrier();
  for (uint stride = 1u; stride < uint(PROJECT_GROUP); stride *= 2u) {
    uint other = t >= stride ? group_sums[t - stride] : 0u;
    barrier();
    group_sums[t] += other;
    barrier();
  }
  uint base = group * uint(PROJECT_GROUP * MOST_VERTICES);
  if (t == uint(PROJECT_GROUP) - 1u) commands[group] = DrawCommand(group_sums[t], 1u, base, 0u);
  next_word = (base + group_sums[t] - count) * uint(WORDS);
  if (count == 0u) return;

#ifdef SURFACES
  if (with_facets) facets(tetrahedron, style, drawn, false, true);
#endif
  for (uint v = 0u; v < 4u; ++v)
    if ((wide >> v & 1u) != 0u)
      for (uint i = 1u; i < 4u; ++i) put_homogeneous(s[(v + i) & 3u].view, tetrahedron, style << KIND_BITS | uint(KIND_WIDE));
  for (uint i = 0u; i < volume.triangles; ++i) {
    uvec3 corner = volume.corner[i];
    uint style_kind = style << KIND_BITS | (volume.at_back ? uint(KIND_BACK) : uint(KIND_FRONT));
    for (uint k = 0u; k < 3u; ++k) {
      uint v = corner[k];
      vec3 tent;
      if (volume.quadrilateral) {  // the third function, D, bounds what is extrapolated beyond the diagonal
        tent.x = k == 0u ? volume.side[corner.x].x : volume.side[corner.x].y;
        tent.y = k == 2u ? volume.side[corner.z].x : volume.side[corner.z].y;
        tent.z = volume.thick;
      } else {
        for (uint j = 0u; j < 3u; ++j) tent[j] = j == k ? volume.side[corner[j]].x : volume.side[corner[j]].y;
      }
#ifdef ORTHOGRAPHIC
      float w = 1.0;
#else
      float w = s[v].q;
#endif
      put(s[v].xy, s[v].q, floatBitsToUint(tent), volume.q_min, style_kind, vec2(w * scalar[v], volume.slope), vec2(w * shade[v], volume.shade_slope));
    }
  }
#ifdef SURFACES
  if (with_facets) facets(tetrahedron, style, drawn, true, true);
#endif
}
