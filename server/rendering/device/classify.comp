// The cells of active bricks: the case of each in each interval that passes through it. First pass: how many records and tetrahedra each
// row of eight cells has, in the order of the grid's cells. With WRITE, after these are added up: the records.
layout(local_size_x = BRICK_GROUP) in;
layout(std430, binding = BUFFER_RULES) readonly restrict buffer RuleBuffer { IsoKeys rules[]; };
layout(std430, binding = BUFFER_COUNTERS) restrict buffer CounterBuffer { ExtractionCounters counters; };
layout(std430, binding = BUFFER_BRICKS) readonly restrict buffer BrickBuffer { uint bricks[]; };
layout(std430, binding = BUFFER_ROWS) readonly restrict buffer RowBuffer { uint row_first[]; };
layout(std430, binding = BUFFER_GROUPS) readonly restrict buffer GroupBuffer { WorkGroups groups[]; };
layout(std430, binding = BUFFER_SUMS) restrict buffer SumBuffer { uvec2 sums[]; };
layout(std430, binding = BUFFER_TABLES) readonly restrict buffer TableBuffer { uint tables[]; };
#ifdef HAS_ABSENT
layout(std430, binding = BUFFER_ABSENT) readonly restrict buffer AbsentBuffer { uint absent[]; };
#endif
#ifdef WRITE
layout(std430, binding = BUFFER_RECORDS) writeonly restrict buffer RecordBuffer { CellRecord records[]; };
layout(std430, binding = BUFFER_FIRST) writeonly restrict buffer FirstBuffer { uint first_tetrahedron[]; };
shared int balance;
#else
layout(std430, binding = BUFFER_TALLY) restrict buffer TallyBuffer { IntervalTally tally[]; };
shared uint tally_records[COUNTED_IN_GROUP], tally_tetrahedra[COUNTED_IN_GROUP];
shared uint active_cells;
#endif

// Where the row of cells r = j + 8 k of active brick n stands among all rows of eight cells, in the order of the grid's cells: first by
// layers of bricks, then by k, by rows of bricks, by j, by bricks.
uint row_of_cells(uint n, uvec3 brick, uint r) {
  uint j = r & 7u, k = r >> 3, row = brick.y + grid.bricks_y * brick.z;
  uint layer_begin = row_first[grid.bricks_y * brick.z], layer_end = row_first[grid.bricks_y * (brick.z + 1u)];
  uint row_begin = row_first[row], row_end = row_first[row + 1u];
  return 64u * layer_begin + 8u * k * (layer_end - layer_begin) + 8u * (row_begin - layer_begin) + j * (row_end - row_begin) + (n - row_begin);
}

#if defined(WRITE) && defined(LOAD_POINTS)
double orient(dvec3 a, dvec3 b, dvec3 c, dvec3 d) { return dot(cross(b - a, c - a), d - a); }

// As cell_geometry.h: the sign of the volume inside the cell's faces, or 0 if rounding decides it. 1 right-handed, 2 left-handed.
uint handedness(uvec3 cell) {
  dvec3 p[8];
  dvec3 lower, upper;
  for (uint v = 0u; v < 8u; ++v) {
    uvec3 corner = uvec3(tables[v] & 1u, (tables[v] >> 1) & 1u, (tables[v] >> 2) & 1u);
    p[v] = grid_point(cell + corner);
    lower = v == 0u ? p[v] : min(lower, p[v]);
    upper = v == 0u ? p[v] : max(upper, p[v]);
  }
  const uvec4 faces[6] = uvec4[6](uvec4(0, 4, 7, 3), uvec4(1, 2, 6, 5), uvec4(0, 1, 5, 4), uvec4(3, 7, 6, 2), uvec4(0, 3, 2, 1), uvec4(4, 5, 6, 7));
  double twice = 0.0lf;
  for (uint f = 0u; f < 6u; ++f) {
    dvec3 a = p[faces[f].x], b = p[faces[f].y], c = p[faces[f].z], d = p[faces[f].w];
    twice += orient(p[0], a, b, c) + orient(p[0], a, c, d) + orient(p[0], b, c, d) + orient(p[0], d, a, b);
  }
  dvec3 reach = max(abs(lower), abs(upper)), extent = upper - lower;
  double size = sqrt(dot(extent, extent));
  double epsilon = packDouble2x32(uvec2(0u, 0x3cb00000u));  // 2^-52
  double tolerance = 4.0lf * epsilon * max(max(max(reach.x, reach.y), reach.z), size) * size * size;
  double volume = twice / 12.0lf;
  return volume > tolerance ? 1u : volume < -tolerance ? 2u : 0u;
}
#endif

void main() {
  uint n = groups[slice].first + gl_WorkGroupID.x, r = gl_LocalInvocationIndex;
#ifdef WRITE
  if (counters.records > grid.record_capacity) return;  // all invocations alike
#endif
  uint number = bricks[n];
  uvec3 brick = brick_at(number), first = 8u * brick;
#ifdef WRITE
  if (r == 0u) balance = 0;
#else
  if (r < COUNTED_IN_GROUP) tally_records[r] = tally_tetrahedra[r] = 0u;
  if (r == 0u) active_cells = 0u;
#endif
  load_brick(brick);

  uvec3 cell = first + uvec3(0u, r & 7u, r >> 3);
  uint row = row_of_cells(n, brick, r), missing = 0u;
  if (cell.y + 1u >= grid.points_y || cell.z + 1u >= grid.points_z) missing = 0xffu;
#ifdef HAS_ABSENT
  missing |= bitfieldExtract(absent[16u * number + (r >> 2)], int(8u * (r & 3u)), 8);
#endif
#ifdef WRITE
  uvec2 at = sums[row];
#else
  uvec2 at = uvec2(0u);
#endif
  for (uint i = 0u; i < 8u && cell.x + 1u < grid.points_x; ++i, ++cell.x) {
    if (((missing >> i) & 1u) != 0u) continue;
    uint corner = i + 9u * (r & 7u) + 81u * (r >> 3);
    Key f[8] = Key[8](keys[corner], keys[corner + 1u], keys[corner + 10u], keys[corner + 9u], keys[corner + 81u], keys[corner + 82u],
                      keys[corner + 91u], keys[corner + 90u]);
    Key lowest = f[0], highest = f[0];
    for (uint v = 1u; v < 8u; ++v) {
      lowest = key_min(lowest, f[v]);
      highest = key_max(highest, f[v]);
    }
    uint begin = 0u;
    if (grid.rules > 4u) {  // the first interval whose end, or an earlier one's, is not below the lowest value
      uint end = grid.rules;
      while (begin < end) {
        uint middle = (begin + end) / 2u;
        if (key_less(make_key(rules[middle].reach_high, rules[middle].reach_low), lowest))
          begin = middle + 1u;
        else
          end = middle;
      }
    }
    uint found = 0u, hand = 0u;
    for (uint s = begin; s < grid.rules; ++s) {
      Key lower = make_key(rules[s].lower_high, rules[s].lower_low), last = make_key(rules[s].last_high, rules[s].last_low);
      if (key_less(highest, lower)) break;
      if (key_less(last, lowest)) continue;
      uint index = 0u;
      for (int v = 7; v >= 0; --v) index = 3u * index + (key_less(f[v], lower) ? 0u : 1u) + (key_less(last, f[v]) ? 1u : 0u);
      uint count = tables[ISO_VERTICES + index] & ((1u << CASE_COUNT_BITS) - 1u);
#ifdef WRITE
#ifdef LOAD_POINTS
      if (found == 0u) {
        hand = handedness(cell);
        if (hand != 0u) atomicAdd(balance, hand == 1u ? 1 : -1);
      }
#endif
      uint linear = cell.x + (grid.points_x - 1u) * (cell.y + (grid.points_y - 1u) * cell.z);
      records[at.x] = CellRecord(linear, index | (hand << RECORD_HAND_SHIFT) | (rules[s].interval << RECORD_INTERVAL_SHIFT));
      first_tetrahedron[at.x] = at.y;
#else
      if (s < COUNTED_IN_GROUP) {
        atomicAdd(tally_records[s], 1u);
        atomicAdd(tally_tetrahedra[s], count);
      } else {
        atomicAdd(tally[rules[s].interval].records, 1u);
        atomicAdd(tally[rules[s].interval].tetrahedra, count);
      }
#endif
      ++found;
      at += uvec2(1u, count);
    }
#ifndef WRITE
    if (found > 0u) atomicAdd(active_cells, 1u);
#endif
  }
#ifdef WRITE
  barrier();
  if (r == 0u && balance != 0) atomicAdd(counters.balance, balance);
#else
  sums[row] = at;
  barrier();
  if (r < min(COUNTED_IN_GROUP, grid.rules) && tally_records[r] > 0u) {
    atomicAdd(tally[rules[r].interval].records, tally_records[r]);
    atomicAdd(tally[rules[r].interval].tetrahedra, tally_tetrahedra[r]);
  }
  if (r == 0u && active_cells > 0u) atomicAdd(counters.active_cells, active_cells);
#endif
}
