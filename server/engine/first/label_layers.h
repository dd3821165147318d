// The layers of a field whose values number things.
#pragma once

#include "data/derived/proxy_grid.h"
#include "data/derived/value_curves.h"
#include "engine/first/layer_choice.h"

namespace isostrata {

/// Each label but the background, with ends midway to those beside it. Its values are taken whole, so a label ends where another one begins. Labels
/// that hide all others are to be looked through. hints: with labels.
LayersChoice label_layers(const ProxyGrid& proxy, const ValueCurves& curves, const FieldHints& hints);

}  // namespace isostrata
