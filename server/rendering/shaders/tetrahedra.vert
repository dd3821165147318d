// A face of a tetrahedron on the screen. The work was done on the CPU (projected_tetrahedra.cpp).
layout(location = ATTRIBUTE_POSITION) in vec3 position;
layout(location = ATTRIBUTE_TENT) in vec3 tent;
layout(location = ATTRIBUTE_Q_MIN) in float q_min;
layout(location = ATTRIBUTE_STYLE) in uint style_side;
layout(location = UNIFORM_CLIP_FROM_PIXELS) uniform vec4 clip_from_pixels;
layout(binding = UNIT_STYLES) uniform samplerBuffer styles;

noperspective out vec4 tent_q;   // everything here is linear on the screen
flat out vec4 rgb_extinction;
flat out vec2 side_q_min;

#ifdef LINEAR_COLOR
layout(location = ATTRIBUTE_SCALAR) in vec2 scalar;
noperspective out float scalar_q;
flat out vec4 slope_map;         // slope, map row, scale, offset
#endif

void main() {
  int style = int(style_side >> 1);
  tent_q = vec4(tent, position.z);
  side_q_min = vec2((style_side & 1u) == 0u ? 1.0 : -1.0, q_min);
  rgb_extinction = texelFetch(styles, 2 * style);
#ifdef LINEAR_COLOR
  scalar_q = scalar.x;
  slope_map = vec4(scalar.y, texelFetch(styles, 2 * style + 1).xyz);
#endif
  gl_Position = vec4(position.xy * clip_from_pixels.xy + clip_from_pixels.zw, 0.0, 1.0);
}
