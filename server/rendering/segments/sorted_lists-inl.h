// Lists of pixels side by side, sorted in vectors; included by the files of kernels once per target.
#if defined(ISOSTRATA_SORTED_LISTS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOSTRATA_SORTED_LISTS_INL
#undef ISOSTRATA_SORTED_LISTS_INL
#else
#define ISOSTRATA_SORTED_LISTS_INL
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "rendering/segments/segment_lists.h"

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

inline HWY_NOINLINE void sort_one_by_one(std::uint64_t* items, std::size_t length) {
  std::vector<std::uint64_t> list(length);
  for (std::size_t lane = 0; lane < kListLanes; ++lane) {
    for (std::size_t k = 0; k < length; ++k) list[k] = items[k * kListLanes + lane];
    std::sort(list.begin(), list.end());
    for (std::size_t k = 0; k < length; ++k) items[k * kListLanes + lane] = list[k];
  }
}

/// kListLanes lists side by side, ascending. The items are compared as the numbers of double precision that have their bits:
/// positive ones have the same order, and their least and greatest take one instruction everywhere.
HWY_INLINE void sort_lists(std::uint64_t* items, std::size_t length) {
  const hn::CappedTag<double, kListLanes> d;
  const std::size_t lanes = hn::Lanes(d);
  constexpr int kPasses = 12;
  bool sorted = length < 2;
  for (int pass = 0; !sorted; ++pass) {
    if (pass == kPasses) return sort_one_by_one(items, length);
    sorted = true;
    for (std::size_t part = 0; part < kListLanes; part += lanes) {
      double* const at = reinterpret_cast<double*>(items + part);
      if (pass % 2 == 0) {  // the greatest sinks to the end
        auto carry = hn::Load(d, at);
        auto moved = hn::MaskFromVec(hn::Zero(d));
        for (std::size_t k = 1; k < length; ++k) {
          const auto next = hn::Load(d, at + k * kListLanes);
          moved = hn::Or(moved, hn::Lt(next, carry));
          hn::Store(hn::Min(carry, next), d, at + (k - 1) * kListLanes);
          carry = hn::Max(carry, next);
        }
        hn::Store(carry, d, at + (length - 1) * kListLanes);
        sorted = sorted && hn::AllFalse(d, moved);
      } else {  // the least rises to the front
        auto carry = hn::Load(d, at + (length - 1) * kListLanes);
        auto moved = hn::MaskFromVec(hn::Zero(d));
        for (std::size_t k = length - 1; k-- > 0;) {
          const auto next = hn::Load(d, at + k * kListLanes);
          moved = hn::Or(moved, hn::Lt(carry, next));
          hn::Store(hn::Max(carry, next), d, at + (k + 1) * kListLanes);
          carry = hn::Min(carry, next);
        }
        hn::Store(carry, d, at);
        sorted = sorted && hn::AllFalse(d, moved);
      }
    }
  }
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
