#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "extraction/extract_intervals.h"

namespace isostrata {

std::vector<float> carry_array(const IntervalMesh& mesh, const PointArray& array) {
  std::vector<float> carried(mesh.origins.size());
  std::visit(
      [&](auto values) {
        parallel_for(static_cast<std::int64_t>(carried.size()), 1 << 15, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t i = begin; i < end; ++i) {
            const PointOrigin& origin = mesh.origins[i];
            if (static_cast<std::uint64_t>(origin.b()) >= values.size())  // b >= a
              throw Error(ErrorCode::invalid_argument, "array '" + array.name + "' has " + std::to_string(values.size()) +
                                                           " values; the mesh lies on a grid with a point " +
                                                           std::to_string(origin.b()));
            const auto at_a = static_cast<double>(values[origin.a()]);
            // A weight of 0 or 1 takes the end itself: the other one may be NaN.
            const double weight = origin.weight();
            if (weight == 0) {
              carried[i] = static_cast<float>(at_a);
              continue;
            }
            const auto at_b = static_cast<double>(values[origin.b()]);
            carried[i] = static_cast<float>(weight == 1 ? at_b : at_a * (1 - weight) + at_b * weight);
          }
        });
      },
      array.values);
  return carried;
}

}  // namespace isostrata
