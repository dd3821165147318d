#include "extraction/surfaces/base_tetrahedra.h"

#include <gtest/gtest.h>

#include <random>

#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/surfaces/interval_surfaces.h"

namespace isostrata {
namespace {

constexpr std::uint64_t kBytes = std::uint64_t{1} << 30;

/// One tetrahedron after the other along x, none sharing points, with the values that are given; every second one mirrored where
/// asked for.
std::shared_ptr<const Dataset> tetrahedra(const std::vector<std::array<float, 4>>& values, bool mirror = false) {
  struct Storage {
    std::vector<Vec3f> points;
    std::vector<std::uint8_t> types;
    std::vector<std::int64_t> offsets{0}, connectivity;
    std::vector<float> values;
  };
  auto storage = std::make_shared<Storage>();
  for (std::size_t t = 0; t < values.size(); ++t) {
    const auto x = static_cast<float>(2 * t);
    const auto first = static_cast<std::int64_t>(4 * t);
    storage->points.insert(storage->points.end(), {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}, {x, 0, 1}});
    storage->values.insert(storage->values.end(), values[t].begin(), values[t].end());
    const bool turned = mirror && t % 2 == 1;
    storage->connectivity.insert(storage->connectivity.end(),
                                 {first, first + 1, first + (turned ? 3 : 2), first + (turned ? 2 : 3)});
    storage->types.push_back(static_cast<std::uint8_t>(CellType::tetrahedron));
    storage->offsets.push_back(first + 4);
  }
  auto dataset = std::make_shared<Dataset>();
  dataset->name = "tetrahedra";
  dataset->grid.shape =
      UnstructuredGrid{std::span<const Vec3f>(storage->points), storage->types, storage->offsets, storage->connectivity};
  dataset->grid.storage = storage;
  dataset->bounds = dataset->grid.bounds();
  dataset->cell_types = count_cell_types(dataset->grid);
  PointArray array;
  array.name = "f";
  array.values = std::span<const float>(storage->values);
  array.storage = storage;
  measure_range(array);
  dataset->arrays.push_back(std::move(array));
  return dataset;
}

/// What the closed surfaces around each interval hold, by the divergence theorem.
std::vector<double> enclosed(const IntervalMesh& mesh) {
  std::vector<double> volumes(mesh.summaries.size());
  for (const BoundaryFacet& facet : mesh.facets) {
    const Vec3d &a = mesh.positions[facet.points[0]], &b = mesh.positions[facet.points[1]], &c = mesh.positions[facet.points[2]];
    volumes[facet.interval] += dot(a, cross(b, c)) / 6;
  }
  return volumes;
}

void expect_as_extracted(const Dataset& dataset, const std::vector<Interval>& intervals) {
  const PointArray& array = dataset.arrays[0];
  const auto base = make_base_tetrahedra(dataset, array.name, kBytes, Task{});
  const IntervalMesh mesh = extract_intervals(dataset.grid, array, intervals, {}, Task{});
  const auto sums = measure_intervals(*base, intervals);
  const IntervalMesh surfaces = interval_surfaces(*base, intervals);
  const std::vector<double> volumes = enclosed(surfaces);
  ASSERT_EQ(sums.size(), intervals.size());
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const double volume = mesh.summaries[i].volume;
    EXPECT_EQ(sums[i].active_cells, mesh.summaries[i].active_cells) << dataset.name << " interval " << i;
    EXPECT_EQ(surfaces.summaries[i].active_cells, mesh.summaries[i].active_cells) << dataset.name << " interval " << i;
    EXPECT_NEAR(sums[i].volume, volume, 1e-6 * volume + 1e-9) << dataset.name << " interval " << i;
    EXPECT_NEAR(volumes[i], volume, 1e-6 * volume + 1e-9) << dataset.name << " interval " << i;
  }
}

TEST(BaseTetrahedra, IntervalsHoldWhatExtractionSaysAndTheirSurfacesEncloseIt) {
  const auto dataset = make_analytic("tets:9", {}, Task{});
  const double lower = dataset->arrays[0].lower, span = dataset->arrays[0].upper - lower;
  const auto at = [&](double share) { return lower + share * span; };
  expect_as_extracted(*dataset, {{at(0.2), at(0.3)}});
  expect_as_extracted(*dataset, {{at(0.2), at(0.3)}, {at(0.3), at(0.55)}, {at(0.7), at(1)}});
  expect_as_extracted(*dataset, {{at(-0.5), at(1.5)}});
  expect_as_extracted(*dataset, {{at(0.1), at(0.6)}, {at(0.3), at(0.4)}});
}

TEST(BaseTetrahedra, EndsThatLieOnValuesBelongWhereExtractionPutsThem) {
  std::mt19937 random(7);
  std::vector<std::array<float, 4>> values;
  for (int t = 0; t < 400; ++t) {
    std::array<float, 4> one{};
    for (float& f : one) f = static_cast<float>(random() % 4);
    values.push_back(one);
  }
  for (const bool mirror : {false, true}) {
    const auto dataset = tetrahedra(values, mirror);
    for (const std::vector<Interval>& intervals :
         {std::vector<Interval>{{1, 2}}, {{0, 1}, {1, 2}, {2, 3}}, {{1, 2}, {2, 2.5}}, {{0.5, 1}, {2, 3}}, {{-1, 0}, {3, 4}}})
      expect_as_extracted(*dataset, intervals);
  }
}

TEST(BaseTetrahedra, TheShareBelowAValueIsThatOfTheLinearField) {
  // Against counting points that are spread evenly.
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < 20; ++trial) {
    double f[4];
    for (double& v : f) v = unit(random);
    if (trial % 4 == 0) f[1] = f[2];
    if (trial % 5 == 0) f[0] = f[3];
    std::sort(std::begin(f), std::end(f));
    const double value = f[0] + (f[3] - f[0]) * unit(random);
    int below = 0;
    constexpr int kPoints = 20000;
    for (int i = 0; i < kPoints; ++i) {
      double cuts[3] = {unit(random), unit(random), unit(random)};
      std::sort(std::begin(cuts), std::end(cuts));
      below += f[0] * cuts[0] + f[1] * (cuts[1] - cuts[0]) + f[2] * (cuts[2] - cuts[1]) + f[3] * (1 - cuts[2]) < value;
    }
    EXPECT_NEAR(share_below(f, value), below / double{kPoints}, 0.02) << "trial " << trial;
  }
}

TEST(BaseTetrahedra, CellsWithoutAValueAreLeftOut) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto dataset = tetrahedra({{0, 1, 2, 3}, {0, 1, nan, 3}, {3, 2, 1, 0}});
  EXPECT_EQ(make_base_tetrahedra(*dataset, "f", kBytes, Task{})->mesh->tetrahedra.size(), 2u);
  expect_as_extracted(*dataset, {{0.5, 1.5}, {1.5, 3}});
}

TEST(BaseTetrahedra, OtherCellsAndTooLittleMemoryAreRefused) {
  const auto mixed = make_analytic("mixed:5", {}, Task{}), tets = make_analytic("tets:8", {}, Task{});
  EXPECT_FALSE(only_tetrahedra(*mixed));
  EXPECT_FALSE(only_tetrahedra(*make_analytic("torus:4", {}, Task{})));
  const auto code = [](const Dataset& dataset, std::uint64_t bytes) {
    try {
      make_base_tetrahedra(dataset, dataset.arrays[0].name, bytes, Task{});
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::internal;
  };
  EXPECT_EQ(code(*mixed, kBytes), ErrorCode::unsupported);
  EXPECT_EQ(code(*tets, base_tetrahedra_bytes(*tets) - 1), ErrorCode::too_large);
}

TEST(BaseTetrahedra, IntervalsThinnerThanSinglePrecisionTellsAreKnown) {
  const auto dataset = tetrahedra({{1e5f, 1e5f + 1, 1e5f + 2, 1e5f + 3}});
  const auto base = make_base_tetrahedra(*dataset, "f", kBytes, Task{});
  EXPECT_TRUE(resolves(*base, {1e5, 1e5 + 30}));
  EXPECT_FALSE(resolves(*base, {1e5, 1e5 + 1}));
}

}  // namespace
}  // namespace isostrata
