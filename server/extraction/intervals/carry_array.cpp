#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "extraction/intervals/extract_intervals.h"

namespace isostrata {

std::vector<float> carry_array(const IntervalMesh& mesh, const PointArray& array) {
  const auto on_edges = static_cast<std::int64_t>(mesh.origins.size());
  const auto inside = static_cast<std::int64_t>(mesh.inner.first.size()) - 1;
  std::vector<float> carried(static_cast<std::size_t>(on_edges + inside));
  std::visit(
      [&](auto values) {
        const auto check = [&](std::int64_t point) {
          if (static_cast<std::uint64_t>(point) >= values.size())
            throw Error(ErrorCode::invalid_argument, "array '" + array.name + "' has " + std::to_string(values.size()) +
                                                         " values; the mesh lies on a grid with a point " +
                                                         std::to_string(point));
          return static_cast<std::size_t>(point);
        };
        parallel_for(on_edges, 1 << 15, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t i = begin; i < end; ++i) {
            const PointOrigin& origin = mesh.origins[i];
            check(origin.b());  // b >= a
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
        parallel_for(inside, 1 << 12, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t i = begin; i < end; ++i) {
            double sum = 0;
            for (std::uint32_t k = mesh.inner.first[i]; k < mesh.inner.first[i + 1]; ++k)
              sum += mesh.inner.weights[k] * static_cast<double>(values[check(mesh.inner.points[k])]);
            carried[on_edges + i] = static_cast<float>(sum);
          }
        });
      },
      array.values);
  return carried;
}

}  // namespace isostrata
