// The work groups of indirect dispatches, in slices of bounded length: over the active bricks of some layers, or over as many items as a
// counter says. A list that has no room is not gone through.
layout(local_size_x = 64) in;
layout(location = UNIFORM_FIRST) uniform uint first_slice;
layout(location = UNIFORM_COUNT) uniform uint slices;
layout(location = UNIFORM_SPAN) uniform uvec4 span;  // groups a slice; items a group; then two of what is named below
layout(std430, binding = BUFFER_COUNTERS) readonly restrict buffer CounterBuffer { uint counters[]; };
layout(std430, binding = BUFFER_ROWS) readonly restrict buffer RowBuffer { uint row_first[]; };
layout(std430, binding = BUFFER_GROUPS) writeonly restrict buffer GroupBuffer { WorkGroups groups[]; };

void main() {
  uint s = gl_GlobalInvocationID.x;
  if (s >= slices) return;
#ifdef PLAN_BRICKS  // rows [span.z, span.w) of bricks
  uint begin = row_first[span.z], items = row_first[span.w] - begin;
#else               // counter span.z
  uint begin = 0u, items = counters[span.z];
#endif
  bool fits = counters[COUNT_BRICKS] <= grid.brick_capacity;
#ifdef PLAN_RECORDS
  fits = fits && counters[COUNT_RECORDS] <= grid.record_capacity;
#endif
  uint total = fits ? items / span.y + (items % span.y != 0u ? 1u : 0u) : 0u;
  uint done = s * span.x;
  groups[first_slice + s] = WorkGroups(total > done ? min(span.x, total - done) : 0u, 1u, 1u, begin + done);
}
