// The interval volume of the four-dimensional cells between two time steps, kept, and its slices.
// Method: P. Bhaniramka, C. Zhang, D. Xue, R. Crawfis, R. Wenger, "Volume Interval Segmentation and Rendering", 2004,
// section 3.2: the interval volume of space-time as 4-simplices, made once; the interval volume at a time is a slice, cut out of
// each 4-simplex by the isosurface table of the simplex with the time as isovalue.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/buffer.h"
#include "base/task.h"
#include "data/dataset/dataset.h"
#include "extraction/mesh/interval_mesh.h"
#include "tables/interval_case.h"

namespace isostrata {

/// Where a point of a slice comes from: (1 - weight) * a + weight * b of the volume's own points.
struct SlicePoint {
  std::uint32_t a = 0, b = 0;
  double weight = 0;
};

struct SliceOptions {
  bool facets = false;                    // fill IntervalMesh::facets
  bool values = true;                     // fill IntervalMesh::values
  bool measure = true;                    // sum the volumes of the summaries and count what is inverted
  std::uint64_t max_bytes = 16ull << 30;  // throws too_large, with the numbers, if the slice would need more
};

/// The interval volume at one time. The mesh conforms, is labelled, and its cell runs are cells of the steps' grid, as those of
/// extract_intervals. Its points lie on no grid edge, so mesh.origins is empty: arrays are carried by SpaceTimeVolume::carry.
struct SpaceTimeSlice {
  IntervalMesh mesh;
  std::vector<SlicePoint> points;  // [np]
};

/// Made once for two steps, an array and intervals; immutable, so that any number of threads may slice it at once.
///
/// The field is linear in each 4-simplex: on meshes of tetrahedra a slice at a step's time is that step's own interval volume,
/// with the same points; other cells are taken as split into tetrahedra (space_time_cells.h). A point that moves between
/// the steps moves along a straight line, and its cells with it: the split is one of the cells' own coordinates and time, where
/// a cell is a straight prism however its points move, and a slice is put where the grid is at that time. So slices fill the cells
/// of that time just so, and turn over only where the split cell is turned over then. A cell that is hidden, or not finite, at one of the steps is in no slice.
///
/// Memory: 50 bytes a 4-simplex, 8 an edge, 72 a point: about 3 kB for each active hexahedron.
class SpaceTimeVolume {
 public:
  /// Throws unsupported (steps of different cells), not_found, invalid_argument, too_large (with the numbers, before the memory
  /// is taken), cancelled. O(cells) to find the active ones, then O(4-simplices). Any thread.
  /// complement: also what is below, between and above the intervals, as further intervals after them.
  SpaceTimeVolume(std::shared_ptr<const Dataset> first, std::shared_ptr<const Dataset> second, const std::string& array,
                  std::span<const Interval> intervals, std::uint64_t max_bytes, const Task& task, bool complement = false);

  /// weight: the time as a fraction of the way from the first step to the second, in [0, 1]; else invalid_argument.
  /// O(edges + 4-simplices), without any search or hash. Throws too_large, cancelled. Any thread.
  SpaceTimeSlice slice(double weight, const SliceOptions& options, const Task& task) const;

  /// Another array, given at both steps, at the points of a slice: [np], linear along the edges of the 4-simplices.
  Buffer<double> carry(const SpaceTimeSlice& slice, const PointArray& at_first, const PointArray& at_second) const;

  const std::shared_ptr<const Dataset>& first() const { return first_; }
  const std::shared_ptr<const Dataset>& second() const { return second_; }
  const std::string& array() const { return array_; }
  const std::vector<Interval>& intervals() const { return intervals_; }  // the complement's, if any, last
  bool complement() const { return complement_; }
  bool moves() const { return moves_; }  // whether any point has another position at the second step
  std::size_t simplices() const { return simplices_.size(); }
  std::size_t points() const { return points_.size(); }
  std::size_t edges() const { return edges_.size(); }
  std::uint64_t bytes() const;

  // What it is made of; space_time_build.cpp fills it, space_time_slice.cpp reads it.

  /// On the edge from a to b, or a itself (b == a). A vertex is a grid point + np * step.
  struct Point {
    Vec3d position;
    double value = 0;
    double weight = 0;
    std::int64_t a = 0, b = 0;
  };
  using Edge = std::array<std::uint32_t, 2>;           // points, the smaller first
  using SimplexEdges = std::array<std::uint32_t, 10>;  // of the points 01, 02, 03, 04, 12, ... 34 in increasing order
  /// Where the facets of a 4-simplex lie, as the codes of FacetLabels, 4 bits each: from bit 0 the facet opposite point k; from
  /// bit 20, where four of the points lie in one step, the triangle that these make without point k. Bit 63: negatively oriented.
  struct SimplexLabels {
    static constexpr int kTriangles = 20;
    static constexpr std::uint64_t kTurned = std::uint64_t{1} << 63;
  };
  struct Run {
    std::int64_t cell = 0;
    std::uint64_t first_simplex = 0;
    double tolerance = 0;   // of volumes of tetrahedra in the cell
    std::uint8_t open = 0;  // bit k: no other cell shares the cell's face k
  };

 private:
  friend class SpaceTimeBuilder;
  friend class SpaceTimeSlicer;

  std::shared_ptr<const Dataset> first_, second_;
  std::string array_;
  std::vector<Interval> intervals_;
  bool complement_, moves_ = false;
  std::int64_t grid_points_ = 0, grid_cells_ = 0;
  Buffer<Point> points_;
  Buffer<double> times_;            // [points] in [0, 1]
  Buffer<Edge> edges_;              // by their points
  Buffer<SimplexEdges> simplices_;  // by cell
  Buffer<std::uint64_t> labels_;    // [simplices] see SimplexLabels
  Buffer<std::uint16_t> interval_;  // [simplices]
  std::vector<Run> runs_;           // [active cells]
};

}  // namespace isostrata
