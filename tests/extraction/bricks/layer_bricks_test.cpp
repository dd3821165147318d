#include "extraction/bricks/layer_bricks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "data/dataset/analytic.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/bricks/extract_structured.h"
#include "extraction/small_grids.h"

namespace isostrata {
namespace {

std::shared_ptr<const Dataset> dataset_of(Grid grid, PointArray array) {
  auto dataset = std::make_shared<Dataset>();
  measure_range(array);
  dataset->bounds = grid.bounds();
  dataset->grid = std::move(grid);
  dataset->arrays.push_back(std::move(array));
  return dataset;
}

/// A structured grid of each kind, with values that lie on isovalues, that are not finite and cells that are hidden, as the seed has it.
std::shared_ptr<const Dataset> random_dataset(std::mt19937_64& random) {
  const std::array<std::int64_t, 3> dims{2 + static_cast<std::int64_t>(random() % 18), 2 + static_cast<std::int64_t>(random() % 18),
                                         2 + static_cast<std::int64_t>(random() % 18)};
  auto values = random_values(dims[0] * dims[1] * dims[2], 0, 8, random);
  const bool whole = random() % 2, holes = random() % 3 == 0;
  for (double& value : values) {
    if (whole) value = std::floor(value);
    if (holes && random() % 60 == 0) value = random() % 2 ? NAN : INFINITY;
  }
  Grid grid = uniform_grid(dims, {1, 2, 3}, {0.5, random() % 2 ? 0.7 : -0.7, 0.9});
  if (random() % 3 == 0) {
    std::vector<Vec3d> points;
    for (std::int64_t p = 0; p < grid.point_count(); ++p) {
      const Vec3d at = grid.point(p);
      points.push_back({at.x + 0.1 * std::sin(at.y), at.y + 0.1 * std::sin(at.z), at.z + 0.1 * std::sin(at.x)});
    }
    grid = curvilinear_grid(dims, std::move(points));
  }
  if (random() % 3 == 0) {
    auto hidden = std::make_shared<std::vector<std::uint8_t>>(static_cast<std::size_t>(grid.cell_count()));
    for (auto& one : *hidden) one = random() % 20 == 0;
    grid.hidden_cells = *hidden;
    grid.storage = std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(grid.storage, hidden);
  }
  return dataset_of(std::move(grid), point_array(values));
}

const std::vector<std::vector<Interval>> kLayers{{{2, 3}}, {{1, 2.5}, {2.5, 4}, {6, 9}}, {{-5, 20}}, {{1, 5}, {3, 7}}};

TEST(StructuredFacets, AloneAreTheVeryFacetsOfTheMeshOfTetrahedra) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const auto dataset = random_dataset(random);
    const auto& intervals = kLayers[seed % kLayers.size()];
    ExtractOptions options;
    options.facets = true;
    const IntervalMesh mesh = *extract_structured(dataset->grid, dataset->arrays[0], intervals, options, Task{});
    options.tetrahedra = false;
    const IntervalMesh alone = *extract_structured(dataset->grid, dataset->arrays[0], intervals, options, Task{});
    EXPECT_TRUE(alone.tetrahedra.empty() && alone.tetrahedron_interval.empty() && alone.cell_runs.empty());
    EXPECT_EQ(alone.active_cells, mesh.active_cells);
    EXPECT_TRUE(std::equal(alone.positions.begin(), alone.positions.end(), mesh.positions.begin(), mesh.positions.end()));
    EXPECT_TRUE(std::equal(alone.origins.begin(), alone.origins.end(), mesh.origins.begin(), mesh.origins.end()));
    EXPECT_TRUE(std::equal(alone.facets.begin(), alone.facets.end(), mesh.facets.begin(), mesh.facets.end(), [](const BoundaryFacet& a, const BoundaryFacet& b) {
      return a.points == b.points && a.interval == b.interval && a.label == b.label && a.range == b.range;
    }));
    for (std::size_t i = 0; i < intervals.size(); ++i) {
      EXPECT_EQ(alone.summaries[i].interval, mesh.summaries[i].interval);
      EXPECT_EQ(alone.summaries[i].active_cells, mesh.summaries[i].active_cells);
      EXPECT_EQ(alone.summaries[i].tetrahedra, mesh.summaries[i].tetrahedra);
      EXPECT_NEAR(alone.summaries[i].signed_volume, mesh.summaries[i].signed_volume, 1e-9 * (1 + mesh.summaries[i].volume));
    }
  }
}

TEST(LayerBricks, TheirSlabsHoldTheVeryFacetsOfTheMesh) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const auto dataset = random_dataset(random);
    const auto& intervals = kLayers[seed % kLayers.size()];
    const PointArray& array = dataset->arrays[0];
    ExtractOptions options;
    options.facets = true;
    const IntervalMesh mesh = *extract_structured(dataset->grid, array, intervals, options, Task{});
    BrickMemory memory;
    const auto found = find_layer_bricks(dataset, array, intervals, memory, 0, kNoLimit, Task{});
    ASSERT_TRUE(found);
    std::size_t at = 0;
    LayerBricks::Slab slab(*found->bricks);
    for (std::int64_t z = 0; z < found->bricks->slabs(); ++z) {
      found->bricks->write(z, nullptr, slab);
      for (const BoundaryFacet& facet : slab.mesh.facets) {
        ASSERT_LT(at, mesh.facets.size());
        const BoundaryFacet& of = mesh.facets[at++];
        ASSERT_EQ(facet.interval, of.interval);
        ASSERT_EQ(facet.label, of.label);
        for (std::size_t v = 0; v < 3; ++v) {
          ASSERT_EQ(slab.mesh.positions[facet.points[v]], mesh.positions[of.points[v]]);
          ASSERT_EQ(slab.mesh.origins[facet.points[v]], mesh.origins[of.points[v]]);
        }
      }
    }
    EXPECT_EQ(at, mesh.facets.size());
    for (std::size_t i = 0; i < intervals.size(); ++i) {
      const IntervalSummary &one = found->mesh.summaries[i], &other = mesh.summaries[i];
      EXPECT_EQ(one.interval, other.interval);
      EXPECT_EQ(one.active_cells, other.active_cells);
      EXPECT_EQ(one.tetrahedra, other.tetrahedra);
      EXPECT_NEAR(one.signed_volume, other.signed_volume, 1e-9 * dataset->grid.cell_count());
    }
    EXPECT_EQ(found->mesh.active_cells, mesh.active_cells);
  }
}

TEST(LayerBricks, BricksThatAreNotWantedHaveNoFacets) {
  const auto dataset = make_analytic("torus:40", {}, Task{});
  BrickMemory memory;
  const Interval interval{0.1, 0.2};
  const auto found = find_layer_bricks(dataset, dataset->arrays[0], {&interval, 1}, memory, 0, kNoLimit, Task{});
  ASSERT_TRUE(found);
  LayerBricks::Slab slab(*found->bricks);
  std::size_t left = 0, all = 0;
  for (std::int64_t z = 0; z < found->bricks->slabs(); ++z) {
    found->bricks->write(z, nullptr, slab);
    all += slab.mesh.facets.size();
    found->bricks->write(z, [](const Box3d& brick) { return brick.lower.x < -0.2; }, slab);
    left += slab.mesh.facets.size();
    for (const BoundaryFacet& facet : slab.mesh.facets)
      for (const std::uint32_t p : facet.points) EXPECT_LT(slab.mesh.positions[p].x, 0.25);
  }
  EXPECT_GT(left, all / 10);
  EXPECT_LT(left, all * 6 / 10);
}

TEST(LayerBricks, AreLeftToAMeshWhereThatIsSmallOrTheGridIsOfAnotherKind) {
  BrickMemory memory;
  const Interval interval{0.1, 0.2};
  const auto bricks_of = [&](const std::string& name, std::int64_t least) {
    const auto dataset = make_analytic(name, {}, Task{});
    return find_layer_bricks(dataset, dataset->arrays[0], {&interval, 1}, memory, least, kNoLimit, Task{}).has_value();
  };
  EXPECT_TRUE(bricks_of("torus:24", 0));
  EXPECT_FALSE(bricks_of("torus:24", 10'000'000));
  EXPECT_FALSE(bricks_of("tets:8", 0));
  EXPECT_FALSE(bricks_of("cylinder:12x16x8", 0)) << "an O-grid meets itself";
  const auto flat = dataset_of(uniform_grid({8, 8, 1}), point_array(std::vector<double>(64, 0.15)));
  EXPECT_FALSE(find_layer_bricks(flat, flat->arrays[0], {&interval, 1}, memory, 0, kNoLimit, Task{}));
}

}  // namespace
}  // namespace isostrata
