// Which values of a field make a picture of it.
#pragma once

#include <string>
#include <vector>

#include "data/proxy_grid.h"
#include "data/value_curves.h"

namespace isostrata {

/// What sort of field it is: that decides how it is cut.
enum class FieldKind {
  labels,      // numbers of things: each is a layer
  image,       // an object in an empty box: a scan, a plume in still air
  two_valued,  // two values, or two phases, and little between: one wall
  waves,       // walls wherever one looks: one wall, at the middle value
  level_set,   // a signed distance: the wall at zero
  noise,       // nothing holds together
  sheet,       // a domain without depth: opaque bands
  field        // the rest
};
const char* to_string(FieldKind kind);

enum class LayerRole { outer, inner, low, high, wall, band, outline, label };

/// Of the proxy's values; 0 and 1 are the ends of what there is.
struct LayerChoice {
  LayerRole role = LayerRole::outer;
  double from = 0, to = 1;
  bool rises_inward = true;  // its surface is at `from`; else at `to`
  std::string name, reason;
  double depth = 0.1;  // of a label, about, in shares of the diagonal
};

struct LayersChoice {
  FieldKind kind = FieldKind::field;
  bool anatomy = false;             // values in Hounsfield units, or shifted by a constant
  std::vector<LayerChoice> layers;  // from the outermost to the innermost; without the outline
  std::string reason;               // of the kind
};

/// What the numbers do not say.
struct FieldHints {
  bool rests_at_zero = false;  // zero is rest: only the high end is of interest
  bool level_set = false;
  bool whole_numbers = false;  // of an integer type
  bool flat = false;           // the grid's cells are areas
  bool missing_below = false, missing_above = false;  // a value far beyond that end stands for none: a layer at that end would line what is missing
  std::vector<double> labels;  // of find_labels
};

/// Needs a proxy that is not empty. Does not depend on the values' unit: a field times a positive number plus another gives the
/// same layers, except where zero means something (a quantity that begins at zero, CT numbers).
LayersChoice choose_layers(const ProxyGrid& proxy, const ValueCurves& curves, const FieldHints& hints);

/// Thins layers that hold more than about `most` tetrahedra, on a grid of `cells` cells of `each` tetrahedra, to a slab behind
/// their lit surface: the surface hides what lies behind it, or its body is but haze, so that the picture stays. A layer that is
/// cut open at the domain's end would look hollow and stays whole up to kMostSolid tetrahedra.
void thin_layers(LayersChoice& choice, const ProxyGrid& proxy, const ValueCurves& curves, double cells, double each, double most);
inline constexpr double kMostSolid = 2e7;

/// The whole numbers' zero on Hounsfield's scale: what the value -1000 + shift of air is raised by, where these values are CT
/// numbers. Nothing else has a peak at air's, one at soft tissue's and a tail of bone; std::nullopt where the peaks are not
/// there.
struct CtScale {
  bool found = false;
  double zero = 0;  // the value of water
};
CtScale ct_scale(const ProxyGrid& proxy, const ValueCurves& curves, const FieldHints& hints);

}  // namespace isostrata
