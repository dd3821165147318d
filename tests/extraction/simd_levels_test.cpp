// One mesh, whatever the processor.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>
#include <limits>

#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "extraction/small_grids.h"
#include "support/simd_levels.h"

namespace isostrata {
namespace {

template <class T>
std::string bytes_of(const T& items) {
  return {reinterpret_cast<const char*>(items.data()), items.size() * sizeof items[0]};
}

/// All that a mesh is made of, bit by bit.
std::vector<std::string> bits_of(const IntervalMesh& mesh) {
  std::vector<std::string> bits{bytes_of(mesh.positions),  bytes_of(mesh.origins),
                                bytes_of(mesh.values),     bytes_of(mesh.tetrahedra),
                                bytes_of(mesh.tetrahedron_interval)};
  std::string runs, facets, sums;
  for (const CellRun& run : mesh.cell_runs)
    runs += std::to_string(run.cell) + "," + std::to_string(run.first_tetrahedron) + ";";
  for (const BoundaryFacet& facet : mesh.facets) {
    for (const std::uint32_t point : facet.points) facets += std::to_string(point) + ",";
    facets += std::to_string(facet.tetrahedron) + "," + std::to_string(facet.interval) + "," +
              std::to_string(static_cast<int>(facet.label)) + "," + std::to_string(facet.range) + ";";
  }
  for (const IntervalSummary& summary : mesh.summaries) {
    char text[200];
    std::snprintf(text, sizeof text, "%a %a %lld %lld %lld;", summary.volume, summary.signed_volume,
                  static_cast<long long>(summary.active_cells), static_cast<long long>(summary.tetrahedra),
                  static_cast<long long>(summary.inverted));
    sums += text;
  }
  bits.insert(bits.end(), {runs, facets, sums});
  return bits;
}

void expect_one_mesh(const Grid& grid, const PointArray& array, const std::vector<Interval>& intervals, const std::string& what) {
  ExtractOptions options;
  options.facets = options.measure = true;
  std::vector<std::string> first;
  testing::with_each_simd_level([&](const std::string&) {
    const IntervalMesh mesh = extract_intervals(grid, array, intervals, options, Task{});
    EXPECT_GT(mesh.tetrahedra.size(), 100u) << what;
    const std::vector<std::string> bits = bits_of(mesh);
    if (first.empty()) first = bits;
    ASSERT_EQ(bits.size(), first.size());
    for (std::size_t part = 0; part < bits.size(); ++part) EXPECT_TRUE(bits[part] == first[part]) << what << ", part " << part;
  });
}

TEST(SimdLevels, GiveTheSameMeshBitByBit) {
  for (const char* name : {"torus:21", "cylinder:14x11x9", "tets:9", "mixed:8"}) {
    const auto dataset = make_analytic(name, {}, Task{});
    const PointArray& array = dataset->arrays[0];
    const double span = array.upper - array.lower;
    expect_one_mesh(dataset->grid, array,
                    {{array.lower + 0.2 * span, array.lower + 0.41 * span}, {array.lower + 0.41 * span, array.upper}}, name);
  }
}

template <class T>
void expect_one_mesh_of_type(const char* what) {
  std::mt19937_64 random(11);
  const Grid grid = uniform_grid({19, 10, 12}, {-1, 2, 0.5}, {0.3, 0.25, 2});
  auto values = random_values<T>(grid.point_count(), 0, 5.999, random);
  if constexpr (std::is_floating_point_v<T>) values[700] = std::numeric_limits<T>::quiet_NaN();
  expect_one_mesh(grid, point_array(values), {{1, 2}, {2, 4}}, what);
}

TEST(SimdLevels, GiveTheSameMeshOfEveryTypeWithTiesAndMissingValues) {
  expect_one_mesh_of_type<std::int8_t>("int8");
  expect_one_mesh_of_type<std::uint8_t>("uint8");
  expect_one_mesh_of_type<std::int16_t>("int16");
  expect_one_mesh_of_type<std::uint16_t>("uint16");
  expect_one_mesh_of_type<std::int32_t>("int32");
  expect_one_mesh_of_type<std::uint32_t>("uint32");
  expect_one_mesh_of_type<std::int64_t>("int64");
  expect_one_mesh_of_type<std::uint64_t>("uint64");
  expect_one_mesh_of_type<float>("float32");
  expect_one_mesh_of_type<double>("float64");
}

}  // namespace
}  // namespace isostrata
