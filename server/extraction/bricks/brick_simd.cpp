#include "extraction/bricks/brick_simd.h"

#include <type_traits>

#include "data/values/for_each_scalar.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "extraction/bricks/brick_simd.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class T>
void include_row(const T* row, std::size_t count, T* lowest, T* highest, T* residue) {
  const hn::ScalableTag<T> d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto v = hn::LoadU(d, row + i), low = hn::LoadU(d, lowest + i), high = hn::LoadU(d, highest + i);
    if constexpr (std::is_floating_point_v<T>) {
      hn::StoreU(hn::IfThenElse(hn::Lt(v, low), v, low), d, lowest + i);
      hn::StoreU(hn::IfThenElse(hn::Gt(v, high), v, high), d, highest + i);
      hn::StoreU(hn::Add(hn::LoadU(d, residue + i), hn::Sub(v, v)), d, residue + i);
    } else {
      hn::StoreU(hn::Min(v, low), d, lowest + i);
      hn::StoreU(hn::Max(v, high), d, highest + i);
    }
  }
  for (; i < count; ++i) {
    const T v = row[i];
    if (v < lowest[i]) lowest[i] = v;
    if (v > highest[i]) highest[i] = v;
    if constexpr (std::is_floating_point_v<T>) residue[i] += v - v;
  }
}

template <class T>
void test_rows(const T* values, std::int64_t row_stride, std::int64_t layer_stride, int rows, int layers, T threshold,
               std::uint16_t* bits) {
  const hn::CappedTag<T, 16> d;
  const std::size_t lanes = hn::Lanes(d);
  const auto least = hn::Set(d, threshold);
  for (int k = 0; k < layers; ++k) {
    for (int j = 0; j < rows; ++j) {
      const T* const row = values + k * layer_stride + j * row_stride;
      unsigned own = 0;
      for (std::size_t i = 0; i < 9; i += lanes) {
        std::uint8_t stored[8] = {};  // 2 are written, with room for targets that write whole words
        const auto v = hn::LoadU(d, row + i);
        if constexpr (std::is_floating_point_v<T>)
          hn::StoreMaskBits(d, hn::Ge(v, least), stored);
        else
          hn::StoreMaskBits(d, hn::Not(hn::Lt(v, least)), stored);
        own |= (stored[0] | static_cast<unsigned>(stored[1]) << 8) << i;
      }
      bits[9 * k + j] = static_cast<std::uint16_t>(own);
    }
  }
}

#define ISOSTRATA_DEFINE(T, NAME)                                                                                             \
  void IncludeRow##NAME(const T* row, std::size_t count, T* lowest, T* highest, T* residue) {                                 \
    include_row(row, count, lowest, highest, residue);                                                                        \
  }                                                                                                                           \
  void TestRows##NAME(const T* values, std::int64_t row_stride, std::int64_t layer_stride, int rows, int layers, T threshold, \
                      std::uint16_t* bits) {                                                                                  \
    test_rows(values, row_stride, layer_stride, rows, layers, threshold, bits);                                               \
  }
ISOSTRATA_FOR_EACH_SCALAR(ISOSTRATA_DEFINE)
#undef ISOSTRATA_DEFINE

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#ifndef HWY_DYNAMIC_POINTER  // Highway before 1.1
#define HWY_DYNAMIC_POINTER(NAME) &HWY_DYNAMIC_DISPATCH(NAME)
#endif

namespace isostrata {
namespace {

/// Until this was called the tables hold a function that finds out at every call.
void choose_target() {
  hwy::ChosenTarget& chosen = hwy::GetChosenTarget();
  if (!chosen.IsInitialized()) chosen.Update(hwy::SupportedTargets());
}

}  // namespace

#define ISOSTRATA_EXPORT(T, NAME) \
  HWY_EXPORT(IncludeRow##NAME);   \
  HWY_EXPORT(TestRows##NAME);
ISOSTRATA_FOR_EACH_SCALAR(ISOSTRATA_EXPORT)

#define ISOSTRATA_CHOOSE(T, NAME)                                                            \
  template <>                                                                                \
  BrickSimd<T> brick_simd<T>() {                                                             \
    choose_target();                                                                         \
    return {HWY_DYNAMIC_POINTER(IncludeRow##NAME), HWY_DYNAMIC_POINTER(TestRows##NAME)};     \
  }
ISOSTRATA_FOR_EACH_SCALAR(ISOSTRATA_CHOOSE)

}  // namespace isostrata
#endif  // HWY_ONCE
