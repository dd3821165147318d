// Prefix sums of pairs, saturating at 2^32 - 1, by adding up tiles and then going through them again (portable: no work group waits for
// another). REDUCE: each tile's sum. SPINE, one work group: the tiles' sums into sums of all before, the total into the counters. APPLY:
// the elements into sums of all before.
layout(local_size_x = SCAN_GROUP) in;
layout(location = UNIFORM_FIRST) uniform uint which;     // counter: COUNT_...
layout(location = UNIFORM_COUNT) uniform uint elements;  // for each one counted
layout(std430, binding = BUFFER_COUNTERS) restrict buffer CounterBuffer { uint counters[]; };
layout(std430, binding = BUFFER_SUMS) restrict buffer SumBuffer { uvec2 sums[]; };
layout(std430, binding = BUFFER_PARTIALS) restrict buffer PartialBuffer { uvec2 partials[]; };
#ifndef SPINE
layout(std430, binding = BUFFER_GROUPS) readonly restrict buffer GroupBuffer { WorkGroups groups[]; };
#else
layout(location = UNIFORM_SPAN) uniform uvec4 totals;  // x, y: the counters that the totals go to
#endif
shared uvec2 part[SCAN_GROUP];

uvec2 add(uvec2 a, uvec2 b) {
  uvec2 carry;
  uvec2 sum = uaddCarry(a, b, carry);
  return mix(sum, uvec2(0xffffffffu), notEqual(carry, uvec2(0u)));
}

// Turns part[] into inclusive sums.
void scan_parts(uint t) {
  barrier();
  for (uint stride = 1u; stride < SCAN_GROUP; stride *= 2u) {
    uvec2 other = t >= stride ? part[t - stride] : uvec2(0u);
    barrier();
    part[t] = add(part[t], other);
    barrier();
  }
}

#define EACH (SCAN_TILE / SCAN_GROUP)

void main() {
  uint t = gl_LocalInvocationIndex;
  uint count = counters[which] <= grid.brick_capacity ? counters[which] * elements : 0u;  // else there is no room for what is counted
#ifdef SPINE
  uint tiles = which == COUNT_TILES ? counters[which] : (count + SCAN_TILE - 1u) / SCAN_TILE;
  uvec2 carried = uvec2(0u);
  for (uint first = 0u; first < tiles; first += SCAN_TILE) {
    uvec2 own[EACH];
    uvec2 sum = uvec2(0u);
    for (uint i = 0u; i < EACH; ++i) {
      uint at = first + EACH * t + i;
      own[i] = at < tiles ? partials[at] : uvec2(0u);
      sum = add(sum, own[i]);
    }
    part[t] = sum;
    scan_parts(t);
    uvec2 so_far = add(carried, t > 0u ? part[t - 1u] : uvec2(0u));
    for (uint i = 0u; i < EACH; ++i) {
      uint at = first + EACH * t + i;
      if (at < tiles) partials[at] = so_far;
      so_far = add(so_far, own[i]);
    }
    carried = add(carried, part[SCAN_GROUP - 1u]);
    barrier();
  }
  if (t == 0u) {
    counters[totals.x] = carried.x;
    if (totals.y != totals.x) counters[totals.y] = carried.y;
  }
#else
  uint tile = groups[slice].first + gl_WorkGroupID.x;
  uint first = tile * SCAN_TILE + EACH * t;
  uvec2 own[EACH];
  uvec2 sum = uvec2(0u);
  for (uint i = 0u; i < EACH; ++i) {
    own[i] = first + i < count ? sums[first + i] : uvec2(0u);
    sum = add(sum, own[i]);
  }
  part[t] = sum;
  scan_parts(t);
#ifdef REDUCE
  if (t == SCAN_GROUP - 1u) partials[tile] = part[t];
#else
  uvec2 so_far = add(partials[tile], t > 0u ? part[t - 1u] : uvec2(0u));
  for (uint i = 0u; i < EACH; ++i) {
    if (first + i < count) sums[first + i] = so_far;
    so_far = add(so_far, own[i]);
  }
#endif
#endif
}
