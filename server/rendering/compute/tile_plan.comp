// The work groups of the indirect dispatches, from the counters.
layout(local_size_x = 1) in;
layout(location = TILE_UNIFORM_PLAN) uniform uint what;
layout(location = TILE_UNIFORM_SLICES) uniform uint slices;
layout(std430, binding = TILE_GROUPS) writeonly restrict buffer GroupBuffer { uvec4 groups[]; };

uvec4 rows_of(uint count) {
  uint x = min(count, TILE_ROW_GROUPS);
  return uvec4(x, x == 0u ? 0u : (count + x - 1u) / x, count == 0u ? 0u : 1u, 0u);
}

void main() {
  if (what == 0u) {
    uint blocks = (pairs_at_hand() + TILE_SORT_TILE - 1u) / TILE_SORT_TILE;
    groups[TILE_GROUPS_SORT] = rows_of(blocks);
    groups[TILE_GROUPS_SORT_SCAN] = rows_of((blocks * TILE_SORT_DIGITS + TILE_SCAN_TILE - 1u) / TILE_SCAN_TILE);
  } else {
    uint batches = counters[TILE_COUNT_BATCHES];
    if (batches > frame.room.z) batches = 0u;
    uint each = (batches + slices - 1u) / slices;
    for (uint s = 0u; s < slices; ++s) groups[TILE_GROUPS_BLEND + s] = rows_of(min(each, batches - min(s * each, batches)));
  }
}
