#include "data/derived/nearest_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "data/dataset/analytic.h"

namespace isostrata {
namespace {

std::shared_ptr<const Dataset> opened(const char* name) { return make_analytic(name, {}, Task()); }

double value_of(const CellValues& cells, std::int64_t cell) {
  return std::visit([&](auto values) { return static_cast<double>(values[static_cast<std::size_t>(cell)]); }, cells.values);
}

TEST(NearestPointCells, HaveTheValueOfTheNearestPointOfBoxes) {
  auto whole = std::make_shared<Dataset>(*opened("torus:9"));
  RectilinearGrid axes;
  axes.dims = {9, 9, 9};
  axes.axes = {{{0, 1, 1.5, 4, 4.25, 5, 6, 7, 9}, {3, 2, 0, -1, -1.5, -2, -2.5, -4, -5}, {0, 1, 2, 4, 8, 16, 17, 18, 20}}};
  for (const bool uneven : {false, true}) {
    if (uneven) whole->grid.shape = axes;
    const std::vector<std::string> names{whole->arrays.front().name};
    const auto made = nearest_point_cells(whole, names, 1 << 30, Task());
    ASSERT_EQ(made->grid.cell_count(), whole->grid.point_count());
    std::array<std::int64_t, kMaxCellVertices> ids{};
    for (std::int64_t cell = 0; cell < made->grid.cell_count(); ++cell) {
      made->grid.cell_points(cell, ids);
      const Vec3d middle = (made->grid.point(ids[0]) + made->grid.point(ids[6])) * 0.5;
      std::int64_t nearest = 0;
      for (std::int64_t p = 1; p < whole->grid.point_count(); ++p)
        if (length(whole->grid.point(p) - middle) < length(whole->grid.point(nearest) - middle)) nearest = p;
      ASSERT_EQ(value_of(*made->arrays.front().cells, cell), whole->arrays.front().at(static_cast<std::size_t>(nearest))) << "cell " << cell << (uneven ? ", uneven" : "");
    }
  }
}

TEST(NearestPointCells, OfOtherCellsArePiecesAtTheirPoints) {
  for (const char* name : {"mixed:5", "tets:4"}) {
    const auto whole = opened(name);
    const auto made = nearest_point_cells(whole, std::vector<std::string>{whole->arrays.front().name}, 1 << 30, Task());
    std::array<std::int64_t, kMaxCellVertices> ids{};
    std::int64_t corners = 0, tips = 0;
    for (std::int64_t c = 0; c < whole->grid.cell_count(); ++c) {
      corners += whole->grid.cell_points(c, ids);
      tips += whole->grid.cell_type(c) == CellType::pyramid;
    }
    EXPECT_EQ(made->grid.cell_count(), corners + 3 * tips) << name;  // the tip of a pyramid is cut into four
    std::set<double> values;
    for (std::int64_t cell = 0; cell < made->grid.cell_count(); ++cell) {
      const double value = value_of(*made->arrays.front().cells, cell);
      // The piece's first vertex is the point that it belongs to.
      made->grid.cell_points(cell, ids);
      bool found = false;
      for (std::int64_t p = 0; p < whole->grid.point_count() && !found; ++p)
        found = whole->grid.point(p) == made->grid.point(ids[0]) && whole->arrays.front().at(static_cast<std::size_t>(p)) == value;
      ASSERT_TRUE(found) << name << ", piece " << cell;
    }
  }
}

TEST(NearestPointCells, AreMadeOnceForAsLongAsSomebodyHoldsThem) {
  const auto whole = opened("torus:5");
  const std::vector<std::string> names{whole->arrays.front().name, whole->arrays.front().name};
  auto made = nearest_point_cells(whole, names, 1 << 30, Task());
  EXPECT_EQ(made->arrays.size(), 1u);
  EXPECT_EQ(nearest_point_cells(whole, names, 1 << 30, Task()), made);
  const std::weak_ptr<const Dataset> gone = made;
  made.reset();
  EXPECT_TRUE(gone.expired());
}

TEST(NearestPointCells, SayWhatIsTooLargeOrNotThere) {
  const auto whole = opened("mixed:5");
  EXPECT_THROW(nearest_point_cells(whole, std::vector<std::string>{whole->arrays.front().name}, 1000, Task()), Error);
  try {
    nearest_point_cells(whole, std::vector<std::string>{"pressure"}, 1 << 30, Task());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::not_found);
    EXPECT_NE(std::string(error.what()).find("pressure"), std::string::npos);
  }
}

}  // namespace
}  // namespace isostrata
