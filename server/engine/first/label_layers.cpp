#include "engine/first/label_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "engine/first/image_layers.h"

namespace isostrata {
namespace {

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

}  // namespace

LayersChoice label_layers(const ProxyGrid& proxy, const ValueCurves& curves, const FieldHints& hints) {
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
  LayersChoice choice;
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
  return choice;
}

}  // namespace isostrata
