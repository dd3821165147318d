// What drawing and projection know of the frame.
layout(std140, binding = BLOCK_FRAME) uniform FrameBlock { RasterFrame frame; };
#define screen frame.screen
#define clip_from_pixels frame.clip_from_pixels

// View space of a point of the mesh.
vec3 to_view(vec3 p) {
  return vec3(dot(frame.view_x.xyz, p) + frame.view_x.w, dot(frame.view_y.xyz, p) + frame.view_y.w,
              dot(frame.view_z.xyz, p) + frame.view_z.w);
}
vec3 turn_to_view(vec3 v) { return vec3(dot(frame.view_x.xyz, v), dot(frame.view_y.xyz, v), dot(frame.view_z.xyz, v)); }
