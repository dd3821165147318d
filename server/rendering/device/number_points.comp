// The mesh points that each point of an active brick owns: itself where an interval keeps it, and the crossings of its edges towards
// larger indices with the isovalues. A crossed edge lies in active cells only, and so does a kept point, unless all cells around are
// absent; so nothing needs to be marked by cells. SLOT_WORDS 1: as bits 0..15 of a word, the brick's points before as bits 16..31.
// SLOT_WORDS 3: bits in two words, points before in the third. With LOCATE, after the bricks' points are added up: where the points are.
layout(local_size_x = BRICK_GROUP) in;
layout(std430, binding = BUFFER_COUNTERS) readonly restrict buffer CounterBuffer { ExtractionCounters counters; };
layout(std430, binding = BUFFER_BRICKS) readonly restrict buffer BrickBuffer { uint bricks[]; };
layout(std430, binding = BUFFER_GROUPS) readonly restrict buffer GroupBuffer { WorkGroups groups[]; };
layout(std430, binding = BUFFER_ISOVALUES) readonly restrict buffer LevelBuffer { IsoLevel levels[]; };
#ifdef LOCATE
layout(std430, binding = BUFFER_SLOTS) readonly restrict buffer SlotBuffer { uint slots[]; };
layout(std430, binding = BUFFER_OWNED) readonly restrict buffer OwnedBuffer { uvec2 owned[]; };
layout(std430, binding = BUFFER_AXES) readonly restrict buffer AxisBuffer { double axes[]; };
layout(std430, binding = BUFFER_POSITIONS) writeonly restrict buffer PositionBuffer { vec4 positions[]; };
layout(std430, binding = BUFFER_ORIGINS) writeonly restrict buffer OriginBuffer { MeshPointOrigin origins[]; };
#else
layout(std430, binding = BUFFER_SLOTS) writeonly restrict buffer SlotBuffer { uint slots[]; };
layout(std430, binding = BUFFER_OWNED) writeonly restrict buffer OwnedBuffer { uvec2 owned[]; };
layout(std430, binding = BUFFER_RULES_OF_POINTS) readonly restrict buffer RuleBuffer { IsoKeys rules[]; };
shared uint before[BRICK_GROUP];
#endif
#ifdef HAS_ABSENT
layout(std430, binding = BUFFER_ABSENT) readonly restrict buffer AbsentBuffer { uint absent[]; };
#endif

#ifdef LOCATE
dvec3 point_at(uvec3 p) {
#ifdef LOAD_POINTS
  return grid_point(p);
#else
  return dvec3(axes[3u + p.x], axes[3u + grid.points_x + p.y], axes[3u + grid.points_x + grid.points_y + p.z]);
#endif
}

void locate(uint to, uvec3 p, Key key, uint slot, uint at) {
  uint linear = p.x + grid.points_x * (p.y + grid.points_y * p.z);
  origins[to] = MeshPointOrigin(linear, slot);
  precise dvec3 position = point_at(p);
  precise double value = value_of(key);
  if (slot > 0u) {
    uint axis = (slot - 1u) / grid.isovalues, i = (slot - 1u) % grid.isovalues;
    uvec3 step = uvec3(axis == 0u ? 1u : 0u, axis == 1u ? 1u : 0u, axis == 2u ? 1u : 0u);
    double other = value_of(keys[at + step.x + 9u * step.y + 81u * step.z]);
    double isovalue = packDouble2x32(uvec2(levels[i].value_low, levels[i].value_high));
    precise double numerator = isovalue - value, denominator = other - value;
    // Differences of values near the ends of the range of double are not finite.
    if (((unpackDouble2x32(numerator).y & 0x7ff00000u) == 0x7ff00000u) || ((unpackDouble2x32(denominator).y & 0x7ff00000u) == 0x7ff00000u)) {
      numerator = isovalue * 0.5lf - value * 0.5lf;
      denominator = other * 0.5lf - value * 0.5lf;
    }
    precise double weight = clamp(numerator / denominator, 0.0lf, 1.0lf);
    dvec3 end = point_at(p + step);
    precise dvec3 between = position + (end - position) * weight;
    position = weight == 1.0lf ? end : between;
    value = isovalue;
  }
  positions[to] = vec4(vec3(position - dvec3(axes[0], axes[1], axes[2])), float(value));
}
#else
#ifdef HAS_ABSENT
bool cell_is_there(ivec3 cell) {
  ivec3 cells = ivec3(grid.points_x, grid.points_y, grid.points_z) - 1;
  if (any(lessThan(cell, ivec3(0))) || any(greaterThanEqual(cell, cells))) return false;
  uvec3 brick = uvec3(cell) >> 3, local = uvec3(cell) & 7u;
  uint bit = local.x + 8u * (local.y + 8u * local.z);
  return ((absent[16u * (brick.x + grid.bricks_x * (brick.y + grid.bricks_y * brick.z)) + (bit >> 5)] >> (bit & 31u)) & 1u) == 0u;
}

// Whether the point, and its edges along x, y, z, lie in a cell that is there: bits 0 to 3.
uint used(uvec3 p) {
  uint bits = 0u;
  for (int c = 0; c < 8; ++c) {
    ivec3 back = ivec3(c & 1, (c >> 1) & 1, c >> 2);
    if (!cell_is_there(ivec3(p) - back)) continue;
    bits |= 1u | (back.x == 0 ? 2u : 0u) | (back.y == 0 ? 4u : 0u) | (back.z == 0 ? 8u : 0u);
  }
  return bits;
}
#endif

uvec2 owned_slots(uvec3 p, uint at) {
  uvec2 bits = uvec2(0u);
#ifdef HAS_ABSENT
  uint use = used(p);
  if (use == 0u) return bits;
#else
  const uint use = 15u;
#endif
  Key own = keys[at];
  for (uint s = 0u; s < grid.rules; ++s)
    if (!key_less(own, make_key(rules[s].lower_high, rules[s].lower_low)) && !key_less(make_key(rules[s].last_high, rules[s].last_low), own))
      bits.x = 1u;
  bvec3 more = lessThan(p + 1u, uvec3(grid.points_x, grid.points_y, grid.points_z));
  for (uint axis = 0u; axis < 3u; ++axis) {
    if (!more[axis] || ((use >> (1u + axis)) & 1u) == 0u) continue;
    Key other = keys[at + (axis == 0u ? 1u : axis == 1u ? 9u : 81u)];
    for (uint i = 0u; i < grid.isovalues; ++i) {
      Key below = make_key(levels[i].below_high, levels[i].below_low);
      uint slot = 1u + axis * grid.isovalues + i;
      if (key_less(below, own) != key_less(below, other)) {
        if (slot < 32u)
          bits.x |= 1u << slot;
        else
          bits.y |= 1u << (slot - 32u);
      }
    }
  }
  return bits;
}
#endif

void main() {
  uint n = groups[slice].first + gl_WorkGroupID.x, r = gl_LocalInvocationIndex;
#ifdef LOCATE
  if (counters.points > grid.point_capacity) return;  // all invocations alike
#endif
  uvec3 brick = brick_at(bricks[n]);
  load_brick(brick);
  uvec3 p = 8u * brick + uvec3(0u, r & 7u, r >> 3);
  uint corner = 9u * (r & 7u) + 81u * (r >> 3);
  uint to = 512u * n + 8u * r;
  bool in_grid = p.y < grid.points_y && p.z < grid.points_z;
#ifdef LOCATE
  uint base = owned[n].x;
  for (uint i = 0u; in_grid && i < 8u && p.x < grid.points_x; ++i, ++p.x) {
#if SLOT_WORDS == 1
    uint word = slots[to + i];
    uvec2 bits = uvec2(word & 0xffffu, 0u);
    uint number = base + (word >> 16);
#else
    uvec2 bits = uvec2(slots[3u * (to + i)], slots[3u * (to + i) + 1u]);
    uint number = base + slots[3u * (to + i) + 2u];
#endif
    for (; bits.x != 0u; bits.x &= bits.x - 1u) locate(number++, p, keys[corner + i], uint(findLSB(bits.x)), corner + i);
    for (; bits.y != 0u; bits.y &= bits.y - 1u) locate(number++, p, keys[corner + i], 32u + uint(findLSB(bits.y)), corner + i);
  }
#else
  uvec2 bits[8];
  uint count = 0u;
  for (uint i = 0u; i < 8u; ++i, ++p.x) {
    bits[i] = in_grid && p.x < grid.points_x ? owned_slots(p, corner + i) : uvec2(0u);
    count += uint(bitCount(bits[i].x) + bitCount(bits[i].y));
  }
  before[r] = count;
  barrier();
  for (uint stride = 1u; stride < BRICK_GROUP; stride *= 2u) {  // inclusive sums
    uint add = r >= stride ? before[r - stride] : 0u;
    barrier();
    before[r] += add;
    barrier();
  }
  uint number = before[r] - count;
  for (uint i = 0u; i < 8u; ++i) {
#if SLOT_WORDS == 1
    slots[to + i] = bits[i].x | (number << 16);
#else
    slots[3u * (to + i)] = bits[i].x;
    slots[3u * (to + i) + 1u] = bits[i].y;
    slots[3u * (to + i) + 2u] = number;
#endif
    number += uint(bitCount(bits[i].x) + bitCount(bits[i].y));
  }
  if (r == BRICK_GROUP - 1u) owned[n] = uvec2(before[r], 0u);
#endif
}
