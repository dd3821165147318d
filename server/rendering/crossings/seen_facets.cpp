#include "rendering/crossings/seen_facets.h"

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "rendering/crossings/facet_spans.h"
#include "rendering/crossings/project_vertices.h"

namespace isostrata {
namespace {

/// What is kept of a slab.
struct Kept {
  std::vector<Vec3d> positions;
  std::vector<PointOrigin> origins;
  std::vector<BoundaryFacet> facets;
};

/// Whether a part of the box may be on the picture; true if that is not easily told.
bool may_be_seen(const Box3d& box, const ScreenTransform& transform) {
  std::int32_t x_low = 0, x_high = 0, y_low = 0, y_high = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const ScreenVertex v = transform.project(transform.view({corner & 1 ? box.upper.x : box.lower.x, corner & 2 ? box.upper.y : box.lower.y,
                                                             corner & 4 ? box.upper.z : box.lower.z}));
    if (v.q == 0) return true;
    x_low = corner == 0 ? v.x : std::min(x_low, v.x), x_high = corner == 0 ? v.x : std::max(x_high, v.x);
    y_low = corner == 0 ? v.y : std::min(y_low, v.y), y_high = corner == 0 ? v.y : std::max(y_high, v.y);
  }
  // Two steps wider each way: the corners are rounded, and so are the points.
  return first_center(x_high + 2) > 0 && first_center(x_low - 2) < transform.width && first_center(y_high + 2) > 0 &&
         first_center(y_low - 2) < transform.height;
}

class Keeper {
 public:
  Keeper(const LayerBricks& bricks, const ScreenTransform& transform, std::span<const std::uint8_t> drawn)
      : bricks_(bricks), transform_(transform), drawn_(drawn), slab_(bricks) {}

  void keep(std::int64_t z, Kept& out) {
    bricks_.write(z, [&](const Box3d& box) { return may_be_seen(box, transform_); }, slab_);
    const IntervalMesh& mesh = slab_.mesh;
    if (mesh.facets.empty()) return;
    project_vertices(mesh.positions, transform_, vertices_);
    const PixelRect picture{0, 0, transform_.width, transform_.height};
    used_.assign(mesh.positions.size(), 0);
    for (const BoundaryFacet& facet : mesh.facets) {
      if (!drawn_[facet.interval]) continue;
      const ScreenVertex &a = vertices_[facet.points[0]], &b = vertices_[facet.points[1]], &c = vertices_[facet.points[2]];
      int first_row = 0, end_row = 0;
      if (a.q != 0 && b.q != 0 && c.q != 0 && !may_cover(a, b, c, picture, first_row, end_row)) continue;
      for (const std::uint32_t point : facet.points) used_[point] = 1;
      out.facets.push_back(facet);
    }
    // In the mesh's order, by which a facet's corners are turned: so depths are the same to the last bit, also of facets that lie on one another.
    numbers_.resize(mesh.positions.size());
    for (std::size_t p = 0; p < used_.size(); ++p) {
      if (!used_[p]) continue;
      numbers_[p] = static_cast<std::uint32_t>(out.positions.size());
      out.positions.push_back(mesh.positions[p]);
      out.origins.push_back(mesh.origins[p]);
    }
    for (BoundaryFacet& facet : out.facets)
      for (std::uint32_t& point : facet.points) point = numbers_[point];
  }

 private:
  const LayerBricks& bricks_;
  const ScreenTransform& transform_;
  const std::span<const std::uint8_t> drawn_;
  LayerBricks::Slab slab_;
  Buffer<ScreenVertex> vertices_;
  std::vector<std::uint8_t> used_;      // whether a facet that is kept uses the slab's point
  std::vector<std::uint32_t> numbers_;  // of those points among the kept ones
};

}  // namespace

IntervalMesh seen_facets(const LayerBricks& bricks, std::span<const IntervalSummary> summaries, const ScreenTransform& transform,
                         std::span<const std::uint8_t> drawn) {
  std::vector<Kept> slabs(static_cast<std::size_t>(bricks.slabs()));
  parallel_for(bricks.slabs(), bricks.slabs() / (4 * thread_count()) + 1, [&](std::int64_t begin, std::int64_t end) {
    Keeper keeper(bricks, transform, drawn);
    for (std::int64_t z = begin; z < end; ++z) keeper.keep(z, slabs[static_cast<std::size_t>(z)]);
  });
  IntervalMesh mesh;
  mesh.summaries.assign(summaries.begin(), summaries.end());
  mesh.cells = bricks.grid().cell_count();
  std::vector<std::size_t> points(1, 0), facets(1, 0);
  for (const Kept& slab : slabs) {
    points.push_back(points.back() + slab.positions.size());
    facets.push_back(facets.back() + slab.facets.size());
  }
  if (std::max(points.back(), facets.back()) > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::too_large, "picture: " + std::to_string(facets.back()) + " facets are seen; expected fewer than 2^32");
  mesh.positions.resize(points.back());
  mesh.origins.resize(points.back());
  mesh.facets.resize(facets.back());
  parallel_for(bricks.slabs(), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto z = static_cast<std::size_t>(begin); z < static_cast<std::size_t>(end); ++z) {
      std::copy(slabs[z].positions.begin(), slabs[z].positions.end(), mesh.positions.begin() + static_cast<std::ptrdiff_t>(points[z]));
      std::copy(slabs[z].origins.begin(), slabs[z].origins.end(), mesh.origins.begin() + static_cast<std::ptrdiff_t>(points[z]));
      BoundaryFacet* to = mesh.facets.data() + facets[z];
      for (BoundaryFacet facet : slabs[z].facets) {
        for (std::uint32_t& point : facet.points) point += static_cast<std::uint32_t>(points[z]);
        *to++ = facet;
      }
      slabs[z] = {};
    }
  });
  return mesh;
}

}  // namespace isostrata
