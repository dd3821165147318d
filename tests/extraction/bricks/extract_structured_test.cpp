#include "extraction/bricks/extract_structured.h"

#include <cmath>
#include <limits>
#include <set>

#include "base/parallel.h"
#include "data/dataset/analytic.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/same_mesh.h"
#include "extraction/small_grids.h"

namespace isostrata {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ExtractOptions with_facets() {
  ExtractOptions options;
  options.facets = true;
  return options;
}

IntervalMesh extract_fast(const Grid& grid, const PointArray& array, const std::vector<Interval>& intervals,
                          const ExtractOptions& options = with_facets()) {
  auto mesh = extract_structured(grid, array, intervals, options, Task{});
  if (!mesh) throw std::runtime_error("extract_structured does not reach this request");
  return std::move(*mesh);
}

void expect_same_as_in_general(const Grid& grid, const PointArray& array, const std::vector<Interval>& intervals,
                               bool complement = false) {
  ExtractOptions options = with_facets();
  options.complement = complement;
  const IntervalMesh fast = extract_fast(grid, array, intervals, options);
  const IntervalMesh slow = extract_in_general(grid, array, intervals, options, Task{});
  ASSERT_EQ(fast.summaries.size(), slow.summaries.size());
  const MeshContent one = content_of(fast), other = content_of(slow);
  ASSERT_EQ(one.points.size(), other.points.size());
  ASSERT_EQ(one.tetrahedra.size(), other.tetrahedra.size());
  ASSERT_TRUE(one.points == other.points);
  ASSERT_TRUE(one.positions == other.positions) << "to the last bit";
  ASSERT_TRUE(one.tetrahedra == other.tetrahedra);
  ASSERT_EQ(one.facets.size(), other.facets.size());
  ASSERT_TRUE(one.facets == other.facets);
  for (const BoundaryFacet& facet : fast.facets) ASSERT_EQ(facet.range, facet.interval);
  ASSERT_EQ(one.counts, other.counts);
  ASSERT_EQ(fast.active_cells, slow.active_cells);
  ASSERT_EQ(fast.cells, slow.cells);
  for (std::size_t i = 0; i < fast.summaries.size(); ++i) {
    ASSERT_NEAR(fast.summaries[i].volume, slow.summaries[i].volume, 1e-12 * (1 + slow.summaries[i].volume));
    ASSERT_NEAR(fast.summaries[i].signed_volume, slow.summaries[i].signed_volume, 1e-12 * (1 + slow.summaries[i].volume));
  }
}

/// Smooth enough that whole bricks lie outside, with noise of the given size.
template <class T>
std::vector<T> random_field(const std::array<std::int64_t, 3>& dims, double scale, double noise, std::mt19937_64& random) {
  const auto phase = random_values(6, 0, 6, random);
  const auto shake = random_values(dims[0] * dims[1] * dims[2], -noise, noise, random);
  std::vector<T> values;
  for (std::int64_t k = 0; k < dims[2]; ++k)
    for (std::int64_t j = 0; j < dims[1]; ++j)
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const double f = std::sin(0.1 * phase[0] * i + phase[1]) + std::sin(0.1 * phase[2] * j + phase[3]) +
                         std::sin(0.1 * phase[4] * k + phase[5]);
        values.push_back(static_cast<T>(std::clamp((f / 6 + 0.5 + shake[values.size()]) * scale, 0.0, scale)));
      }
  return values;
}

/// One to five intervals within [0, scale]: touching, apart or overlapping, some with ends that points have.
template <class T>
std::vector<Interval> random_intervals(const std::vector<T>& values, double scale, std::mt19937_64& random) {
  std::vector<double> ends;
  while (ends.size() < 6) {
    const auto at = static_cast<double>(values[random() % values.size()]);
    const double end = random() % 3 == 0 ? at : std::uniform_real_distribution<double>(0, scale)(random);
    if (std::isfinite(end)) ends.push_back(end);
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  std::vector<Interval> out;
  const std::size_t count = 1 + random() % 5;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t a = random() % ends.size(), b = random() % 2 ? a + 1 : random() % ends.size();
    if (a == b || b >= ends.size())
      out.push_back({0.3 * scale, 0.6 * scale});
    else
      out.push_back({std::min(ends[a], ends[b]), std::max(ends[a], ends[b])});
  }
  return out;
}

std::array<std::int64_t, 3> random_dims(std::mt19937_64& random) {
  std::array<std::int64_t, 3> dims{};
  for (auto& d : dims) d = 2 + static_cast<std::int64_t>(random() % 19);
  return dims;
}

Grid random_box_grid(const std::array<std::int64_t, 3>& dims, std::mt19937_64& random) {
  const auto sign = [&] { return random() % 3 == 0 ? -1.0 : 1.0; };
  if (random() % 2 == 0) return uniform_grid(dims, {1, -2, 0.3}, {0.1 * sign(), 0.7 * sign(), sign()});
  RectilinearGrid shape;
  shape.dims = dims;
  for (int axis = 0; axis < 3; ++axis) {
    const double direction = sign();
    double at = 0;
    for (std::int64_t i = 0; i < dims[axis]; ++i)
      shape.axes[axis].push_back(at += direction * std::uniform_real_distribution<double>(0.1, 2)(random));
  }
  return {shape, {}, nullptr};
}

/// Bent, now and then left-handed; some cells without volume; if asked for, some positions that are not finite.
Grid random_curvilinear_grid(const std::array<std::int64_t, 3>& dims, bool not_finite, std::mt19937_64& random) {
  std::vector<Vec3d> points;
  const double sign = random() % 2 ? 1 : -1;
  for (std::int64_t k = 0; k < dims[2]; ++k)
    for (std::int64_t j = 0; j < dims[1]; ++j)
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const auto shake = random_values(3, -0.3, 0.3, random);
        Vec3d p{sign * (static_cast<double>(i) + shake[0]), static_cast<double>(j) + shake[1], static_cast<double>(k) + shake[2]};
        if (i == 0 && random() % 4 == 0) p.x = sign;  // collapsed columns
        if (not_finite && random() % 200 == 0) p[static_cast<int>(random() % 3)] = random() % 2 ? kNaN : kInfinity;
        points.push_back(p);
      }
  return curvilinear_grid(dims, points);
}

void hide_cells(Grid& grid, unsigned one_of, std::mt19937_64& random) {
  auto storage = std::make_shared<std::pair<std::vector<std::uint8_t>, std::shared_ptr<const void>>>();
  storage->second = grid.storage;
  storage->first.resize(grid.cell_count());
  for (auto& hidden : storage->first) hidden = random() % one_of == 0;
  grid.hidden_cells = storage->first;
  grid.storage = storage;
}

template <class T>
class ExtractStructuredTyped : public testing::Test {};
using ScalarTypes = testing::Types<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t, std::uint32_t,
                                   std::int64_t, std::uint64_t, float, double>;
TYPED_TEST_SUITE(ExtractStructuredTyped, ScalarTypes);

TYPED_TEST(ExtractStructuredTyped, GivesWhatTheGeneralWayGives) {
  for (std::uint64_t seed = 1; seed <= 25; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const auto dims = random_dims(random);
    const double scale = std::is_floating_point_v<TypeParam> ? 1.0 : 120.0;
    const auto values = random_field<TypeParam>(dims, scale, random() % 3 == 0 ? 0.5 : 0.05, random);
    const Grid grid = random_box_grid(dims, random);
    ASSERT_NO_FATAL_FAILURE(expect_same_as_in_general(grid, point_array(values), random_intervals(values, scale, random)));
  }
}

TYPED_TEST(ExtractStructuredTyped, ComparesAtTheEndsOfTheType) {
  using Limits = std::numeric_limits<TypeParam>;
  std::mt19937_64 random(3);
  std::vector<TypeParam> values;
  for (int i = 0; i < 11 * 9 * 4; ++i) {
    const TypeParam all[] = {Limits::lowest(), Limits::max(), TypeParam{0}, TypeParam{1},
                             static_cast<TypeParam>(Limits::max() / 2)};
    values.push_back(all[random() % 5]);
  }
  const auto lowest = static_cast<double>(Limits::lowest()), most = static_cast<double>(Limits::max());
  const Grid grid = uniform_grid({11, 9, 4});
  for (const auto& intervals : std::vector<std::vector<Interval>>{{{lowest, most}},
                                                                  {{most / 2, most}},
                                                                  {{lowest - 1, 0}, {0, 1}},
                                                                  {{lowest / 2, most / 4}, {1, most}},
                                                                  {{-1e300, 1e300}},
                                                                  {{0.5, 0.6}}})
    ASSERT_NO_FATAL_FAILURE(expect_same_as_in_general(grid, point_array(values), intervals)) << intervals[0].lower;
}

TEST(ExtractStructured, LeavesOutWhatIsNotFiniteOrHidden) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const auto dims = random_dims(random);
    auto values = random_field<double>(dims, 1, 0.2, random);
    const auto intervals = random_intervals(values, 1, random);
    const unsigned holes = random() % 3 == 0 ? 10 : 300;
    if (random() % 2)
      for (double& value : values)
        if (random() % holes == 0) value = random() % 3 ? kNaN : random() % 2 ? kInfinity : -kInfinity;
    Grid grid = random_box_grid(dims, random);
    if (random() % 2) hide_cells(grid, random() % 2 ? 3 : 40, random);
    ASSERT_NO_FATAL_FAILURE(expect_same_as_in_general(grid, point_array(values), intervals));
  }
}

TEST(ExtractStructured, FollowsTheHandOfEveryCurvilinearCell) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const auto dims = random_dims(random);
    const auto values = random_field<float>(dims, 1, 0.1, random);
    Grid grid = random_curvilinear_grid(dims, random() % 2 == 0, random);
    if (random() % 3 == 0) hide_cells(grid, 20, random);
    ASSERT_NO_FATAL_FAILURE(expect_same_as_in_general(grid, point_array(values), random_intervals(values, 1, random)));
  }
}

TEST(ExtractStructured, GivesWhatLiesBetweenTheIntervalsToo) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    const auto dims = random_dims(random);
    const auto values = random_field<float>(dims, 1, 0.1, random);
    const Grid grid = random_box_grid(dims, random);
    ASSERT_NO_FATAL_FAILURE(expect_same_as_in_general(grid, point_array(values), random_intervals(values, 1, random), true));
  }
}

TEST(ExtractStructured, TakesManyIntervalsAtOnce) {
  std::mt19937_64 random(5);
  const auto values = random_values(13 * 10 * 9, 0, 1, random);
  std::vector<double> ends;
  for (int i = 0; i <= 256; ++i) ends.push_back(i / 256.0);
  const Grid grid = uniform_grid({13, 10, 9});
  expect_same_as_in_general(grid, point_array(values), tiling(ends));
  ends.push_back(1.1);
  EXPECT_FALSE(extract_structured(grid, point_array(values), tiling(ends), {}, Task{}).has_value());
}

TEST(ExtractStructured, NumbersDoNotDependOnThreads) {
  const auto dataset = make_analytic("torus:60", {}, Task{});
  const std::vector<Interval> intervals{{0.2, 0.3}, {0.3, 0.35}, {0.25, 0.5}};
  set_thread_count(1);
  const IntervalMesh one = extract_fast(dataset->grid, dataset->arrays[0], intervals);
  set_thread_count(0);
  const IntervalMesh all = extract_fast(dataset->grid, dataset->arrays[0], intervals);
  EXPECT_EQ(one.positions, all.positions);
  EXPECT_EQ(one.origins, all.origins);
  EXPECT_EQ(one.tetrahedra, all.tetrahedra);
  EXPECT_EQ(one.tetrahedron_interval, all.tetrahedron_interval);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(one.summaries[i].signed_volume, all.summaries[i].signed_volume);
}

TEST(ExtractStructured, MakesOnlyWhatIsAskedFor) {
  const auto dataset = make_analytic("torus:40", {}, Task{});
  const std::vector<Interval> intervals{{0.2, 0.3}};
  const IntervalMesh whole = extract_fast(dataset->grid, dataset->arrays[0], intervals);
  ExtractOptions bare;
  bare.values = bare.measure = false;
  BrickMemory memory;
  bare.bricks = &memory;
  const IntervalMesh mesh = extract_fast(dataset->grid, dataset->arrays[0], intervals, bare);
  EXPECT_EQ(mesh.tetrahedra, whole.tetrahedra);
  EXPECT_EQ(mesh.origins, whole.origins);
  EXPECT_TRUE(mesh.values.empty());
  EXPECT_TRUE(mesh.facets.empty());
  EXPECT_EQ(mesh.summaries[0].volume, 0);
  EXPECT_EQ(mesh.summaries[0].tetrahedra, whole.summaries[0].tetrahedra);
}

TEST(ExtractStructured, RefusesWhatDoesNotFit) {
  const auto dataset = make_analytic("torus:40", {}, Task{});
  for (const std::uint64_t bytes : {std::uint64_t{1}, std::uint64_t{200'000}, std::uint64_t{2'000'000}}) {
    ExtractOptions options = with_facets();
    options.max_bytes = bytes;
    try {
      extract_fast(dataset->grid, dataset->arrays[0], {{0.1, 0.6}}, options);
      ADD_FAILURE() << bytes << " bytes were enough";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::too_large);
      EXPECT_NE(std::string(error.what()).find(std::to_string(bytes)), std::string::npos) << error.what();
    }
  }
}

TEST(ExtractStructured, EndsWhenCancelled) {
  const auto dataset = make_analytic("torus:40", {}, Task{});
  for (int stop_at = 0; stop_at < 12; ++stop_at) {
    int reports = 0;
    Task* task_of = nullptr;
    Task task([&](double, std::string_view) {
      if (reports++ == stop_at) task_of->cancel();
    });
    task_of = &task;
    ExtractOptions options = with_facets();
    EXPECT_THROW(extract_structured(dataset->grid, dataset->arrays[0], std::vector<Interval>{{0.1, 0.6}}, options, task), Error)
        << "after report " << stop_at;
  }
}

}  // namespace
}  // namespace isostrata
