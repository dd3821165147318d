// One tetrahedron an invocation: which tiles it may cover. COUNT writes how many; FILL, once these are summed up, the pairs of (tile, group,
// place in the order) and tetrahedron: as many as were counted, whatever this program makes of its own sums, the last ones of no tile.
layout(local_size_x = TILE_GROUP) in;
layout(std430, binding = TILE_ORDER) readonly restrict buffer OrderBuffer { uint order[]; };
layout(std430, binding = TILE_SUMS) restrict buffer SumBuffer { uint sums[]; };
layout(std430, binding = TILE_PAIRS) writeonly restrict buffer PairBuffer { uvec2 pairs[]; };

#ifdef FILL
// Cells are drawn by their index distance from the eye's cell, which every step of a ray away from the eye raises.
uint depth_key(uint id) {
  if (frame.keys.x != TILE_ORDER_INDEX) return 0u;
  uint cell = frame.eye_cell.w + 2u * runs[id];
  ivec3 at = ivec3(runs[cell] & 0xffffu, runs[cell] >> 16, runs[cell + 1u]);
  ivec3 away = abs(at - ivec3(frame.eye_cell.xyz));
  return uint(away.x + away.y + away.z);
}
#endif

void main() {
  uint slot = work_group() * TILE_GROUP + gl_LocalInvocationIndex;
#ifdef FILL
  if (slot >= frame.room.x || pairs_at_hand() == 0u) return;
  uint at = sums[slot], end = sums[slot + 1u];
  if (end == at) return;
#else
  if (slot > frame.room.x) return;
  sums[slot] = 0u;
  if (slot == frame.room.x) return;
#endif
  uint id = frame.keys.x == TILE_ORDER_LIST ? order[slot] : slot;
  uint info = infos[id], interval = info & TILE_INFO_INTERVAL;
  float kind = style_row(interval, TILE_STYLE_RANGE).z;
  if (kind == 0.0 || (info & TILE_INFO_FLAT) != 0u) return;
  uvec4 points = tetrahedra[id];
  vec3 p[4] = vec3[4](turned(points.x), turned(points.y), turned(points.z), turned(points.w));
  for (int v = 0; v < 4; ++v) p[v] += view_origin();
  ivec4 box;
#ifdef FILL
  if (!covered_box(p, box)) box = ivec4(0, 0, -1, -1);
  ivec4 tiles = box >> TILE_SIDE_SHIFT;
#else
  if (!covered_box(p, box) || clipped_away(p)) return;
  ivec4 tiles = box >> TILE_SIDE_SHIFT;
#endif
#ifdef FILL
  uint group = uint(style_row(interval, TILE_STYLE_LIGHT).w);
  uint low = kind == 1.0 ? depth_key(id) : 0u;
  if (frame.keys.x != TILE_ORDER_LIST) low |= group << frame.keys.y;
  for (int y = tiles.y; y <= tiles.w; ++y)
    for (int x = tiles.x; x <= tiles.z && at < end; ++x) pairs[at++] = uvec2(((uint(y) * frame.part.z + uint(x)) << frame.keys.z) | low, id);
  while (at < end) pairs[at++] = uvec2((frame.part.z * frame.part.w) << frame.keys.z, id);
#else
  sums[slot] = uint((tiles.z - tiles.x + 1) * (tiles.w - tiles.y + 1));
#endif
}
