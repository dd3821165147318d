// What drawing and projection know of the frame.
layout(std140, binding = BLOCK_FRAME) uniform FrameBlock { RasterFrame frame; };
#define screen frame.screen
#define clip_from_pixels frame.clip_from_pixels

// View space of a point of the mesh: the same bits wherever it is asked for.
vec3 to_view(vec3 p) {
  precise vec3 view = vec3(dot(frame.view_x.xyz, p) + frame.view_x.w, dot(frame.view_y.xyz, p) + frame.view_y.w,
                           dot(frame.view_z.xyz, p) + frame.view_z.w);
  return view;
}
vec3 turn_to_view(vec3 v) { return vec3(dot(frame.view_x.xyz, v), dot(frame.view_y.xyz, v), dot(frame.view_z.xyz, v)); }
