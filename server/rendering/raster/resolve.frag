// From the float target to 8 bits, on the device, because reading floats back costs many times more. Turns the picture over: row 0 is the
// top row.
layout(binding = UNIT_ACCUMULATED) uniform sampler2D accumulated;
layout(location = UNIFORM_BACKGROUND) uniform vec4 background;
layout(location = UNIFORM_SIZE) uniform vec2 size;
layout(location = 0) out vec4 color;

void main() {
  vec4 sum = texelFetch(accumulated, ivec2(int(gl_FragCoord.x), int(size.y) - 1 - int(gl_FragCoord.y)), 0);
  vec3 straight = sum.a > 0.0 ? sum.rgb / sum.a : vec3(0.0);
  color = background.a > 0.5 ? vec4(straight, sum.a) : vec4(sum.rgb + (1.0 - sum.a) * background.rgb, 1.0);
}
