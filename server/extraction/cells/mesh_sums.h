// What an interval's tetrahedra add up to, part of the mesh by part, so that sums do not depend on threads.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "extraction/cells/cell_geometry.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// As IntervalSummary has them.
struct IntervalSums {
  std::int64_t active_cells = 0, tetrahedra = 0, inverted = 0;
  double volume = 0, signed_volume = 0;

  /// Of one tetrahedron. tolerance: what its rounding makes uncertain; flat ones come out as rounding of either sign.
  void measure(double of_one, double tolerance) {
    volume += std::abs(of_one);
    signed_volume += of_one;
    inverted += of_one < -tolerance;
  }
};

/// Of one part of a mesh.
class MeshSums {
 public:
  IntervalSums& of(std::uint16_t interval) {
    if (!last_ || interval != interval_) last_ = &sums_[interval_ = interval];
    return *last_;
  }
  void add_to(std::span<IntervalSummary> summaries) const {
    for (const auto& [interval, sums] : sums_) {
      IntervalSummary& summary = summaries[interval];
      summary.active_cells += sums.active_cells;
      summary.tetrahedra += sums.tetrahedra;
      summary.inverted += sums.inverted;
      summary.volume += sums.volume;
      summary.signed_volume += sums.signed_volume;
    }
  }

 private:
  std::map<std::uint16_t, IntervalSums> sums_;
  IntervalSums* last_ = nullptr;
  std::uint16_t interval_ = 0;
};

/// Adds the volumes of tetrahedra [first, last), which lie in one cell. tolerance: what its rounding makes uncertain.
inline void measure_tetrahedra(const IntervalMesh& mesh, std::uint64_t first, std::uint64_t last, double tolerance,
                               IntervalSums& sums) {
  const auto& x = mesh.positions;
  for (std::uint64_t i = first; i < last; ++i) {
    const auto& p = mesh.tetrahedra[i];
    sums.measure(orient3d(x[p[0]], x[p[1]], x[p[2]], x[p[3]]) / 6, tolerance);
  }
}

}  // namespace isostrata
