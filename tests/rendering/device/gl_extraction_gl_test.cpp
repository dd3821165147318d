// Extraction on a device against extraction on the CPU, by llvmpipe.
#include "rendering/device/gl_extraction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <tuple>

#include "base/error.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/small_grids.h"
#include "rendering/device/gl_extraction_mesh.h"
#include "support/test_device.h"

namespace isostrata {
namespace {

using testing::test_device;
using ::testing::HasSubstr;

GlExtraction& device() {
  static GlExtraction extraction(test_device());
  return extraction;
}

/// A budget of the device, for as long as this lives.
struct Budget {
  explicit Budget(std::uint64_t bytes, std::uint64_t largest_part = 0) { device().set_budget(bytes, largest_part); }
  ~Budget() { device().set_budget(0); }
};

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
    out.emplace_back(o.a(), o.b(), o.a() == o.b() ? 0.0 : mesh.values[i]);
  }
  return out;
}

std::vector<Origin> device_origins(const Case& c, const GlMeshParts& parts) {
  const IsoRules rules(c.intervals);
  const auto dims = c.grid.dims();
  const std::array<std::int64_t, 3> step{1, dims[0], dims[0] * dims[1]};
  const auto isovalues = static_cast<std::uint32_t>(rules.isovalues().size());
  std::vector<Origin> out;
  for (const auto& [point, slot] : parts.origins) {
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
  std::stable_sort(expected.begin(), expected.end(), [](const CellCase& a, const CellCase& b) { return a.cell < b.cell; });
  const auto found = device().read_records(task);
  ASSERT_EQ(found.size(), expected.size()) << c.name;
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].cell, expected[i].cell) << c.name << ", record " << i;
    ASSERT_EQ(found[i].interval, expected[i].interval) << c.name << ", record " << i;
    ASSERT_EQ(found[i].case_index, expected[i].case_index) << c.name << ", record " << i;
  }
}

void expect_equal_meshes(const Case& c, const IntervalMesh& mesh, const Task& task) {
  const GlMeshParts parts = device().read_mesh(task);
  const auto& tetrahedra = parts.tetrahedra;
  const auto positions = device().read_positions(task);
  std::vector<std::uint16_t> intervals;
  for (std::size_t i = 0; i < parts.records.size(); ++i)
    intervals.resize(i + 1 < parts.records.size() ? parts.first_tetrahedron[i + 1] : tetrahedra.size(),
                     static_cast<std::uint16_t>(parts.records[i].case_interval >> RECORD_INTERVAL_SHIFT));
  const std::vector<Origin> origins = device_origins(c, parts), expected = cpu_origins(mesh);

  std::vector<Origin> a = origins, b = expected;
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  ASSERT_EQ(a, b) << c.name << ": points";
  ASSERT_EQ(sorted_keys(tetrahedra, intervals, origins), sorted_keys(mesh.tetrahedra, mesh.tetrahedron_interval, expected))
      << c.name << ": tetrahedra";

  const Vec3d anchor = device().anchor();
  const double size = c.grid.bounds().diagonal(), tolerance = 1e-6 * size;
  std::map<Origin, std::size_t> number;
  for (std::size_t i = 0; i < expected.size(); ++i) number[expected[i]] = i;
  for (std::size_t i = 0; i < origins.size(); ++i) {
    const std::size_t j = number.at(origins[i]);
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_NEAR(static_cast<double>(positions[i][axis]) + anchor[axis], mesh.positions[j][axis], tolerance) << c.name;
    // A device may take what is too small for a whole mantissa for 0.
    const auto value = static_cast<float>(mesh.values[j]);
    if (positions[i][3] != 0 || std::abs(value) >= std::numeric_limits<float>::min()) {
      ASSERT_EQ(positions[i][3], value) << c.name;
    }
  }
  std::vector<double> volumes(c.intervals.size());
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
    std::array<Vec3d, 4> p;
    for (int v = 0; v < 4; ++v)
      p[v] = {positions[tetrahedra[t][v]][0], positions[tetrahedra[t][v]][1], positions[tetrahedra[t][v]][2]};
    volumes[intervals[t]] += orient3d(p[0], p[1], p[2], p[3]) / 6;
  }
  const Box3d bounds = c.grid.bounds();
  const Vec3d extent = bounds.empty() ? Vec3d{} : bounds.upper - bounds.lower;
  for (std::size_t i = 0; i < volumes.size(); ++i)
    EXPECT_NEAR(volumes[i], mesh.summaries[i].signed_volume, 1e-6 * extent.x * extent.y * extent.z)
        << c.name << ", interval " << i;
}

IntervalMesh extract_on_cpu(const Case& c) {
  const Task task;
  ExtractOptions options;
  options.values = options.measure = true;
  return extract_intervals(c.grid, c.array, c.intervals, options, task);
}

void expect_equal_counts(const Case& c, const GlCounts& counts, const IntervalMesh& mesh) {
  EXPECT_EQ(counts.cells, mesh.cells) << c.name;
  EXPECT_EQ(counts.active_cells, mesh.active_cells) << c.name;
  EXPECT_EQ(counts.tetrahedra, static_cast<std::int64_t>(mesh.tetrahedra.size())) << c.name;
  for (std::size_t i = 0; i < c.intervals.size(); ++i) {
    EXPECT_EQ(counts.intervals[i].active_cells, mesh.summaries[i].active_cells) << c.name << ", interval " << i;
    EXPECT_EQ(counts.intervals[i].tetrahedra, mesh.summaries[i].tetrahedra) << c.name << ", interval " << i;
  }
}

/// Loads and extracts on the device and compares everything with the CPU's.
GlCounts expect_equal(const Case& c) {
  const Task task;
  device().load(c.grid, c.array, task);
  const GlCounts counts = device().extract(c.intervals, GlExtent::tetrahedra, task);
  const IntervalMesh mesh = extract_on_cpu(c);
  expect_equal_counts(c, counts, mesh);
  EXPECT_EQ(counts.points, static_cast<std::int64_t>(mesh.positions.size())) << c.name;
  expect_equal_records(c, task);
  if (!::testing::Test::HasFailure()) expect_equal_meshes(c, mesh, task);
  return counts;
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
  expect_equal_for_type<std::int32_t>("int32", -2147483648.0, 2147483648.0,
                                      {{-1e9, 3}, {2147483647.0, 3e9}, {-3e9, -2147483648.0}});
  expect_equal_for_type<float>("float32", -1, 1, {{-0.5, 0.25}, {0.25, 0.75}});
  expect_equal_for_type<double>("float64", -1, 1, {{-0.5, 0.25}, {0.1, 0.75}});
  expect_equal_for_type<std::int64_t>("int64", -1e18, 1e18, {{-5e17, 0}, {0, 9e17}});
  expect_equal_for_type<std::uint64_t>("uint64", 0, 1e19, {{1e18, 5e18}});
}

/// A field of waves with a little noise: some bricks are active, some are not.
std::vector<float> waves(const std::array<std::int64_t, 3>& dims, double noise, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-noise, noise);
  std::vector<float> values;
  for (std::int64_t k = 0; k < dims[2]; ++k)
    for (std::int64_t j = 0; j < dims[1]; ++j)
      for (std::int64_t i = 0; i < dims[0]; ++i)
        values.push_back(static_cast<float>(std::sin(0.21 * static_cast<double>(i)) + std::cos(0.17 * static_cast<double>(j)) +
                                            0.05 * static_cast<double>(k) + uniform(random)));
  return values;
}

TEST(GlExtraction, EqualsTheCpuWhereThePointsAreAMultipleOfABrickOrOneMore) {
  for (const std::array<std::int64_t, 3>& dims :
       {std::array<std::int64_t, 3>{16, 8, 24}, {17, 9, 25}, {2, 2, 2}, {9, 2, 3}, {8, 8, 8}, {33, 31, 7}}) {
    std::mt19937_64 random(7);
    const Case c{"waves " + std::to_string(dims[0]) + "x" + std::to_string(dims[1]) + "x" + std::to_string(dims[2]),
                 uniform_grid(dims),
                 typed_array(waves(dims, 0.1, random)),
                 {{0.2, 0.6}}};
    expect_equal(c);
  }
}

TEST(GlExtraction, EqualsTheCpuForManyIntervalsThatTouchAndOverlap) {
  std::mt19937_64 random(11);
  const std::array<std::int64_t, 3> dims{19, 12, 10};
  const auto values = waves(dims, 0.3, random);
  expect_equal({"touching", uniform_grid(dims), typed_array(values), tiling({-1, -0.5, 0, 0.25, 0.5, 1.5})});
  expect_equal(
      {"overlapping, not in order", uniform_grid(dims), typed_array(values), {{0.4, 1}, {-1, 0.5}, {0.1, 0.2}, {-0.5, 2}}});
  std::vector<double> ends;
  for (int i = 0; i < 21; ++i) ends.push_back(-1 + 0.12 * i);
  expect_equal({"21 isovalues", uniform_grid(dims), typed_array(values), tiling(ends)});
}

TEST(GlExtraction, EqualsTheCpuForMoreIntervalsThanAWorkGroupCounts) {
  std::mt19937_64 random(12);
  const std::array<std::int64_t, 3> dims{12, 10, 9};
  std::vector<double> ends;
  for (int i = 0; i < 80; ++i) ends.push_back(-1 + 0.03 * i);
  const Case c{"80 isovalues", uniform_grid(dims), typed_array(waves(dims, 0.3, random)), tiling(ends)};
  const Task task;
  device().load(c.grid, c.array, task);
  expect_equal_counts(c, device().extract(c.intervals, GlExtent::records, task), extract_on_cpu(c));
  expect_equal_records(c, task);
  try {
    device().extract(c.intervals, GlExtent::tetrahedra, task);
    FAIL() << "80 isovalues";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::unsupported);
    EXPECT_THAT(error.what(), HasSubstr("80 distinct ends"));
    EXPECT_THAT(error.what(), HasSubstr("on the CPU"));
  }
}

TEST(GlExtraction, EqualsTheCpuWhereValuesLieOnIsovaluesAndArePlusOrMinusZero) {
  std::mt19937_64 random(13);
  const std::array<std::int64_t, 3> dims{10, 9, 11};
  std::uniform_int_distribution<int> pick(0, 5);
  const std::array<float, 6> choices{-0.0f, 0.0f, 0.5f, 1.0f, -0.5f, std::numeric_limits<float>::denorm_min()};
  std::vector<float> values(product(dims));
  for (float& value : values) value = choices[pick(random)];
  expect_equal({"float", uniform_grid(dims), typed_array(values), {{0, 0.5}, {0.5, 1}}});
  expect_equal({"float, closed above", uniform_grid(dims), typed_array(values), {{-0.5, -0.0}, {0.1, 0.5}}});
  std::vector<double> doubles(values.begin(), values.end());
  doubles[5] = std::numeric_limits<double>::denorm_min();
  doubles[7] = 1.7e308;
  doubles[8] = -1.7e308;
  expect_equal({"double", uniform_grid(dims), typed_array(doubles), {{0, 0.5}, {0.5, 1}}});
  // Which side 0.1 lies on is decided in double precision: the float nearest to it is above it.
  std::vector<float> tenths(product(dims), 0.1f);
  for (std::size_t i = 0; i < tenths.size(); i += 3) tenths[i] = 0.0f;
  expect_equal({"tenths", uniform_grid(dims), typed_array(tenths), {{0.05, 0.1}}});
  expect_equal({"tenths promoted", uniform_grid(dims), typed_array(tenths), {{0.05, static_cast<double>(0.1f)}}});
}

TEST(GlExtraction, LeavesOutCellsThatAreHiddenOrNotFinite) {
  for (const std::uint64_t seed : {21u, 22u}) {
    std::mt19937_64 random(seed);
    const std::array<std::int64_t, 3> dims{17, 10, 12};
    auto values = waves(dims, 0.2, random);
    std::uniform_int_distribution<std::size_t> pick(0, values.size() - 1);
    for (int i = 0; i < 20; ++i) {
      values[pick(random)] = std::numeric_limits<float>::quiet_NaN();
      values[pick(random)] = std::numeric_limits<float>::infinity();
      values[pick(random)] = -std::numeric_limits<float>::infinity();
    }
    values[pick(random)] = std::bit_cast<float>(0xffc00001u);  // a NaN with its sign bit set
    auto hidden = std::make_shared<std::vector<std::uint8_t>>(16 * 9 * 11);
    std::bernoulli_distribution coin(0.2);
    for (auto& h : *hidden) h = coin(random) ? 1 : 0;
    Grid grid = uniform_grid(dims);
    const std::string name = ", seed " + std::to_string(seed);
    expect_equal({"not finite" + name, grid, typed_array(values), {{0.2, 0.6}, {0.6, 1}}});
    grid.hidden_cells = *hidden;
    grid.storage = hidden;
    expect_equal({"hidden and not finite" + name, grid, typed_array(values), {{0.2, 0.6}, {0.6, 1}}});
    const std::vector<double> doubles(values.begin(), values.end());
    expect_equal({"double, hidden and not finite" + name, grid, typed_array(doubles), {{0.2, 0.6}}});
    std::vector<std::uint8_t> bytes;
    for (const float v : values) bytes.push_back(std::isfinite(v) ? static_cast<std::uint8_t>(std::clamp(60 * (v + 2), 0.0f, 255.0f)) : 0);
    expect_equal({"bytes, hidden" + name, grid, typed_array(bytes), {{100, 160}}});
  }
}

/// The lattice pushed about a little; mirrored: left-handed.
template <class Point>
Grid bent_grid(const std::array<std::int64_t, 3>& dims, bool mirrored, bool broken, std::mt19937_64& random) {
  std::uniform_real_distribution<double> push(-0.15, 0.15);
  auto points = std::make_shared<std::vector<Point>>();
  using T = decltype(Point::x);
  for (std::int64_t k = 0; k < dims[2]; ++k)
    for (std::int64_t j = 0; j < dims[1]; ++j)
      for (std::int64_t i = 0; i < dims[0]; ++i)
        points->push_back({static_cast<T>((mirrored ? -1 : 1) * (static_cast<double>(i) + push(random))),
                           static_cast<T>(static_cast<double>(j) + push(random)),
                           static_cast<T>(static_cast<double>(k) + push(random))});
  if (broken) (*points)[points->size() / 2].y = std::numeric_limits<T>::quiet_NaN();
  return {CurvilinearGrid{dims, std::span<const Point>(*points)}, {}, points};
}

TEST(GlExtraction, EqualsTheCpuOnCurvilinearGridsOfEitherHand) {
  const std::array<std::int64_t, 3> dims{11, 10, 9};
  for (const bool mirrored : {false, true}) {
    std::mt19937_64 random(31);
    const std::string name = mirrored ? "left-handed" : "right-handed";
    const auto values = waves(dims, 0.2, random);
    expect_equal(
        {name + ", floats", bent_grid<Vec3f>(dims, mirrored, false, random), typed_array(values), {{0.2, 0.6}, {0.6, 1}}});
    expect_equal({name + ", doubles", bent_grid<Vec3d>(dims, mirrored, false, random), typed_array(values), {{0.2, 0.6}}});
    expect_equal({name + ", a point that is not finite",
                  bent_grid<Vec3d>(dims, mirrored, true, random),
                  typed_array(values),
                  {{-1, 0.6}}});
  }
}

TEST(GlExtraction, TurnsFlatCellsAsMostOthersAre) {
  std::mt19937_64 random(32);
  const std::array<std::int64_t, 3> dims{6, 5, 7};
  for (const bool mirrored : {false, true}) {
    auto points = std::make_shared<std::vector<Vec3d>>();
    for (std::int64_t k = 0; k < dims[2]; ++k)
      for (std::int64_t j = 0; j < dims[1]; ++j)
        for (std::int64_t i = 0; i < dims[0]; ++i)  // two layers coincide
          points->push_back(
              {(mirrored ? -1.0 : 1.0) * static_cast<double>(i), static_cast<double>(j), static_cast<double>(k == 3 ? 2 : k)});
    const Grid grid{CurvilinearGrid{dims, std::span<const Vec3d>(*points)}, {}, points};
    expect_equal({mirrored ? "left-handed" : "right-handed", grid, typed_array(waves(dims, 0.5, random)), {{0.2, 1}}});
  }
}

TEST(GlExtraction, EqualsTheCpuOnRectilinearGridsWithFallingAxes) {
  std::mt19937_64 random(41);
  const std::array<std::int64_t, 3> dims{9, 8, 10};
  const auto values = waves(dims, 0.2, random);
  for (int falling = 0; falling < 8; ++falling) {
    RectilinearGrid shape;
    shape.dims = dims;
    for (int axis = 0; axis < 3; ++axis)
      for (std::int64_t i = 0; i < dims[axis]; ++i)
        shape.axes[axis].push_back((falling >> axis & 1 ? -1 : 1) * (static_cast<double>(i) + 0.05 * static_cast<double>(i * i)));
    expect_equal({"falling axes " + std::to_string(falling), Grid{shape, {}, nullptr}, typed_array(values), {{0.2, 0.6}}});
  }
}

TEST(GlExtraction, KeepsItsDigitsFarFromTheOrigin) {
  std::mt19937_64 random(42);
  const std::array<std::int64_t, 3> dims{10, 9, 8};
  expect_equal({"far away",
                uniform_grid(dims, {1e7, -1e7, 3e6}, {0.01, 0.01, 0.01}),
                typed_array(waves(dims, 0.2, random)),
                {{0.2, 0.6}}});
}

TEST(GlExtraction, EqualsTheCpuWhereTheGridNeedsSeveralBuffers) {
  std::mt19937_64 random(51);
  const std::array<std::int64_t, 3> dims{12, 11, 45};
  {
    const Budget parts(0, 12 * 11 * 17 * sizeof(Vec3d));  // two layers of bricks with points, and no more
    expect_equal({"in parts", bent_grid<Vec3d>(dims, false, false, random), typed_array(waves(dims, 0.1, random)), {{0.2, 0.6}}});
  }
  expect_equal({"in one", uniform_grid(dims), typed_array(waves(dims, 0.1, random)), {{0.2, 0.6}}});
}

TEST(GlExtraction, MakesRoomForWhatIsMoreThanItGuessed) {
  std::mt19937_64 random(61);
  const std::array<std::int64_t, 3> dims{24, 24, 24};
  const Case c{"all active", uniform_grid(dims), typed_array(random_values<float>(product(dims), 0, 1, random)), {{0.3, 0.7}}};
  EXPECT_GT(expect_equal(c).attempts, 1);
  const Task task;
  EXPECT_EQ(device().extract(c.intervals, GlExtent::tetrahedra, task).attempts, 1);  // it has learnt
}

TEST(GlExtraction, FindsNothingWhereThereIsNothing) {
  const Task task;
  const std::array<std::int64_t, 3> dims{10, 10, 10};
  const std::vector<float> constant(1000, 0.5f), nan(1000, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(expect_equal({"outside", uniform_grid(dims), typed_array(constant), {{1, 2}}}).active_bricks, 0);
  expect_equal({"all of it", uniform_grid(dims), typed_array(constant), {{0, 1}}});
  expect_equal({"nothing finite", uniform_grid(dims), typed_array(nan), {{0, 1}}});
  expect_equal({"no cells", uniform_grid({5, 1, 1}), typed_array(std::vector<float>(5, 0.5f)), {{0, 1}}});
  expect_equal({"no points", uniform_grid({0, 0, 0}), typed_array(std::vector<float>()), {{0, 1}}});
  const std::vector<std::uint8_t> bytes(1000, 7);
  expect_equal({"below every byte", uniform_grid(dims), typed_array(bytes), {{-7, -1}, {300, 400}}});
}

TEST(GlExtraction, RefusesWhatItCannotDoAndGoesOn) {
  const Task task;
  const auto refused = [&](ErrorCode code, const std::string& what, auto&& call) {
    try {
      call();
      FAIL() << what;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_THAT(error.what(), HasSubstr(what));
    }
  };
  const std::array<std::int64_t, 3> dims{16, 16, 16};
  std::mt19937_64 random(71);
  const Case c{"after an error", uniform_grid(dims), typed_array(waves(dims, 0.3, random)), {{0.2, 0.6}}};
  GlExtraction fresh(test_device());
  refused(ErrorCode::invalid_argument, "no field is loaded", [&] { fresh.extract(c.intervals, GlExtent::records, task); });
  refused(ErrorCode::invalid_argument, "nothing has been extracted", [&] { fresh.read_records(task); });
  refused(ErrorCode::unsupported, "unstructured", [&] { device().load(unstructured_grid(as_parts(c.grid)), c.array, task); });
  refused(ErrorCode::invalid_argument, "no field is loaded", [&] { device().extract(c.intervals, GlExtent::records, task); });
  refused(ErrorCode::invalid_argument, "4096 points", [&] { device().load(c.grid, typed_array(std::vector<float>(5)), task); });
  device().load(c.grid, c.array, task);
  refused(ErrorCode::invalid_argument, "lower must be less", [&] { device().extract({{{1, 1}}}, GlExtent::records, task); });
  EXPECT_GT(device().extract(c.intervals, GlExtent::records, task).records, 0);  // the field is still there
  refused(ErrorCode::invalid_argument, "expected tetrahedra", [&] { device().read_mesh(task); });
  {
    const Budget none(100 << 10);
    refused(ErrorCode::too_large, "the array 'f' would need 16384 bytes", [&] { device().load(c.grid, c.array, task); });
  }
  {
    const Budget none(0, 16 * 16 * 9 * sizeof(float) - 16);
    refused(ErrorCode::too_large, "on the CPU", [&] { device().load(c.grid, c.array, task); });
  }
  {
    const Budget little(500 << 10);
    device().load(c.grid, c.array, task);
    refused(ErrorCode::too_large, "are in use", [&] { device().extract(c.intervals, GlExtent::tetrahedra, task); });
  }
  expect_equal(c);
}

TEST(GlExtraction, StopsWhereItIsCancelledAndGoesOn) {
  const std::array<std::int64_t, 3> dims{40, 40, 40};
  std::mt19937_64 random(81);
  const Case c{"after a cancel", uniform_grid(dims), typed_array(waves(dims, 0.3, random)), {{0.2, 0.6}}};
  Task cancelled;
  cancelled.cancel();
  EXPECT_THROW(device().load(c.grid, c.array, cancelled), Error);
  const Task task;
  device().load(c.grid, c.array, task);
  // At its first report it is cancelled; the next dispatch must notice.
  Task* pointer = nullptr;
  Task late([&](double, std::string_view) { pointer->cancel(); });
  pointer = &late;
  try {
    device().extract(c.intervals, GlExtent::tetrahedra, late);
    FAIL() << "not cancelled";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::cancelled);
  }
  EXPECT_THROW(device().read_records(task), Error);
  EXPECT_EQ(device().extract(c.intervals, GlExtent::tetrahedra, task).tetrahedra,
            static_cast<std::int64_t>(extract_on_cpu(c).tetrahedra.size()));
}

TEST(GlExtraction, GivesTheMeshOfTheCpu) {
  std::mt19937_64 random(91);
  const std::array<std::int64_t, 3> dims{13, 12, 11};
  for (const bool mirrored : {false, true}) {
    const Case c{mirrored ? "left-handed" : "right-handed",
                 bent_grid<Vec3d>(dims, mirrored, false, random),
                 typed_array(waves(dims, 0.3, random)),
                 {{0.2, 0.6}, {0.6, 1}}};
    const Task task;
    ExtractOptions options;
    options.facets = options.values = options.measure = true;
    const IntervalMesh found = extract_intervals_on(device(), c.grid, c.array, c.intervals, options, task);
    const IntervalMesh expected = extract_intervals(c.grid, c.array, c.intervals, options, task);
    EXPECT_EQ(unmatched(found), 0) << c.name;
    EXPECT_EQ(found.cell_runs.size(), expected.cell_runs.size()) << c.name;
    EXPECT_EQ(sorted_keys(found.tetrahedra, found.tetrahedron_interval, cpu_origins(found)),
              sorted_keys(expected.tetrahedra, expected.tetrahedron_interval, cpu_origins(expected)))
        << c.name;
    for (const FacetLabel label : {FacetLabel::lower, FacetLabel::upper, FacetLabel::domain})
      EXPECT_EQ(count_label(found, label), count_label(expected, label)) << c.name;
    for (std::size_t i = 0; i < c.intervals.size(); ++i) {
      EXPECT_EQ(found.summaries[i].inverted, expected.summaries[i].inverted) << c.name;
      EXPECT_EQ(found.summaries[i].active_cells, expected.summaries[i].active_cells) << c.name;
      EXPECT_NEAR(found.summaries[i].volume, expected.summaries[i].volume, 1e-9) << c.name;
      EXPECT_NEAR(found.summaries[i].signed_volume, expected.summaries[i].signed_volume, 1e-9) << c.name;
    }
  }
}

TEST(GlExtraction, ChecksItself) { EXPECT_EQ(check_gl_extraction(test_device()), ""); }

TEST(GlExtraction, NamesTheDeviceThatIsNotThere) {
  EXPECT_THROW(GlExtraction("egl:77"), Error);
  EXPECT_THAT(check_gl_extraction("egl:77"), HasSubstr("egl:77"));
}

}  // namespace
}  // namespace isostrata
