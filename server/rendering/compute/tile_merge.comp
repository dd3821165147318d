// One tile a work group: its batches, nearest first, into the picture: 8 bits over the background, or with straight colours and alpha, or
// the floats as they are.
layout(local_size_x = TILE_GROUP) in;
layout(std430, binding = TILE_BATCHES) readonly restrict buffer BatchBuffer { uint batches[]; };
layout(std430, binding = TILE_LIGHT) readonly restrict buffer LightBuffer { vec4 light[]; };
#ifdef NEAREST_DEPTH
#ifdef MEAN_DEPTH
layout(std430, binding = TILE_NEAREST) readonly restrict buffer NearestBuffer { vec2 nearest[]; };
#else
layout(std430, binding = TILE_NEAREST) readonly restrict buffer NearestBuffer { float nearest[]; };
#endif
layout(std430, binding = TILE_PICTURE) writeonly restrict buffer PictureBuffer { vec4 picture[]; };
layout(std430, binding = TILE_DEPTH) writeonly restrict buffer DepthBuffer { float depths[]; };
#else
layout(std430, binding = TILE_PICTURE) writeonly restrict buffer PictureBuffer { uint picture[]; };
#endif

void main() {
  uint t = gl_LocalInvocationIndex, tile = work_group(), tiles = frame.part.z * frame.part.w;
  if (tile >= tiles || counters[TILE_COUNT_BATCHES] > frame.room.z) return;
  uvec2 pixel = uvec2(tile % frame.part.z, tile / frame.part.z) * 16u + uvec2(t & 15u, t >> 4);
  if (pixel.x >= frame.part.x || pixel.y >= frame.part.y) return;
  vec3 sum = vec3(0.0);
  float through = 1.0, u = -1e30, depth_sum = 0.0;
  for (uint b = batches[tile]; b < batches[tile + 1u]; ++b) {
    vec4 own = light[b * TILE_GROUP + t];
    sum += through * own.rgb;
#ifdef MEAN_DEPTH
    depth_sum += through * nearest[b * TILE_GROUP + t].y;
    u = max(u, nearest[b * TILE_GROUP + t].x);
#endif
    through *= own.a;
#if defined NEAREST_DEPTH && !defined MEAN_DEPTH
    u = max(u, nearest[b * TILE_GROUP + t]);
#endif
  }
  uint at = pixel.y * frame.part.x + pixel.x;
  float alpha = 1.0 - through;
#ifdef NEAREST_DEPTH
  picture[at] = vec4(sum, alpha);
  depths[at] = u <= -1e30 ? uintBitsToFloat(0x7f800000u) : frame.limits.z > 0.5 ? 1.0 / u : -u;
#ifdef MEAN_DEPTH
  depths[frame.part.x * frame.part.y + at] = depth_sum;
#endif
#else
  bool transparent = mod(frame.background.w, 2.0) > 0.5;
  vec4 color = transparent ? vec4(alpha > 0.0 ? sum / alpha : vec3(0.0), alpha) : vec4(sum + through * frame.background.rgb, 1.0);
  uvec4 bytes = uvec4(floor(clamp(color, 0.0, 1.0) * 255.0 + 0.5));
  picture[at] = bytes.r | bytes.g << 8 | bytes.b << 16 | bytes.a << 24;
#endif
}
