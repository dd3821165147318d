#include "data/dataset/analytic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "data/files.h"

namespace isostrata {
namespace {

std::shared_ptr<const Dataset> make(std::string_view name, int step = 0) {
  OpenOptions options;
  options.step = step;
  return make_analytic(name, options, Task());
}

ErrorCode refused(std::string_view name, const OpenOptions& options = {}) {
  try {
    make_analytic(name, options, Task());
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(std::string(name.substr(0, name.find(':')))), std::string::npos) << error.what();
    return error.code();
  }
  ADD_FAILURE() << name << " was made";
  return ErrorCode::internal;
}

TEST(Analytic, SphereIsTheDistanceToTheOrigin) {
  const auto data = make("sphere:9");
  EXPECT_EQ(data->grid.point_count(), 729);
  const PointArray& distance = data->array("distance");
  for (std::int64_t id = 0; id < 729; ++id)
    EXPECT_FLOAT_EQ(static_cast<float>(distance.at(static_cast<std::size_t>(id))),
                    static_cast<float>(length(data->grid.point(id))));
  EXPECT_EQ(distance.lower, 0);
  EXPECT_FLOAT_EQ(static_cast<float>(distance.upper), std::sqrt(3.0f));
}

TEST(Analytic, TorusIsTheLeastDistanceToItsCircle) {
  const auto data = make("torus:13");
  const PointArray& distance = data->array("distance");
  for (std::int64_t id = 0; id < data->grid.point_count(); ++id) {
    const Vec3d p = data->grid.point(id);
    double least = 10;
    for (int step = 0; step < 3600; ++step) {
      const double angle = 2 * M_PI * step / 3600;
      least = std::min(least, length(p - Vec3d{0.6 * std::cos(angle), 0.6 * std::sin(angle), 0}));
    }
    EXPECT_NEAR(distance.at(static_cast<std::size_t>(id)), least, 1e-3) << id;
  }
}

TEST(Analytic, FieldsHaveTheGridsSymmetriesToTheLastBit) {
  const auto data = make("torus:10");
  const PointArray& distance = data->array("distance");
  for (std::size_t k = 0; k < 10; ++k)
    for (std::size_t j = 0; j < 10; ++j)
      for (std::size_t i = 0; i < 10; ++i) {
        EXPECT_EQ(distance.at(i + 10 * (j + 10 * k)), distance.at((9 - i) + 10 * (j + 10 * k)));
        EXPECT_EQ(distance.at(i + 10 * (j + 10 * k)), distance.at(j + 10 * (i + 10 * k)));
      }
}

TEST(Analytic, MarschnerLobbStaysWithinZeroAndOne) {
  const auto data = make("marschner-lobb:41");
  const PointArray& rho = data->array("rho");
  EXPECT_GE(rho.lower, 0.0);
  EXPECT_LE(rho.upper, 1.0);
  EXPECT_GT(rho.upper - rho.lower, 0.8);
  EXPECT_NEAR(marschner_lobb({0, 0, 0}), (1 + 0.25 * 2) / 2.5, 1e-12);  // cos(2 pi 6) = 1
}

/// How often each face occurs: as its sorted corners.
std::map<std::vector<std::int64_t>, int> count_faces(const Grid& grid) {
  static const std::map<CellType, std::vector<std::vector<std::size_t>>> kFaces{
      {CellType::tetrahedron, {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}},
      {CellType::pyramid, {{0, 1, 2, 3}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}},
      {CellType::wedge, {{0, 1, 2}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}},
      {CellType::hexahedron, {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}}};
  std::map<std::vector<std::int64_t>, int> counts;
  std::array<std::int64_t, kMaxCellVertices> ids{};
  for (std::int64_t cell = 0; cell < grid.cell_count(); ++cell) {
    grid.cell_points(cell, ids);
    for (const auto& face : kFaces.at(grid.cell_type(cell))) {
      std::vector<std::int64_t> corners;
      for (const std::size_t v : face) corners.push_back(ids[v]);
      std::sort(corners.begin(), corners.end());
      ++counts[corners];
    }
  }
  return counts;
}

void expect_conforming(const Dataset& data, int n) {
  const auto faces = count_faces(data.grid);
  for (const auto& [corners, count] : faces) {
    bool outside = false;
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-1.0, 1.0})
        outside = outside ||
                  std::all_of(corners.begin(), corners.end(), [&](std::int64_t id) { return data.grid.point(id)[axis] == side; });
    ASSERT_EQ(count, outside ? 1 : 2) << data.name << ", " << n << ": a face of " << corners.size() << " corners at point "
                                      << corners[0];
  }
}

TEST(Analytic, TetrahedraConformAndFillTheCube) {
  for (const int n : {2, 3, 6}) {
    const auto data = make("tets:" + std::to_string(n));
    EXPECT_EQ(data->grid.cell_count(), 6 * (n - 1) * (n - 1) * (n - 1));
    expect_conforming(*data, n);
    double volume = 0;
    for (std::int64_t cell = 0; cell < data->grid.cell_count(); ++cell) {
      const double one = test::cell_volume(data->grid, cell);
      EXPECT_GT(one, 0) << cell;
      volume += one;
    }
    EXPECT_NEAR(volume, 8, 1e-6);
  }
}

TEST(Analytic, MixedCellsConformHaveAllFourTypesAndFillTheCube) {
  for (const int n : {5, 6, 7, 8, 9, 12}) {
    const auto data = make("mixed:" + std::to_string(n));
    EXPECT_EQ(data->cell_types.size(), 4u) << n;
    expect_conforming(*data, n);
    double volume = 0;
    for (std::int64_t cell = 0; cell < data->grid.cell_count(); ++cell) {
      const double one = test::cell_volume(data->grid, cell);
      EXPECT_GT(one, 0) << "n " << n << ", cell " << cell << " of type " << static_cast<int>(data->grid.cell_type(cell));
      volume += one;
    }
    EXPECT_NEAR(volume, 8, 1e-5) << n;
  }
}

TEST(Analytic, CylinderIsARingAroundATaperedBodyWithASeam) {
  const auto data = make("cylinder:17x9x5");
  EXPECT_STREQ(data->grid.kind_name(), "curvilinear");
  EXPECT_EQ(data->grid.dims(), (std::array<std::int64_t, 3>{17, 9, 5}));
  for (std::int64_t row = 0; row < 9 * 5; ++row) EXPECT_EQ(data->grid.point(17 * row), data->grid.point(17 * row + 16));
  const Vec3d root = data->grid.point(0), tip = data->grid.point(17 * 9 * 4);
  EXPECT_GT(root.x, tip.x);
  for (std::int64_t cell = 0; cell < data->grid.cell_count(); ++cell) EXPECT_NE(test::cell_volume(data->grid, cell), 0) << cell;
}

TEST(Analytic, CylinderSlowsToRestOnTheBodyAndItsDensityIsNearOne) {
  const auto data = make("cylinder");
  EXPECT_EQ(data->grid.dims(), (std::array<std::int64_t, 3>{64, 64, 32}));
  const PointArray& density = data->array("Density");
  EXPECT_GT(density.lower, 0.9);
  EXPECT_LT(density.upper, 1.05);
  EXPECT_LT(density.lower, 0.9934);
  EXPECT_GT(density.upper, 0.9944);
  const PointArray& momentum = data->array("Momentum");
  for (std::size_t k = 0; k < 32; ++k)
    for (std::size_t i = 0; i < 64; ++i) EXPECT_LT(momentum.at(i + 64 * 64 * k), 1e-6);
  for (const char* name : {"Momentum_x", "Momentum_y", "Momentum_z"}) EXPECT_EQ(data->array(name).components, 3) << name;
  for (std::size_t p = 0; p < 5000; ++p) {
    const Vec3d m{data->array("Momentum_x").at(p), data->array("Momentum_y").at(p), data->array("Momentum_z").at(p)};
    EXPECT_NEAR(momentum.at(p), length(m), 1e-5);
  }
}

TEST(Analytic, CylinderShedsPeriodically) {
  const auto start = make("cylinder:16x8x4x21"), later = make("cylinder:16x8x4x21", 5), period = make("cylinder:16x8x4x21", 20);
  ASSERT_EQ(start->times.size(), 21u);
  EXPECT_TRUE(std::is_sorted(start->times.begin(), start->times.end()));
  double moved = 0, returned = 0;
  for (std::size_t p = 0; p < 16 * 8 * 4; ++p) {
    moved = std::max(moved, std::abs(start->array("Density").at(p) - later->array("Density").at(p)));
    returned = std::max(returned, std::abs(start->array("Density").at(p) - period->array("Density").at(p)));
  }
  EXPECT_GT(moved, 1e-3);
  EXPECT_LT(returned, 1e-5);
}

TEST(Analytic, ComesOutTheSameEveryTime) {
  const auto a = make("cylinder:32x16x8"), b = make("cylinder:32x16x8");
  for (std::size_t p = 0; p < 32 * 16 * 8; ++p) ASSERT_EQ(a->array("Energy").at(p), b->array("Energy").at(p));
}

TEST(Analytic, RefusesSizesThatMakeNoSense) {
  for (const char* name : {"torus:", "torus:x", "torus:1", "torus:-4", "torus:0", "torus:8x8", "torus:8.5", "mixed:4", "tets:1",
                           "cylinder:8x8", "cylinder:3x8x8", "cylinder:8x8x8x0", "cylinder:8x8x8x8x8", "sphere:12 "})
    EXPECT_EQ(refused(name), ErrorCode::invalid_argument) << name;
  for (const char* name : {"torus:100000", "torus:99999999999999999999", "tets:5000", "cylinder:9000x8x8", "mixed:1025"})
    EXPECT_EQ(refused(name), ErrorCode::too_large) << name;
}

TEST(Analytic, RespectsTheMemoryBudget) {
  OpenOptions options;
  options.max_bytes = 1000000;
  EXPECT_EQ(refused("torus:64", options), ErrorCode::too_large);
  EXPECT_EQ(refused("tets:32", options), ErrorCode::too_large);
  EXPECT_EQ(refused("mixed:32", options), ErrorCode::too_large);
  EXPECT_EQ(refused("cylinder", options), ErrorCode::too_large);
  EXPECT_NO_THROW(make_analytic("torus:62", options, Task()));
}

TEST(Analytic, HasNoStepsThatAreNotThere) {
  OpenOptions options;
  options.step = 1;
  EXPECT_EQ(refused("torus:8", options), ErrorCode::not_found);
  EXPECT_EQ(refused("cylinder:8x8x8", options), ErrorCode::not_found);
  options.step = -1;
  EXPECT_EQ(refused("cylinder:8x8x8x3", options), ErrorCode::not_found);
}

TEST(Analytic, StopsWhenCancelled) {
  Task task;
  task.cancel();
  for (const char* name : {"torus:64", "tets:16", "mixed:9", "cylinder:16x16x16"}) {
    try {
      make_analytic(name, {}, task);
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::cancelled) << name;
    }
  }
}

TEST(Dataset, ListsItsArraysWhenOneIsMissing) {
  try {
    make("cylinder:8x8x8")->array("Pressure");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::not_found);
    EXPECT_NE(std::string(error.what()).find("Density, Momentum"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace isostrata
