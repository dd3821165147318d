#include "extraction/intervals/extract_whole.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "base/parallel.h"
#include "data/dataset/analytic.h"
#include "extraction/laws/check_laws.h"
#include "extraction/layers/extract_layers.h"
#include "extraction/layers/own_points.h"
#include "extraction/small_grids.h"

namespace isostrata {
namespace {

template <class T>
CellValues cell_values(const std::vector<T>& values) {
  const PointArray array = point_array(values);
  CellValues cells{array.type, array.values, 0, 0, 0, array.storage};
  measure_range(cells);
  return cells;
}

std::vector<int> random_labels(std::int64_t count, std::mt19937_64& random) {
  std::vector<int> labels(static_cast<std::size_t>(count));
  constexpr std::array kLabels{1, 2, 5};
  for (int& label : labels) label = kLabels[random() % 3];
  return labels;
}

IntervalMesh whole(const Grid& grid, const CellValues& cells, const std::vector<Interval>& intervals, bool complement = false) {
  ExtractOptions options;
  options.facets = true;
  options.complement = complement;
  return extract_whole(grid, cells, intervals, options, Task());
}

std::string broken_laws(const Grid& grid, const IntervalMesh& mesh) {
  LawOptions laws;
  laws.one_range = false;
  std::string text;
  for (const BrokenLaw& law : check_laws(grid, mesh, laws, Task())) text += law.law + ": " + law.first + "\n";
  return text;
}

/// Grids of every kind, with the volume of their cells.
std::vector<Grid> grids(std::mt19937_64& random) {
  std::vector<Vec3d> bent;
  for (int p = 0; p < 6 * 5 * 4; ++p) {
    const auto shift = random_values(3, -0.2, 0.2, random);
    bent.push_back({p % 6 + shift[0], p / 6 % 5 + shift[1], p / 30 + shift[2]});
  }
  std::vector<Grid> all{uniform_grid({7, 6, 5}, {1, 2, 3}, {0.5, -2, 1}), curvilinear_grid({6, 5, 4}, bent)};
  all.push_back(unstructured_grid(as_parts(all[1], random_numbers(6 * 5 * 4, random))));
  for (const char* name : {"mixed:5", "tets:5"}) {
    const auto dataset = make_analytic(name, {}, Task());
    all.push_back(unstructured_grid(as_parts(dataset->grid)));
  }
  return all;
}

TEST(ExtractWhole, TakesTheLabelsThatAnIntervalHoldsAndNothingBetween) {
  std::mt19937_64 random(7);
  for (const Grid& grid : grids(random)) {
    const std::vector<int> labels = random_labels(grid.cell_count(), random);
    const IntervalMesh mesh = whole(grid, cell_values(labels), {{0.5, 1.5}, {1.5, 2.5}, {3, 4}, {5, 6}});
    for (const auto& [interval, label] : {std::pair{0, 1}, {1, 2}, {2, 4}, {3, 5}})
      EXPECT_EQ(mesh.summaries[static_cast<std::size_t>(interval)].active_cells, std::count(labels.begin(), labels.end(), label)) << grid.kind_name() << ", seed 7";
    EXPECT_EQ(mesh.summaries[2].tetrahedra, 0) << "nothing is in 3:4";
    EXPECT_EQ(mesh.summaries[2].volume, 0);
  }
}

TEST(ExtractWhole, PartsTileTheGridAndConform) {
  std::mt19937_64 random(8);
  for (const Grid& grid : grids(random)) {
    const CellValues cells = cell_values(random_labels(grid.cell_count(), random));
    const IntervalMesh all = whole(grid, cells, {{-1e6, 1e6}});
    const IntervalMesh parts = whole(grid, cells, {{1, 2}, {4.5, 5.5}}, true);
    SCOPED_TRACE(std::string(grid.kind_name()) + ", seed 8");
    EXPECT_NEAR(total_signed_volume(parts), total_signed_volume(all), 1e-12 * std::abs(total_signed_volume(all)));
    EXPECT_EQ(parts.tetrahedra.size(), all.tetrahedra.size());
    EXPECT_EQ(all.active_cells, grid.cell_count());
    for (const IntervalMesh* mesh : {&all, &parts}) {
      EXPECT_EQ(unmatched(*mesh), 0);
      EXPECT_EQ(broken_laws(grid, *mesh), "");
    }
    EXPECT_EQ(count_label(all, FacetLabel::lower) + count_label(all, FacetLabel::upper), 0);
    // What bounds one part from above bounds others from below.
    EXPECT_EQ(count_label(parts, FacetLabel::lower), count_label(parts, FacetLabel::upper));
    EXPECT_EQ(count_label(parts, FacetLabel::domain), count_label(all, FacetLabel::domain));
  }
}

TEST(ExtractWhole, FacetsSayOnWhichSideTheNeighbourIs) {
  const Grid grid = uniform_grid({9, 8, 7});
  std::mt19937_64 random(9);
  const std::vector<int> labels = random_labels(grid.cell_count(), random);
  const IntervalMesh mesh = whole(grid, cell_values(labels), {{1.5, 2.5}, {0, 3}});
  ASSERT_GT(mesh.facets.size(), 0u);
  for (const BoundaryFacet& facet : mesh.facets) {
    Vec3d middle{}, normal = cross(mesh.positions[facet.points[1]] - mesh.positions[facet.points[0]], mesh.positions[facet.points[2]] - mesh.positions[facet.points[0]]);
    for (const std::uint32_t p : facet.points) middle = middle + mesh.positions[p] * (1.0 / 3);
    const Vec3d beside = middle + normal * (0.25 / length(normal));
    const bool outside = beside.x < 0 || beside.y < 0 || beside.z < 0 || beside.x > 8 || beside.y > 7 || beside.z > 6;
    FacetLabel expected = FacetLabel::domain;
    if (!outside) {
      const int label = labels[static_cast<std::size_t>(std::floor(beside.x) + 8 * (std::floor(beside.y) + 7 * std::floor(beside.z)))];
      ASSERT_TRUE(label < mesh.summaries[facet.interval].interval.lower || label > mesh.summaries[facet.interval].interval.upper);
      expected = label < 2 ? FacetLabel::lower : FacetLabel::upper;
    }
    ASSERT_EQ(facet.label, expected) << "seed 9";
  }
}

TEST(ExtractWhole, OfAStructuredGridIsThatOfItsCellsWrittenOut) {
  std::mt19937_64 random(10);
  const Grid grid = grids(random)[1];
  const CellValues cells = cell_values(random_labels(grid.cell_count(), random));
  const IntervalMesh a = whole(grid, cells, {{1.5, 5}, {0, 1}}), b = whole(unstructured_grid(as_parts(grid)), cells, {{1.5, 5}, {0, 1}});
  for (const FacetLabel label : {FacetLabel::lower, FacetLabel::upper, FacetLabel::domain}) EXPECT_EQ(count_label(a, label), count_label(b, label));
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(a.summaries[i].active_cells, b.summaries[i].active_cells);
}

TEST(ExtractWhole, LeavesOutWhatIsHiddenOrHasNoValue) {
  Grid grid = uniform_grid({4, 2, 2});
  static const std::vector<std::uint8_t> hidden{0, 0, 1};
  const double nan = std::nan("");
  const IntervalMesh with_nan = whole(grid, cell_values(std::vector<double>{1, nan, 1}), {{0, 2}});
  EXPECT_EQ(with_nan.active_cells, 2);
  EXPECT_EQ(count_label(with_nan, FacetLabel::domain), 24);
  grid.hidden_cells = hidden;
  const IntervalMesh with_hidden = whole(grid, cell_values(std::vector<float>{1, 1, 1}), {{0, 2}});
  EXPECT_EQ(with_hidden.active_cells, 2);
  EXPECT_EQ(count_label(with_hidden, FacetLabel::domain), 20);
  EXPECT_NEAR(with_hidden.summaries[0].signed_volume, 2, 1e-14);
}

TEST(ExtractWhole, GoesOnAcrossTheSeamOfARing) {
  std::vector<Vec3d> points;
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 13; ++i) {
        const double angle = 2 * std::numbers::pi * (i % 12) / 12;
        points.push_back({(1 + j) * std::cos(angle), (1 + j) * std::sin(angle), double(k)});
      }
  const Grid grid = curvilinear_grid({13, 3, 3}, points);
  std::vector<int> labels(static_cast<std::size_t>(grid.cell_count()), 1);
  const IntervalMesh ring = whole(grid, cell_values(labels), {{0, 2}});
  EXPECT_EQ(count_label(ring, FacetLabel::domain), 2 * (2 * 12 * 2 + 2 * 12 * 2)) << "inside, outside, bottom and top";
  EXPECT_EQ(unmatched(ring), 0);
  for (std::size_t c = 0; c < labels.size(); c += 12) labels[c] = 7;  // the first cells beside the seam
  const IntervalMesh open = whole(grid, cell_values(labels), {{0, 2}});
  EXPECT_EQ(count_label(open, FacetLabel::upper), 2 * 2 * 4);
  EXPECT_EQ(unmatched(open), 0);
}

TEST(ExtractWhole, GivesTheSameFacetsAndSumsWithoutTetrahedra) {
  std::mt19937_64 random(11);
  for (const Grid& grid : grids(random)) {
    const CellValues cells = cell_values(random_labels(grid.cell_count(), random));
    ExtractOptions options;
    options.facets = true;
    const std::vector<Interval> intervals{{1.5, 2.5}, {2.5, 6}};
    const IntervalMesh full = extract_whole(grid, cells, intervals, options, Task());
    options.tetrahedra = false;
    const IntervalMesh facets = extract_whole(grid, cells, intervals, options, Task());
    EXPECT_TRUE(facets.tetrahedra.empty());
    ASSERT_EQ(facets.facets.size(), full.facets.size());
    for (std::size_t f = 0; f < facets.facets.size(); ++f) ASSERT_EQ(facets.facets[f].points, full.facets[f].points);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(facets.summaries[i].signed_volume, full.summaries[i].signed_volume);
      EXPECT_EQ(facets.summaries[i].tetrahedra, full.summaries[i].tetrahedra);
    }
  }
}

TEST(ExtractWhole, OfAFlatGridAreItsFaces) {
  const Grid grid = uniform_grid({5, 4, 1}, {}, {0.5, 2, 1});
  std::vector<int> labels(12, 1);
  labels[3] = labels[7] = 2;
  const IntervalMesh mesh = whole(grid, cell_values(labels), {{1.5, 2.5}, {3, 4}});
  EXPECT_EQ(mesh.summaries[0].active_cells, 2);
  EXPECT_NEAR(mesh.summaries[0].area, 2, 1e-14);
  EXPECT_EQ(mesh.summaries[1].triangles, 0);
  EXPECT_EQ(values_in_cells(mesh, cell_values(labels)), std::vector<float>(mesh.facets.size(), 2));
}

TEST(ExtractWhole, RefusesValuesThatAreNotOfTheCells) {
  EXPECT_THROW(whole(uniform_grid({3, 3, 3}), cell_values(std::vector<int>(27)), {{0, 1}}), Error);
}

TEST(WithOwnPoints, CellsShareNoPointAndLieWhereTheyWere) {
  std::mt19937_64 random(12);
  for (const Grid& grid : grids(random)) {
    const CellValues cells = cell_values(random_labels(grid.cell_count(), random));
    const IntervalMesh mesh = whole(grid, cells, {{1.5, 6}});
    const std::vector<float> values = values_in_cells(mesh, cells);
    const OwnPoints own = with_own_points(mesh, 1 << 30);
    ASSERT_EQ(own.mesh.tetrahedra.size(), mesh.tetrahedra.size());
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
      for (std::size_t v = 0; v < 4; ++v) {
        const std::uint32_t p = own.mesh.tetrahedra[t][v];
        ASSERT_EQ(own.point[p], mesh.tetrahedra[t][v]);
        ASSERT_EQ(own.mesh.positions[p], mesh.positions[mesh.tetrahedra[t][v]]);
        ASSERT_EQ(values[own.simplex[p]], values[t]) << "a point has the value of its cell";
      }
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
      for (std::size_t v = 0; v < 3; ++v) ASSERT_EQ(own.point[own.mesh.facets[f].points[v]], mesh.facets[f].points[v]);
  }
}

LayerRequest request_of(const Dataset& dataset) {
  LayerRequest request;
  request.array = dataset.arrays.front().name;
  request.intervals = {{0.2, 0.4}};
  request.values = FieldValues::whole;
  return request;
}

TEST(WholeLayers, OfPointsAreWhatIsNearestToThem) {
  for (const char* name : {"torus:12", "mixed:5", "tets:5"}) {
    const auto dataset = make_analytic(name, {}, Task());
    LayerRequest request = request_of(*dataset);
    const PointArray& array = dataset->arrays.front();
    request.intervals = {{array.lower, (array.lower + array.upper) / 2}, {(array.lower + array.upper) / 2, array.upper}};
    request.facets = true;
    const Layers layers = extract_layers(request, [&](int, const Task&) { return dataset; }, Task());
    EXPECT_NEAR(total_signed_volume(layers.mesh), grid_volume(dataset->grid), 1e-9 * grid_volume(dataset->grid)) << name;
    EXPECT_EQ(unmatched(layers.mesh), 0) << name;
    EXPECT_EQ(broken_laws(layers.dataset->grid, layers.mesh), "") << name;
  }
}

TEST(WholeLayers, RefuseWhatTheyCannotBe) {
  const auto dataset = make_analytic("torus:8", {}, Task());
  const auto code_of = [&](const LayerRequest& request) {
    try {
      extract_layers(request, [&](int, const Task&) { return dataset; }, Task());
      return ErrorCode::internal;
    } catch (const Error& error) {
      return error.code();
    }
  };
  LayerRequest combined = request_of(*dataset), between = combined, strict = combined;
  combined.terms = {{RangeOperator::intersect, dataset->arrays.front().name, {0, 1}}};
  between.time = 0;
  between.time_mode = TimeMode::interpolate;
  strict.triangulation = Triangulation::strict;
  for (const LayerRequest& request : {combined, between, strict}) EXPECT_EQ(code_of(request), ErrorCode::unsupported);
}

}  // namespace
}  // namespace isostrata
