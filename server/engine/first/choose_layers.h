// Which values of a field make a picture of it.
#pragma once

#include "data/derived/proxy_grid.h"
#include "data/derived/value_curves.h"
#include "engine/first/layer_choice.h"

namespace isostrata {

/// Needs a proxy that is not empty. Does not depend on the values' unit: a field times a positive number plus another gives the
/// same layers, except where zero means something (a quantity that begins at zero, CT numbers).
LayersChoice choose_layers(const ProxyGrid& proxy, const ValueCurves& curves, const FieldHints& hints);

/// Thins layers that hold more than about `most` tetrahedra, on a grid of `cells` cells of `each` tetrahedra, to a slab behind
/// their lit surface: the surface hides what lies behind it, or its body is but haze, so that the picture stays. A layer that is
/// cut open at the domain's end would look hollow and stays whole up to kMostSolid tetrahedra.
void thin_layers(LayersChoice& choice, const ProxyGrid& proxy, const ValueCurves& curves, double cells, double each, double most);
inline constexpr double kMostSolid = 2e7;

/// The whole numbers' zero on Hounsfield's scale: what the value -1000 + shift of air is raised by, where these values are CT
/// numbers. Nothing else has a peak at air's, one at soft tissue's and a tail of bone; std::nullopt if the peaks are not
/// there.
struct CtScale {
  bool found = false;
  double zero = 0;  // the value of water
};
CtScale ct_scale(const ProxyGrid& proxy, const ValueCurves& curves, const FieldHints& hints);

}  // namespace isostrata
