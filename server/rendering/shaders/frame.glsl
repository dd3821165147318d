// What drawing and projection know of the frame.
layout(std140, binding = BLOCK_FRAME) uniform FrameBlock { RasterFrame frame; };
#define screen frame.screen
#define clip_from_pixels frame.clip_from_pixels

// View space of a point of the mesh. What projects sees it sheared, so that the axis of view meets the middle of the picture.
vec3 turn_to_view(vec3 v) {
  vec3 turned = vec3(dot(frame.view_x.xyz, v), dot(frame.view_y.xyz, v), dot(frame.view_z.xyz, v));
#ifdef PROJECTS
  turned.xy += frame.shear.xy * turned.z;
#endif
  return turned;
}
vec3 to_view(vec3 p) {
  vec3 view = vec3(dot(frame.view_x.xyz, p) + frame.view_x.w, dot(frame.view_y.xyz, p) + frame.view_y.w,
                   dot(frame.view_z.xyz, p) + frame.view_z.w);
#ifdef PROJECTS
  view.xy += frame.shear.xy * view.z + frame.shear.zw;
#endif
  return view;
}
