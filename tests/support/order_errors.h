// How far an order of tetrahedra is from the order along each pixel's ray.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "support/oracle_bins.h"
#include "support/oracle_ray.h"

namespace isostrata::testing {

/// A fragment is a tetrahedron's segment on a pixel's ray. Neighbours on the ray that may change places (of one interval whose
/// style is constant()) form a run. A fragment is in the wrong order if it is drawn before some fragment of the next run
/// behind it; no fragment is, exactly where the picture is composited in the right order. Fragments shorter than 1e-7 of the
/// bounds' diagonal do not count, and two that overlap by more than that (inverted tetrahedra) have no order.
struct OrderErrors {
  std::int64_t fragments = 0;    // with another run behind them: whose order matters
  std::int64_t wrong = 0;        // of these
  std::int64_t overlapping = 0;  // pairs in neighbouring runs that have no order
  double share() const { return fragments > 0 ? static_cast<double>(wrong) / static_cast<double>(fragments) : 0.0; }
};

/// Fragments of one ray, near ones first.
inline void count_order_errors(const DrawInput& input, std::span<const std::int64_t> rank, double epsilon,
                               std::span<const OracleSegment> met, OrderErrors& errors) {
  const auto interval = [&](std::size_t i) { return input.mesh->tetrahedron_interval[met[i].tetrahedron]; };
  const auto run_end = [&](std::size_t begin) {
    std::size_t end = begin + 1;
    if (begin < met.size() && input.styles[interval(begin)].constant())
      while (end < met.size() && interval(end) == interval(begin)) ++end;
    return std::min(end, met.size());
  };
  for (std::size_t begin = 0, middle = run_end(0); middle < met.size();) {
    const std::size_t end = run_end(middle);
    for (std::size_t near = begin; near < middle; ++near) {
      bool wrong = false;
      for (std::size_t far = middle; far < end; ++far) {
        if (met[near].leave > met[far].enter + epsilon)
          ++errors.overlapping;
        else
          wrong = wrong || rank[met[near].tetrahedron] < rank[met[far].tetrahedron];
      }
      ++errors.fragments;
      errors.wrong += wrong;
    }
    begin = middle;
    middle = end;
  }
}

/// order: tetrahedra, the first is drawn first; those that are not in it are not drawn. RenderMode::sorted. Parallel over rows.
inline OrderErrors order_errors(const DrawInput& input, std::span<const std::uint32_t> order) {
  std::vector<std::int64_t> rank(input.mesh->tetrahedra.size(), -1);
  for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<std::int64_t>(i);
  const double epsilon = 1e-7 * input.bounds.diagonal();
  const OracleBins bins(input);
  std::vector<OrderErrors> rows(static_cast<std::size_t>(input.height));
  parallel_for(input.height, 1, [&](std::int64_t begin, std::int64_t end) {
    std::vector<OracleSegment> met;
    for (std::int64_t y = begin; y < end; ++y)
      for (int x = 0; x < input.width; ++x) {
        const OracleRay ray = oracle_ray(input, x, static_cast<double>(y));
        met.clear();
        OracleSegment segment{};
        for (const std::uint32_t t : bins.of_pixel(x, static_cast<int>(y)).tetrahedra)
          if (rank[t] >= 0 && oracle_segment(*input.mesh, nullptr, t, ray, segment) && segment.leave - segment.enter > epsilon)
            met.push_back(segment);
        std::sort(met.begin(), met.end(),
                  [](const OracleSegment& a, const OracleSegment& b) { return a.enter + a.leave < b.enter + b.leave; });
        count_order_errors(input, rank, epsilon, met, rows[static_cast<std::size_t>(y)]);
      }
  });
  OrderErrors sum;
  for (const OrderErrors& row : rows) {
    sum.fragments += row.fragments;
    sum.wrong += row.wrong;
    sum.overlapping += row.overlapping;
  }
  return sum;
}

}  // namespace isostrata::testing
