#include "data/grids/region_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <random>
#include <set>

#include "data/parts/take_region.h"
#include "support/field_dataset.h"

namespace isostrata {
namespace {

std::vector<std::shared_ptr<const Dataset>> grids() {
  const auto field = [](Vec3d p) { return p.x + 2 * p.y * p.z; };
  auto rising = testing::field_dataset({9, 7, 12}, field);
  auto falling = std::make_shared<Dataset>(*rising);
  RectilinearGrid axes{{9, 7, 12}, {}};
  for (int i = 0; i < 9; ++i) axes.axes[0].push_back(5 - i * i * 0.1);
  for (int i = 0; i < 7; ++i) axes.axes[1].push_back(i * 0.3);
  for (int i = 0; i < 12; ++i) axes.axes[2].push_back(-i);
  falling->grid.shape = axes;
  falling->bounds = falling->grid.bounds();
  auto held = std::make_shared<std::vector<Vec3d>>();
  for (std::int64_t p = 0; p < rising->grid.point_count(); ++p) {
    const Vec3d at = rising->grid.point(p);
    held->push_back({at.x + 0.1 * at.y * at.y, at.y + 0.05 * at.z, at.z});
  }
  auto bent = std::make_shared<Dataset>(*rising);
  bent->grid.shape = CurvilinearGrid{{9, 7, 12}, std::span<const Vec3d>(*held)};
  bent->grid.storage = held;
  testing::OwnedMesh mesh;
  mesh.points = *held;
  std::array<std::int64_t, kMaxCellVertices> ids;
  for (std::int64_t cell = 0; cell < bent->grid.cell_count(); cell += 1 + cell % 3) {
    const int n = bent->grid.cell_points(cell, ids);
    mesh.add(CellType::hexahedron, {ids.begin(), ids.begin() + n});
  }
  return {rising, falling, bent, testing::mesh_dataset(std::move(mesh), field)};
}

Vec3d corner(const Grid& grid, std::int64_t cell) {
  std::array<std::int64_t, kMaxCellVertices> ids;
  grid.cell_points(cell, ids);
  return grid.point(ids[0]);
}

TEST(RegionTree, EveryPointLiesInTheOneRegionWhoseBoxHoldsIt) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> at(-6, 6);
  for (const auto& dataset : grids())
    for (const int count : {1, 2, 3, 4, 7, 8}) {
      const RegionTree tree = make_regions(dataset->grid, count);
      ASSERT_EQ(region_count(tree), count);
      for (int i = 0; i < 200; ++i) {
        const Vec3d p{at(random), at(random), at(random)};
        int holders = 0;
        for (int region = 0; region < count; ++region) {
          const Box3d box = region_box(tree, region);
          bool inside = true;
          for (int a = 0; a < 3; ++a) inside = inside && p[a] >= box.lower[a] && p[a] < box.upper[a];
          holders += inside;
          EXPECT_EQ(inside, region_at(tree, p) == region);
        }
        EXPECT_EQ(holders, 1);
      }
    }
}

TEST(RegionTree, RegionsOfAGridOfBoxesHoldAboutAsManyCells) {
  for (const auto& dataset : grids()) {
    const RegionTree tree = make_regions(dataset->grid, 5);
    std::array<std::int64_t, 5> cells{};
    for (std::int64_t cell = 0; cell < dataset->grid.cell_count(); ++cell) {
      std::array<std::int64_t, kMaxCellVertices> ids;
      const int n = dataset->grid.cell_points(cell, ids);
      Box3d box;
      for (int v = 0; v < n; ++v) box.include(dataset->grid.point(ids[static_cast<std::size_t>(v)]));
      ++cells[static_cast<std::size_t>(region_at(tree, (box.lower + box.upper) * 0.5))];
    }
    for (const std::int64_t own : cells)
      EXPECT_NEAR(static_cast<double>(own), static_cast<double>(dataset->grid.cell_count()) / 5, 0.15 * static_cast<double>(dataset->grid.cell_count()));
  }
}

TEST(RegionTree, ARayMeetsRegionsInTheirOrder) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> at(-2, 2);
  for (const auto& dataset : grids()) {
    const RegionTree tree = make_regions(dataset->grid, 7);
    for (int ray = 0; ray < 300; ++ray) {
      const Vec3d eye{at(random), at(random), at(random)}, to{at(random), at(random), at(random)};
      const bool parallel = ray % 2 == 0;
      const std::vector<int> order = parallel ? front_to_back_along(tree, to - eye) : front_to_back(tree, eye);
      ASSERT_EQ(order.size(), 7u);
      std::ptrdiff_t last = 0;
      for (int step = 0; step <= 400; ++step) {
        const int region = region_at(tree, eye + (to - eye) * (step * 0.01));
        const std::ptrdiff_t place = std::find(order.begin(), order.end(), region) - order.begin();
        ASSERT_GE(place, last) << "seed 8, ray " << ray;
        last = place;
      }
    }
  }
}

TEST(RegionTree, MoreRegionsThanCellsLeaveSomeEmpty) {
  const auto one = testing::field_dataset({2, 2, 2}, [](Vec3d p) { return p.x; });
  const RegionTree tree = make_regions(one->grid, 5);
  EXPECT_EQ(region_count(tree), 5);
  int owned = 0;
  for (int region = 0; region < 5; ++region) {
    owned += region_at(tree, corner(one->grid, 0)) == region;
    EXPECT_EQ(take_region(*one, tree, region)->grid.cell_count(), 1);
  }
  EXPECT_EQ(owned, 1);
}

TEST(TakeRegion, EveryCellIsOwnedOnceAndHasItsBits) {
  for (const auto& dataset : grids()) {
    const RegionTree tree = make_regions(dataset->grid, 6);
    std::int64_t owned = 0;
    for (int region = 0; region < 6; ++region) {
      const auto part = take_region(*dataset, tree, region);
      EXPECT_LT(part->grid.cell_count(), dataset->grid.cell_count());
      EXPECT_EQ(part->arrays[0].lower, dataset->arrays[0].lower);
      EXPECT_EQ(part->arrays[0].upper, dataset->arrays[0].upper);
      EXPECT_EQ(part->bounds.lower, dataset->bounds.lower);
      std::map<std::array<double, 3>, std::pair<std::int64_t, double>> points;  // the whole's, by position
      for (std::int64_t p = 0; p < dataset->grid.point_count(); ++p) {
        const Vec3d at = dataset->grid.point(p);
        points[{at.x, at.y, at.z}] = {p, dataset->arrays[0].at(static_cast<std::size_t>(p))};
      }
      std::int64_t before = -1;
      for (std::int64_t p = 0; p < part->grid.point_count(); ++p) {
        const Vec3d at = part->grid.point(p);
        const auto found = points.find({at.x, at.y, at.z});
        ASSERT_NE(found, points.end()) << dataset->grid.kind_name();
        EXPECT_GT(found->second.first, before);  // local numbers rise with the whole's
        before = found->second.first;
        EXPECT_EQ(part->arrays[0].at(static_cast<std::size_t>(p)), found->second.second);
      }
      for (std::int64_t cell = 0; cell < part->grid.cell_count(); ++cell) owned += region_at(tree, corner(part->grid, cell)) == region;
    }
    EXPECT_EQ(owned, dataset->grid.cell_count()) << dataset->grid.kind_name();
  }
}

TEST(TakeRegion, TheMarginHasEveryNeighbourOfACellThatMeetsTheRegion) {
  for (const auto& dataset : grids()) {
    const RegionTree tree = make_regions(dataset->grid, 4);
    for (int region = 0; region < 4; ++region) {
      const Box3d box = region_box(tree, region);
      const auto part = take_region(*dataset, tree, region);
      std::set<std::array<double, 3>> near, in_part;  // corners of cells that reach into the region; first corners of the part's cells
      const auto key = [](const Vec3d& p) { return std::array<double, 3>{p.x, p.y, p.z}; };
      std::array<std::int64_t, kMaxCellVertices> ids;
      for (std::int64_t cell = 0; cell < part->grid.cell_count(); ++cell) in_part.insert(key(corner(part->grid, cell)));
      const auto corners = [&](std::int64_t cell) {
        std::vector<Vec3d> out;
        const int n = dataset->grid.cell_points(cell, ids);
        for (int v = 0; v < n; ++v) out.push_back(dataset->grid.point(ids[static_cast<std::size_t>(v)]));
        return out;
      };
      for (std::int64_t cell = 0; cell < dataset->grid.cell_count(); ++cell) {
        Box3d own;
        for (const Vec3d& p : corners(cell)) own.include(p);
        bool meets = true;
        for (int a = 0; a < 3; ++a) meets = meets && own.lower[a] < box.upper[a] && own.upper[a] > box.lower[a];
        if (meets)
          for (const Vec3d& p : corners(cell)) near.insert(key(p));
      }
      for (std::int64_t cell = 0; cell < dataset->grid.cell_count(); ++cell) {
        const auto all = corners(cell);
        const bool neighbour = std::any_of(all.begin(), all.end(), [&](const Vec3d& p) { return near.contains(key(p)); });
        EXPECT_TRUE(!neighbour || in_part.contains(key(corner(dataset->grid, cell)))) << dataset->grid.kind_name() << ", region " << region;
      }
    }
  }
}

}  // namespace
}  // namespace isostrata
