// What the extraction programs share: the grid, its values as keys, the bricks. Compiled with BYTES_PER_VALUE (1, 2, 4, 8), KEY_SIGNED or
// KEY_FLOAT, HAS_ABSENT where some cell is absent.
layout(std140, binding = BLOCK_GRID) uniform GridBlock { ExtractionGrid grid; };
layout(location = UNIFORM_SLICE) uniform uint slice;
layout(location = UNIFORM_PART_LAYER) uniform uint part_layer;

// ---- keys: unsigned numbers in the order of the values (field_keys.h) ----------------------------------------------------------------
#if BYTES_PER_VALUE == 8
#define Key uvec2  // high, low
bool key_less(Key a, Key b) { return a.x < b.x || (a.x == b.x && a.y < b.y); }
Key make_key(uint high, uint low) { return uvec2(high, low); }
#else
#define Key uint
bool key_less(Key a, Key b) { return a < b; }
Key make_key(uint high, uint low) { return high; }
#endif
Key key_min(Key a, Key b) { return key_less(b, a) ? b : a; }
Key key_max(Key a, Key b) { return key_less(a, b) ? b : a; }

#ifdef KEY_FLOAT
#if BYTES_PER_VALUE == 8
Key key_of(uvec2 bits) {  // low word first, as in memory
  uint high = bits.y, low = bits.x;
  if (((high << 1) | low) == 0u) high = 0u;  // -0 is 0
  return (high >> 31) != 0u ? uvec2(~high, ~low) : uvec2(high | 0x80000000u, low);
}
bool key_is_finite(Key key) { return key.x > 0x000fffffu && key.x < 0xfff00000u; }
double value_of(Key key) {
  return packDouble2x32((key.x >> 31) != 0u ? uvec2(key.y, key.x & 0x7fffffffu) : uvec2(~key.y, ~key.x));
}
#else
Key key_of(uint bits) {
  if ((bits << 1) == 0u) bits = 0u;  // -0 is 0
  return (bits >> 31) != 0u ? ~bits : bits | 0x80000000u;
}
bool key_is_finite(Key key) { return key > 0x007fffffu && key < 0xff800000u; }
// By its parts: a conversion may flush numbers below the smallest normal float to 0.
double value_of(Key key) {
  uint bits = (key >> 31) != 0u ? key & 0x7fffffffu : ~key;
  uint exponent = (bits >> 23) & 0xffu, fraction = bits & 0x7fffffu;
  double magnitude = exponent == 0u ? double(fraction) * packDouble2x32(uvec2(0u, (1023u - 149u) << 20))
                                    : packDouble2x32(uvec2(fraction << 29, ((exponent + 896u) << 20) | (fraction >> 3)));
  return (bits >> 31) != 0u ? -magnitude : magnitude;
}
#endif
#else
bool key_is_finite(Key key) { return true; }
#ifdef KEY_SIGNED
#define KEY_OFFSET (1u << (8 * BYTES_PER_VALUE - 1))
Key key_of(uint bits) { return bits ^ KEY_OFFSET; }
double value_of(Key key) { return double(key) - double(KEY_OFFSET); }
#else
Key key_of(uint bits) { return bits; }
double value_of(Key key) { return double(key); }
#endif
#endif

uvec3 brick_at(uint brick) {
  uint row = brick / grid.bricks_x;
  return uvec3(brick - row * grid.bricks_x, row % grid.bricks_y, row / grid.bricks_y);
}

#ifdef LOAD_BRICK
// ---- the 9^3 values around a brick, in shared memory ---------------------------------------------------------------------------------
layout(std430, binding = BUFFER_FIELD) readonly restrict buffer FieldBuffer { uint field_words[]; };
shared Key keys[729];

#if BYTES_PER_VALUE == 8
#define ROW_WORDS 9
#else
#define VALUES_A_WORD (4 / BYTES_PER_VALUE)
#define ROW_WORDS (9 / VALUES_A_WORD + (VALUES_A_WORD > 1 ? 1 : 0))  // 3, 5 or 9: wherever the row begins in its first word
#endif

// One load of a 32-bit word brings four bytes or two halves; neighbouring invocations read neighbouring words. Keys of points outside the
// grid are left as they are. All invocations; ends with a barrier.
void load_brick(uvec3 brick) {
  uvec3 first = 8u * brick;
  uint count = min(9u, grid.points_x - first.x);
  for (uint t = gl_LocalInvocationIndex; t < 81u * ROW_WORDS; t += BRICK_GROUP) {
    uint row = t / ROW_WORDS, w = t - row * ROW_WORDS;
    uint y = first.y + row % 9u, z = first.z + row / 9u;
    if (y >= grid.points_y || z >= grid.points_z) continue;
    uint at = first.x + grid.points_x * (y + grid.points_y * (z - part_layer));
#if BYTES_PER_VALUE == 8
    if (w < count) keys[9u * row + w] = key_of(uvec2(field_words[2u * (at + w)], field_words[2u * (at + w) + 1u]));
#elif BYTES_PER_VALUE == 4
    if (w < count) keys[9u * row + w] = key_of(field_words[at + w]);
#else
    uint word = at / VALUES_A_WORD + w;
    int i = int(w * VALUES_A_WORD) - int(at % VALUES_A_WORD);
    if (i >= int(count)) continue;
    uint bits = field_words[word];
    for (uint b = 0u; b < VALUES_A_WORD; ++b, ++i)
      if (i >= 0 && i < int(count)) keys[9u * row + uint(i)] = key_of(bitfieldExtract(bits, int(8u * BYTES_PER_VALUE * b), 8 * BYTES_PER_VALUE));
#endif
  }
  barrier();
}
#endif

#ifdef LOAD_POINTS
layout(std430, binding = BUFFER_POINTS) readonly restrict buffer PointsBuffer {
#ifdef POINTS_DOUBLE
  double coordinates[];
#else
  float coordinates[];
#endif
};
dvec3 grid_point(uvec3 p) {
  uint at = 3u * (p.x + grid.points_x * (p.y + grid.points_y * (p.z - part_layer)));
  return dvec3(coordinates[at], coordinates[at + 1u], coordinates[at + 2u]);
}
#endif
