// Which bricks an interval may pass through. First pass: how many in each tile of SCAN_GROUP bricks. With COMPACT, after these are added
// up: their list, their ranks, and how many come before each row of bricks.
layout(local_size_x = SCAN_GROUP) in;
layout(location = UNIFORM_FIRST) uniform uint first_group;
layout(std430, binding = BUFFER_RANGES) readonly restrict buffer RangeBuffer { IsoRange ranges[]; };
layout(std430, binding = BUFFER_RULES) readonly restrict buffer RuleBuffer { IsoKeys rules[]; };
layout(std430, binding = BUFFER_PARTIALS) restrict buffer PartialBuffer { uvec2 partials[]; };
#ifdef COMPACT
layout(std430, binding = BUFFER_COUNTERS) readonly restrict buffer CounterBuffer { ExtractionCounters counters; };
layout(std430, binding = BUFFER_BRICKS) writeonly restrict buffer BrickBuffer { uint bricks[]; };
layout(std430, binding = BUFFER_ROWS) writeonly restrict buffer RowBuffer { uint row_first[]; };
layout(std430, binding = BUFFER_SUMS) writeonly restrict buffer RankBuffer { uint ranks[]; };
#endif
shared uint before[SCAN_GROUP];

bool is_active(uint brick) {
  IsoRange range = ranges[brick];
  Key lowest = make_key(range.lower_high, range.lower_low), highest = make_key(range.upper_high, range.upper_low);
  if (key_less(highest, lowest)) return false;
  uint begin = 0u, end = grid.rules;  // the first interval whose end is not below the lowest value
  while (begin < end) {
    uint middle = (begin + end) / 2u;
    if (key_less(make_key(rules[middle].reach_high, rules[middle].reach_low), lowest))
      begin = middle + 1u;
    else
      end = middle;
  }
  return begin < grid.rules && !key_less(highest, make_key(rules[begin].lower_high, rules[begin].lower_low));
}

void main() {
  uint tile = first_group + gl_WorkGroupID.x, t = gl_LocalInvocationIndex;
  uint brick = tile * SCAN_GROUP + t;
  uint count = grid.bricks_x * grid.bricks_y * grid.bricks_z;
  bool reached = brick < count && is_active(brick);
  before[t] = reached ? 1u : 0u;
  barrier();
  for (uint stride = 1u; stride < SCAN_GROUP; stride *= 2u) {  // inclusive sums
    uint add = t >= stride ? before[t - stride] : 0u;
    barrier();
    before[t] += add;
    barrier();
  }
#ifdef COMPACT
  if (brick >= count) return;
  uint rank = partials[tile].x + before[t] - (reached ? 1u : 0u);
  ranks[brick] = rank;
  if (brick % grid.bricks_x == 0u) row_first[brick / grid.bricks_x] = rank;
  if (brick + 1u == count) row_first[grid.bricks_y * grid.bricks_z] = counters.bricks;
  if (reached && rank < grid.brick_capacity) bricks[rank] = brick;
#else
  if (t == SCAN_GROUP - 1u) partials[tile] = uvec2(before[t], 0u);
#endif
}
