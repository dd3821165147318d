// Extraction on a device against extraction on the CPU, by llvmpipe.
#include "rendering/gl_extraction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "base/error.h"
#include "extraction/iso_rules.h"
#include "extraction/small_grids.h"
#include "rendering/gl_compute.h"

namespace isostrata {
namespace {

using ::testing::HasSubstr;

GlExtraction& device() {
  static GlExtraction extraction("surfaceless");
  return extraction;
}

template <class T>
PointArray typed_array(const std::vector<T>& values) {
  PointArray array = point_array(values);
  array.type = static_cast<ScalarType>(array.values.index());
  return array;
}

struct Case {
  std::string name;
  Grid grid;
  PointArray array;
  std::vector<Interval> intervals;
};

/// A point of the mesh whatever its number: the grid edge it lies on and the isovalue, or the grid point (b == a).
using Origin = std::tuple<std::int64_t, std::int64_t, double>;
using TetrahedronKey = std::tuple<std::uint16_t, std::array<Origin, 4>>;

/// Equal for even permutations of the points.
TetrahedronKey tetrahedron_key(std::uint16_t interval, std::array<Origin, 4> p) {
  bool odd = false;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j + 1 < 4; ++j)
      if (p[j + 1] < p[j]) {
        std::swap(p[j], p[j + 1]);
        odd = !odd;
      }
  if (odd) std::swap(p[0], p[1]);
  return {interval, p};
}

std::vector<Origin> cpu_origins(const IntervalMesh& mesh) {
  std::vector<Origin> out;
  for (std::size_t i = 0; i < mesh.origins.size(); ++i) {
    const PointOrigin& o = mesh.origins[i];
    out.emplace_back(o.a, o.b, o.a == o.b ? 0.0 : mesh.values[i]);
  }
  return out;
}

std::vector<Origin> device_origins(const Case& c, const Task& task) {
  const IsoRules rules(c.intervals);
  const auto dims = c.grid.dims();
  const std::array<std::int64_t, 3> step{1, dims[0], dims[0] * dims[1]};
  const auto isovalues = static_cast<std::uint32_t>(rules.isovalues().size());
  std::vector<Origin> out;
  for (const auto& [point, slot] : device().read_origins(task)) {
    if (slot == 0)
      out.emplace_back(point, point, 0.0);
    else
      out.emplace_back(point, point + step[(slot - 1) / isovalues], rules.isovalues()[(slot - 1) % isovalues]);
  }
  return out;
}

std::vector<TetrahedronKey> sorted_keys(std::span<const std::array<std::uint32_t, 4>> tetrahedra,
                                        std::span<const std::uint16_t> intervals, std::span<const Origin> origins) {
  std::vector<TetrahedronKey> out;
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    const auto& p = tetrahedra[t];
    for (const std::uint32_t point : p)
      if (point >= origins.size()) {
        ADD_FAILURE() << "tetrahedron " << t << " names point " << point << " of " << origins.size();
        return {};
      }
    out.push_back(tetrahedron_key(intervals[t], {origins[p[0]], origins[p[1]], origins[p[2]], origins[p[3]]}));
  }
  std::sort(out.begin(), out.end());
  return out;
}

void expect_equal_records(const Case& c, const Task& task) {
  const IsoRules rules(c.intervals);
  auto expected = find_active_cells(c.grid, c.array, rules, std::uint64_t{1} << 30, task);
  const auto found = device().read_records(task);
  ASSERT_EQ(found.size(), expected.size()) << c.name;
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].cell, expected[i].cell) << c.name << ", record " << i;
    ASSERT_EQ(found[i].interval, expected[i].interval) << c.name << ", record " << i;
    ASSERT_EQ(found[i].case_index, expected[i].case_index) << c.name << ", record " << i;
  }
}

void expect_equal_meshes(const Case& c, const IntervalMesh& mesh, const Task& task) {
  const auto records = device().read_records(task);
  const auto first = device().read_first_tetrahedra(task);
  const auto tetrahedra = device().read_tetrahedra(task);
  const auto positions = device().read_positions(task);
  std::vector<std::uint16_t> intervals;
  for (std::size_t i = 0; i < records.size(); ++i)
    intervals.resize(i + 1 < records.size() ? first[i + 1] : tetrahedra.size(), records[i].interval);
  const std::vector<Origin> origins = device_origins(c, task), expected = cpu_origins(mesh);

  std::vector<Origin> a = origins, b = expected;
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  ASSERT_EQ(a, b) << c.name << ": points";
  ASSERT_EQ(sorted_keys(tetrahedra, intervals, origins), sorted_keys(mesh.tetrahedra, mesh.tetrahedron_interval, expected))
      << c.name << ": tetrahedra";

  const Vec3d anchor = device().buffers().anchor;
  const double size = c.grid.bounds().diagonal(), tolerance = 1e-6 * size;
  std::map<Origin, std::size_t> number;
  for (std::size_t i = 0; i < expected.size(); ++i) number[expected[i]] = i;
  for (std::size_t i = 0; i < origins.size(); ++i) {
    const std::size_t j = number.at(origins[i]);
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_NEAR(static_cast<double>(positions[i][axis]) + anchor[axis], mesh.positions[j][axis], tolerance) << c.name;
    ASSERT_EQ(positions[i][3], static_cast<float>(mesh.values[j])) << c.name;
  }
  std::vector<double> volumes(c.intervals.size());
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    std::array<Vec3d, 4> p;
    for (int v = 0; v < 4; ++v)
      p[v] = {positions[tetrahedra[t][v]][0], positions[tetrahedra[t][v]][1], positions[tetrahedra[t][v]][2]};
    volumes[intervals[t]] += orient3d(p[0], p[1], p[2], p[3]) / 6;
  }
  for (std::size_t i = 0; i < volumes.size(); ++i)
    EXPECT_NEAR(volumes[i], mesh.summaries[i].signed_volume, 1e-5 * std::max(grid_volume(c.grid), 1e-300)) << c.name << ", interval " << i;
}

void expect_equal(const Case& c, GlExtent extent = GlExtent::tetrahedra) {
  const Task task;
  device().load(c.grid, c.array, task);
  const GlCounts counts = device().extract(c.intervals, extent, task);
  const IntervalMesh mesh = extract(c.grid, c.array, c.intervals);
  EXPECT_EQ(counts.cells, mesh.cells) << c.name;
  EXPECT_EQ(counts.active_cells, mesh.active_cells) << c.name;
  EXPECT_EQ(counts.tetrahedra, static_cast<std::int64_t>(mesh.tetrahedra.size())) << c.name;
  for (std::size_t i = 0; i < c.intervals.size(); ++i) {
    EXPECT_EQ(counts.intervals[i].active_cells, mesh.summaries[i].active_cells) << c.name << ", interval " << i;
    EXPECT_EQ(counts.intervals[i].tetrahedra, mesh.summaries[i].tetrahedra) << c.name << ", interval " << i;
  }
  expect_equal_records(c, task);
  if (extent == GlExtent::records || ::testing::Test::HasFatalFailure()) return;
  EXPECT_EQ(counts.points, static_cast<std::int64_t>(mesh.positions.size())) << c.name;
  expect_equal_meshes(c, mesh, task);
}

std::int64_t product(const std::array<std::int64_t, 3>& dims) { return dims[0] * dims[1] * dims[2]; }

template <class T>
void expect_equal_for_type(const char* type, double lower, double upper, const std::vector<Interval>& intervals) {
  for (const std::uint64_t seed : {1u, 2u}) {
    std::mt19937_64 random(seed);
    const std::array<std::int64_t, 3> dims =
        seed == 1 ? std::array<std::int64_t, 3>{11, 9, 10} : std::array<std::int64_t, 3>{18, 5, 3};
    Case c{std::string(type) + ", seed " + std::to_string(seed), uniform_grid(dims, {3, -2, 1}, {0.5, 1, 2}),
           typed_array(random_values<T>(product(dims), lower, upper, random)), intervals};
    expect_equal(c);
  }
}

TEST(GlExtraction, EqualsTheCpuForEveryTypeOfBytesAndHalves) {
  expect_equal_for_type<std::uint8_t>("uint8", 0, 256, {{0, 100}, {100, 255}, {254.5, 300}});
  expect_equal_for_type<std::int8_t>("int8", -128, 128, {{-128, -127}, {-20.5, 30}, {-1e9, -128}});
  expect_equal_for_type<std::uint16_t>("uint16", 0, 65536, {{1000, 30000}, {20000.2, 40000}});
  expect_equal_for_type<std::int16_t>("int16", -32768, 32768, {{-100, 20000}, {32767, 32768}});
}

TEST(GlExtraction, EqualsTheCpuForEveryTypeOfWords) {
  expect_equal_for_type<std::uint32_t>("uint32", 0, 4294967296.0, {{0, 2e9}, {4294967295.0, 5e9}, {-3, -1}});
  expect_equal_for_type<std::int32_t>("int32", -2147483648.0, 2147483648.0, {{-1e9, 3}, {2147483647.0, 3e9}, {-3e9, -2147483648.0}});
  expect_equal_for_type<float>("float32", -1, 1, {{-0.5, 0.25}, {0.25, 0.75}});
  expect_equal_for_type<double>("float64", -1, 1, {{-0.5, 0.25}, {0.1, 0.75}});
  expect_equal_for_type<std::int64_t>("int64", -1e18, 1e18, {{-5e17, 0}, {0, 9e17}});
  expect_equal_for_type<std::uint64_t>("uint64", 0, 1e19, {{1e18, 5e18}});
}

}  // namespace
}  // namespace isostrata
