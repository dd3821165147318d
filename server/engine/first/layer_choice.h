// What is chosen of a field for its first picture: layers, each with its reason. Values are in shares of the proxy's range.
#pragma once

#include <string>
#include <vector>

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
  bool map = false;            // an axis is in another unit (unlike_axis.h): what is seen of it is a matter of its scale
  bool missing_below = false, missing_above = false;  // a value far beyond that end stands for none: a layer at that end would line what is missing
  std::vector<double> labels;  // of find_labels
};

}  // namespace isostrata
