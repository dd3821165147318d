// One pass of a stable radix sort of the pairs by TILE_SORT_BITS bits of their keys, least significant first. COUNT: how often each digit is
// in each block, digit by digit; summed up, that is where each block's pairs of a digit go. SCATTER: moves them there.
// Source: N. Satish, M. Harris, M. Garland, "Designing Efficient Sorting Algorithms for Manycore GPUs", 2009.
layout(local_size_x = TILE_GROUP) in;
layout(location = TILE_UNIFORM_SHIFT) uniform uint shift;
layout(std430, binding = TILE_SUMS) restrict buffer SumBuffer { uint sums[]; };
layout(std430, binding = TILE_PAIRS) readonly restrict buffer PairBuffer { uvec2 pairs[]; };
layout(std430, binding = TILE_SORTED) writeonly restrict buffer SortedBuffer { uvec2 sorted[]; };

#define EACH (TILE_SORT_TILE / TILE_GROUP)
#define HALF_DIGITS (TILE_SORT_DIGITS / 2)
// How many pairs of each digit each invocation has, two digits to a word: digit d in the low half, d + 8 in the high half of
// [d][invocation].
shared uint counts[HALF_DIGITS * TILE_GROUP];
shared uint part[TILE_GROUP];

uint digit_of(uint key) { return (key >> shift) & (TILE_SORT_DIGITS - 1u); }
uint half_of(uint word, uint digit) { return digit < HALF_DIGITS ? word & 0xffffu : word >> 16; }
uint word_of(uint digit, uint t) { return (digit % HALF_DIGITS) * TILE_GROUP + t; }

void main() {
  uint t = gl_LocalInvocationIndex, block = work_group(), count = pairs_at_hand();
  uint blocks = (count + TILE_SORT_TILE - 1u) / TILE_SORT_TILE;
  uint first = block * TILE_SORT_TILE + EACH * t;
  for (uint d = 0u; d < HALF_DIGITS; ++d) counts[d * TILE_GROUP + t] = 0u;
  uvec2 own[EACH];
  for (uint i = 0u; i < EACH; ++i) {
    if (first + i >= count) break;
    own[i] = pairs[first + i];
    uint digit = digit_of(own[i].x);
    counts[word_of(digit, t)] += digit < HALF_DIGITS ? 1u : 0x10000u;
  }
  barrier();
#ifdef COUNT
  // Sixteen invocations, one a digit, would wait for 256 additions each; so each adds up sixteen and the first of a digit these.
  uint digit = t / 16u, lane = t % 16u, sum = 0u;
  for (uint i = 0u; i < 16u; ++i) sum += half_of(counts[word_of(digit, lane * 16u + i)], digit);
  part[t] = sum;
  barrier();
  if (lane == 0u && block < blocks) {
    for (uint i = 1u; i < 16u; ++i) sum += part[t + i];
    sums[digit * blocks + block] = sum;
  }
#else
  uint words[HALF_DIGITS];
  uint sum = 0u;
  for (uint i = 0u; i < HALF_DIGITS; ++i) {
    words[i] = counts[HALF_DIGITS * t + i];
    sum += words[i];
  }
  part[t] = sum;
  barrier();
  for (uint stride = 1u; stride < TILE_GROUP; stride *= 2u) {
    uint other = t >= stride ? part[t - stride] : 0u;
    barrier();
    part[t] += other;
    barrier();
  }
  uint so_far = t > 0u ? part[t - 1u] : 0u;
  for (uint i = 0u; i < HALF_DIGITS; ++i) {
    counts[HALF_DIGITS * t + i] = so_far;
    so_far += words[i];
  }
  barrier();
  if (t < TILE_SORT_DIGITS && block < blocks)  // where the block's pairs of the digit go, less their place in the block
    part[t] = sums[t * blocks + block] - half_of(counts[word_of(t, 0u)], t);
  barrier();
  for (uint i = 0u; i < EACH; ++i) {
    if (first + i >= count) break;
    uint digit = digit_of(own[i].x), word = word_of(digit, t);
    sorted[part[digit] + half_of(counts[word], digit)] = own[i];
    counts[word] += digit < HALF_DIGITS ? 1u : 0x10000u;
  }
#endif
}
