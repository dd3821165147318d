// One ray through one tetrahedron: its exact length between the two faces that the ray meets, the light that it adds and what it lets
// through. Premultiplied colour, blended over what lies behind.
noperspective in vec4 tent_q;
flat in vec4 rgb_extinction;
flat in vec2 side_q_min;
layout(location = UNIFORM_RAY_FROM_FRAGMENT) uniform vec4 ray_from_fragment;

#ifdef LINEAR_COLOR
noperspective in float scalar_q;
flat in vec4 slope_map;
layout(binding = UNIT_MAPS) uniform sampler2D maps;
#endif

layout(location = 0) out vec4 color;
#ifdef NEAREST_DEPTH
layout(location = 1) out float nearest;  // the largest inverse depth; blended with MAX
#endif

#ifdef LINEAR_COLOR
vec3 map_color(float scalar) {
  float t = clamp(scalar * slope_map.z + slope_map.w, 0.0, 1.0);
  vec2 size = vec2(textureSize(maps, 0));
  return slope_map.y < 0.0 ? rgb_extinction.rgb
                           : textureLod(maps, vec2((t * (size.x - 1.0) + 0.5) / size.x, (slope_map.y + 0.5) / size.y), 0.0).rgb;
}
#endif

void main() {
  // The inverse depth is linear on the screen over each face; the difference of the far side's from the drawn face's is a tent over the
  // silhouette: the least of three linear functions.
  float difference = max(min(min(tent_q.x, tent_q.y), tent_q.z), 0.0);
  float q = max(tent_q.w, side_q_min.y);
  float other = max(q - side_q_min.x * difference, side_q_min.y);
  vec2 ray = gl_FragCoord.xy * ray_from_fragment.xy + ray_from_fragment.zw;
  float depth_per_length = sqrt(1.0 + dot(ray, ray));
  float path = difference / (q * other) * depth_per_length;
  float tau = rgb_extinction.a * path;

  // 1 - exp(-tau); by its series where the subtraction would lose the digits that many thin layers need.
  float alpha = tau < 0.1 ? tau * (1.0 - tau * (0.5 - tau * (1.0 / 6.0 - tau * (1.0 / 24.0 - tau * (1.0 / 120.0))))) : 1.0 - exp(-tau);
#ifdef LINEAR_COLOR
  // Colour linear along the ray, constant extinction: the integral of c(t) sigma exp(-sigma t) in closed form.
  float drawn_scalar = scalar_q / q;
  float other_scalar = (scalar_q - side_q_min.x * difference * slope_map.x) / other;
  vec3 drawn_color = map_color(drawn_scalar), other_color = map_color(other_scalar);
  vec3 front = side_q_min.x > 0.0 ? drawn_color : other_color, back = side_q_min.x > 0.0 ? other_color : drawn_color;
  float back_weight = tau < 0.1 ? tau * (0.5 - tau * (1.0 / 3.0 - tau * (1.0 / 8.0 - tau * (1.0 / 30.0)))) : alpha / tau - (1.0 - alpha);
  color = vec4(front * (alpha - back_weight) + back * back_weight, alpha);
#else
  color = vec4(rgb_extinction.rgb * alpha, alpha);
#endif
#ifdef NEAREST_DEPTH
  nearest = difference > 0.0 ? max(q, other) : 0.0;
#endif
}
