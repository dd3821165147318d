#include "engine/first/image_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

namespace isostrata {
namespace {

constexpr int kRimBins = 64;

/// Where the main peak of the values above t goes over into its tail (G. Zack, W. Rogers, S. Latt, "Automatic measurement of
/// sister chromatid exchange frequency", 1977).
std::optional<double> triangle(const ValueCurves& curves, double t) {
  const ValueCurves::Curve h = smoothed(curves.histogram());
  const int first = std::max(static_cast<int>(std::ceil(t * ValueCurves::kBins - 0.5)), 0), n = ValueCurves::kBins - first;
  if (n < 8) return std::nullopt;
  const auto y = [&](int i) { return h[static_cast<std::size_t>(first + i)]; };
  int peak = 0;
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += y(i);
  for (int i = 0; i < n - 3; ++i)
    if (y(i) > y(peak)) peak = i;
  int end = 0;
  for (double part = y(0); end < n - 1 && part < 0.998 * sum;) part += y(++end);
  if (end - peak < 6 || !(y(peak) > 0)) return std::nullopt;
  int best = peak;
  double farthest = -1;
  for (int i = peak; i <= end; ++i) {
    const double x = static_cast<double>(i - peak) / (end - peak), under = 1 - x - y(i) / y(peak) + y(end) / y(peak) * x;
    if (under > farthest) farthest = under, best = i;
  }
  return ValueCurves::middle(first + best);
}

/// The first valley of the histogram above t.
std::optional<double> first_gap(const ValueCurves& curves, double t) {
  const ValueCurves::Curve h = smoothed(curves.histogram());
  int lowest = ValueCurves::bin_of(t);
  for (int b = lowest; b < ValueCurves::kBins; ++b) {
    const double here = h[static_cast<std::size_t>(b)], least = h[static_cast<std::size_t>(lowest)];
    if (here < least) lowest = b;
    if (here > 1.3 * least && here > 0.001) return ValueCurves::middle(lowest);
  }
  return std::nullopt;
}

}  // namespace

std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, share < 0.0095 ? "%.1f %%" : "%.0f %%", 100 * share);
  return text;
}

Reference reference_of(const ValueCurves& curves) {
  std::array<int, kRimBins> count{};
  for (const float t : curves.rim())
    ++count[static_cast<std::size_t>(std::clamp(static_cast<int>(t * kRimBins), 0, kRimBins - 1))];
  Reference ref;
  ref.bin = static_cast<int>(std::max_element(count.begin(), count.end()) - count.begin());
  ref.from = static_cast<double>(std::max(ref.bin - 2, 0)) / kRimBins;
  ref.to = static_cast<double>(std::min(ref.bin + 3, kRimBins)) / kRimBins;
  ref.of_rim = curves.share_of_rim(ref.from, ref.to);
  ref.of_all = curves.share_above(ref.from) - (ref.to >= 1 ? 0 : curves.share_above(ref.to));
  std::vector<float> inside;
  for (const float t : curves.rim())
    if (t >= ref.from && t <= ref.to) inside.push_back(t);
  ref.value = inside.empty() ? curves.rim_value(0.5) : inside[inside.size() / 2];
  return ref;
}

Shells image_shells(const ValueCurves& curves, const Reference& ref) {
  Shells shells;
  // What the background's own values reach up to.
  const double near = ref.value + 0.15;
  double end = ref.value;
  if (const double share = curves.share_of_rim(0, near); share > 0) end = curves.rim_value(0.998 * share);
  const double ground = std::max(ref.value + 0.02, end);
  const double object = curves.share_above(ground);
  ValueCurves::Curve strength{}, faces{};
  double most_area = 0;
  for (int b = ValueCurves::bin_of(ground); b < ValueCurves::kBins; ++b)
    most_area = std::max(most_area, curves.area()[static_cast<std::size_t>(b)]);
  for (std::size_t b = 0; b < ValueCurves::kBins; ++b)
    if (ValueCurves::middle(static_cast<int>(b)) > ground && curves.area()[b] > 0.02 * most_area) {
      strength[b] = curves.strength()[b];
      faces[b] = strength[b] * curves.area()[b];
    }
  const double strongest = *std::max_element(strength.begin(), strength.end());
  std::vector<int> found = peaks(strength, 0.06 * strongest);
  std::erase_if(found, [&](int b) { return ValueCurves::middle(b) <= ground + 0.02; });

  const double half = curves.value_above(0.5 * object);
  if (!found.empty() && curves.share_above(ValueCurves::middle(found.front())) >= 0.28 * object) {
    int b = found.front();
    while (b > 0 && ValueCurves::middle(b - 1) > ground &&
           strength[static_cast<std::size_t>(b - 1)] > 0.7 * strength[static_cast<std::size_t>(found.front())])
      --b;
    shells.outer = ValueCurves::middle(b);
    shells.outer_reason = "the first boundary beside the background";
  } else if (const auto gap = first_gap(curves, ground); gap && curves.share_above(*gap) >= 0.28 * object) {
    shells.outer = *gap;
    shells.outer_reason = "where the background's values end and the object's begin";
  } else {
    shells.outer = half;
    shells.outer_reason = "half of what stands out from the background";
  }
  const double held = curves.share_above(shells.outer);
  const double fifth = curves.value_above(0.18 * held);
  const std::optional<double> tail = triangle(curves, shells.outer);
  const double in_tail = tail ? curves.share_above(*tail) : 0;
  if (tail && *tail > shells.outer && in_tail >= 0.03 * held && in_tail <= 0.5 * held && curves.coherence(*tail, true) >= 0.65) {
    shells.inner = *tail;
    shells.inner_reason = "where the object's commonest values end";
  } else {
    shells.inner = fifth;
    shells.inner_reason = "the fifth of the object that is farthest from the background";
    double grown = 0.18;
    while (grown < 0.5 && curves.coherence(curves.value_above(grown * held), true) < 0.65) grown *= 1.2;
    if (grown > 0.18 && grown < 0.5) {
      shells.inner = curves.value_above(grown * held);
      shells.inner_reason = "the " + percent(grown) + " of the object that are farthest from the background: what is farther is noise";
    } else if (grown >= 0.5) {
      double best = 0;
      for (const int b : found) {
        const double t = ValueCurves::middle(b), inside = curves.share_above(t);
        if (t <= std::max(tail.value_or(0), fifth) || inside < 0.008 * held || inside > 0.5 * held ||
            curves.coherence(t, true) < 0.65)
          continue;
        if (faces[static_cast<std::size_t>(b)] > best) {
          best = faces[static_cast<std::size_t>(b)];
          shells.inner = t;
          shells.inner_reason = "the strongest boundary inside";
        }
      }
    }
  }
  if (shells.inner > 1 - 0.05 * (1 - shells.outer)) {
    shells.inner = (shells.outer + 1) / 2;
    shells.inner_reason = "midway to the farthest value";
  }
  return shells;
}

void calm(const ValueCurves& curves, bool high, Shells& shells) {
  const auto value = [&](double share) { return high ? curves.value_above(share) : curves.value_above(1 - share); };
  const auto share = [&](double t) { return high ? curves.share_above(t) : share_below(curves, t); };
  const auto coherence = [&](double s) { return curves.coherence(value(s), high); };
  double outer = share(shells.outer), inner = share(shells.inner);
  const double outer_before = outer, inner_before = inner;
  for (int i = 0; i < 5 && outer >= 0.02 && coherence(outer) < 0.70; ++i) outer *= 0.6;
  if (outer < outer_before) inner = std::min(inner, 0.4 * outer);
  for (int i = 0; i < 3 && inner <= 0.45 * outer && coherence(inner) < 0.65; ++i) inner *= 1.6;
  inner = std::min(inner, 0.6 * outer);
  if (outer != outer_before) shells.outer = value(outer), shells.outer_reason += ", less where it is noise";
  if (inner != inner_before) shells.inner = value(inner), shells.inner_reason += ", moved to where it holds together";
}

}  // namespace isostrata
