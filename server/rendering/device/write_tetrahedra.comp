// The tetrahedra of the records as numbers of mesh points: each work group takes RECORD_GROUP records, each invocation tetrahedra of any of
// them, so that neighbouring invocations write neighbouring tetrahedra.
layout(local_size_x = RECORD_GROUP) in;
layout(std430, binding = BUFFER_COUNTERS) readonly restrict buffer CounterBuffer { ExtractionCounters counters; };
layout(std430, binding = BUFFER_GROUPS) readonly restrict buffer GroupBuffer { WorkGroups groups[]; };
layout(std430, binding = BUFFER_RANKS) readonly restrict buffer RankBuffer { uint ranks[]; };
layout(std430, binding = BUFFER_SLOTS) readonly restrict buffer SlotBuffer { uint slots[]; };
layout(std430, binding = BUFFER_OWNED) readonly restrict buffer OwnedBuffer { uvec2 owned[]; };
layout(std430, binding = BUFFER_ISOVALUES) readonly restrict buffer PairBuffer { uvec4 pairs[]; };
layout(std430, binding = BUFFER_TABLES) readonly restrict buffer TableBuffer { uint tables[]; };
layout(std430, binding = BUFFER_RECORDS) readonly restrict buffer RecordBuffer { CellRecord records[]; };
layout(std430, binding = BUFFER_FIRST) readonly restrict buffer FirstBuffer { uint first_tetrahedron[]; };
layout(std430, binding = BUFFER_TETRAHEDRA) writeonly restrict buffer TetrahedronBuffer { uvec4 tetrahedra[]; };
layout(location = UNIFORM_FIRST) uniform uint mirrored;  // the axes' own handedness: 1 if cells of unknown handedness are left-handed
shared uint first[RECORD_GROUP + 1];
shared uint words[RECORD_GROUP];
shared uvec3 cells[RECORD_GROUP];

uint number_of(uvec3 cell, uint isovertex, uvec4 pair) {
  uint word = tables[isovertex], axis = (word >> ISO_AXIS_SHIFT) & 3u;
  uvec3 p = cell + uvec3(word & 1u, (word >> 1) & 1u, (word >> 2) & 1u);
  uint slot = axis == 3u ? 0u : 1u + axis * grid.isovalues + ((word >> ISO_UPPER_SHIFT) != 0u ? pair.y : pair.x);
  uvec3 brick = p >> 3, local = p & 7u;
  uint n = ranks[brick.x + grid.bricks_x * (brick.y + grid.bricks_y * brick.z)];
  uint at = 512u * n + local.x + 8u * (local.y + 8u * local.z);
#if SLOT_WORDS == 1
  uint bits = slots[at];
  return owned[n].x + (bits >> 16) + uint(bitCount(bits & ((1u << slot) - 1u)));
#else
  uint low = slots[3u * at], high = slots[3u * at + 1u];
  uint below = slot < 32u ? uint(bitCount(low & ((1u << slot) - 1u))) : uint(bitCount(low) + bitCount(high & ((1u << (slot - 32u)) - 1u)));
  return owned[n].x + slots[3u * at + 2u] + below;
#endif
}

void main() {
  if (counters.tetrahedra > grid.tetrahedron_capacity) return;  // all invocations alike
  uint t = gl_LocalInvocationIndex;
  uint begin = (groups[slice].first + gl_WorkGroupID.x) * RECORD_GROUP;
  uint count = min(RECORD_GROUP, counters.records - begin);
  if (t < count) {
    CellRecord record = records[begin + t];
    uint cells_x = grid.points_x - 1u, cells_y = grid.points_y - 1u, row = record.cell / cells_x;
    cells[t] = uvec3(record.cell - row * cells_x, row % cells_y, row / cells_y);
    words[t] = record.case_interval;
    first[t] = first_tetrahedron[begin + t];
  }
  if (t == 0u) first[count] = begin + count < counters.records ? first_tetrahedron[begin + count] : counters.tetrahedra;
  barrier();
  for (uint to = first[0] + t; to < first[count]; to += RECORD_GROUP) {
    uint low = 0u, high = count;  // the last record that begins at or before `to`
    while (low + 1u < high) {
      uint middle = (low + high) / 2u;
      if (first[middle] <= to)
        low = middle;
      else
        high = middle;
    }
    uint word = words[low], hand = (word >> RECORD_HAND_SHIFT) & 3u;
    uvec4 pair = pairs[grid.isovalues + (word >> RECORD_INTERVAL_SHIFT)];
    uint entry = tables[ISO_VERTICES + (word & RECORD_CASE_MASK)] >> CASE_COUNT_BITS;
    uint code = tables[ISO_VERTICES + HEXAHEDRON_CASES + entry + (to - first[low])];
    uvec4 v = uvec4(code & 0xffu, (code >> 8) & 0xffu, (code >> 16) & 0xffu, code >> 24);
    bool left = hand == 0u ? (mirrored != 0u || counters.balance < 0) : hand == 2u;
    if (left) v.xy = v.yx;  // positive if the cell's own orientation is
    tetrahedra[to] = uvec4(number_of(cells[low], v.x, pair), number_of(cells[low], v.y, pair), number_of(cells[low], v.z, pair),
                           number_of(cells[low], v.w, pair));
  }
}
