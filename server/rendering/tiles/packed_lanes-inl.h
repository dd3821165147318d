// Packing lanes of vectors, and runs of numbers for vectors to look up; included by the files of kernels once per target.
#if defined(ISOSTRATA_PACKED_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOSTRATA_PACKED_LANES_INL
#undef ISOSTRATA_PACKED_LANES_INL
#else
#define ISOSTRATA_PACKED_LANES_INL
#endif

#include <hwy/highway.h>

#include "rendering/tiles/packed_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Moves the lanes that a mask leaves to the front: one look into a table for any number of vectors.
template <class D>
class Packer {
  static constexpr std::size_t kLanes = hn::MaxLanes(D{});
  static constexpr bool kByTable = kLanes == 4 || kLanes == 8;  // longer ones have an instruction
  using DI = hn::RebindToSigned<D>;
  using Mask = hn::Mask<D>;

 public:
  HWY_INLINE Packer(D d, Mask mask) : mask_(mask), count_(hn::CountTrue(d, mask)) {
    if constexpr (kByTable) {
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(d, mask, bits);
      const std::uint8_t* from;
      if constexpr (kLanes == 8)
        from = kPackedLanes8.from[bits[0]];
      else
        from = kPackedLanes4.from[bits[0] & 15];
      from_ = hn::PromoteTo(DI(), hn::LoadU(hn::Rebind<std::uint8_t, DI>(), from));
    }
  }
  template <class V>
  HWY_INLINE V operator()(V v) const {
    using DV = hn::DFromV<V>;
    if constexpr (kByTable)
      return hn::TableLookupLanes(v, hn::IndicesFromVec(DV(), from_));
    else
      return hn::Compress(v, hn::RebindMask(DV(), mask_));
  }
  std::size_t count() const { return count_; }

 private:
  Mask mask_;
  std::size_t count_;
  hn::Vec<DI> from_;
};

/// Writes start, start + step, ...: at least `count` numbers, in whole vectors without a branch if they are few.
HWY_INLINE void write_run(std::uint16_t* out, std::size_t count, unsigned start, unsigned step) {
  const hn::CappedTag<std::uint16_t, 16> d;
  const auto steps = hn::Mul(hn::Iota(d, 0), hn::Set(d, static_cast<std::uint16_t>(step)));
  const auto run = hn::Add(steps, hn::Set(d, static_cast<std::uint16_t>(start)));
  hn::StoreU(run, d, out);
  for (std::size_t i = hn::Lanes(d); HWY_UNLIKELY(i < count); i += hn::Lanes(d))
    hn::StoreU(hn::Add(run, hn::Set(d, static_cast<std::uint16_t>(i * step))), d, out + i);
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
