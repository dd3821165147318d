#include "extraction/layers/owned_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "data/parts/take_region.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/bricks/layer_bricks.h"
#include "extraction/intervals/extract_intervals.h"
#include "support/field_dataset.h"

namespace isostrata {
namespace {

const std::array<Interval, 2> kIntervals{{{-0.3, 0.1}, {0.1, 0.8}}};

std::vector<std::shared_ptr<const Dataset>> datasets() {
  const auto field = [](Vec3d p) { return p.x * p.y + 0.7 * p.z - 0.2 * p.x; };
  auto boxes = testing::field_dataset({11, 9, 10}, field);
  testing::OwnedMesh mesh;
  for (std::int64_t p = 0; p < boxes->grid.point_count(); ++p) mesh.points.push_back(boxes->grid.point(p) + Vec3d{0.01 * (p % 3), 0.013 * (p % 5), 0.009 * (p % 7)});
  std::array<std::int64_t, kMaxCellVertices> c;
  for (std::int64_t cell = 0; cell < boxes->grid.cell_count(); ++cell) {
    boxes->grid.cell_points(cell, c);
    if (cell % 2) {
      mesh.add(CellType::hexahedron, {c.begin(), c.begin() + 8});
    } else if (cell % 4 == 0) {  // its first corner is where others have their last
      mesh.add(CellType::hexahedron, {c[6], c[7], c[4], c[5], c[2], c[3], c[0], c[1]});
    } else {
      mesh.add(CellType::wedge, {c[0], c[1], c[2], c[4], c[5], c[6]});
      mesh.add(CellType::wedge, {c[0], c[2], c[3], c[4], c[6], c[7]});
    }
  }
  return {boxes, testing::mesh_dataset(std::move(mesh), field)};
}

IntervalMesh extract(const Dataset& dataset) {
  ExtractOptions options;
  options.facets = true;
  return extract_intervals(dataset.grid, dataset.arrays[0], kIntervals, options, Task{});
}

OwnsCell owner(const Grid& grid, const RegionTree& tree, int region) {
  return [&grid, &tree, region](std::int64_t cell) {
    std::array<std::int64_t, kMaxCellVertices> ids;
    grid.cell_points(cell, ids);
    return region_at(tree, grid.point(ids[0])) == region;
  };
}

TEST(OwnedCells, BricksOfPartsHoldWhatTheMeshOfTheWholeHolds) {
  const auto dataset = testing::field_dataset({37, 29, 41}, [](Vec3d p) { return p.x * p.y + 0.7 * p.z - 0.2 * p.x; });
  const IntervalMesh whole = extract(*dataset);
  const RegionTree tree = make_regions(dataset->grid, 5);
  std::vector<IntervalSummary> sum(2);
  for (int region = 0; region < 5; ++region) {
    const auto part = take_region(*dataset, tree, region);
    BrickMemory memory;
    const auto found = find_layer_bricks(part, part->arrays[0], kIntervals, memory, 0, 1u << 30, Task{});
    ASSERT_TRUE(found);
    const std::vector<IntervalSummary> own = found->bricks->summaries_of(owner(part->grid, tree, region), Task{});
    for (std::size_t i = 0; i < 2; ++i) {
      sum[i].active_cells += own[i].active_cells;
      sum[i].tetrahedra += own[i].tetrahedra;
      sum[i].signed_volume += own[i].signed_volume;
    }
  }
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_GT(sum[i].tetrahedra, 10000);
    EXPECT_EQ(sum[i].active_cells, whole.summaries[i].active_cells);
    EXPECT_EQ(sum[i].tetrahedra, whole.summaries[i].tetrahedra);
    EXPECT_NEAR(sum[i].signed_volume, whole.summaries[i].signed_volume, 1e-12 * whole.summaries[i].volume);
  }
}

TEST(OwnedCells, PartsAddUpToTheWhole) {
  for (const auto& dataset : datasets()) {
    const IntervalMesh whole = extract(*dataset);
    const RegionTree tree = make_regions(dataset->grid, 5);
    std::vector<IntervalSummary> sum(2);
    std::int64_t cells = 0, active = 0;
    std::array<std::size_t, 3> facets{};
    for (int region = 0; region < 5; ++region) {
      const auto part = take_region(*dataset, tree, region);
      const OwnedPart own = owned_mesh(part->grid, extract(*part), owner(part->grid, tree, region), Task{});
      for (std::size_t i = 0; i < 2; ++i) {
        sum[i].active_cells += own.mesh.summaries[i].active_cells;
        sum[i].tetrahedra += own.mesh.summaries[i].tetrahedra;
        sum[i].volume += own.mesh.summaries[i].volume;
        sum[i].signed_volume += own.mesh.summaries[i].signed_volume;
      }
      cells += own.mesh.cells;
      active += own.mesh.active_cells;
      for (const BoundaryFacet& facet : own.mesh.facets) ++facets[static_cast<std::size_t>(facet.label)];
    }
    EXPECT_EQ(cells, whole.cells);
    EXPECT_EQ(active, whole.active_cells);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(sum[i].active_cells, whole.summaries[i].active_cells);
      EXPECT_EQ(sum[i].tetrahedra, whole.summaries[i].tetrahedra);
      EXPECT_NEAR(sum[i].volume, whole.summaries[i].volume, 1e-12 * whole.summaries[i].volume);
      EXPECT_NEAR(sum[i].signed_volume, whole.summaries[i].signed_volume, 1e-12 * whole.summaries[i].volume);
    }
    std::array<std::size_t, 3> expected{};
    for (const BoundaryFacet& facet : whole.facets) ++expected[static_cast<std::size_t>(facet.label)];
    EXPECT_EQ(facets, expected);
  }
}

// A facet of a tetrahedron is by itself if no other one of the same interval has its three corners, bit for bit. Those of the joined pieces
// must be the facets that bound the whole.
TEST(OwnedCells, PiecesJoinWithoutAnUnmatchedFacet) {
  using Corner = std::array<double, 3>;
  for (const auto& dataset : datasets()) {
    const RegionTree tree = make_regions(dataset->grid, 6);
    std::map<std::pair<std::uint16_t, std::array<Corner, 3>>, int> seen;
    const auto note = [&](const IntervalMesh& mesh, std::array<std::uint32_t, 3> facet, std::uint16_t interval) {
      std::array<Corner, 3> corners;
      for (std::size_t v = 0; v < 3; ++v) corners[v] = {mesh.positions[facet[v]].x, mesh.positions[facet[v]].y, mesh.positions[facet[v]].z};
      std::sort(corners.begin(), corners.end());
      ++seen[{interval, corners}];
    };
    for (int region = 0; region < 6; ++region) {
      const auto part = take_region(*dataset, tree, region);
      const OwnedPart own = owned_mesh(part->grid, extract(*part), owner(part->grid, tree, region), Task{});
      for (std::size_t t = 0; t < own.mesh.tetrahedra.size(); ++t) {
        const auto& p = own.mesh.tetrahedra[t];
        for (const auto& f : {std::array{1, 2, 3}, std::array{0, 3, 2}, std::array{0, 1, 3}, std::array{0, 2, 1}})
          note(own.mesh, {p[static_cast<std::size_t>(f[0])], p[static_cast<std::size_t>(f[1])], p[static_cast<std::size_t>(f[2])]}, own.mesh.tetrahedron_interval[t]);
      }
      for (const BoundaryFacet& facet : own.mesh.facets) note(own.mesh, facet.points, facet.interval);  // its partner
    }
    std::size_t unmatched = 0;
    for (const auto& [facet, count] : seen) unmatched += count != 2;
    EXPECT_EQ(unmatched, 0u);
    EXPECT_GT(seen.size(), 1000u);
  }
}

}  // namespace
}  // namespace isostrata
