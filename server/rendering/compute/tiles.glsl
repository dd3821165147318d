// What the tile renderer's programs share. View space is x right, y down, z away from the eye, in units of the bounds' diagonal.
layout(std140, binding = TILE_BLOCK_FRAME) uniform FrameBlock { TileFrame frame; };
layout(std430, binding = TILE_COUNTERS) restrict buffer CounterBuffer { uint counters[]; };

uint work_group() { return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x; }
uint saturated_add(uint a, uint b) {
  uint sum = a + b;
  return sum < a ? 0xffffffffu : sum;
}
// 0 if there is no room for them: the frame is then drawn again.
uint pairs_at_hand() { return counters[TILE_COUNT_PAIRS] <= frame.room.y ? counters[TILE_COUNT_PAIRS] : 0u; }

#ifdef USES_MESH
layout(std430, binding = TILE_POSITIONS) readonly restrict buffer PositionBuffer { float positions[]; };
layout(std430, binding = TILE_TETRAHEDRA) readonly restrict buffer TetrahedronBuffer { uvec4 tetrahedra[]; };
layout(std430, binding = TILE_INFO) readonly restrict buffer InfoBuffer { uint infos[]; };
layout(std430, binding = TILE_STYLES) readonly restrict buffer StyleBuffer { vec4 styles[]; };
layout(std430, binding = TILE_CLIP_PLANES) readonly restrict buffer ClipBuffer { vec4 clip_planes[]; };
layout(std430, binding = TILE_RUNS) readonly restrict buffer RunBuffer { uint runs[]; };

vec4 style_row(uint interval, uint row) { return styles[interval * TILE_STYLE_ROWS + row]; }
bool perspective() { return frame.limits.z > 0.5; }

// View space but for the translation, so that differences of neighbours keep their digits. The same in all programs.
vec3 turned(uint point) {
  vec3 p = vec3(positions[3u * point], positions[3u * point + 1u], positions[3u * point + 2u]);
  precise vec3 at = vec3(dot(frame.right.xyz, p), dot(frame.down.xyz, p), dot(frame.forward.xyz, p));
  return at;
}
vec3 view_origin() { return vec3(frame.right.w, frame.down.w, frame.forward.w); }

// Pixels are sampled a little beside their middles, so that no ray lies in a face that is seen edge-on: common in straight views of regular
// grids, where the face's two tetrahedra would have to agree which of them has the ray.
const vec2 kBesideMiddle = vec2(1.0 / 8192.0, 1.0 / 12288.0);
// Of the part's pixel, counted from the middle of the picture.
vec2 sample_of(ivec2 pixel) { return vec2(pixel) + 0.5 + kBesideMiddle - frame.lens.zw; }

vec2 on_screen(vec3 p) {
  precise vec2 at = perspective() ? p.xy * (frame.lens.x / p.z) : p.xy * frame.lens.x;
  return at;
}

// The part's pixels that the tetrahedron may cover, first and last; false if there are none.
bool covered_box(vec3 p[4], out ivec4 box) {
  vec2 low = vec2(1e30), high = vec2(-1e30);
  float least = perspective() ? frame.limits.x : -1e30;
  for (int v = 0; v < 4; ++v) {
    if (p[v].z < least) continue;
    vec2 at = on_screen(p[v]);
    low = min(low, at);
    high = max(high, at);
  }
  if (low.x > high.x) return false;
  if (min(min(p[0].z, p[1].z), min(p[2].z, p[3].z)) < least)
    for (int a = 0; a < 3; ++a)
      for (int b = a + 1; b < 4; ++b)
        if ((p[a].z < least) != (p[b].z < least)) {
          vec3 cut = mix(p[a], p[b], (least - p[a].z) / (p[b].z - p[a].z));
          vec2 at = on_screen(vec3(cut.xy, least));
          low = min(low, at);
          high = max(high, at);
        }
  const float kSlack = 1.0 / 512.0;  // of a pixel: positions on the screen are that sure
  vec2 first = ceil(low - kSlack - 0.5 - kBesideMiddle + frame.lens.zw), last = floor(high + kSlack - 0.5 - kBesideMiddle + frame.lens.zw);
  vec2 most = vec2(frame.part.xy) - 1.0;
  box = ivec4(clamp(first, vec2(0.0), most), clamp(last, vec2(0.0), most));
  return first.x <= last.x && first.y <= last.y && first.x <= most.x && first.y <= most.y && last.x >= 0.0 && last.y >= 0.0;
}

bool clipped_away(vec3 p[4]) {
  for (uint i = 0u; i < frame.keys.w; ++i) {
    vec4 plane = clip_planes[i];
    bool outside = true;
    for (int v = 0; v < 4; ++v) outside = outside && dot(plane.xyz, p[v]) < plane.w;
    if (outside) return true;
  }
  return false;
}
#endif
