// Times between steps.
#pragma once

namespace isostrata {

/// How a time between two steps is understood (the paper's section 3.2). All agree at the steps themselves.
enum class TimeMode {
  step,         // the step whose time is nearest
  interpolate,  // the array's values at t, linear between the two steps, extracted as one field
  spacetime     // the interval volume of the four-dimensional cells between the two steps, sliced at t
};

}  // namespace isostrata
