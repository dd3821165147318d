#include "engine/first/choose_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "engine/first/filled_layers.h"
#include "engine/first/image_layers.h"
#include "engine/first/label_layers.h"

namespace isostrata {
namespace {

/// What is known of a field.
struct Field {
  const ProxyGrid& proxy;
  const ValueCurves& curves;
  const FieldHints& hints;
};

/// The layers of a field of one kind, or nothing if it is not of that kind. Those that come later may take for granted that it is of none before.
using Recogniser = std::optional<LayersChoice> (*)(const Field&);

LayersChoice one_wall(FieldKind kind, const char* reason, LayerChoice wall) {
  LayersChoice choice;
  choice.kind = kind;
  choice.reason = reason;
  choice.layers = {std::move(wall)};
  return choice;
}

// ---- labels and sheets ----

std::optional<LayersChoice> labels(const Field& field) {
  if (field.hints.labels.empty() || field.proxy.logarithmic) return std::nullopt;
  return label_layers(field.proxy, field.curves, field.hints);
}

bool is_sheet(const ProxyGrid& proxy) {
  const Vec3d s = proxy.sides();
  std::array<double, 3> sides{s.x, s.y, s.z};
  std::sort(sides.begin(), sides.end());
  return proxy.thickness < 0.035 || sides[0] < 0.12 * sides[1];
}

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

std::optional<LayersChoice> sheet(const Field& field) {
  if (!field.hints.flat && !field.hints.map && !is_sheet(field.proxy)) return std::nullopt;
  LayersChoice choice;
  choice.kind = FieldKind::sheet;
  choice.reason = field.hints.flat ? "the cells are areas" : field.hints.map ? "a map: one axis is in another unit" : "the domain has no depth to look into";
  choice.layers = bands(field.curves);
  return choice;
}

// ---- one wall ----

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

std::optional<LayersChoice> level_set(const Field& field) {
  const double zero = field.proxy.share_at(0);
  if (!(zero > 0.01 && zero < 0.99)) return std::nullopt;
  if (!field.hints.level_set && !(even_slopes(field.proxy) && field.curves.share_of_rim(0, zero) < 0.02)) return std::nullopt;
  return one_wall(FieldKind::level_set,
                  field.hints.level_set ? "a signed distance, by its name" : "a signed distance: its gradient has one length everywhere, and its zero closes inside",
                  {LayerRole::wall, 0, zero, false, "", "the solid whose surface is at zero"});
}

std::optional<LayersChoice> two_values(const Field& field) {
  const double bottom = share_below(field.curves, 0.03), top = field.curves.share_above(0.97);
  if (!(bottom + top > 0.9 && std::min(bottom, top) > 0.003)) return std::nullopt;
  const bool high = top < bottom;
  return one_wall(FieldKind::two_valued, "nine tenths of the values lie at the two ends of the range",
                  {LayerRole::wall, high ? 0.5 : 0, high ? 1 : 0.5, high, "", "the rarer of two values; the wall is midway"});
}

/// The walls of the middle value, in diagonals' cross-sections: a plane across the box has about one.
double walls(const ProxyGrid& proxy, const ValueCurves& curves, double t) {
  return curves.area_at(t) * ValueCurves::kBins * proxy.diagonal();
}

/// How often an isosurface crosses the box, counted in planes across it. Unlike walls() it counts jumps, too.
double planes(const ProxyGrid& proxy, const ValueCurves& curves, double t) {
  return 3 * (1 - curves.coherence(t, true)) * curves.share_above(t) / proxy.neighbour;
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

std::optional<LayersChoice> two_phases(const Field& field) {
  const auto between = valley(field.curves);
  if (!between || !(planes(field.proxy, field.curves, *between) > 2.5)) return std::nullopt;
  const bool high = field.curves.share_above(*between) <= 0.5;
  if (!(lining(field.proxy, high ? *between : 0, high ? 1 : *between) < 0.6)) return std::nullopt;
  return one_wall(FieldKind::two_valued, "two phases: the histogram has two peaks and little between",
                  {LayerRole::wall, high ? *between : 0, high ? 1 : *between, high, "", "the rarer phase; the wall is in the valley between"});
}

std::optional<LayersChoice> waves(const Field& field) {
  const ValueCurves& curves = field.curves;
  const double middle = curves.value_above(0.5), in_the_middle = curves.share_above(0.25) - curves.share_above(0.75);
  if (!(walls(field.proxy, curves, middle) > 5 && planes(field.proxy, curves, middle) > 2 && in_the_middle < 0.65 && curves.share_above(0.75) > 0.1 &&
        share_below(curves, 0.25) > 0.1 && !field.hints.rests_at_zero))
    return std::nullopt;
  return one_wall(FieldKind::waves, "waves: one wall shows more than two ends", {LayerRole::wall, middle, 1, true, "", "the half with the higher values"});
}

// ---- objects in something else ----

std::optional<LayersChoice> ct_numbers(const Field& field) {
  const CtScale ct = ct_scale(field.proxy, field.curves, field.hints);
  if (!ct.found) return std::nullopt;
  const auto t = [&](double hounsfield) { return field.proxy.share_at(hounsfield + ct.zero); };
  LayersChoice choice;
  choice.kind = FieldKind::image;
  choice.anatomy = true;
  choice.reason = "CT numbers: air and soft tissue have the values of Hounsfield's scale";
  choice.layers = {{LayerRole::outer, t(-480), t(170), true, "skin", "from midway between air and tissue"},
                   {LayerRole::inner, t(170), 1, true, "bone", "above 170 Hounsfield units"}};
  return choice;
}

/// What lies around the object has one value, and the object's values lie above it.
bool holds_object(const ValueCurves& curves, const Reference& ref) {
  const double above = ref.to >= 1 ? 0 : curves.share_above(ref.to), below = share_below(curves, ref.from);
  return ref.of_rim > 0.8 && ref.of_all > 0.4 && above > 5 * below;
}

LayersChoice as_object(const ValueCurves& curves, const Reference& ref) {
  LayersChoice choice;
  choice.kind = FieldKind::image;
  choice.reason = "an object in an empty box: " + percent(ref.of_rim) + " of the box's faces and " + percent(ref.of_all) + " of it have one value";
  Shells shells = image_shells(curves, ref);
  calm(curves, true, shells);
  choice.layers = as_layers(shells, true);
  return choice;
}

std::optional<LayersChoice> object_in_box(const Field& field) {
  if (!(field.proxy.fill > 0.95)) return std::nullopt;
  const Reference ref = reference_of(field.curves);
  const bool empty_box = ref.of_rim > 0.5 && ((ref.of_all > 0.4 && ref.bin <= 6) || (ref.of_all > 0.25 && ref.bin <= 2));
  if (empty_box || holds_object(field.curves, ref)) return as_object(field.curves, ref);
  const ValueCurves over = field.curves.mirrored();
  const Reference top = reference_of(over);
  if (!holds_object(over, top)) return std::nullopt;
  LayersChoice choice = as_object(over, top);  // whose values lie below
  for (LayerChoice& layer : choice.layers) layer = {layer.role, 1 - layer.to, 1 - layer.from, false, layer.name, layer.reason};
  return choice;
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

std::optional<LayersChoice> noise(const Field& field) {
  const ValueCurves& curves = field.curves;
  const double middle = curves.value_above(0.5);
  if (!(curves.coherence(middle, true) < 0.6 && curves.coherence(middle, false) < 0.6)) return std::nullopt;
  for (const bool above : {true, false})
    if (const auto shells = shells_in_noise(curves, above)) {
      LayersChoice choice;
      choice.kind = FieldKind::image;
      choice.reason = std::string("an object in noise: its ") + (above ? "high" : "low") + " values hold together, those around it do not";
      choice.layers = as_layers(*shells, above);
      return choice;
    }
  return one_wall(FieldKind::noise, "noise: no range of values holds together",
                  {LayerRole::wall, middle, 1, true, "", "the half with the higher values: its ends would be dust"});
}

std::optional<LayersChoice> filled(const Field& field) { return filled_layers(field.proxy, field.curves, reference_of(field.curves), field.hints); }

constexpr std::array<Recogniser, 10> kInOrder{labels, sheet, level_set, two_values, ct_numbers, object_in_box, two_phases, noise, waves, filled};

// ---- what is left of it ----

/// Layers that are empty, or turned over, by many equal values.
void drop_empty(LayersChoice& choice, const ValueCurves& curves) {
  std::erase_if(choice.layers, [](const LayerChoice& layer) { return !(layer.from < layer.to); });
  if (!choice.layers.empty()) return;
  // Nearly all samples have one value: what is not that value.
  const double common = curves.value_above(0.5);
  const bool high = curves.share_above(std::min(common + 0.02, 1.0)) >= share_below(curves, std::max(common - 0.02, 0.0));
  const double middle = high ? (common + 1) / 2 : common / 2;
  choice.kind = FieldKind::two_valued;
  choice.layers = {{LayerRole::wall, high ? middle : 0, high ? 1 : middle, high, "",
                    "what differs from the value that nearly all places have"}};
}

}  // namespace

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
  for (const Recogniser recognise : kInOrder)
    if (auto recognised = recognise({proxy, curves, hints})) {
      choice = std::move(*recognised);
      break;
    }
  drop_empty(choice, curves);
  return choice;
}

}  // namespace isostrata
