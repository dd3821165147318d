// Sums of all before, saturating at 2^32 - 1, by adding up tiles and then going through them again (portable: no work group waits for
// another). REDUCE: each tile's sum. SPINE, one work group: the tiles' sums into sums of all before, the total into a counter. APPLY: the
// elements into sums of all before.
layout(local_size_x = TILE_GROUP) in;
layout(location = TILE_UNIFORM_ELEMENTS) uniform uint given_elements;
layout(location = TILE_UNIFORM_TOTAL) uniform uint total;
layout(std430, binding = TILE_SUMS) restrict buffer SumBuffer { uint sums[]; };
layout(std430, binding = TILE_PARTIALS) restrict buffer PartialBuffer { uint partials[]; };
shared uint part[TILE_GROUP];

#define EACH (TILE_SCAN_TILE / TILE_GROUP)

uint element_count() {
  return given_elements != 0u ? given_elements : (pairs_at_hand() + TILE_SORT_TILE - 1u) / TILE_SORT_TILE * TILE_SORT_DIGITS;
}

// Turns part[] into inclusive sums.
void scan_parts(uint t) {
  barrier();
  for (uint stride = 1u; stride < TILE_GROUP; stride *= 2u) {
    uint other = t >= stride ? part[t - stride] : 0u;
    barrier();
    part[t] = saturated_add(part[t], other);
    barrier();
  }
}

void main() {
  uint t = gl_LocalInvocationIndex, count = element_count();
#ifdef SPINE
  uint tiles = (count + TILE_SCAN_TILE - 1u) / TILE_SCAN_TILE;
  uint carried = 0u;
  for (uint first = 0u; first < tiles; first += TILE_SCAN_TILE) {
    uint own[EACH];
    uint sum = 0u;
    for (uint i = 0u; i < EACH; ++i) {
      uint at = first + EACH * t + i;
      own[i] = at < tiles ? partials[at] : 0u;
      sum = saturated_add(sum, own[i]);
    }
    part[t] = sum;
    scan_parts(t);
    uint so_far = saturated_add(carried, t > 0u ? part[t - 1u] : 0u);
    for (uint i = 0u; i < EACH; ++i) {
      uint at = first + EACH * t + i;
      if (at < tiles) partials[at] = so_far;
      so_far = saturated_add(so_far, own[i]);
    }
    carried = saturated_add(carried, part[TILE_GROUP - 1u]);
    barrier();
  }
  if (t == 0u && total < TILE_COUNTER_WORDS) counters[total] = carried;
#else
  uint tile = work_group();
  uint first = tile * TILE_SCAN_TILE + EACH * t;
  uint own[EACH];
  uint sum = 0u;
  for (uint i = 0u; i < EACH; ++i) {
    own[i] = first + i < count ? sums[first + i] : 0u;
    sum = saturated_add(sum, own[i]);
  }
  part[t] = sum;
  scan_parts(t);
  if (tile * TILE_SCAN_TILE >= count) return;
#ifdef REDUCE
  if (t == TILE_GROUP - 1u) partials[tile] = part[t];
#else
  uint so_far = saturated_add(partials[tile], t > 0u ? part[t - 1u] : 0u);
  for (uint i = 0u; i < EACH; ++i) {
    if (first + i < count) sums[first + i] = so_far;
    so_far = saturated_add(so_far, own[i]);
  }
#endif
#endif
}
