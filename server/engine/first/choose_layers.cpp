#include "engine/first/choose_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "engine/first/image_layers.h"

namespace isostrata {
namespace {

bool is_sheet(const ProxyGrid& proxy) {
  const Vec3d s = proxy.sides();
  std::array<double, 3> sides{s.x, s.y, s.z};
  std::sort(sides.begin(), sides.end());
  return proxy.thickness < 0.035 || sides[0] < 0.12 * sides[1];
}

/// The walls of the middle value, in diagonals' cross-sections: a plane across the box has about one.
double walls(const ProxyGrid& proxy, const ValueCurves& curves, double t) {
  return curves.area_at(t) * ValueCurves::kBins * proxy.diagonal();
}

/// How often an isosurface crosses the box, counted in planes across it. Unlike walls() it counts jumps, too.
double planes(const ProxyGrid& proxy, const ValueCurves& curves, double t) {
  return 3 * (1 - curves.coherence(t, true)) * curves.share_above(t) / proxy.neighbour;
}

// ---- sheets ----

std::vector<LayerChoice> bands(const ValueCurves& curves) {
  const double low = curves.value_above(0.98), high = curves.value_above(0.02);
  std::vector<double> cuts{low + (high - low) * 0.25, low + (high - low) * 0.5, low + (high - low) * 0.75};
  const auto shares = [&] {
    std::vector<double> held;
    double above = 1;
    for (const double cut : cuts) {
      const double next = curves.share_above(cut);
      held.push_back(above - next);
      above = next;
    }
    held.push_back(above);
    return held;
  };
  std::string how = "a quarter of the range that holds 96 % of the values";
  std::vector<double> held = shares();
  if (*std::min_element(held.begin(), held.end()) < 0.02) {
    cuts = {curves.value_above(0.55), curves.value_above(0.25), curves.value_above(0.07)};
    how = "cut where 55, 25 and 7 % of the domain lie above";
  }
  std::vector<LayerChoice> layers;
  double from = 0;
  cuts.push_back(1);
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    if (!(cuts[i] > from)) continue;  // many equal values
    layers.push_back({LayerRole::band, from, cuts[i], true, "", how});
    from = cuts[i];
  }
  if (!layers.empty()) layers.back().to = 1;
  return layers;
}

std::vector<LayerChoice> as_layers(const Shells& shells, bool high) {
  if (high)
    return {{LayerRole::outer, shells.outer, shells.inner, true, "", shells.outer_reason},
            {LayerRole::inner, shells.inner, 1, true, "", shells.inner_reason}};
  return {{LayerRole::outer, shells.inner, shells.outer, false, "", shells.outer_reason},
          {LayerRole::inner, 0, shells.inner, false, "", shells.inner_reason}};
}

// ---- fields ----

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

/// How much of a layer lies at the domain's end.
double lining(const ProxyGrid& proxy, double from, double to) {
  std::int64_t inside = 0, at_end = 0;
  for (std::size_t s = 0; s < proxy.size(); ++s)
    if (const float t = proxy.values[s]; t >= from && t <= to) ++inside, at_end += proxy.rim[s];
  return inside ? static_cast<double>(at_end) / static_cast<double>(inside) : 1;
}

/// Whether the gradient has one length nearly everywhere, as a distance's has.
bool even_slopes(const ProxyGrid& proxy) {
  std::vector<float> slopes;
  for (std::size_t s = 0; s < proxy.size(); ++s)
    if (!std::isnan(proxy.values[s])) slopes.push_back(proxy.slopes[s]);
  if (slopes.size() < 100) return false;
  const auto middle = slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 2);
  std::nth_element(slopes.begin(), middle, slopes.end());
  const float median = *middle;
  const auto near = std::count_if(slopes.begin(), slopes.end(), [&](float s) { return std::abs(s - median) < 0.1f * median; });
  return near > static_cast<std::ptrdiff_t>(slopes.size() * 85 / 100);
}

/// The valley between the histogram's two peaks, where there are two phases: each a tenth or more, and few values between.
std::optional<double> valley(const ValueCurves& curves) {
  const ValueCurves::Curve h = smoothed(smoothed(curves.histogram()));
  const std::vector<int> found = peaks(h, 0.1 * *std::max_element(h.begin(), h.end()));
  if (found.size() != 2) return std::nullopt;
  const auto lowest = std::min_element(h.begin() + found[0], h.begin() + found[1]);
  if (*lowest > 0.4 * std::min(h[static_cast<std::size_t>(found[0])], h[static_cast<std::size_t>(found[1])])) return std::nullopt;
  const int first = static_cast<int>(lowest - h.begin());  // of a plain as wide as it may be the middle
  int last = first;
  while (last + 1 < found[1] && h[static_cast<std::size_t>(last + 1)] <= *lowest * 1.05 + 1e-6) ++last;
  const double t = ValueCurves::middle((first + last) / 2), above = curves.share_above(t);
  if (above < 0.1 || above > 0.9 || curves.coherence(t, true) < 0.7 || curves.coherence(t, false) < 0.7) return std::nullopt;
  return t;
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

/// An object in noise: somewhere towards an end the values hold together, though half of all do not.
std::optional<Shells> shells_in_noise(const ValueCurves& curves, bool high) {
  constexpr double kHolds = 0.72;
  const auto value = [&](double share) { return curves.value_above(high ? share : 1 - share); };
  for (double share = 0.4; share > 0.004; share *= 0.85) {
    const double t = value(share);
    if (curves.coherence(t, high) < kHolds) continue;
    Shells shells{t, value(0.4 * share), "where the values begin to hold together", "the part of that which stands out most"};
    calm(curves, high, shells);
    return shells;
  }
  return std::nullopt;
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

void cut_field(const ProxyGrid& proxy, const ValueCurves& curves, Side side, LayersChoice& choice) {
  if (side == Side::both) {
    const double low = steepest_near(curves, 0.08, 2, false), high = steepest_near(curves, 0.08, 2, true);
    if (low < high) {
      const std::string at = "of the domain, where the field is steepest";
      choice.layers = {{LayerRole::low, 0, low, false, "", "the lowest " + percent(share_below(curves, low)) + " " + at},
                       {LayerRole::high, high, 1, true, "", "the highest " + percent(curves.share_above(high)) + " " + at}};
      if (!(proxy.thickness > 0.04)) return;
      const double lines_low = lining(proxy, 0, low), lines_high = lining(proxy, high, 1);
      if (std::max(lines_low, lines_high) <= 0.8 || std::min(lines_low, lines_high) > 0.8) return;
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
  calm(curves, high, shells);
  leave_plateau(curves, high, shells);
  choice.layers = as_layers(shells, high);
  if (!(proxy.thickness > 0.04)) return;
  // An inner layer that only lines the domain's end is that of the wall: what there is of it inside, if anything, is less.
  const auto value = [&](double share) { return curves.value_above(high ? share : 1 - share); };
  const auto lines = [&](double t) { return high ? lining(proxy, t, 1) : lining(proxy, 0, t); };
  if (lines(shells.inner) <= 0.6) return;
  for (double share = 0.02; share > 0.002; share *= 0.7) {
    if (lines(value(share)) > 0.35 || curves.coherence(value(share), high) < 0.6) continue;
    shells.inner = value(share);
    shells.outer = value(std::min(0.15, 5 * share));
    shells.inner_reason = end + percent(share) + " of the domain: more would line the domain's end";
    shells.outer_reason = end + percent(std::min(0.15, 5 * share)) + " of the domain";
    choice.layers = as_layers(shells, high);
    return;
  }
}

// ---- labels ----

constexpr std::size_t kMostLabelLayers = 8;

/// The label that one sees of all from outside, if there is one: the first on nearly every line into the box, from all sides. Null: more are seen, or one
/// is all there is.
LayerChoice* hull_of(std::vector<LayerChoice>& layers, const ProxyGrid& proxy) {
  constexpr double kNearlyAll = 0.9;
  std::vector<std::int64_t> first_on(layers.size());
  std::int64_t lines = 0;
  const std::array<std::size_t, 3> dims{static_cast<std::size_t>(proxy.dims[0]), static_cast<std::size_t>(proxy.dims[1]), static_cast<std::size_t>(proxy.dims[2])},
      jump{1, dims[0], dims[0] * dims[1]};
  const auto layer_at = [&](std::size_t sample) {
    const float t = proxy.values[sample];
    return std::find_if(layers.begin(), layers.end(), [&](const LayerChoice& layer) { return layer.role == LayerRole::label && t >= layer.from && (t < layer.to || layer.to >= 1); });
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (std::size_t line = 0; line < dims[u] * dims[v]; ++line)
      for (const bool forward : {true, false})
        for (std::size_t i = 0; i < dims[axis]; ++i) {
          const std::size_t along = forward ? i : dims[axis] - 1 - i;
          const auto met = layer_at(line % dims[u] * jump[u] + line / dims[u] * jump[v] + along * jump[axis]);
          if (met == layers.end()) continue;
          ++first_on[static_cast<std::size_t>(met - layers.begin())];
          ++lines;
          break;
        }
  }
  const auto most = std::max_element(first_on.begin(), first_on.end());
  const auto labels = std::count_if(layers.begin(), layers.end(), [](const LayerChoice& layer) { return layer.role == LayerRole::label; });
  if (labels < 2 || static_cast<double>(*most) < kNearlyAll * static_cast<double>(lines)) return nullptr;
  return &layers[static_cast<std::size_t>(most - first_on.begin())];
}

/// Each label but the background, with ends midway to those beside it. Its values are taken whole, so a label ends where another one begins.
void cut_labels(const ValueCurves& curves, const ProxyGrid& proxy, const FieldHints& hints, LayersChoice& choice) {
  struct Label {
    LayerChoice layer;
    double share = 0, of_rim = 0;
  };
  const double volume = static_cast<double>(proxy.count) * proxy.step.x * proxy.step.y * proxy.step.z;
  std::vector<Label> labels;
  double from = 0;
  for (std::size_t i = 0; i < hints.labels.size(); ++i) {
    const bool last = i + 1 == hints.labels.size();
    const double value = hints.labels[i];
    const double to = last ? 1 : std::clamp(proxy.share_at(std::floor((value + hints.labels[i + 1]) / 2) + 0.5), from, 1.0);
    std::array<char, 40> name{};
    std::snprintf(name.data(), name.size(), "label %.0f", value);
    const double share = curves.share_above(from) - (last ? 0 : curves.share_above(to));
    labels.push_back({{LayerRole::label, from, to, true, name.data(), percent(share) + " of the domain", 0.5 * std::cbrt(share * volume) / proxy.diagonal()},
                      share, curves.share_of_rim(from, to)});
    from = to;
  }
  const auto background = std::max_element(labels.begin(), labels.end(), [](const Label& a, const Label& b) { return a.of_rim < b.of_rim; });
  choice.kind = FieldKind::labels;
  choice.reason = std::to_string(labels.size()) + " whole numbers, and neighbours have the same one: they number things";
  if (background->of_rim > 0.5) {
    choice.reason += "; " + background->layer.name + " is left out, the background";
    labels.erase(background);
  }
  std::vector<double> shares;
  for (const Label& label : labels) shares.push_back(label.share);
  std::sort(shares.rbegin(), shares.rend());
  const double least = shares.size() > kMostLabelLayers ? shares[kMostLabelLayers - 1] : 0;
  std::size_t taken = 0;
  for (const Label& label : labels)
    if (label.share >= least && taken < kMostLabelLayers) choice.layers.push_back(label.layer), ++taken;
  constexpr int kMostHulls = 2;  // a third would be fog
  for (int i = 0; i < kMostHulls && !hints.flat; ++i)
    if (LayerChoice* const hull = hull_of(choice.layers, proxy)) {
      hull->role = LayerRole::outer;
      hull->reason += "; it is looked through, for the others lie inside";
    }
  if (labels.size() > taken) choice.reason += "; the " + std::to_string(taken) + " largest of " + std::to_string(labels.size()) + " are shown";
}

// ---- CT ----

const LayerChoice* find(const LayersChoice& choice, LayerRole role) {
  for (const LayerChoice& layer : choice.layers)
    if (layer.role == role) return &layer;
  return nullptr;
}

/// Layers that are empty, or turned over, by many equal values.
void drop_empty(LayersChoice& choice, const ValueCurves& curves) {
  std::erase_if(choice.layers, [](const LayerChoice& layer) { return !(layer.from < layer.to); });
  if (!choice.layers.empty() || find(choice, LayerRole::wall)) return;
  // Nearly all samples have one value: what is not that value.
  const double common = curves.value_above(0.5);
  const bool high = curves.share_above(std::min(common + 0.02, 1.0)) >= share_below(curves, std::max(common - 0.02, 0.0));
  const double middle = high ? (common + 1) / 2 : common / 2;
  choice.kind = FieldKind::two_valued;
  choice.layers = {{LayerRole::wall, high ? middle : 0, high ? 1 : middle, high, "",
                    "what differs from the value that nearly all places have"}};
}

}  // namespace

const char* to_string(FieldKind kind) {
  switch (kind) {
    case FieldKind::labels:
      return "labels";
    case FieldKind::image:
      return "image";
    case FieldKind::two_valued:
      return "two-valued";
    case FieldKind::waves:
      return "waves";
    case FieldKind::level_set:
      return "level set";
    case FieldKind::noise:
      return "noise";
    case FieldKind::sheet:
      return "sheet";
    case FieldKind::field:
      break;
  }
  return "field";
}

CtScale ct_scale(const ProxyGrid& proxy, const ValueCurves& curves, const FieldHints& hints) {
  if (!hints.whole_numbers || proxy.logarithmic || proxy.upper - proxy.lower < 1500 || proxy.upper - proxy.lower > 70000)
    return {};
  const auto share = [&](double from, double to) {
    const auto t = [&](double v) { return proxy.share_at(v); };
    return (t(from) <= 0   ? 1
            : t(from) >= 1 ? 0
                           : curves.share_above(t(from))) -
           (t(to) <= 0   ? 1
            : t(to) >= 1 ? 0
                         : curves.share_above(t(to)));
  };
  for (const double zero : {0.0, 1024.0, 1000.0}) {
    const double least = zero == 0 ? -4000 : -100;
    if (proxy.lower < least || (zero == 0 && proxy.lower > -500)) continue;
    const double air = share(zero - 4000, zero - 750), soft = share(zero - 200, zero + 150),
                 between = share(zero - 750, zero - 300), bone = share(zero + 150, zero + 4000);
    if (air > 0.1 && soft > 0.04 && between < 0.6 * soft && between < air && bone > 0.0005 && bone < soft) return {true, zero};
  }
  return {};
}

void thin_layers(LayersChoice& choice, const ProxyGrid& proxy, const ValueCurves& curves, double cells, double each,
                 double most) {
  if (choice.kind == FieldKind::sheet || choice.kind == FieldKind::labels || !(cells > 0)) return;
  const double volume = static_cast<double>(proxy.count) * proxy.step.x * proxy.step.y * proxy.step.z,
               cell = std::cbrt(volume / cells);
  for (LayerChoice& layer : choice.layers) {
    const double above_from = curves.share_above(layer.from), above_to = layer.to >= 1 ? 0 : curves.share_above(layer.to);
    const double tetrahedra = (above_from - above_to) * cells * each;
    const bool capped = layer.role != LayerRole::outer && lining(proxy, layer.from, layer.to) > 0.02;
    if (tetrahedra <= (capped ? kMostSolid : most)) continue;
    const double share = most / (cells * each), surface = layer.rises_inward ? layer.from : layer.to;
    const double least = 0.75 * cell * curves.strength_at(surface);  // a cell's depth, about
    if (layer.rises_inward)
      layer.to = std::min(layer.to, std::max(curves.value_above(above_from - share), layer.from + least));
    else
      layer.from = std::max(layer.from, std::min(curves.value_above(above_to + share), layer.to - least));
    layer.reason += "; thin, since what lies behind its surface would not be seen";
  }
}

LayersChoice choose_layers(const ProxyGrid& proxy, const ValueCurves& curves, const FieldHints& hints) {
  LayersChoice choice;
  if (!hints.labels.empty() && !proxy.logarithmic) {
    cut_labels(curves, proxy, hints, choice);
    drop_empty(choice, curves);
    return choice;
  }
  if (hints.flat || is_sheet(proxy)) {
    choice.kind = FieldKind::sheet;
    choice.reason = hints.flat ? "the cells are areas" : "the domain has no depth to look into";
    choice.layers = bands(curves);
    drop_empty(choice, curves);
    return choice;
  }
  const double zero = proxy.share_at(0);
  if (zero > 0.01 && zero < 0.99 && (hints.level_set || (even_slopes(proxy) && curves.share_of_rim(0, zero) < 0.02))) {
    choice.kind = FieldKind::level_set;
    choice.reason = hints.level_set ? "a signed distance, by its name"
                                    : "a signed distance: its gradient has one length everywhere, and its zero closes inside";
    choice.layers = {{LayerRole::wall, 0, zero, false, "", "the solid whose surface is at zero"}};
    return choice;
  }
  const double bottom = share_below(curves, 0.03), top = curves.share_above(0.97);
  if (bottom + top > 0.9 && std::min(bottom, top) > 0.003) {
    choice.kind = FieldKind::two_valued;
    choice.reason = "nine tenths of the values lie at the two ends of the range";
    const bool high = top < bottom;
    choice.layers = {{LayerRole::wall, high ? 0.5 : 0, high ? 1 : 0.5, high, "", "the rarer of two values; the wall is midway"}};
    return choice;
  }
  if (const CtScale ct = ct_scale(proxy, curves, hints); ct.found) {
    const auto t = [&](double hounsfield) { return proxy.share_at(hounsfield + ct.zero); };
    choice.kind = FieldKind::image;
    choice.anatomy = true;
    choice.reason = "CT numbers: air and soft tissue are where Hounsfield's scale has them";
    choice.layers = {{LayerRole::outer, t(-480), t(170), true, "skin", "from midway between air and tissue"},
                     {LayerRole::inner, t(170), 1, true, "bone", "above 170 Hounsfield units"}};
    return choice;
  }
  const Reference ref = reference_of(curves);
  const bool box = proxy.fill > 0.95;
  const bool empty_box = ref.of_rim > 0.5 && ((ref.of_all > 0.4 && ref.bin <= 6) || (ref.of_all > 0.25 && ref.bin <= 2));
  const double above = ref.to >= 1 ? 0 : curves.share_above(ref.to), below = share_below(curves, ref.from);
  const bool one_sided = ref.of_rim > 0.8 && ref.of_all > 0.4 && above > 5 * below;
  if (box && (empty_box || one_sided)) {
    choice.kind = FieldKind::image;
    choice.reason = "an object in an empty box: " + percent(ref.of_rim) + " of the box's faces and " + percent(ref.of_all) +
                    " of it have one value";
    Shells shells = image_shells(curves, ref);
    calm(curves, true, shells);
    choice.layers = as_layers(shells, true);
    drop_empty(choice, curves);
    return choice;
  }
  choice.reason = "a field that fills its domain";
  const double middle = curves.value_above(0.5);
  const auto between = valley(curves);
  const bool high = between && curves.share_above(*between) <= 0.5;
  const double lines = between ? lining(proxy, high ? *between : 0, high ? 1 : *between) : 1;
  if (between && planes(proxy, curves, *between) > 2.5 && lines < 0.6) {
    choice.kind = FieldKind::two_valued;
    choice.reason = "two phases: the histogram has two peaks and little between";
    choice.layers = {{LayerRole::wall, high ? *between : 0, high ? 1 : *between, high, "",
                      "the rarer phase; the wall is in the valley between"}};
    return choice;
  }
  const Side side = side_of(proxy, curves, ref, hints);
  const double in_the_middle = curves.share_above(0.25) - curves.share_above(0.75);
  if (curves.coherence(middle, true) < 0.6 && curves.coherence(middle, false) < 0.6) {
    for (const bool above : {true, false})
      if (const auto shells = shells_in_noise(curves, above)) {
        choice.kind = FieldKind::image;
        choice.reason = std::string("an object in noise: its ") + (above ? "high" : "low") + " values hold together, those around it do not";
        choice.layers = as_layers(*shells, above);
        drop_empty(choice, curves);
        return choice;
      }
    choice.kind = FieldKind::noise;
    choice.reason = "noise: no range of values holds together";
    choice.layers = {{LayerRole::wall, middle, 1, true, "", "the half with the higher values: its ends would be dust"}};
    drop_empty(choice, curves);
    return choice;
  }
  if (walls(proxy, curves, middle) > 5 && planes(proxy, curves, middle) > 2 && in_the_middle < 0.65 &&
      curves.share_above(0.75) > 0.1 && share_below(curves, 0.25) > 0.1 && !hints.rests_at_zero) {
    choice.kind = FieldKind::waves;
    choice.reason = "waves: one wall shows more than two ends";
    choice.layers = {{LayerRole::wall, middle, 1, true, "", "the half with the higher values"}};
    return choice;
  }
  cut_field(proxy, curves, side, choice);
  drop_empty(choice, curves);
  return choice;
}

}  // namespace isostrata
