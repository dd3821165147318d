// One tile an invocation: which of the sorted pairs are its own, and how many batches they make.
layout(local_size_x = TILE_GROUP) in;
layout(std430, binding = TILE_PAIRS) readonly restrict buffer PairBuffer { uvec2 pairs[]; };
layout(std430, binding = TILE_RANGES) writeonly restrict buffer RangeBuffer { uvec2 ranges[]; };
layout(std430, binding = TILE_SUMS) writeonly restrict buffer SumBuffer { uint sums[]; };

// The first pair of this tile or a later one.
uint first_of(uint tile) {
  uint low = 0u, high = pairs_at_hand();
  while (low < high) {
    uint middle = (low + high) / 2u;
    if ((pairs[middle].x >> frame.keys.z) < tile)
      low = middle + 1u;
    else
      high = middle;
  }
  return low;
}

void main() {
  uint tile = work_group() * TILE_GROUP + gl_LocalInvocationIndex, tiles = frame.part.z * frame.part.w;
  if (tile > tiles) return;
  uint first = tile < tiles ? first_of(tile) : 0u, end = tile < tiles ? first_of(tile + 1u) : 0u;
  ranges[tile] = uvec2(first, end);
  sums[tile] = (end - first + frame.room.w - 1u) / frame.room.w;
}
