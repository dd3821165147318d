// Boundary surfaces among the segments: fragments of no length, lit by surface_shading.h.
#pragma once

#include <optional>
#include <vector>

#include "rendering/picture/surface_shading.h"
#include "rendering/segments/segment_bins.h"
#include "rendering/segments/segment_fragments.h"

namespace isostrata {

/// A facet on the screen, or a piece of one that was cut at the eye.
struct SurfaceTriangle {
  double x[3], y[3], q[3];
  double weight[3][3];  // of the facet's points at each corner
  std::uint32_t facet;
  bool entering;  // a ray that meets it comes into the interval
};

class SegmentSurfaces {
 public:
  /// The facets that the styles ask for. Parallel. input and the rest outlive it.
  SegmentSurfaces(const DrawInput& input, const SegmentView& view, const SegmentOptics& optics, int tiles_x, int tiles_y);

  bool any() const { return !triangles_.empty(); }
  std::span<const SegmentEntry> in_tile(std::size_t tile) const { return bins_.of(tile); }
  std::uint16_t interval(std::uint32_t triangle) const;
  /// How many fragments the triangle can add at most within the part.
  std::size_t room(std::uint32_t triangle, const CoverInput& part) const;
  /// Appends the triangle's fragments. Any thread.
  void add(std::uint32_t triangle, const CoverInput& part, FragmentStore& store) const;

 private:
  void place(std::uint32_t facet, std::vector<SurfaceTriangle>& out) const;

  const DrawInput& input_;
  const SegmentView& view_;
  const SegmentOptics& optics_;
  std::vector<std::optional<SurfaceMaterial>> materials_;  // [intervals] of those that draw a surface
  std::vector<SurfaceTriangle> triangles_;
  TileBins bins_;
};

}  // namespace isostrata
