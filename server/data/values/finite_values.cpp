#include "data/values/finite_values.h"

#include <cmath>
#include <type_traits>

#include "data/values/for_each_scalar.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "data/values/finite_values.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Two accumulators of each kind, so that the loop waits for memory and not for itself.
template <class T>
FiniteValues measure_finite(const T* values, std::size_t count) {
  constexpr bool kFloating = std::is_floating_point_v<T>;
  constexpr T kMost = kFloating ? std::numeric_limits<T>::infinity() : std::numeric_limits<T>::max();
  constexpr T kLeast = kFloating ? -std::numeric_limits<T>::infinity() : std::numeric_limits<T>::lowest();
  const hn::ScalableTag<T> d;
  const std::size_t lanes = hn::Lanes(d);
  const auto most = hn::Set(d, kMost), least = hn::Set(d, kLeast);
  auto low0 = most, low1 = most, high0 = least, high1 = least;
  std::size_t i = 0, finite = 0;
  for (; i + 2 * lanes <= count; i += 2 * lanes) {
    const auto a = hn::LoadU(d, values + i), b = hn::LoadU(d, values + i + lanes);
    if constexpr (kFloating) {
      const auto a_is = hn::Lt(hn::Abs(a), most), b_is = hn::Lt(hn::Abs(b), most);  // not NaN, for which every comparison is false
      finite += hn::CountTrue(d, a_is) + hn::CountTrue(d, b_is);
      low0 = hn::Min(low0, hn::IfThenElse(a_is, a, most));
      low1 = hn::Min(low1, hn::IfThenElse(b_is, b, most));
      high0 = hn::Max(high0, hn::IfThenElse(a_is, a, least));
      high1 = hn::Max(high1, hn::IfThenElse(b_is, b, least));
    } else {
      low0 = hn::Min(low0, a);
      low1 = hn::Min(low1, b);
      high0 = hn::Max(high0, a);
      high1 = hn::Max(high1, b);
    }
  }
  T lower = kMost, upper = kLeast;
  HWY_ALIGN T lows[hn::MaxLanes(d)], highs[hn::MaxLanes(d)];
  hn::Store(hn::Min(low0, low1), d, lows);
  hn::Store(hn::Max(high0, high1), d, highs);
  for (std::size_t k = 0; k < lanes; ++k) {
    lower = std::min(lower, lows[k]);
    upper = std::max(upper, highs[k]);
  }
  FiniteValues found;
  found.not_finite = kFloating ? static_cast<std::int64_t>(i - finite) : 0;
  bool any = kFloating ? finite > 0 : i > 0;
  for (; i < count; ++i) {
    if constexpr (kFloating)
      if (!std::isfinite(values[i])) {
        ++found.not_finite;
        continue;
      }
    any = true;
    lower = std::min(lower, values[i]);
    upper = std::max(upper, values[i]);
  }
  if (!any) return found;
  found.lower = static_cast<double>(lower) + 0.0;  // of 0 and -0 vectors keep either; with this it is 0
  found.upper = static_cast<double>(upper) + 0.0;
  return found;
}

#define ISOSTRATA_DEFINE(T, NAME) \
  FiniteValues MeasureFinite##NAME(const T* values, std::size_t count) { return measure_finite(values, count); }
ISOSTRATA_FOR_EACH_SCALAR(ISOSTRATA_DEFINE)
#undef ISOSTRATA_DEFINE

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isostrata {

#define ISOSTRATA_EXPORT(T, NAME) HWY_EXPORT(MeasureFinite##NAME);
ISOSTRATA_FOR_EACH_SCALAR(ISOSTRATA_EXPORT)
#undef ISOSTRATA_EXPORT

#define ISOSTRATA_CHOOSE(T, NAME)                                                                                  \
  template <>                                                                                                      \
  MeasureFinite<T> finite_values_of<T>() {                                                                         \
    return [](const T* values, std::size_t count) { return HWY_DYNAMIC_DISPATCH(MeasureFinite##NAME)(values, count); }; \
  }
ISOSTRATA_FOR_EACH_SCALAR(ISOSTRATA_CHOOSE)
#undef ISOSTRATA_CHOOSE

}  // namespace isostrata
#endif  // HWY_ONCE
