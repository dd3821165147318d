// Interval volumes as one conforming, labelled tetrahedral mesh.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "base/buffer.h"
#include "base/vec.h"
#include "scene/interval.h"

namespace isostrata {

enum class FacetLabel : std::uint8_t {
  lower,  // on the isosurface f = lower
  upper,  // on the isosurface f = upper
  domain  // on the boundary of the grid
};

/// A point of the mesh lies on the grid edge a-b: (1 - weight) * a + weight * b, or is the grid point a (then b == a, weight 0).
/// Any other point array is carried to the mesh by the same formula (carry_array). The weight is rounded to single precision;
/// positions are made with the weight in double. 16 bytes: grids have fewer than 2^47 points.
class PointOrigin {
 public:
  PointOrigin() = default;
  PointOrigin(std::int64_t a, std::int64_t b, double weight)
      : low_(static_cast<std::uint64_t>(a) | static_cast<std::uint64_t>(b) << 48),
        high_(static_cast<std::uint64_t>(b) >> 16 |
              static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(static_cast<float>(weight))) << 32) {}

  std::int64_t a() const { return static_cast<std::int64_t>(low_ & ((std::uint64_t{1} << 48) - 1)); }
  std::int64_t b() const { return static_cast<std::int64_t>(low_ >> 48 | (high_ & 0xffffffffu) << 16); }
  float weight() const { return std::bit_cast<float>(static_cast<std::uint32_t>(high_ >> 32)); }

  bool operator==(const PointOrigin&) const = default;

 private:
  std::uint64_t low_ = 0;   // a, and the lowest 16 bits of b above it
  std::uint64_t high_ = 0;  // the rest of b, and the weight's bits above it
};

struct BoundaryFacet {
  std::array<std::uint32_t, 3> points{};  // counter-clockwise seen from outside the interval
  std::uint32_t tetrahedron = 0;          // the tetrahedron it bounds
  std::uint16_t interval = 0;             // of that tetrahedron
  FacetLabel label = FacetLabel::domain;
  /// Whose end it lies on: of the request's n intervals, or n + k: of the range of term k. The interval's own where nothing is
  /// combined. Of domain facets: the interval.
  std::uint16_t range = 0;
};

/// The tetrahedra of one active cell: [first_tetrahedron, next run's first_tetrahedron).
struct CellRun {
  std::int64_t cell = 0;
  std::uint32_t first_tetrahedron = 0;
};

struct IntervalSummary {
  Interval interval;
  std::int64_t active_cells = 0;
  std::int64_t tetrahedra = 0;
  // 0 if ExtractOptions::measure is off:
  double volume = 0;          // sum of absolute volumes
  double signed_volume = 0;   // sum of signed volumes; positive for the orientation of the cell they lie in
  std::int64_t inverted = 0;  // tetrahedra of the other sign
  std::int64_t triangles = 0;  // of a flat grid, in place of tetrahedra
  double area = 0;            // of these
  int term = -1;              // the term of the request that alone brought them in; -1: they lie in an interval
};

/// Points inside cells, which only the strict triangulation makes. Mesh point origins.size() + i is the sum of weights[k] * grid
/// point points[k] over k in [first[i], first[i + 1]); the weights add up to 1.
struct InnerPoints {
  std::vector<std::uint32_t> first{0};  // [inner points + 1]
  std::vector<std::int64_t> points;
  std::vector<float> weights;
};

/// What the strict triangulation met and did, in active cells; all 0 if it was not asked for.
struct StrictSummary {
  std::int64_t turned_cells = 0;      // in which the tables' tetrahedra are turned against the cell; of these:
  std::int64_t pulled_cells = 0;      //   triangulated from another point, with the same boundary
  std::int64_t centred_cells = 0;     //   an interval's part from a point inside that part, with the same boundary
  std::int64_t star_cells = 0;        //   cut around a point inside
  std::int64_t tangled_cells = 0;     //   left with turned ones: from no point inside are all its faces seen
  std::int64_t added_tetrahedra = 0;  // more than the tables' (or fewer)
  std::int64_t added_points = 0;
};

/// Touching intervals share the points on their common isosurface. Of a flat grid there are no tetrahedra, and the facets are the areas
/// themselves (extract_areas.h). Immutable once made.
struct IntervalMesh {
  Buffer<Vec3d> positions;                          // [np] world space
  Buffer<PointOrigin> origins;                      // [np - inner points]; empty if ranges were combined: they lie on no edge
  Buffer<double> values;                            // [np] the array that was extracted on; empty unless asked for
  Buffer<std::array<std::uint32_t, 4>> tetrahedra;  // [nt] point indices, grouped by cell: see cell_runs
  Buffer<std::uint16_t> tetrahedron_interval;       // [nt] index into summaries
  Buffer<CellRun> cell_runs;                        // [active cells] each cell once, those near one another close together
  Buffer<BoundaryFacet> facets;                // empty unless asked for
  std::vector<IntervalSummary> summaries;           // one per interval of the request, in its order; then per term that adds
  std::int64_t cells = 0;                           // of the grid, hidden ones included
  std::int64_t active_cells = 0;                    // active in at least one interval
  InnerPoints inner;                                // the last points
  StrictSummary strict;
};

/// A named value at each point of the mesh, or in each tetrahedron.
struct MeshArray {
  std::string name;
  std::vector<float> values;  // [np], or [nt] (of a flat grid [facets])
  bool in_cells = false;
};

}  // namespace isostrata
