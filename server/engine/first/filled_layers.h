// The layers of a field that fills its domain: what stands out at one end of its values, or at both.
#pragma once

#include <optional>
#include <vector>

#include "data/derived/proxy_grid.h"
#include "data/derived/value_curves.h"
#include "engine/first/image_layers.h"
#include "engine/first/layer_choice.h"

namespace isostrata {

/// At the end of the values that is of interest; of both, if neither is more so. A layer that would only line the domain's end is left out.
LayersChoice filled_layers(const ProxyGrid& proxy, const ValueCurves& curves, const Reference& ref, const FieldHints& hints);

/// Two surfaces as an outer and an inner layer. high: they hold what lies above their surfaces.
std::vector<LayerChoice> as_layers(const Shells& shells, bool high);

/// How much of a layer lies at the domain's end, from 0 to 1; 1 of one that is empty.
double lining(const ProxyGrid& proxy, double from, double to);

}  // namespace isostrata
