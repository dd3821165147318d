#include "rendering/segments/reach_tetrahedra.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rendering/segments/reach_tetrahedra.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Bit i: tetrahedron i of the block reaches into the interval.
std::uint64_t ReachOfBlock(const float* least, const float* most, float begin, float end) {
  const hn::CappedTag<float, 16> d;
  constexpr std::size_t kBlock = TetrahedronRanges::kBlock;
  const std::size_t lanes = hn::Lanes(d);
  const auto from = hn::Set(d, begin), to = hn::Set(d, end);
  std::uint64_t mask = 0;
  for (std::size_t i = 0; i < kBlock; i += lanes) {
    const auto reaches = hn::And(hn::Ge(hn::LoadU(d, most + i), from), hn::Lt(hn::LoadU(d, least + i), to));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, reaches, bits);
    const std::uint64_t here = (bits[0] | std::uint64_t{bits[1]} << 8) & ((std::uint64_t{1} << lanes) - 1);
    mask |= here << i;
  }
  return mask;
}

void ReachTetrahedra(const TetrahedronRanges& ranges, std::size_t first, std::size_t last, std::span<const ReachOf> intervals,
                     std::vector<Reach>& out) {
  constexpr std::size_t kBlock = TetrahedronRanges::kBlock;
  for (std::size_t b = first; b < last; ++b)
    for (const ReachOf& of : intervals) {
      if (!ranges.block_reaches(b, of.bounds)) continue;
      std::uint64_t mask =
          ReachOfBlock(ranges.least.data() + b * kBlock, ranges.most.data() + b * kBlock, of.bounds.begin, of.bounds.end);
      for (; mask; mask &= mask - 1)
        out.push_back({static_cast<std::uint32_t>(b * kBlock + static_cast<std::size_t>(__builtin_ctzll(mask))), of.interval});
    }
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

HWY_EXPORT(ReachTetrahedra);

void reach_tetrahedra(const TetrahedronRanges& ranges, std::size_t first, std::size_t last, std::span<const ReachOf> intervals,
                      std::vector<Reach>& out) {
  HWY_DYNAMIC_DISPATCH(ReachTetrahedra)(ranges, first, last, intervals, out);
}

}  // namespace isostrata
#endif  // HWY_ONCE
