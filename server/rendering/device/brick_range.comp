// Once an array: the extremes of the finite values around each brick, and whether any cell is absent for what is not finite. With
// HAS_ABSENT instead: adds those cells to the bits of the hidden ones.
layout(local_size_x = BRICK_GROUP) in;
layout(location = UNIFORM_FIRST) uniform uint first_group;
#ifdef HAS_ABSENT
layout(std430, binding = BUFFER_ABSENT) restrict buffer AbsentBuffer { uint absent[]; };
shared uint absent_words[16];
#else
layout(std430, binding = BUFFER_RANGES) writeonly restrict buffer RangeBuffer { IsoRange ranges[]; };
layout(std430, binding = BUFFER_COUNTERS) restrict buffer CounterBuffer { ExtractionCounters counters; };
shared Key lowest[BRICK_GROUP], highest[BRICK_GROUP];
#endif

bool coordinates_are_finite(uvec3 p) {
#ifdef LOAD_POINTS
  uint at = 3u * (p.x + grid.points_x * (p.y + grid.points_y * (p.z - part_layer)));
  for (uint c = 0u; c < 3u; ++c) {
#ifdef POINTS_DOUBLE
    if ((unpackDouble2x32(coordinates[at + c]).y & 0x7ff00000u) == 0x7ff00000u) return false;
#else
    if ((floatBitsToUint(coordinates[at + c]) & 0x7f800000u) == 0x7f800000u) return false;
#endif
  }
#endif
  return true;
}

void main() {
  uint number = first_group + gl_WorkGroupID.x, r = gl_LocalInvocationIndex;
  uvec3 brick = brick_at(number), first = 8u * brick;
  load_brick(brick);
#ifdef HAS_ABSENT
  if (r < 16u) absent_words[r] = 0u;
  barrier();
  uvec3 cell = first + uvec3(0u, r & 7u, r >> 3);
  uint bits = 0u;
  if (cell.y + 1u < grid.points_y && cell.z + 1u < grid.points_z)
    for (uint i = 0u; i < 8u && first.x + i + 1u < grid.points_x; ++i)
      for (uint v = 0u; v < 8u; ++v) {
        uvec3 offset = uvec3(i + (v & 1u), (v >> 1) & 1u, v >> 2);
        uint at = offset.x + 9u * ((r & 7u) + offset.y) + 81u * ((r >> 3) + offset.z);
        if (!key_is_finite(keys[at]) || !coordinates_are_finite(cell + offset)) bits |= 1u << i;
      }
  atomicOr(absent_words[r >> 2], bits << (8u * (r & 3u)));
  barrier();
  if (r < 16u) absent[16u * number + r] |= absent_words[r];
#else
  uvec3 size = min(uvec3(9u), uvec3(grid.points_x, grid.points_y, grid.points_z) - first);
  bool found = false, finite = true;
  Key lo = make_key(0xffffffffu, 0xffffffffu), hi = make_key(0u, 0u);
  for (uint t = r; t < 729u; t += BRICK_GROUP) {
    uvec3 p = uvec3(t % 9u, t / 9u % 9u, t / 81u);
    if (any(greaterThanEqual(p, size))) continue;
    Key key = keys[t];
    if (key_is_finite(key)) {
      lo = key_min(lo, key);
      hi = key_max(hi, key);
    } else
      finite = false;
    finite = finite && coordinates_are_finite(first + p);
  }
  if (!finite) atomicOr(counters.any_absent, 1u);
  lowest[r] = lo;
  highest[r] = hi;
  for (uint stride = BRICK_GROUP / 2; stride > 0u; stride /= 2u) {
    barrier();
    if (r < stride) {
      lowest[r] = key_min(lowest[r], lowest[r + stride]);
      highest[r] = key_max(highest[r], highest[r + stride]);
    }
  }
  if (r == 0u) {
#if BYTES_PER_VALUE == 8
    ranges[number] = IsoRange(lowest[0].x, lowest[0].y, highest[0].x, highest[0].y);
#else
    ranges[number] = IsoRange(lowest[0], 0u, highest[0], 0u);
#endif
  }
#endif
}
