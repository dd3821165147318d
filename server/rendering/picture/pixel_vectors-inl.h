// What kernels over pixels share; included by their files once per target.
#if defined(ISOSTRATA_PIXEL_VECTORS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOSTRATA_PIXEL_VECTORS_INL
#undef ISOSTRATA_PIXEL_VECTORS_INL
#else
#define ISOSTRATA_PIXEL_VECTORS_INL
#endif

#include <hwy/highway.h>

#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace isostrata::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// visit(d, i) for whole vectors, then for the last few one at a time.
template <class Visit>
HWY_INLINE void for_vectors(std::size_t count, const Visit& visit) {
  const hn::ScalableTag<float> d;
  const hn::CappedTag<float, 1> single;
  std::size_t i = 0;
  for (; i + hn::Lanes(d) <= count; i += hn::Lanes(d)) visit(d, i);
  for (; i < count; ++i) visit(single, i);
}

/// Where in a segment of this optical depth, and opacity (through is the rest), the light that leaves it comes from on average, as a share of its length:
/// 1 / depth - through / opacity, which is a half if it is thin.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V middle_of_light(D d, V depth, V through, V opacity) {
  const V thin = hn::NegMulAdd(depth, hn::Set(d, 1.0f / 12), hn::Set(d, 0.5f));
  const V thick = hn::Sub(hn::Div(hn::Set(d, 1.0f), depth), hn::Div(through, opacity));
  return hn::IfThenElse(hn::Gt(depth, hn::Set(d, 0.05f)), thick, thin);
}

}  // namespace isostrata::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
