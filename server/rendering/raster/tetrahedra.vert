// A face of a tetrahedron or a facet on the screen. The work was done before (projected_tetrahedra.cpp, project_tetrahedra.comp).
layout(location = ATTRIBUTE_POSITION) in vec3 position;
layout(location = ATTRIBUTE_TENT) in vec3 tent;
layout(location = ATTRIBUTE_Q_MIN) in float q_min;
layout(location = ATTRIBUTE_STYLE) in uint style_kind;
layout(location = ATTRIBUTE_ID) in uint id;
layout(binding = UNIT_STYLES) uniform samplerBuffer styles;

noperspective out vec4 tent_q;   // everything here is linear on the screen
flat out uvec2 style_kind_id;
flat out float least_q;
flat out vec4 rgb_extinction;

#ifdef LINEAR_COLOR
layout(location = ATTRIBUTE_SCALAR) in vec2 scalar;
noperspective out float scalar_q;
flat out float slope;
flat out vec4 map;
#endif
#ifdef BODY_SHADING
layout(location = ATTRIBUTE_SHADE) in vec2 shade;
noperspective out float shade_q;
flat out float shade_slope;
#endif

void main() {
  tent_q = vec4(tent, position.z);
  style_kind_id = uvec2(style_kind, id);
  least_q = q_min;
  rgb_extinction = texelFetch(styles, STYLE_TEXELS * int(style_kind >> KIND_BITS));
#ifdef LINEAR_COLOR
  scalar_q = scalar.x;
  slope = scalar.y;
  map = texelFetch(styles, STYLE_TEXELS * int(style_kind >> KIND_BITS) + 1);
#endif
#ifdef BODY_SHADING
  shade_q = shade.x;
  shade_slope = shade.y;
#endif
  bool homogeneous = (style_kind & uint(KIND_HOMOGENEOUS)) != 0u;
  float w = homogeneous ? position.z : 1.0;
  gl_Position = vec4(position.xy * clip_from_pixels.xy + clip_from_pixels.zw * w, homogeneous ? w - 2.0 * screen.y : 0.0, w);
}
