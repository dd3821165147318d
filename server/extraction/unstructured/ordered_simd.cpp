#include "extraction/unstructured/ordered_simd.h"

#include <cstring>

#include "data/values/for_each_scalar.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "extraction/unstructured/ordered_simd.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Plain loops of a fixed length: the compiler makes them vectors of the target.
template <class T>
HWY_ATTR void count_reached(const T* values, std::size_t count, std::span<const T> thresholds, std::uint8_t* bins) {
  constexpr std::size_t kTogether = 64;
  std::size_t first = 0;
  for (; first + kTogether <= count; first += kTogether) {
    const T* const v = values + first;
    std::uint8_t* const b = bins + first;
    if (thresholds.size() == 2) {  // one interval
      const T lower = thresholds[0], above = thresholds[1];
      for (std::size_t i = 0; i < kTogether; ++i) b[i] = static_cast<std::uint8_t>((v[i] >= lower) + (v[i] >= above));
      continue;
    }
    std::uint8_t own[kTogether] = {};
    for (const T threshold : thresholds)
      for (std::size_t i = 0; i < kTogether; ++i) own[i] = static_cast<std::uint8_t>(own[i] + (v[i] >= threshold));
    for (std::size_t i = 0; i < kTogether; ++i) b[i] = own[i];
  }
  for (; first < count; ++first) {
    unsigned own = 0;
    for (const T threshold : thresholds) own += values[first] >= threshold;
    bins[first] = static_cast<std::uint8_t>(own);
  }
}

HWY_ATTR void find_all_cases(const std::array<std::uint8_t, 64>& bins, const std::array<std::array<std::uint8_t, 64>, 4>& corners,
                             BlockCases& out) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_SSSE3
  const hn::CappedTag<std::uint8_t, 64> d;
  constexpr std::size_t kLanes = hn::MaxLanes(d);
  // A table of 64 is four of 16. What is not in one of them gets an index of 128 or more there, which reads 0.
  const auto part = [&](std::size_t i) HWY_ATTR { return hn::LoadDup128(d, bins.data() + 16 * i); };
  const auto table0 = part(0), table1 = part(1), table2 = part(2), table3 = part(3);
  const auto above = hn::Set(d, 0x70);
  std::uint64_t active = 0;
  for (std::size_t first = 0; first < 64; first += kLanes) {
    auto sum = hn::Zero(d);
    for (int v = 3; v >= 0; --v) {
      const auto at = hn::LoadU(d, corners[v].data() + first);
      const auto look = [&](decltype(at) table, std::uint8_t begin) HWY_ATTR {
        return hn::TableLookupBytesOr0(table, hn::SaturatedAdd(hn::Sub(at, hn::Set(d, begin)), above));
      };
      const auto bin = hn::Or(hn::Or(look(table0, 0), look(table1, 16)), hn::Or(look(table2, 32), look(table3, 48)));
      sum = hn::Add(hn::Add(sum, hn::Add(sum, sum)), bin);
    }
    hn::StoreU(sum, d, out.of.data() + first);
    const auto is_active = hn::And(hn::Ne(sum, hn::Zero(d)), hn::Ne(sum, hn::Set(d, 80)));
    std::uint8_t bits[16] = {};
    hn::StoreMaskBits(d, is_active, bits);
    std::uint64_t word;
    std::memcpy(&word, bits, sizeof word);
    active |= word << first;
  }
  out.active = active;
#else
  out.active = 0;
  for (std::size_t t = 0; t < 64; ++t) {
    const int sum = bins[corners[0][t]] + 3 * bins[corners[1][t]] + 9 * bins[corners[2][t]] + 27 * bins[corners[3][t]];
    out.of[t] = static_cast<std::uint8_t>(sum);
    out.active |= std::uint64_t{sum != 0 && sum != 80} << t;
  }
#endif
}

/// Eight tetrahedra, of which the first row.count mean something.
HWY_ATTR void write_eight(const std::uint32_t* numbers, const CutRow& row, std::uint32_t* out) {
  const std::uint8_t* const slots = row.slots[0].data();
#if !HWY_HAVE_SCALABLE
  const hn::CappedTag<std::uint32_t, 16> d;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  constexpr std::size_t kLanes = hn::MaxLanes(d);
  if constexpr (kLanes == 16) {  // all sixteen numbers in a register
    const auto table = hn::LoadU(d, numbers);
    const auto write_four = [&](int first) HWY_ATTR {
      const auto at = hn::IndicesFromVec(d, hn::PromoteTo(d, hn::LoadU(d8, slots + 4 * first)));
      hn::StoreU(hn::TableLookupLanes(table, at), d, out + 4 * first);
    };
    write_four(0);
    if (row.count > 4) write_four(4);
    return;
  } else if constexpr (kLanes == 8) {  // in two
    const auto lower = hn::LoadU(d, numbers), upper = hn::LoadU(d, numbers + 8);
    const auto write_two = [&](int first) HWY_ATTR {
      const auto slot = hn::PromoteTo(d, hn::LoadU(d8, slots + 4 * first));
      const auto at = hn::IndicesFromVec(d, hn::And(slot, hn::Set(d, 7)));
      const auto in_upper = hn::Ne(hn::And(slot, hn::Set(d, 8)), hn::Zero(d));
      hn::StoreU(hn::IfThenElse(in_upper, hn::TableLookupLanes(upper, at), hn::TableLookupLanes(lower, at)), d, out + 4 * first);
    };
    write_two(0);
    write_two(2);
    if (row.count > 4) write_two(4);
    return;
  }
#endif
  for (int i = 0; i < 4 * row.count; ++i) out[i] = numbers[slots[i]];
}

HWY_ATTR void write_all(const std::array<std::uint32_t, CutRow::kNumbers>* numbers, const CutRow* const* rows, std::size_t count,
                        std::span<std::array<std::uint32_t, 4>> out) {
  std::array<std::uint32_t, 4>* to = out.data();
  std::array<std::uint32_t, 4>* const end = to + out.size();
  for (std::size_t i = 0; i < count; ++i) {
    const CutRow& row = *rows[i];
    const auto& of = numbers[i];
    if (end - to >= 8)
      write_eight(of.data(), row, to->data());
    else
      for (int t = 0; t < row.count; ++t)
        to[t] = {of[row.slots[t][0]], of[row.slots[t][1]], of[row.slots[t][2]], of[row.slots[t][3]]};
    to += row.count;
  }
}

#define ISOSTRATA_DEFINE(T, NAME)                                                                                  \
  void CountReached##NAME(const T* values, std::size_t count, std::span<const T> thresholds, std::uint8_t* bins) { \
    count_reached<T>(values, count, thresholds, bins);                                                             \
  }
ISOSTRATA_FOR_EACH_SCALAR(ISOSTRATA_DEFINE)
#undef ISOSTRATA_DEFINE

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

#define ISOSTRATA_EXPORT(T, NAME) HWY_EXPORT(CountReached##NAME);
ISOSTRATA_FOR_EACH_SCALAR(ISOSTRATA_EXPORT)

#define ISOSTRATA_CHOOSE(T, NAME)                                                                      \
  template <>                                                                                          \
  CountReached<T> count_reached<T>() {                                                                 \
    return [](const T* values, std::size_t count, std::span<const T> thresholds, std::uint8_t* bins) { \
      HWY_DYNAMIC_DISPATCH(CountReached##NAME)(values, count, thresholds, bins);                       \
    };                                                                                                 \
  }
ISOSTRATA_FOR_EACH_SCALAR(ISOSTRATA_CHOOSE)

HWY_EXPORT(find_all_cases);
void find_cases(const std::array<std::uint8_t, 64>& bins, const std::array<std::array<std::uint8_t, 64>, 4>& corners,
                BlockCases& out) {
  HWY_DYNAMIC_DISPATCH(find_all_cases)(bins, corners, out);
}

HWY_EXPORT(write_all);
void write_rows(const std::array<std::uint32_t, CutRow::kNumbers>* numbers, const CutRow* const* rows, std::size_t count,
                std::span<std::array<std::uint32_t, 4>> out) {
  HWY_DYNAMIC_DISPATCH(write_all)(numbers, rows, count, out);
}

}  // namespace isostrata
#endif  // HWY_ONCE
