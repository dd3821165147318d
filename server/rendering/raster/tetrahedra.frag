// One ray through one tetrahedron: its exact length between the two faces that the ray meets, the light that it adds and what it lets
// through; or one ray through a boundary facet. Premultiplied colour, blended over what lies behind.
//
// Nearness q is what is linear on the screen over a plane: the inverse depth in perspective, base - depth where rays are parallel.
noperspective in vec4 tent_q;
flat in uvec2 style_kind_id;
flat in float least_q;
flat in vec4 rgb_extinction;

#ifdef LINEAR_COLOR
noperspective in float scalar_q;
flat in float slope;
flat in vec4 map;
#endif
#ifdef BODY_SHADING
noperspective in float shade_q;
flat in float shade_slope;
#endif

layout(location = 0) out vec4 color;
#ifdef NEAREST_DEPTH
layout(location = 1) out float nearest;  // the largest nearness; blended with MAX
#endif
#ifdef MEAN_DEPTH
layout(location = 2) out vec4 seen_at;  // the depth times alpha, 0, 0, alpha; blended like a colour
#endif

#ifdef WIDE
layout(std430, binding = BUFFER_MESH_POINTS) readonly restrict buffer PointBuffer { vec4 points[]; };
layout(std430, binding = BUFFER_MESH_CELLS) readonly restrict buffer CellBuffer { uvec4 cells[]; };
#ifdef BODY_SHADING
layout(std430, binding = BUFFER_SHADES) readonly restrict buffer ShadeBuffer { float shades[]; };
#endif
#endif
#ifdef SURFACES
layout(std430, binding = BUFFER_FACETS) readonly restrict buffer FacetBuffer { FacetCorner corners[]; };
#endif
#ifdef CLIP_PLANES
layout(std430, binding = BUFFER_PLANES) readonly restrict buffer PlaneBuffer { vec4 planes[]; };
#endif

float nearness(float depth) {
#ifdef ORTHOGRAPHIC
  return screen.z - depth;
#else
  return 1.0 / max(depth, screen.y);
#endif
}

// The ray's points are from + depth * along.
struct Ray {
  vec3 from, along;
  float depth_per_length;
  float first, last;  // depths: what the eye and the clip planes leave
};

struct Segment {
  float front, path;           // depth, length along the ray
  float scalar_front, scalar_back;
  vec2 shade;                  // of the light that is left at the front and at the back
};

Ray ray_here() {
  vec2 xy = gl_FragCoord.xy * frame.ray_from_fragment.xy + frame.ray_from_fragment.zw;
#ifdef ORTHOGRAPHIC
  Ray ray = Ray(vec3(xy, 0.0), vec3(0.0, 0.0, 1.0), 1.0, -3e38, 3e38);
#else
  Ray ray = Ray(vec3(0.0), vec3(xy, 1.0), sqrt(1.0 + dot(xy, xy)), 0.0, 3e38);
#endif
#ifdef CLIP_PLANES
  for (uint i = 0u; i < frame.counts.x; ++i) {
    float along = dot(planes[i].xyz, ray.along), at = planes[i].w - dot(planes[i].xyz, ray.from);
    if (along > 0.0)
      ray.first = max(ray.first, at / along);
    else if (along < 0.0)
      ray.last = min(ray.last, at / along);
    else if (at > 0.0)
      ray.last = -3e38;
  }
#endif
  return ray;
}

#ifdef WIDE
// From the four points: each point's weight is linear along the ray and not negative inside.
bool wide_segment(Ray ray, uint tetrahedron, out Segment segment) {
  uvec4 ids = cells[tetrahedron];
  vec3 p[4];
  float scalar[4];
  for (int v = 0; v < 4; ++v) {
    vec4 point = points[ids[v]];
    p[v] = to_view(point.xyz) - ray.from;
    scalar[v] = point.w;
  }
  float enter = ray.first, leave = ray.last;
  vec2 scalar_line = vec2(0.0), shade_line = vec2(0.0);
  float low = 3e38, high = -3e38;
  for (int v = 0; v < 4; ++v) {
    vec3 a = p[(v + 1) & 3];
    vec3 n = cross(p[(v + 2) & 3] - a, p[(v + 3) & 3] - a);
    float volume = dot(n, p[v] - a);
    if (volume == 0.0) return false;
    vec2 weight = vec2(-dot(n, a), dot(n, ray.along)) / volume;  // at depth 0, per depth
    if (weight.y > 0.0)
      enter = max(enter, -weight.x / weight.y);
    else if (weight.y < 0.0)
      leave = min(leave, -weight.x / weight.y);
    else if (weight.x < 0.0)
      return false;
    scalar_line += scalar[v] * weight;
#ifdef BODY_SHADING
    shade_line += shades[ids[v]] * weight;
#endif
    low = min(low, scalar[v]);
    high = max(high, scalar[v]);
  }
  if (!(leave > enter)) return false;
  segment = Segment(enter, (leave - enter) * ray.depth_per_length, clamp(scalar_line.x + scalar_line.y * enter, low, high),
                    clamp(scalar_line.x + scalar_line.y * leave, low, high), clamp(shade_line.x + shade_line.y * vec2(enter, leave), 0.0, 1.0));
  return true;
}
#endif

// From the tent. The difference of the far side's nearness from the drawn face's is the least of three linear functions.
bool tent_segment(Ray ray, bool drawn_at_back, out Segment segment) {
  float difference = max(min(min(tent_q.x, tent_q.y), tent_q.z), 0.0);
  float q = max(tent_q.w, least_q);
  float side = drawn_at_back ? -1.0 : 1.0;
  float other = max(q - side * difference, least_q);
  float front = max(q, other);
#ifdef ORTHOGRAPHIC
  float depth = screen.z - front, depths = difference;
#else
  float depth = 1.0 / front, depths = difference / (q * other);
#endif
  float scalar_front = 0.0, scalar_back = 0.0;
#ifdef LINEAR_COLOR
#ifdef ORTHOGRAPHIC
  float drawn_scalar = scalar_q, other_scalar = scalar_q - side * difference * slope;
#else
  float drawn_scalar = scalar_q / q, other_scalar = (scalar_q - side * difference * slope) / other;
#endif
  scalar_front = drawn_at_back ? other_scalar : drawn_scalar;
  scalar_back = drawn_at_back ? drawn_scalar : other_scalar;
#endif
  vec2 shade = vec2(1.0);
#ifdef BODY_SHADING
#ifdef ORTHOGRAPHIC
  shade = vec2(shade_q, shade_q - side * difference * shade_slope);
#else
  shade = vec2(shade_q / q, (shade_q - side * difference * shade_slope) / other);
#endif
  shade = clamp(drawn_at_back ? shade.yx : shade, 0.0, 1.0);
#endif
  segment = Segment(depth, depths * ray.depth_per_length, scalar_front, scalar_back, shade);
#ifdef CLIP_PLANES
  if (ray.first > depth || ray.last < depth + depths) {
    float from = max(ray.first, depth), to = min(ray.last, depth + depths);
    if (!(to > from)) return false;
    vec2 share = vec2(from - depth, to - depth) / depths;
    segment = Segment(from, (to - from) * ray.depth_per_length, mix(scalar_front, scalar_back, share.x),
                      mix(scalar_front, scalar_back, share.y), mix(shade.xx, shade.yy, share));
  }
#endif
  return difference > 0.0;
}

#ifdef SURFACES
void draw_surface(Ray ray, int style, uint facet) {
  vec3 p[3];
  vec4 corner_normal[3];
  vec3 scalars;
  for (int v = 0; v < 3; ++v) {
    FacetCorner corner = corners[3u * facet + uint(v)];
    p[v] = to_view(corner.position_scalar.xyz) - ray.from;
    scalars[v] = corner.position_scalar.w;
    corner_normal[v] = corner.normal_texture;
  }
  vec3 ab = p[1] - p[0], ac = p[2] - p[0];
  vec3 own_normal = cross(ab, ac);
  float facing = dot(own_normal, ray.along);
  // Where the ray meets the plane, as weights of the corners. Seen edge-on they have no digits; they stay inside.
  vec3 weight = max(vec3(dot(cross(p[1], p[2]), ray.along), dot(cross(p[2], p[0]), ray.along), dot(cross(p[0], p[1]), ray.along)) *
                        (facing < 0.0 ? -1.0 : 1.0),
                    0.0);
  float sum = weight.x + weight.y + weight.z;
  weight = sum > 0.0 ? weight / sum : vec3(1.0 / 3.0);
  float depth = dot(weight, vec3(p[0].z, p[1].z, p[2].z));
  if (depth < ray.first || depth > ray.last) discard;
  vec4 normal_texture = corner_normal[0] * weight.x + corner_normal[1] * weight.y + corner_normal[2] * weight.z;
  float size = max(max(abs(own_normal.x), abs(own_normal.y)), abs(own_normal.z));  // its square may be too small for a float
  own_normal = size > 0.0 ? normalize(own_normal / size) : vec3(0.0);
  vec3 normal = frame.counts.w == 0u ? own_normal : turn_to_view(normal_texture.xyz);  // none were given: the facet's own
  vec4 own_map = texelFetch(styles, STYLE_TEXELS * style + 1);
  vec3 base = color_at(rgb_extinction, own_map, dot(weight, scalars) * own_map.y + own_map.z);
  color = shade_surface(style, base, normal, own_normal, -normalize(ray.along), normal_texture.w);
#ifdef NEAREST_DEPTH
  nearest = color.a > 0.0 ? nearness(depth) : 0.0;
#endif
#ifdef MEAN_DEPTH
  seen_at = vec4(color.a * depth, 0.0, 0.0, color.a);
#endif
}
#endif

void main() {
  int style = int(style_kind_id.x >> KIND_BITS);
  uint kind = style_kind_id.x & KIND_MASK;
  Ray ray = ray_here();
#ifdef SURFACES
  if ((kind & ~uint(KIND_HOMOGENEOUS)) == uint(KIND_SURFACE)) {
    draw_surface(ray, style, style_kind_id.y);
    return;
  }
#endif
  Segment segment;
  bool met;
#ifdef WIDE
  if (kind == uint(KIND_WIDE))
    met = wide_segment(ray, style_kind_id.y, segment);
  else
#endif
    met = tent_segment(ray, kind == uint(KIND_BACK), segment);
#ifdef CLIP_PLANES
  if (!met) discard;  // so that it is not counted
#endif
#ifdef LINEAR_COLOR
  vec4 light = linear_light(style, rgb_extinction, map, segment.path, segment.scalar_front, segment.scalar_back);
#else
  vec4 light = constant_light(rgb_extinction, segment.path);
#endif
#ifdef BODY_SHADING
  light.rgb *= mix(segment.shade.x, segment.shade.y, middle_of_light(light.a));
#endif
  color = met ? light : vec4(0.0);
#ifdef NEAREST_DEPTH
  nearest = met && light.a > 0.0 ? nearness(segment.front) : 0.0;
#endif
#ifdef MEAN_DEPTH
  seen_at = vec4(met ? light.a * (segment.front + middle_of_light(light.a) * segment.path / ray.depth_per_length) : 0.0, 0.0, 0.0, color.a);
#endif
}
