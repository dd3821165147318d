#include "extraction/unstructured/extract_ordered.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "base/parallel.h"
#include "data/dataset/analytic.h"
#include "extraction/same_mesh.h"
#include "extraction/small_grids.h"
#include "extraction/unstructured/ordered_memory.h"
#include "extraction/unstructured/sorted_tetrahedron.h"
#include "support/simd_levels.h"

namespace isostrata {
namespace {

constexpr std::uint64_t kPlenty = std::uint64_t{1} << 30;
const Task kQuiet;

IntervalMesh extract_slowly(const Grid& grid, const PointArray& array, const std::vector<Interval>& intervals,
                            bool complement = false) {
  ExtractOptions options;
  options.facets = true;
  options.complement = complement;
  return extract_in_general(grid, array, intervals, options, kQuiet);
}

/// By the layout, or not at all.
IntervalMesh extract_by_layout(const Grid& grid, const PointArray& array, const std::vector<Interval>& intervals,
                               bool complement = false) {
  const auto tetrahedra = OrderedTetrahedra::make(grid, kPlenty, kQuiet);
  if (!tetrahedra) throw std::runtime_error("the grid cannot be laid out");
  const auto values = order_values(*tetrahedra, array, kQuiet);
  if (!values) throw std::runtime_error("the array cannot be laid out");
  ExtractOptions options;
  options.facets = true;
  options.complement = complement;
  auto mesh = extract_ordered(grid, *tetrahedra, *values, intervals, options, kQuiet);
  if (!mesh) throw std::runtime_error("extract_ordered does not reach this request");
  return std::move(*mesh);
}

/// A conforming mesh of tetrahedra whose points and cells are numbered at random, some mirrored.
UnstructuredParts shuffled_tetrahedra(int size, std::mt19937_64& random) {
  const auto dataset = make_analytic("tets:" + std::to_string(size), {}, kQuiet);
  const UnstructuredParts parts = as_parts(dataset->grid, random_numbers(dataset->grid.point_count(), random));
  UnstructuredParts out;
  out.points = parts.points;
  for (const std::int64_t c : random_numbers(dataset->grid.cell_count(), random)) {
    std::vector<std::int64_t> ids{parts.connectivity.begin() + 4 * c, parts.connectivity.begin() + 4 * c + 4};
    if (random() % 8 == 0) std::swap(ids[random() % 4], ids[random() % 4]);
    out.add(CellType::tetrahedron, ids);
  }
  return out;
}

/// Tetrahedra between points anywhere: they overlap, share edges by chance, and some have no volume.
UnstructuredParts random_tetrahedra(std::int64_t points, int cells, std::mt19937_64& random) {
  UnstructuredParts parts;
  for (std::int64_t p = 0; p < points; ++p) {
    const auto at = random_values(3, -1, 1, random);
    parts.points.push_back({at[0], at[1], random() % 3 == 0 ? 0 : at[2]});
  }
  for (int c = 0; c < cells; ++c) {
    auto ids = random_numbers(points, random);
    ids.resize(4);
    parts.add(CellType::tetrahedron, ids);
  }
  return parts;
}

/// One to five intervals, some of which touch or overlap, some with ends that points have.
std::vector<Interval> random_intervals(const std::vector<double>& values, std::mt19937_64& random) {
  std::vector<Interval> out;
  for (std::size_t i = 1 + random() % 5; i > 0; --i) {
    double ends[2];
    for (double& end : ends)
      end = random() % 3 == 0 ? values[random() % values.size()] : std::uniform_real_distribution<double>(0, 1)(random);
    if (!out.empty() && random() % 2 == 0) ends[0] = out.back().upper;
    if (ends[0] == ends[1]) ends[1] += 0.125;
    out.push_back({std::min(ends[0], ends[1]), std::max(ends[0], ends[1])});
  }
  return out;
}

std::vector<std::uint8_t> random_hidden(std::int64_t cells, std::mt19937_64& random) {
  std::vector<std::uint8_t> hidden(static_cast<std::size_t>(cells));
  for (auto& h : hidden) h = random() % 10 == 0;
  return hidden;
}

TEST(ExtractOrdered, GivesWhatTheGeneralWayGivesOnAMesh) {
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    Grid grid = unstructured_grid(shuffled_tetrahedra(7, random));
    const auto values = random_values(grid.point_count(), 0, 1, random);
    const auto hidden = random_hidden(grid.cell_count(), random);
    if (seed % 3 == 0) grid.hidden_cells = hidden;
    const auto intervals = seed % 4 == 1 ? std::vector<Interval>{{0.25, 0.5}} : random_intervals(values, random);
    const IntervalMesh fast = extract_by_layout(grid, point_array(values), intervals, seed % 4 == 2);
    expect_the_same(fast, extract_slowly(grid, point_array(values), intervals, seed % 4 == 2));
    EXPECT_EQ(unmatched(fast), 0);
  }
}

TEST(ExtractOrdered, GivesWhatTheGeneralWayGivesOnAnyTetrahedra) {
  for (std::uint64_t seed = 1; seed <= 80; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    UnstructuredParts parts = random_tetrahedra(6 + static_cast<std::int64_t>(random() % 40), 40, random);
    if (seed % 5 == 0) parts.points[random() % parts.points.size()].y = std::numeric_limits<double>::quiet_NaN();
    auto values = random_values(static_cast<std::int64_t>(parts.points.size()), 0, 1, random);
    if (seed % 2 == 0)
      for (double& value : values) value = std::floor(6 * value) / 6;  // ties
    const auto intervals = random_intervals(values, random);
    const Grid grid = unstructured_grid(parts);
    expect_the_same(extract_by_layout(grid, point_array(values), intervals),
                    extract_slowly(grid, point_array(values), intervals));
  }
}

template <class T>
void expect_agreement_of_type(const Grid& grid, std::mt19937_64& random) {
  const auto array = point_array(random_values<T>(grid.point_count(), 0, 9.99, random));
  for (const auto& intervals :
       {std::vector<Interval>{{2, 4}}, std::vector<Interval>{{2, 4}, {4, 7.5}, {3, 1000}}, std::vector<Interval>{{-1e30, 5}}})
    expect_the_same(extract_by_layout(grid, array, intervals), extract_slowly(grid, array, intervals));
}

TEST(ExtractOrdered, AgreesForEveryTypeOfValue) {
  std::mt19937_64 random(8);
  const auto dataset = make_analytic("tets:6", {}, kQuiet);  // points of single precision
  expect_agreement_of_type<std::int8_t>(dataset->grid, random);
  expect_agreement_of_type<std::uint8_t>(dataset->grid, random);
  expect_agreement_of_type<std::int16_t>(dataset->grid, random);
  expect_agreement_of_type<std::uint16_t>(dataset->grid, random);
  expect_agreement_of_type<std::int32_t>(dataset->grid, random);
  expect_agreement_of_type<std::uint32_t>(dataset->grid, random);
  expect_agreement_of_type<std::int64_t>(dataset->grid, random);
  expect_agreement_of_type<std::uint64_t>(dataset->grid, random);
  expect_agreement_of_type<float>(dataset->grid, random);
  expect_agreement_of_type<double>(dataset->grid, random);
}

template <class T>
bool same_bits(const T& a, const T& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
}

void expect_identical(const IntervalMesh& mesh, const IntervalMesh& first) {
  EXPECT_TRUE(same_bits(mesh.tetrahedra, first.tetrahedra));
  EXPECT_TRUE(same_bits(mesh.tetrahedron_interval, first.tetrahedron_interval));
  EXPECT_TRUE(same_bits(mesh.origins, first.origins));
  EXPECT_TRUE(same_bits(mesh.positions, first.positions));
  EXPECT_TRUE(same_bits(mesh.values, first.values));
  ASSERT_EQ(mesh.cell_runs.size(), first.cell_runs.size());
  for (std::size_t r = 0; r < mesh.cell_runs.size(); ++r) {
    ASSERT_EQ(mesh.cell_runs[r].cell, first.cell_runs[r].cell);
    ASSERT_EQ(mesh.cell_runs[r].first_tetrahedron, first.cell_runs[r].first_tetrahedron);
  }
  for (std::size_t i = 0; i < mesh.summaries.size(); ++i)
    EXPECT_EQ(mesh.summaries[i].signed_volume, first.summaries[i].signed_volume);
}

TEST(ExtractOrdered, DoesNotDependOnThreadsOrTheProcessor) {
  std::mt19937_64 random(9);
  const Grid grid = unstructured_grid(shuffled_tetrahedra(20, random));
  const auto array = point_array(random_values<float>(grid.point_count(), 0, 1, random));
  for (const auto& intervals : {std::vector<Interval>{{0.4, 0.5}}, std::vector<Interval>{{0.1, 0.3}, {0.3, 0.4}, {0.35, 0.9}}}) {
    set_thread_count(1);
    const IntervalMesh alone = extract_by_layout(grid, array, intervals);
    EXPECT_GT(alone.tetrahedra.size(), 1000u);
    for (int threads = 2; threads <= 4; ++threads) {
      set_thread_count(threads);
      expect_identical(extract_by_layout(grid, array, intervals), alone);
    }
    set_thread_count(0);
    testing::with_each_simd_level(
        [&](const std::string&) { expect_identical(extract_by_layout(grid, array, intervals), alone); });
  }
}

TEST(ExtractOrdered, TakesAsManyEndsAsThereAreAndLeavesMoreToTheOtherWay) {
  std::mt19937_64 random(10);
  const Grid grid = unstructured_grid(random_tetrahedra(30, 40, random));
  const auto array = point_array(random_values(30, 0, 1, random));
  for (const int count : {127, 128}) {  // 254 and 256 ends
    std::vector<Interval> intervals;
    for (int i = 0; i < count; ++i) {
      const auto ends = random_values(2, 0, 1, random);
      intervals.push_back({std::min(ends[0], ends[1]), std::max(ends[0], ends[1])});
    }
    const IntervalMesh slow = extract_slowly(grid, array, intervals);
    OrderedMemory memory(kPlenty);
    memory.make(grid, kQuiet);
    ExtractOptions options;
    options.facets = true;
    options.ordered = &memory;
    expect_the_same(extract_intervals(grid, array, intervals, options, kQuiet), slow);
    if (count == 127)
      expect_the_same(extract_by_layout(grid, array, intervals), slow);
    else
      EXPECT_THROW(extract_by_layout(grid, array, intervals), std::runtime_error);
  }
}

TEST(ExtractOrdered, RefusesWhatNeedsTooMuchMemoryAndCanBeCancelled) {
  const auto dataset = make_analytic("tets:12", {}, kQuiet);
  const auto tetrahedra = OrderedTetrahedra::make(dataset->grid, kPlenty, kQuiet);
  const auto values = order_values(*tetrahedra, dataset->arrays[0], kQuiet);
  const std::vector<Interval> all{{0, 1}};
  ExtractOptions options;
  for (const std::uint64_t bytes : {100u, 20'000u, 400'000u}) {
    options.max_bytes = bytes;
    try {
      extract_ordered(dataset->grid, *tetrahedra, *values, all, options, kQuiet);
      FAIL() << bytes << " bytes are not enough";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::too_large);
    }
  }
  options.max_bytes = kPlenty;
  Task cancelled;
  cancelled.cancel();
  EXPECT_THROW(extract_ordered(dataset->grid, *tetrahedra, *values, all, options, cancelled), Error);
}

TEST(OrderedTetrahedra, AreOnlyMadeOfTetrahedraWithFourPoints) {
  std::mt19937_64 random(11);
  EXPECT_EQ(OrderedTetrahedra::make(uniform_grid({3, 3, 3}), kPlenty, kQuiet), nullptr);
  EXPECT_EQ(OrderedTetrahedra::make(make_analytic("mixed:5", {}, kQuiet)->grid, kPlenty, kQuiet), nullptr);
  UnstructuredParts parts = random_tetrahedra(8, 3, random);
  EXPECT_NE(OrderedTetrahedra::make(unstructured_grid(parts), kPlenty, kQuiet), nullptr);
  parts.add(CellType::tetrahedron, {1, 2, 3, 1});
  EXPECT_EQ(OrderedTetrahedra::make(unstructured_grid(parts), kPlenty, kQuiet), nullptr);
}

TEST(OrderedTetrahedra, NumberEachEdgeOnceFromItsLowerEnd) {
  std::mt19937_64 random(12);
  const Grid grid = unstructured_grid(shuffled_tetrahedra(9, random));
  const auto of = OrderedTetrahedra::make(grid, kPlenty, kQuiet);
  ASSERT_EQ(of->count(), static_cast<std::size_t>(grid.cell_count()));
  std::vector<std::uint32_t> begin(of->edge_count());
  for (std::uint32_t p = 0; p < of->point_count(); ++p) {
    EXPECT_EQ(of->position(p), grid.point(of->ids[p]));
    for (std::uint32_t e = of->first_edge[p]; e < of->first_edge[p + 1]; ++e) {
      begin[e] = p;
      EXPECT_LT(of->ids[p], of->ids[of->ends[e]]);
      if (e > of->first_edge[p]) {
        EXPECT_LT(of->ends[e - 1], of->ends[e]);
      }
    }
  }
  std::vector<bool> used(of->edge_count());
  for (std::size_t t = 0; t < of->count(); ++t) {
    std::array<std::int64_t, kMaxCellVertices> ids;
    grid.cell_points(of->cells[t], ids);
    std::sort(ids.begin(), ids.begin() + 4);
    for (std::size_t e = 0; e < 6; ++e) {
      const std::uint32_t edge = of->edges[t][e];
      used[edge] = true;
      EXPECT_EQ(of->ids[begin[edge]], ids[kSortedEdges[e][0]]);
      EXPECT_EQ(of->ids[of->ends[edge]], ids[kSortedEdges[e][1]]);
    }
  }
  EXPECT_EQ(std::count(used.begin(), used.end(), true), static_cast<std::ptrdiff_t>(of->edge_count()));
}

TEST(OrderedTetrahedra, KnowTheFacesThatNoOtherTetrahedronHas) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    UnstructuredParts parts = seed % 2 ? shuffled_tetrahedra(5, random) : random_tetrahedra(12, 60, random);
    Grid grid = unstructured_grid(parts);
    const auto hidden = random_hidden(grid.cell_count(), random);
    if (seed % 4 < 2) grid.hidden_cells = hidden;
    std::map<std::array<std::int64_t, 3>, int> having;
    const auto face_of = [&](std::int64_t cell, std::size_t face) {
      std::array<std::int64_t, kMaxCellVertices> ids;
      grid.cell_points(cell, ids);
      const CellFace& of = topology(CellType::tetrahedron).faces[face];
      std::array<std::int64_t, 3> key{ids[of.vertex[0]], ids[of.vertex[1]], ids[of.vertex[2]]};
      std::sort(key.begin(), key.end());
      return key;
    };
    for (std::int64_t cell = 0; cell < grid.cell_count(); ++cell)
      for (std::size_t face = 0; face < 4 && !grid.hidden(cell); ++face) ++having[face_of(cell, face)];
    const auto of = OrderedTetrahedra::make(grid, kPlenty, kQuiet);
    ASSERT_EQ(of->open_faces.size(), of->count());
    for (std::size_t t = 0; t < of->count(); ++t)
      for (std::size_t face = 0; face < 4; ++face)
        ASSERT_EQ((of->open_faces[t] >> face & 1) != 0, having[face_of(of->cells[t], face)] == 1) << "tetrahedron " << t << ", face " << face;
  }
}

TEST(OrderedTetrahedra, LieNearOneAnother) {
  std::mt19937_64 random(13);
  const Grid grid = unstructured_grid(shuffled_tetrahedra(17, random));
  const auto of = OrderedTetrahedra::make(grid, kPlenty, kQuiet);
  double sum = 0;
  for (std::size_t t = 0; t < of->count(); ++t) {
    const auto vertices = of->vertices(t);
    const auto [least, most] = std::minmax_element(vertices.begin(), vertices.end());
    sum += *most - *least;
  }
  // In the grid's own order the four numbers of a cell span 3/5 of all.
  EXPECT_LT(sum / static_cast<double>(of->count()), 0.12 * static_cast<double>(of->point_count())) << "seed 13";
}

TEST(OrderedMemory, KeepsAGridAndItsArraysAsLongAsTheyLive) {
  OrderedMemory memory(kPlenty);
  auto dataset = make_analytic("tets:9", {}, kQuiet);
  std::mt19937_64 random(14);
  const Grid& grid = dataset->grid;
  const PointArray& array = dataset->arrays[0];
  EXPECT_EQ(memory.find(grid, array, kQuiet).tetrahedra, nullptr);
  EXPECT_FALSE(memory.knows(grid));
  memory.make(grid, kQuiet);
  EXPECT_TRUE(memory.knows(grid));
  const OrderedField field = memory.find(grid, array, kQuiet);
  ASSERT_NE(field.tetrahedra, nullptr);
  EXPECT_EQ(memory.find(grid, array, kQuiet).values, field.values);
  EXPECT_EQ(memory.bytes(), field.tetrahedra->bytes() + bytes_of(*field.values));
  {
    const auto other = point_array(random_values(grid.point_count(), 0, 1, random));
    const OrderedField second = memory.find(grid, other, kQuiet);
    EXPECT_EQ(second.tetrahedra, field.tetrahedra);
    EXPECT_NE(second.values, field.values);
    auto holes = random_values(grid.point_count(), 0, 1, random);
    holes[7] = std::numeric_limits<double>::infinity();
    EXPECT_EQ(memory.find(grid, point_array(holes), kQuiet).tetrahedra, nullptr);
  }
  dataset.reset();
  EXPECT_FALSE(memory.knows(make_analytic("tets:4", {}, kQuiet)->grid));
  EXPECT_EQ(memory.bytes(), 0u);
}

TEST(OrderedMemory, DropsWhatDoesNotFitAndNotesWhatItCannotMake) {
  const auto one = make_analytic("tets:9", {}, kQuiet), other = make_analytic("tets:8", {}, kQuiet),
             mixed = make_analytic("mixed:5", {}, kQuiet);
  OrderedMemory memory(OrderedTetrahedra::foreseen_bytes(one->grid) + 1000);
  memory.make(one->grid, kQuiet);
  EXPECT_NE(memory.find(one->grid, one->arrays[0], kQuiet).tetrahedra, nullptr);
  memory.make(mixed->grid, kQuiet);
  EXPECT_TRUE(memory.knows(mixed->grid));
  EXPECT_EQ(memory.find(mixed->grid, mixed->arrays[0], kQuiet).tetrahedra, nullptr);
  memory.make(other->grid, kQuiet);
  EXPECT_NE(memory.find(other->grid, other->arrays[0], kQuiet).tetrahedra, nullptr);
  EXPECT_FALSE(memory.knows(one->grid));
  const auto large = make_analytic("tets:14", {}, kQuiet);
  memory.make(large->grid, kQuiet);
  EXPECT_TRUE(memory.knows(large->grid));
  EXPECT_EQ(memory.find(large->grid, large->arrays[0], kQuiet).tetrahedra, nullptr);
}

TEST(OrderedMemory, ForgetsWhatWasCancelled) {
  const auto dataset = make_analytic("tets:9", {}, kQuiet);
  OrderedMemory memory(kPlenty);
  Task cancelled;
  cancelled.cancel();
  EXPECT_THROW(memory.make(dataset->grid, cancelled), Error);
  EXPECT_FALSE(memory.knows(dataset->grid));
  EXPECT_EQ(memory.bytes(), 0u);
}

}  // namespace
}  // namespace isostrata
