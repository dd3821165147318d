// Round numbers for axes and colour bars, and numbers as people write them.
#pragma once

#include <string>
#include <vector>

namespace isostrata {

struct AxisTicks {
  double step = 0;             // 1, 2 or 5 times a power of ten
  std::vector<double> values;  // multiples of step within the range, ends included
};

/// At most `most` ticks (at least 2 are tried for) over [lower, upper]. None if the range is empty or not finite.
AxisTicks axis_ticks(double lower, double upper, int most);

/// The ticks' texts, alike in their number of decimals; all or none of them with a power of ten (1.5×10⁻⁷). UTF-8.
std::vector<std::string> tick_texts(const AxisTicks& ticks);

/// A number to so many significant digits without trailing zeros, with a power of ten where it would be long. UTF-8.
std::string number_text(double value, int digits = 4);

}  // namespace isostrata
