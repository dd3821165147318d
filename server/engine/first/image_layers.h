// The surfaces of an object that stands in an empty box, and of others that are to be looked through.
#pragma once

#include <string>

#include "data/derived/value_curves.h"

namespace isostrata {

/// The commonest value at the domain's end, in a window of five of 64 bins.
struct Reference {
  int bin = 0;
  double from = 0, to = 0;        // the window
  double value = 0;               // median of the end's samples in it
  double of_rim = 0, of_all = 0;  // what the window holds
};

/// Of a field that is not constant at its domain's end, too.
Reference reference_of(const ValueCurves& curves);

/// Two surfaces, one inside the other.
struct Shells {
  double outer = 0, inner = 0;
  std::string outer_reason, inner_reason;
};

/// Of an object whose values lie above the background's: its skin at the first strong boundary, and inside that what is denser.
Shells image_shells(const ValueCurves& curves, const Reference& ref);

/// Crumbs: a noisy outer layer shrinks, a noisy inner one grows. high: the layers hold what lies above their surfaces.
void calm(const ValueCurves& curves, bool high, Shells& shells);

/// "15 %".
std::string percent(double share);

inline double share_below(const ValueCurves& curves, double t) { return 1 - curves.share_above(t); }

}  // namespace isostrata
