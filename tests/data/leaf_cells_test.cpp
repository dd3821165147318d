#include "import/adaptive/leaf_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "data/files.h"
#include "import/adaptive/level_weights.h"
#include "support/block_tree.h"

namespace isostrata {
namespace {

using test::BlockTree;
using test::block_tree;

ReadRequest request() {
  ReadRequest of;
  of.file = "/levels.vthb";
  of.max_bytes = std::uint64_t{1} << 30;
  return of;
}

struct Made {
  LevelLattice lattice;
  LeafCells leaves;
  Grid grid;
};

Made make(const LevelBoxes& levels) {
  Made made{lattice_of(levels, "levels"), {}, {}};
  made.leaves = leaf_cells(made.lattice, request());
  made.grid.shape = UnstructuredGrid{std::span<const Vec3d>(made.leaves.points), made.leaves.types, made.leaves.offsets, made.leaves.connectivity};
  return made;
}

struct Case {
  const char* name;
  BlockTree tree;
};

constexpr std::uint64_t kSeeds = 5;

const std::array<Case, 7> kSolid{{
    {"ratio 2, with parents", {}},
    {"ratio 2, leaves alone", {.parents = false}},
    {"ratio 3", {.roots = {2, 1, 1}, .ratio = 3, .depth = 2}},
    {"ratio 4, with parents", {.roots = {2, 1, 1}, .ratio = 4, .depth = 1}},
    {"ratio 4, leaves alone", {.roots = {1, 2, 1}, .ratio = 4, .depth = 2, .parents = false}},
    {"five levels", {.roots = {1, 2, 1}, .depth = 5}},
    {"one level", {.depth = 0}},
}};

const std::array<Case, 3> kFlat{{
    {"in x and y", {.roots = {3, 2, 0}, .depth = 4}},
    {"in y and z, ratio 3", {.roots = {0, 3, 2}, .ratio = 3}},
    {"in x and z, leaves alone", {.roots = {3, 0, 2}, .depth = 4, .parents = false}},
}};

double size_of_domain(const BlockTree& tree) {
  double size = 1;
  for (int axis = 0; axis < 3; ++axis)
    if (const std::int64_t roots = tree.roots[static_cast<std::size_t>(axis)]; roots > 0) size *= static_cast<double>(roots * tree.ratio) * tree.spacing[axis];
  return size;
}

std::vector<std::vector<std::int64_t>> faces_of(const Grid& grid, std::int64_t cell) {
  std::array<std::int64_t, kMaxCellVertices> ids{};
  const auto n = static_cast<std::size_t>(grid.cell_points(cell, ids));
  std::vector<std::vector<std::int64_t>> faces;
  if (is_flat(grid.cell_type(cell)))
    for (std::size_t i = 0; i < n; ++i) faces.push_back({ids[i], ids[(i + 1) % n]});
  else
    for (const CellFace& face : topology(grid.cell_type(cell)).faces) {
      faces.emplace_back();
      for (int v = 0; v < face.size; ++v) faces.back().push_back(ids[static_cast<std::size_t>(face.vertex[static_cast<std::size_t>(v)])]);
    }
  for (auto& face : faces) std::sort(face.begin(), face.end());
  return faces;
}

/// Every face between cells is a face of two of them; the others lie on the sides of the domain.
void expect_closed(const Made& made, const BlockTree& tree) {
  std::map<std::vector<std::int64_t>, int> uses;
  for (std::int64_t cell = 0; cell < made.grid.cell_count(); ++cell)
    for (auto& face : faces_of(made.grid, cell)) ++uses[face];
  std::int64_t inside = 0, shared = 0;
  for (const auto& [face, count] : uses) {
    ASSERT_LE(count, 2);
    if (count == 2) {
      ++shared;
      continue;
    }
    bool on_side = false;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t roots = tree.roots[static_cast<std::size_t>(axis)];
      const double lower = tree.origin[axis], upper = lower + static_cast<double>(roots * tree.ratio) * tree.spacing[axis];
      for (const double side : {lower, upper})
        on_side = on_side || (roots > 0 && std::all_of(face.begin(), face.end(), [&](std::int64_t id) { return std::abs(made.grid.point(id)[axis] - side) < 1e-12; }));
    }
    inside += !on_side;
  }
  EXPECT_EQ(inside, 0);
  EXPECT_GT(shared, 0);
}

TEST(LeafCells, FillTheDomainAndMeetFaceToFace) {
  for (const Case& of : kSolid)
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      SCOPED_TRACE(std::string(of.name) + ", seed " + std::to_string(seed));
      const Made made = make(block_tree(of.tree, seed));
      double sum = 0;
      for (std::int64_t cell = 0; cell < made.grid.cell_count(); ++cell) {
        const double volume = test::cell_volume(made.grid, cell);
        ASSERT_GT(volume, 0) << "cell " << cell;
        sum += volume;
      }
      EXPECT_NEAR(sum, size_of_domain(of.tree), 1e-12 * sum);
      expect_closed(made, of.tree);
      EXPECT_EQ(std::ssize(made.leaves.in_file), made.lattice.leaves);
    }
}

TEST(LeafCells, OfFlatLevelsFillThePlane) {
  for (const Case& of : kFlat)
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      SCOPED_TRACE(std::string(of.name) + ", seed " + std::to_string(seed));
      const Made made = make(block_tree(of.tree, seed));
      const int flat = made.lattice.flat_axis;
      double sum = 0;
      std::array<std::int64_t, kMaxCellVertices> ids{};
      for (std::int64_t cell = 0; cell < made.grid.cell_count(); ++cell) {
        const int n = made.grid.cell_points(cell, ids);
        double area = 0;
        for (int i = 1; i + 1 < n; ++i) {
          const Vec3d a = made.grid.point(ids[0]);
          area += cross(made.grid.point(ids[static_cast<std::size_t>(i)]) - a, made.grid.point(ids[static_cast<std::size_t>(i) + 1]) - a)[flat] / 2;
        }
        if (flat == 1) area = -area;  // x turns into z against y
        ASSERT_GT(area, 0) << "cell " << cell;
        sum += area;
      }
      EXPECT_NEAR(sum, size_of_domain(of.tree), 1e-12 * sum);
      expect_closed(made, of.tree);
    }
}

TEST(LeafCells, FarFromFinerOnesStayHexahedra) {
  // One cell of 5 x 5 x 5 in the middle is refined: the 18 that share a face or an edge with it are cut, the 8 at its corners are not.
  LevelBoxes levels{.boxes = {{{0, 0, 0}, {1, 1, 1}, {5, 5, 5}}, {{2, 2, 2}, {0.5, 0.5, 0.5}, {2, 2, 2}}}, .axes = {}};
  const Made made = make(levels);
  EXPECT_EQ(made.leaves.split, 18);
  const auto counts = count_cell_types(made.grid);
  EXPECT_EQ(counts.at("hexahedron"), 124 - 18 + 8);
  // A cell at a face of it: 4 small faces, one whole one, and 4 with a point in the middle of an edge. One at an edge: 4 whole ones and 2 with a point.
  EXPECT_EQ(counts.at("pyramid"), 6 * 5 + 12 * 4);
  EXPECT_EQ(counts.at("tetrahedron"), (6 * 4 + 12 * 2) * 5);
}

TEST(LeafCells, OfLargeBoxesAreTheSameAsOfTheirParts) {
  // More than one tile of 64 cells, beside the same cells as many boxes.
  LevelBoxes large{.boxes = {{{0, 0, 0}, {1, 1, 1}, {70, 3, 4}}, {{62, 0, 0}, {0.5, 0.5, 0.5}, {8, 4, 4}}}, .axes = {}}, parts = large;
  parts.boxes.erase(parts.boxes.begin());
  for (int i = 0; i < 70; ++i) parts.boxes.push_back({{static_cast<double>(i), 0, 0}, {1, 1, 1}, {1, 3, 4}});
  const Made a = make(large), b = make(parts);
  EXPECT_EQ(a.leaves.points.size(), b.leaves.points.size());
  EXPECT_EQ(count_cell_types(a.grid), count_cell_types(b.grid));
  EXPECT_EQ(a.leaves.split, b.leaves.split);
  EXPECT_GT(a.leaves.split, 0);
}

// ---- values -----------------------------------------------------------------------------------------------------------------------

TEST(LevelWeights, AreMeansThatKeepLinearFieldsWhereALevelMeetsTheNext) {
  std::size_t of_next = 0, of_others = 0, exact = 0, exact_of_others = 0;
  for (const auto& cases : {std::span<const Case>(kSolid), std::span<const Case>(kFlat)})
    for (const Case& of : cases)
      for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        SCOPED_TRACE(std::string(of.name) + ", seed " + std::to_string(seed));
        const Made made = make(block_tree(of.tree, seed));
        const PointWeights weights = level_weights(made.lattice, made.leaves);
        ASSERT_TRUE(std::is_sorted(weights.points.begin(), weights.points.end()));
        std::map<std::int64_t, Box3d> box_of_leaf;
        for (std::int64_t cell = 0; cell < made.grid.cell_count(); ++cell) {
          std::array<std::int64_t, kMaxCellVertices> ids{};
          for (int v = 0, n = made.grid.cell_points(cell, ids); v < n; ++v)
            box_of_leaf[made.leaves.source[static_cast<std::size_t>(cell)]].include(made.grid.point(ids[static_cast<std::size_t>(v)]));
        }
        for (std::size_t at = 0; at < weights.points.size(); ++at) {
          const Vec3d p = made.grid.point(weights.points[at]);
          double sum = 0, smallest = 1e9, largest = 0;
          Vec3d mean;
          for (std::size_t k = weights.first[at]; k < weights.first[at + 1]; ++k) {
            ASSERT_GT(weights.weights[k], 0);
            const Box3d& box = box_of_leaf.at(made.leaves.source[static_cast<std::size_t>(weights.cells[k])]);
            sum += weights.weights[k];
            mean = mean + (box.lower + box.upper) * (0.5 * weights.weights[k]);
            smallest = std::min(smallest, length(box.upper - box.lower));
            largest = std::max(largest, length(box.upper - box.lower));
          }
          ASSERT_NEAR(sum, 1, 1e-12);
          bool inside = true;
          for (int axis = 0; axis < 3; ++axis) {
            const std::int64_t roots = of.tree.roots[static_cast<std::size_t>(axis)];
            const double from = p[axis] - of.tree.origin[axis], width = static_cast<double>(roots * of.tree.ratio) * of.tree.spacing[axis];
            inside = inside && (roots == 0 || (from > 1e-9 && from < width - 1e-9));
          }
          if (!inside) continue;
          const bool next = largest < 1.01 * smallest * static_cast<double>(of.tree.ratio), keeps = length(mean - p) < 1e-9 * smallest;
          (next ? of_next : of_others) += 1;
          (next ? exact : exact_of_others) += keeps;
        }
      }
  EXPECT_GT(of_next, 5'000u);
  EXPECT_EQ(exact, of_next);
  EXPECT_GT(of_others, 1'000u);
  EXPECT_GT(exact_of_others, of_others * 3 / 4) << "the others do not lie between the middles of the leaves around them";
}

// ---- what is refused --------------------------------------------------------------------------------------------------------------

std::string refusal(const std::vector<LevelBox>& boxes) {
  try {
    lattice_of({.boxes = boxes, .axes = {}}, "x.vthb");
  } catch (const Error& error) {
    return error.what();
  }
  return "taken";
}

TEST(LevelLattice, RefusesBoxesThatMakeNoGrid) {
  const LevelBox root{{0, 0, 0}, {1, 1, 1}, {4, 4, 4}};
  const auto with = [&](Vec3d origin, Vec3d spacing, std::array<std::int64_t, 3> cells) { return refusal({root, {origin, spacing, cells}}); };
  const double nan = std::nan("");
  EXPECT_EQ(refusal({}), "x.vthb: has no boxes of cells");
  EXPECT_EQ(with({2, 0, 0}, {1, 1, 1}, {4, 4, 4}), "x.vthb: box 0 and box 1 are of one level and overlap");
  EXPECT_EQ(with({0.5, 0, 4}, {1, 1, 1}, {4, 4, 4}), "x.vthb: box 1 begins inside a cell of its own level");
  EXPECT_EQ(with({0.5, 0, 0}, {0.5, 0.5, 0.5}, {2, 2, 2}), "x.vthb: box 1 begins or ends inside a cell of the next coarser level");
  EXPECT_EQ(with({3, 0, 0}, {0.5, 0.5, 0.5}, {4, 2, 2}), "x.vthb: box 1 lies only in part on the next coarser level");
  EXPECT_EQ(with({0, 0, 0}, {0.5, 0.5, 1}, {2, 2, 2}), "x.vthb: its cells are refined by 1.000000 along z; expected a whole number of 2 or more, the same along all axes");
  EXPECT_EQ(with({0, 0, 0}, {0.4, 0.4, 0.4}, {2, 2, 2}), "x.vthb: its cells are refined by 2.500000 along x; expected a whole number of 2 or more, the same along all axes");
  EXPECT_EQ(with({0, 0, 4}, {1, 1, 2}, {4, 4, 4}), "x.vthb: box 1 has cells of another shape than box 0, which are as long along x");
  EXPECT_EQ(with({0, 0, 0}, {0.5, 0.5, 0.5}, {2, -2, 2}), "x.vthb: box 1 has -2 cells along y");
  EXPECT_EQ(with({0, 0, 0}, {0.5, 0.5, 0.5}, {2, 2, 0}), "x.vthb: box 1 has 0 cells along z");
  EXPECT_EQ(with({nan, 0, 0}, {0.5, 0.5, 0.5}, {2, 2, 2}), "x.vthb: box 1 has no finite place and size");
  EXPECT_EQ(with({0, 0, 0}, {-0.5, 0.5, 0.5}, {2, 2, 2}), "x.vthb: box 1 has no finite place and size");
  EXPECT_EQ(with({1e300, 0, 0}, {1, 1, 1}, {2, 2, 2}), "x.vthb: box 1 lies too far from the others for cells so small");
  EXPECT_EQ(with({4, 0, 0}, {1, 1, 1}, {std::int64_t{1} << 40, 1 << 30, 1 << 30}), "x.vthb: box 1: a size of 1073741824 makes no sense");
  // Two levels finer, with cells of the level in between beside it.
  EXPECT_EQ(refusal({root, {{0, 0, 0}, {0.5, 0.5, 0.5}, {2, 2, 2}}, {{1, 0, 0}, {0.25, 0.25, 0.25}, {4, 4, 4}}}), "x.vthb: box 2 lies only in part on the next coarser level");
  EXPECT_EQ(with({4, 0, 0}, {0.5, 0.5, 0.5}, {2, 2, 2}), "taken") << "a finer box may lie beside the coarser ones";
}

TEST(LeafCells, SayThatTheyAreTooManyBeforeTheyTakeMemory) {
  ReadRequest of = request();
  const LevelLattice lattice = lattice_of({.boxes = {{{0, 0, 0}, {1, 1, 1}, {2000, 2000, 2000}}}, .axes = {}}, "x.vthb");
  try {
    leaf_cells(lattice, of);
    ADD_FAILURE() << "was made";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::too_large);
  }
}

}  // namespace
}  // namespace isostrata
