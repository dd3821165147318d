#include "engine/first/filled_layers.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace isostrata {
namespace {

/// Moved to the steepest place among those that hold a like share, at most `factor` times or a `factor`-th of it.
double steepest_near(const ValueCurves& curves, double share, double factor, bool high) {
  const auto value = [&](double s) { return curves.value_above(high ? s : 1 - s); };
  const double a = value(std::min(0.98, share * factor)), b = value(share / factor);
  double best = -1, at = value(share);
  for (int bin = 0; bin < ValueCurves::kBins; ++bin) {
    const double t = ValueCurves::middle(bin);
    if (t < std::min(a, b) || t > std::max(a, b)) continue;
    if (curves.strength()[static_cast<std::size_t>(bin)] > best) best = curves.strength()[static_cast<std::size_t>(bin)], at = t;
  }
  return at;
}

/// Moved towards the layer's inside, off a value that many places have: a surface there would follow its last digit.
double off_plateau(const ValueCurves& curves, double t, bool high) {
  constexpr double kMany = 0.15;  // of the domain, in three bins
  const ValueCurves::Curve& h = curves.histogram();
  const int bin = ValueCurves::bin_of(t), first = std::max(bin - 1, 0), last = std::min(bin + 1, ValueCurves::kBins - 1);
  double held = 0, most = 0;
  for (int b = first; b <= last; ++b) held += h[static_cast<std::size_t>(b)], most = std::max(most, h[static_cast<std::size_t>(b)]);
  if (held < kMany) return t;
  for (int b = bin; b >= 0 && b < ValueCurves::kBins; b += high ? 1 : -1)
    if (std::abs(b - bin) > 1 && h[static_cast<std::size_t>(b)] < 0.1 * most) return ValueCurves::middle(b);
  return t;
}

void leave_plateau(const ValueCurves& curves, bool high, Shells& shells) {
  const double outer = off_plateau(curves, shells.outer, high);
  if (outer == shells.outer) return;
  const double share = high ? curves.share_above(outer) : share_below(curves, outer);
  if (share < 0.002) return;  // there is no inside
  shells.outer = outer;
  shells.outer_reason += ", less the value that most places have";
  const double inner = high ? std::max(shells.inner, curves.value_above(0.3 * share)) : std::min(shells.inner, curves.value_above(1 - 0.3 * share));
  if (inner == shells.inner) return;
  shells.inner = inner;
  shells.inner_reason = "the part of that which is farthest from it";
}

enum class Side { high, low, both };

Side side_of(const ProxyGrid& proxy, const ValueCurves& curves, const Reference& ref, const FieldHints& hints) {
  if (hints.missing_below || hints.missing_above) return hints.missing_below ? Side::high : Side::low;
  // Of a speed the high end, for zero is rest; but in a stream that flows past something its lee.
  if (hints.rests_at_zero) return ref.value > 0.6 && ref.of_all > 0.4 ? Side::low : Side::high;
  const double high = (curves.value_above(0.005) - ref.value) * curves.strength_at(curves.value_above(0.04));
  const double low = (ref.value - curves.value_above(0.995)) * curves.strength_at(curves.value_above(0.96));
  if (high > 2.5 * low) return Side::high;
  if (low > 2.5 * high) return Side::low;
  if (proxy.lower >= 0 && proxy.lower < 0.02 * proxy.upper) return Side::high;  // a quantity whose zero is nothing
  return Side::both;
}

}  // namespace

std::vector<LayerChoice> as_layers(const Shells& shells, bool high) {
  if (high)
    return {{LayerRole::outer, shells.outer, shells.inner, true, "", shells.outer_reason},
            {LayerRole::inner, shells.inner, 1, true, "", shells.inner_reason}};
  return {{LayerRole::outer, shells.inner, shells.outer, false, "", shells.outer_reason},
          {LayerRole::inner, 0, shells.inner, false, "", shells.inner_reason}};
}

double lining(const ProxyGrid& proxy, double from, double to) {
  std::int64_t inside = 0, at_end = 0;
  for (std::size_t s = 0; s < proxy.size(); ++s)
    if (const float t = proxy.values[s]; t >= from && t <= to) ++inside, at_end += proxy.rim[s];
  return inside ? static_cast<double>(at_end) / static_cast<double>(inside) : 1;
}

constexpr double kDust = 0.01;  // of the range

LayersChoice filled_layers(const ProxyGrid& proxy, const ValueCurves& curves, const Reference& ref, const FieldHints& hints) {
  LayersChoice choice;
  choice.reason = "a field that fills its domain";
  Side side = side_of(proxy, curves, ref, hints);
  if (side == Side::both) {
    const double low = steepest_near(curves, 0.08, 2, false), high = steepest_near(curves, 0.08, 2, true);
    if (low < high) {
      const std::string at = "of the domain, where the field is steepest";
      choice.layers = {{LayerRole::low, 0, low, false, "", "the lowest " + percent(share_below(curves, low)) + " " + at},
                       {LayerRole::high, high, 1, true, "", "the highest " + percent(curves.share_above(high)) + " " + at}};
      if (!(proxy.thickness > 0.04)) return choice;
      const double lines_low = lining(proxy, 0, low), lines_high = lining(proxy, high, 1);
      if (std::max(lines_low, lines_high) <= 0.8 || std::min(lines_low, lines_high) > 0.8) return choice;
      side = lines_low > 0.8 ? Side::high : Side::low;  // a layer that only lines the domain's end hides the rest
      choice.reason += "; the other end's layer would only line the domain's end";
    } else {
      side = Side::high;
    }
  }
  const bool high = side == Side::high;
  Shells shells{curves.value_above(high ? 0.15 : 0.85), curves.value_above(high ? 0.03 : 0.97), "", ""};
  const std::string end = high ? "the highest " : "the lowest ";
  shells.outer_reason = end + "15 % of the domain";
  shells.inner_reason = end + "3 % of the domain";
  const Shells before = shells;
  calm(curves, high, shells);
  if ((high ? 1 - shells.outer : shells.outer) < kDust) shells = before;  // no part holds together
  leave_plateau(curves, high, shells);
  choice.layers = as_layers(shells, high);
  if (!(proxy.thickness > 0.04)) return choice;
  // An inner layer that only lines the domain's end is that of the wall: what there is of it inside, if anything, is less.
  const auto value = [&](double share) { return curves.value_above(high ? share : 1 - share); };
  const auto lines = [&](double t) { return high ? lining(proxy, t, 1) : lining(proxy, 0, t); };
  if (lines(shells.inner) <= 0.6) return choice;
  for (double share = 0.02; share > 0.002; share *= 0.7) {
    if (lines(value(share)) > 0.35 || curves.coherence(value(share), high) < 0.6) continue;
    shells.inner = value(share);
    shells.outer = value(std::min(0.15, 5 * share));
    shells.inner_reason = end + percent(share) + " of the domain: more would line the domain's end";
    shells.outer_reason = end + percent(std::min(0.15, 5 * share)) + " of the domain";
    choice.layers = as_layers(shells, high);
    return choice;
  }
  return choice;
}

}  // namespace isostrata
