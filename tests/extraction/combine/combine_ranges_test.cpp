#include "extraction/combine/combine_ranges.h"

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "base/parallel.h"
#include "data/dataset/analytic.h"
#include "extraction/small_grids.h"

namespace isostrata {
namespace {

constexpr RangeOperator kAnd = RangeOperator::intersect, kOr = RangeOperator::unite, kMinus = RangeOperator::subtract,
                        kXor = RangeOperator::exclusive_or;
constexpr std::array kOperators{kAnd, kOr, kMinus, kXor};

Combined combine_all(const Grid& grid, const PointArray& array, const std::vector<Interval>& intervals,
                     const std::vector<ArrayTerm>& terms, const std::vector<const PointArray*>& carried = {}) {
  const Task task;
  const auto extract = [&](const Grid& on, const PointArray& a, std::span<const Interval> i, const ExtractOptions& options) {
    return extract_intervals(on, a, i, options, task);
  };
  CombineOptions options;
  options.facets = true;
  return combine_arrays(grid, array, intervals, terms, carried, extract, options, task);
}

IntervalMesh combine(const Grid& grid, const PointArray& array, const std::vector<Interval>& intervals,
                     const std::vector<ArrayTerm>& terms) {
  return combine_all(grid, array, intervals, terms).mesh;
}

double volume(const IntervalMesh& mesh) { return total_signed_volume(mesh); }

double volume_of_terms(const IntervalMesh& mesh) {
  double sum = 0;
  for (const IntervalSummary& summary : mesh.summaries)
    if (summary.term >= 0) sum += summary.signed_volume;
  return sum;
}

struct Field {
  Grid grid;
  std::vector<PointArray> arrays;  // four
  std::string name;
};

/// Random values, or whole numbers if ties are wanted: then ranges between whole numbers meet many points.
std::vector<PointArray> random_arrays(const Grid& grid, bool ties, std::mt19937_64& random) {
  std::vector<PointArray> arrays;
  for (int i = 0; i < 4; ++i) {
    auto values = random_values(grid.point_count(), 0, ties ? 6 : 1, random);
    if (ties)
      for (double& value : values) value = std::floor(value) / 5;
    arrays.push_back(point_array(values, "f" + std::to_string(i)));
  }
  return arrays;
}

Field tetrahedra(int points, bool ties, std::uint64_t seed) {
  const Task task;
  std::mt19937_64 random(seed);
  const auto dataset = make_analytic("tets:" + std::to_string(points), {}, task);
  const Grid grid = unstructured_grid(as_parts(dataset->grid, random_numbers(dataset->grid.point_count(), random)));
  return {grid, random_arrays(grid, ties, random), "tets, seed " + std::to_string(seed) + (ties ? ", ties" : "")};
}

/// Every kind of grid and cell.
std::vector<Field> all_kinds(bool ties, std::uint64_t seed) {
  const Task task;
  std::mt19937_64 random(seed);
  std::vector<Field> out;
  const auto add = [&](const Grid& grid, const std::string& name) {
    out.push_back({grid, random_arrays(grid, ties, random), name + ", seed " + std::to_string(seed) + (ties ? ", ties" : "")});
  };
  add(uniform_grid({5, 4, 4}, {1, 2, 3}, {0.5, 1, 0.25}), "uniform");
  add(uniform_grid({4, 4, 4}, {}, {-1, 1, 1}), "left-handed");
  const Grid cylinder = make_analytic("cylinder:8x5x4", {}, task)->grid;
  add(cylinder, "curvilinear");
  const auto mixed = make_analytic("mixed:5", {}, task);
  add(unstructured_grid(as_parts(mixed->grid, random_numbers(mixed->grid.point_count(), random))), "mixed");
  out.push_back(tetrahedra(5, ties, seed));
  return out;
}

std::vector<ArrayTerm> random_chain(const std::vector<PointArray>& arrays, int depth, bool ties, std::mt19937_64& random) {
  std::vector<ArrayTerm> chain;
  for (int k = 0; k < depth; ++k) {
    auto ends = random_values(2, 0.1, 0.9, random);
    std::sort(ends.begin(), ends.end());
    if (ties) ends = {std::floor(ends[0] * 5) / 5, std::floor(ends[1] * 5) / 5 + 0.2};
    chain.push_back({kOperators[random() % 4], &arrays[random() % arrays.size()], {ends[0], ends[1]}});
  }
  return chain;
}

// ---- laws of sets ----

TEST(CombineRanges, IntersectionAndDifferencePartitionTheInterval) {
  for (const bool ties : {false, true})
    for (std::uint64_t seed = 1; seed <= 6; ++seed)
      for (const Field& f : all_kinds(ties, seed)) {
        SCOPED_TRACE(f.name);
        const double all = volume(extract(f.grid, f.arrays[0], {{0.2, 0.8}}));
        const IntervalMesh in = combine(f.grid, f.arrays[0], {{0.2, 0.8}}, {{kAnd, &f.arrays[1], {0.4, 0.6}}});
        const IntervalMesh out = combine(f.grid, f.arrays[0], {{0.2, 0.8}}, {{kMinus, &f.arrays[1], {0.4, 0.6}}});
        EXPECT_GT(volume(in), 0);
        EXPECT_GT(volume(out), 0);
        EXPECT_NEAR(volume(in) + volume(out), all, 1e-12 * all);
        EXPECT_EQ(unmatched(in), 0);
        EXPECT_EQ(unmatched(out), 0);
      }
}

/// Triangles by their corners' positions.
std::set<std::array<std::array<double, 3>, 3>> triangles_on(const IntervalMesh& mesh, std::uint16_t range) {
  std::set<std::array<std::array<double, 3>, 3>> out;
  for (const BoundaryFacet& facet : mesh.facets) {
    if (facet.label == FacetLabel::domain || facet.range != range) continue;
    std::array<std::array<double, 3>, 3> corners;
    for (int i = 0; i < 3; ++i) {
      const Vec3d p = mesh.positions[facet.points[i]];
      corners[i] = {p.x, p.y, p.z};
    }
    std::sort(corners.begin(), corners.end());
    out.insert(corners);
  }
  return out;
}

/// From one base: without cells that are left out as idle, which differ between the two and with them the points' numbers.
TEST(CombineRanges, IntersectionAndDifferenceShareTheFacetsBetweenThem) {
  const Task task;
  for (const Field& f : all_kinds(false, 7)) {
    SCOPED_TRACE(f.name);
    const IntervalMesh base = extract(f.grid, f.arrays[0], {{0.2, 0.8}});
    const std::vector<Buffer<double>> fields{base.values, carry_values(base, exact_weights(base, f.arrays[0]), f.arrays[1])};
    const auto part = [&](RangeOperator op) {
      const std::vector<FieldTerm> terms{{op, 1, {0.4, 0.6}}};
      return combine_ranges(base, 1, fields, terms, {.facets = true}, task).mesh;
    };
    const IntervalMesh in = part(kAnd), out = part(kMinus);
    EXPECT_GT(triangles_on(in, 1).size(), 100u);
    EXPECT_EQ(triangles_on(in, 1), triangles_on(out, 1));
  }
}

TEST(CombineRanges, UnionsCountWhatIsInBothOnce) {
  for (const bool ties : {false, true})
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const Field f = tetrahedra(5, ties, seed);
      SCOPED_TRACE(f.name);
      const Interval a{0.2, 0.6}, b{0.4, 0.8};
      const double all_a = volume(extract(f.grid, f.arrays[0], {a})), all_b = volume(extract(f.grid, f.arrays[1], {b}));
      const double both = volume(combine(f.grid, f.arrays[0], {a}, {{kAnd, &f.arrays[1], b}}));
      const double either = volume(combine(f.grid, f.arrays[0], {a}, {{kOr, &f.arrays[1], b}}));
      const double one = volume(combine(f.grid, f.arrays[0], {a}, {{kXor, &f.arrays[1], b}}));
      EXPECT_GT(both, 0);
      EXPECT_NEAR(either, all_a + all_b - both, 1e-12 * either);
      EXPECT_NEAR(one, either - both, 1e-12 * either);
    }
}

TEST(CombineRanges, UnionsKeepTheIntervalAsItIsAndAddTheRest) {
  for (const bool ties : {false, true})
    for (std::uint64_t seed = 1; seed <= 6; ++seed)
      for (const Field& f : all_kinds(ties, seed)) {
        SCOPED_TRACE(f.name);
        const Interval a{0.2, 0.6}, b{0.4, 0.8};
        const IntervalMesh alone = extract(f.grid, f.arrays[0], {a});
        const IntervalMesh either = combine(f.grid, f.arrays[0], {a}, {{kOr, &f.arrays[1], b}});
        const IntervalMesh one = combine(f.grid, f.arrays[0], {a}, {{kXor, &f.arrays[1], b}});
        const IntervalMesh less = combine(f.grid, f.arrays[0], {a}, {{kMinus, &f.arrays[1], b}});
        const IntervalMesh rest = combine(f.grid, f.arrays[0], {a}, {{kOr, &f.arrays[1], b}, {kMinus, &f.arrays[0], a}});
        ASSERT_EQ(either.summaries.size(), 2u);
        EXPECT_EQ(either.summaries[0].term, -1);
        EXPECT_EQ(either.summaries[1].term, 0);
        EXPECT_EQ(either.summaries[1].interval, b);
        EXPECT_NEAR(either.summaries[0].signed_volume, volume(alone), 1e-12 * volume(alone));
        EXPECT_NEAR(one.summaries[0].signed_volume, volume(less), 1e-12 * volume(alone));
        EXPECT_NEAR(one.summaries[1].signed_volume, volume_of_terms(either), 1e-12 * volume(alone));
        EXPECT_EQ(rest.summaries[0].tetrahedra, 0) << "A is taken away again";
        EXPECT_NEAR(volume(rest), volume_of_terms(either), 1e-12 * volume(alone));
        EXPECT_EQ(unmatched(either), 0);
        EXPECT_EQ(unmatched(one), 0);
        EXPECT_EQ(unmatched(rest), 0);
      }
}

TEST(CombineRanges, OrderOfTermsOfOneKindMakesNoDifference) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    for (const RangeOperator op : kOperators) {
      const Field f = tetrahedra(4, seed % 2 == 0, seed);
      SCOPED_TRACE(f.name);
      const ArrayTerm b{op, &f.arrays[1], {0.2, 0.6}}, c{op, &f.arrays[2], {0.4, 0.8}};
      const double bc = volume(combine(f.grid, f.arrays[0], {{0.2, 0.8}}, {b, c}));
      EXPECT_NEAR(volume(combine(f.grid, f.arrays[0], {{0.2, 0.8}}, {c, b})), bc, 1e-12 * grid_volume(f.grid));
      if (op == kMinus) continue;  // the others commute with A, too
      const double ba = volume(combine(f.grid, f.arrays[1], {{0.2, 0.6}}, {{op, &f.arrays[0], {0.2, 0.8}}, c}));
      EXPECT_NEAR(ba, bc, 1e-12 * grid_volume(f.grid));
    }
}

TEST(CombineRanges, ARangeWithItselfIsItselfOrNothing) {
  for (const bool ties : {false, true})
    for (const Field& f : all_kinds(ties, 8)) {
      SCOPED_TRACE(f.name);
      const Interval a{0.2, 0.6};
      const IntervalMesh alone = extract(f.grid, f.arrays[0], {a});
      const IntervalMesh both = combine(f.grid, f.arrays[0], {a}, {{kAnd, &f.arrays[0], a}});
      EXPECT_EQ(both.tetrahedra.size(), alone.tetrahedra.size()) << "nothing is cut twice";
      EXPECT_EQ(volume(both), volume(alone));
      EXPECT_EQ(combine(f.grid, f.arrays[0], {a}, {{kMinus, &f.arrays[0], a}}).tetrahedra.size(), 0u);
      EXPECT_NEAR(volume(combine(f.grid, f.arrays[0], {a}, {{kOr, &f.arrays[0], a}})), volume(alone), 1e-12 * volume(alone));
      EXPECT_NEAR(volume(combine(f.grid, f.arrays[0], {a}, {{kXor, &f.arrays[0], a}})), 0, 1e-12 * volume(alone));
    }
}

TEST(CombineRanges, ATermAppliedTwiceCutsNothingTwice) {
  for (const bool ties : {false, true})
    for (const Field& f : all_kinds(ties, 9))
      for (const RangeOperator op : {kAnd, kMinus, kOr}) {
        SCOPED_TRACE(f.name);
        const ArrayTerm b{op, &f.arrays[1], {0.4, 0.6}};
        const IntervalMesh once = combine(f.grid, f.arrays[0], {{0.2, 0.8}}, {b});
        const IntervalMesh twice = combine(f.grid, f.arrays[0], {{0.2, 0.8}}, {b, b});
        EXPECT_EQ(twice.tetrahedra.size(), once.tetrahedra.size());
        EXPECT_EQ(volume(twice), volume(once));
        EXPECT_EQ(unmatched(twice), 0);
      }
}

// ---- against a slow, obvious way ----

using Corner = std::pair<std::array<long double, 3>, std::vector<long double>>;  // position and values
using Corners = std::array<Corner, 4>;

long double signed_volume(const Corners& t) {
  std::array<std::array<long double, 3>, 3> e;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) e[i][k] = t[i + 1].first[k] - t[0].first[k];
  return (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) - e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
          e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
         6;
}

/// Splits a tetrahedron at value `end` of a field by halving edges that cross it until none does.
void split(const Corners& t, std::size_t field, long double end, std::vector<Corners>& out) {
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 4; ++k) {
      const long double a = t[i].second[field], b = t[k].second[field];
      if (!(a < end && end < b)) continue;
      const long double w = (end - a) / (b - a);
      Corner middle = t[i];
      for (int x = 0; x < 3; ++x) middle.first[x] += (t[k].first[x] - t[i].first[x]) * w;
      for (std::size_t f = 0; f < middle.second.size(); ++f) middle.second[f] += (t[k].second[f] - t[i].second[f]) * w;
      middle.second[field] = end;
      for (const int replaced : {i, k}) {
        Corners part = t;
        part[replaced] = middle;
        split(part, field, end, out);
      }
      return;
    }
  out.push_back(t);
}

/// Of a piece that no end passes through: its middle is on an end only where the whole piece is.
bool lies_in(const Corners& t, std::size_t field, const Interval& range) {
  long double sum = 0;
  for (const Corner& corner : t) sum += corner.second[field];
  return sum / 4 >= range.lower && sum / 4 <= range.upper;
}

/// The volume of each label in one tetrahedron: every piece between the ends is asked on its own. Terms that are not finite at a
/// corner do not hold it.
std::map<int, long double> oracle(const Corners& whole, const Interval& a,
                                  const std::vector<std::pair<ArrayTerm, std::size_t>>& chain) {
  std::vector<bool> valid;
  for (std::size_t f = 0; f < whole[0].second.size(); ++f)
    valid.push_back(std::all_of(whole.begin(), whole.end(), [&](const Corner& c) { return std::isfinite(c.second[f]); }));
  std::vector<Corners> pieces{whole};
  const auto cut = [&](std::size_t field, double end) {
    std::vector<Corners> next;
    for (const Corners& piece : pieces) split(piece, field, end, next);
    pieces = std::move(next);
  };
  cut(0, a.lower);
  cut(0, a.upper);
  for (const auto& [term, field] : chain)
    for (const double end : {term.range.lower, term.range.upper})
      if (valid[field]) cut(field, end);
  std::map<int, long double> volumes;
  for (const Corners& piece : pieces) {
    int label = lies_in(piece, 0, a) ? 0 : -1, next = 1;
    for (const auto& [term, field] : chain) {
      const bool in = valid[field] && lies_in(piece, field, term.range);
      const int own = adds(term.op) ? next++ : -1;
      if (!combined(term.op, label >= 0, in))
        label = -1;
      else if (label < 0)
        label = own;
    }
    if (label >= 0) volumes[label] += std::abs(signed_volume(piece));
  }
  return volumes;
}

/// [cell][label] volumes of the mesh.
std::map<std::int64_t, std::map<int, double>> volumes_by_cell(const IntervalMesh& mesh) {
  std::map<std::int64_t, std::map<int, double>> out;
  for (std::size_t r = 0; r < mesh.cell_runs.size(); ++r) {
    const std::size_t end = r + 1 < mesh.cell_runs.size() ? mesh.cell_runs[r + 1].first_tetrahedron : mesh.tetrahedra.size();
    for (std::size_t t = mesh.cell_runs[r].first_tetrahedron; t < end; ++t) {
      const auto& p = mesh.tetrahedra[t];
      out[mesh.cell_runs[r].cell][mesh.tetrahedron_interval[t]] +=
          orient3d(mesh.positions[p[0]], mesh.positions[p[1]], mesh.positions[p[2]], mesh.positions[p[3]]) / 6;
    }
  }
  return out;
}

void expect_like_oracle(const Field& f, const std::vector<ArrayTerm>& chain) {
  const Interval a{0.2, 0.6};
  const IntervalMesh mesh = combine(f.grid, f.arrays[0], {a}, chain);
  EXPECT_EQ(unmatched(mesh), 0);
  auto found = volumes_by_cell(mesh);
  std::vector<std::pair<ArrayTerm, std::size_t>> fields;
  for (const ArrayTerm& term : chain) fields.emplace_back(term, term.array - f.arrays.data());
  std::array<std::int64_t, kMaxCellVertices> ids;
  for (std::int64_t cell = 0; cell < f.grid.cell_count(); ++cell) {
    f.grid.cell_points(cell, ids);
    Corners whole;
    for (int v = 0; v < 4; ++v) {
      const Vec3d p = f.grid.point(ids[v]);
      whole[v].first = {p.x, p.y, p.z};
      for (const PointArray& array : f.arrays) whole[v].second.push_back(array.at(ids[v]));
    }
    const auto expected = oracle(whole, a, fields);
    const double size = static_cast<double>(std::abs(signed_volume(whole)));
    for (int label = 0; label < static_cast<int>(mesh.summaries.size()); ++label) {
      const auto at = expected.find(label);
      ASSERT_NEAR(found[cell][label], at == expected.end() ? 0.0 : static_cast<double>(at->second), 1e-11 * size)
          << "cell " << cell << ", label " << label;
    }
  }
}

TEST(CombineRanges, DeepChainsAgreeWithCuttingEveryTetrahedronOnItsOwn) {
  for (const bool ties : {false, true})
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      std::mt19937_64 random(seed);
      const Field f = tetrahedra(3, ties, seed);
      SCOPED_TRACE(f.name);
      expect_like_oracle(f, random_chain(f.arrays, 6, ties, random));
    }
}

TEST(CombineRanges, EveryOperatorOnEveryOtherAgreesWithCuttingOnItsOwn) {
  for (const RangeOperator first : kOperators)
    for (const RangeOperator second : kOperators) {
      const Field f = tetrahedra(3, false, 20);
      SCOPED_TRACE(f.name + ", operators " + std::to_string(int(first)) + " and " + std::to_string(int(second)));
      expect_like_oracle(f, {{first, &f.arrays[1], {0.3, 0.7}}, {second, &f.arrays[2], {0.4, 0.8}}});
    }
}

// ---- conformity and labels ----

/// The volume that a label's facets enclose is that of its tetrahedra, and its surface is closed.
void expect_closed(const IntervalMesh& mesh) {
  std::vector<double> enclosed(mesh.summaries.size());
  std::map<std::tuple<int, std::uint32_t, std::uint32_t>, int> edges;
  for (const BoundaryFacet& facet : mesh.facets) {
    const auto& x = mesh.positions;
    enclosed[facet.interval] += dot(x[facet.points[0]], cross(x[facet.points[1]], x[facet.points[2]])) / 6;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = facet.points[i], b = facet.points[(i + 1) % 3];
      edges[{facet.interval, std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  for (std::size_t i = 0; i < mesh.summaries.size(); ++i)
    EXPECT_NEAR(enclosed[i], mesh.summaries[i].signed_volume, 1e-10 * (1 + mesh.summaries[i].volume)) << "label " << i;
  for (const auto& [edge, balance] : edges) ASSERT_EQ(balance, 0) << "an edge of the surface of label " << std::get<0>(edge);
}

/// Also across labels facets meet whole facets: none has two owners on one side, and where it has one owner only, just outside of
/// it is not inside the region.
void expect_conforming_across_labels(const IntervalMesh& mesh) {
  std::map<std::array<std::uint32_t, 3>, int> owners;
  for (const auto& t : mesh.tetrahedra)
    for (int i = 0; i < 4; ++i) {
      std::array<std::uint32_t, 3> p{t[(i + 1) % 4], t[(i + 2) % 4], t[(i + 3) % 4]};
      std::sort(p.begin(), p.end());
      ++owners[p];
    }
  // The surface of the whole, made of facets with one owner, encloses the whole and is closed: a facet that met parts of others
  // would leave edges open.
  double enclosed = 0;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const BoundaryFacet& facet : mesh.facets) {
    auto key = facet.points;
    std::sort(key.begin(), key.end());
    ASSERT_LE(owners[key], 2);
    if (owners[key] != 1) continue;
    const auto& x = mesh.positions;
    enclosed += dot(x[facet.points[0]], cross(x[facet.points[1]], x[facet.points[2]])) / 6;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = facet.points[i], b = facet.points[(i + 1) % 3];
      edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
    owners[key] = 0;
  }
  for (const auto& [key, count] : owners) ASSERT_NE(count, 1) << "a facet with one owner that is not listed";
  for (const auto& [edge, balance] : edges) ASSERT_EQ(balance, 0);
  EXPECT_NEAR(enclosed, volume(mesh), 1e-10 * (1 + volume(mesh)));
}

TEST(CombineRanges, ChainsConformOverAllKindsOfCells) {
  for (const bool ties : {false, true})
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      std::mt19937_64 random(seed + 100);
      for (const Field& f : all_kinds(ties, seed)) {
        SCOPED_TRACE(f.name);
        const auto chain = random_chain(f.arrays, static_cast<int>(seed), ties, random);
        const IntervalMesh mesh = combine(f.grid, f.arrays[0], tiling({0.2, 0.4, 0.6}), chain);
        EXPECT_EQ(unmatched(mesh), 0);
        expect_closed(mesh);
        expect_conforming_across_labels(mesh);
      }
    }
}

/// A surface between what is in and what is not, seen from one label: the facets of A's own surface where the other side is only
/// in the united range are on both labels, and whole.
TEST(CombineRanges, FacetsBetweenLabelsAreTheSameOnBothSides) {
  for (const Field& f : all_kinds(false, 10)) {
    SCOPED_TRACE(f.name);
    const IntervalMesh mesh = combine(f.grid, f.arrays[0], {{0.3, 0.6}}, {{kOr, &f.arrays[1], {0.3, 0.7}}});
    std::map<std::array<std::uint32_t, 3>, std::array<int, 2>> owners;  // by label
    for (const BoundaryFacet& facet : mesh.facets) {
      auto key = facet.points;
      std::sort(key.begin(), key.end());
      ++owners[key][facet.interval];
    }
    std::int64_t shared = 0;
    for (const BoundaryFacet& facet : mesh.facets) {
      if (facet.label == FacetLabel::domain || facet.range != 0) continue;
      auto key = facet.points;
      std::sort(key.begin(), key.end());
      shared += owners[key] == std::array{1, 1};
      if (facet.interval == 1) {
        ASSERT_EQ(owners[key], (std::array{1, 1})) << "only A's surface ends what was added";
      }
    }
    EXPECT_GT(shared, 100);
  }
}

TEST(CombineRanges, FacetsLieOnWhatTheySay) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    for (const Field& f : all_kinds(false, seed)) {
      SCOPED_TRACE(f.name);
      const std::vector<Interval> intervals{{0.2, 0.5}, {0.6, 0.8}};
      const std::vector<ArrayTerm> terms{
          {kAnd, &f.arrays[1], {0.1, 0.7}}, {kXor, &f.arrays[2], {0.3, 0.9}}, {kMinus, &f.arrays[3], {0.4, 0.5}}};
      const Combined all = combine_all(f.grid, f.arrays[0], intervals, terms, {&f.arrays[1], &f.arrays[2], &f.arrays[3]});
      std::set<std::pair<int, FacetLabel>> seen;
      for (const BoundaryFacet& facet : all.mesh.facets) {
        ASSERT_EQ(facet.interval, all.mesh.tetrahedron_interval[facet.tetrahedron]);
        if (facet.label == FacetLabel::domain) continue;
        seen.insert({facet.range, facet.label});
        const Interval range = facet.range < 2 ? intervals[facet.range] : terms[facet.range - 2].range;
        const auto& field = facet.range < 2 ? all.mesh.values : all.fields[facet.range - 1];
        for (const std::uint32_t p : facet.points)
          ASSERT_EQ(field[p], facet.label == FacetLabel::lower ? range.lower : range.upper);
      }
      EXPECT_EQ(seen.size(), 10u) << "both ends of both intervals and of the three terms";
    }
}

// A ball and a slab: on the sphere the normals are the radii, on the planes the axis, and on the edges between them there are none.
TEST(CombineRanges, SurfacesHaveTheDirectionOfTheArrayThatTheyAreOf) {
  for (const char* name : {"sphere:24", "tets:16"}) {
    SCOPED_TRACE(name);
    const auto dataset = make_analytic(name, {}, Task{});
    const Box3d box = dataset->bounds;
    const Vec3d center = (box.lower + box.upper) / 2.0, axis = normalized(Vec3d{1, 2, 3});
    const double size = box.diagonal();
    std::vector<double> radius, height;
    for (std::int64_t p = 0; p < dataset->grid.point_count(); ++p) {
      const Vec3d at = dataset->grid.point(p) - center;
      radius.push_back(length(at) / size);
      height.push_back(dot(at, axis) / size);
    }
    const PointArray ball = point_array(radius, "radius"), slab = point_array(height, "height");
    const std::vector<Interval> intervals{{-1, 0.22}};
    const std::vector<ArrayTerm> terms{{kAnd, &slab, {-0.1, 0.13}}};
    const auto extract = [&](const Grid& on, const PointArray& a, std::span<const Interval> i, const ExtractOptions& options) {
      return extract_intervals(on, a, i, options, Task{});
    };
    const Combined all = combine_arrays(dataset->grid, ball, intervals, terms, {}, extract, {.facets = true, .normals = true, .body_normals = true}, Task{});
    ASSERT_EQ(all.normals.size(), all.mesh.positions.size());
    ASSERT_EQ(all.body_normals.size(), all.mesh.positions.size());
    std::vector<std::set<int>> ranges(all.normals.size());
    for (const BoundaryFacet& facet : all.mesh.facets)
      for (const std::uint32_t p : facet.points) ranges[p].insert(facet.range);
    std::size_t on_ball = 0, on_slab = 0, on_edge = 0;
    for (std::size_t p = 0; p < ranges.size(); ++p) {
      const Vec3d n{all.normals[p].x, all.normals[p].y, all.normals[p].z};
      if (ranges[p].size() != 1) {
        ASSERT_EQ(n, Vec3d{}) << p;
        on_edge += ranges[p].size() == 2;
        continue;
      }
      const bool of_ball = *ranges[p].begin() == 0;
      const Vec3d body{all.body_normals[p].x, all.body_normals[p].y, all.body_normals[p].z}, out = all.mesh.positions[p] - center;
      if (length(out) > 0.1 * size) {
        ASSERT_GT(dot(body, normalized(out)), 0.9) << "the ball's everywhere, " << p;
      }
      ++(of_ball ? on_ball : on_slab);
      ASSERT_GT(dot(n, of_ball ? normalized(all.mesh.positions[p] - center) : axis), of_ball ? 0.99 : 0.99999) << p;
    }
    EXPECT_GT(on_ball, 100u);
    EXPECT_GT(on_slab, 100u);
    EXPECT_GT(on_edge, 10u);
    EXPECT_TRUE(combine_all(dataset->grid, ball, intervals, terms).normals.empty());
  }
}

TEST(CombineRanges, TetrahedraLieWhereTheirLabelSays) {
  for (const Field& f : all_kinds(false, 11)) {
    SCOPED_TRACE(f.name);
    const std::vector<Interval> intervals{{0.2, 0.5}, {0.6, 0.8}};
    const Combined all =
        combine_all(f.grid, f.arrays[0], intervals, {{kOr, &f.arrays[1], {0.3, 0.7}}, {kMinus, &f.arrays[2], {0.4, 0.9}}},
                    {&f.arrays[1], &f.arrays[2]});
    const auto middle = [&](const Buffer<double>& values, const std::array<std::uint32_t, 4>& t) {
      return (values[t[0]] + values[t[1]] + values[t[2]] + values[t[3]]) / 4;
    };
    const auto holds = [](const Interval& range, double value) {
      return value > range.lower - 1e-12 && value < range.upper + 1e-12;
    };
    ASSERT_EQ(all.mesh.summaries.size(), 3u);
    for (std::size_t t = 0; t < all.mesh.tetrahedra.size(); ++t) {
      const auto& points = all.mesh.tetrahedra[t];
      const int label = all.mesh.tetrahedron_interval[t];
      for (int i = 0; i < 2; ++i) {
        const double value = middle(all.mesh.values, points);
        if (label == i) {
          ASSERT_TRUE(holds(intervals[i], value));
        }
        if (label == 2) {
          ASSERT_FALSE(value > intervals[i].lower + 1e-12 && value < intervals[i].upper - 1e-12);
        }
      }
      if (label == 2) {
        ASSERT_TRUE(holds({0.3, 0.7}, middle(all.fields[1], points)));
      }
      const double removed = middle(all.fields[2], points);
      ASSERT_FALSE(removed > 0.4 + 1e-12 && removed < 0.9 - 1e-12);
    }
  }
}

TEST(CombineRanges, RunsGroupTetrahedraByCell) {
  for (const Field& f : all_kinds(false, 12)) {
    SCOPED_TRACE(f.name);
    const IntervalMesh mesh =
        combine(f.grid, f.arrays[0], {{0.2, 0.6}}, {{kXor, &f.arrays[1], {0.3, 0.7}}, {kAnd, &f.arrays[2], {0.4, 0.9}}});
    ASSERT_FALSE(mesh.cell_runs.empty());
    EXPECT_EQ(mesh.cell_runs[0].first_tetrahedron, 0u);
    std::set<std::int64_t> seen;
    EXPECT_EQ(mesh.active_cells, static_cast<std::int64_t>(mesh.cell_runs.size()));
    std::array<std::int64_t, kMaxCellVertices> ids;
    for (std::size_t r = 0; r < mesh.cell_runs.size(); ++r) {
      const std::size_t end = r + 1 < mesh.cell_runs.size() ? mesh.cell_runs[r + 1].first_tetrahedron : mesh.tetrahedra.size();
      ASSERT_LT(mesh.cell_runs[r].first_tetrahedron, end);
      ASSERT_TRUE(seen.insert(mesh.cell_runs[r].cell).second);
      const int n = f.grid.cell_points(mesh.cell_runs[r].cell, ids);
      Box3d box;
      for (int v = 0; v < n; ++v) box.include(f.grid.point(ids[v]));
      for (std::size_t t = mesh.cell_runs[r].first_tetrahedron; t < end; ++t)
        for (const std::uint32_t p : mesh.tetrahedra[t])
          for (int axis = 0; axis < 3; ++axis) {
            ASSERT_GE(mesh.positions[p][axis], box.lower[axis] - 1e-12);
            ASSERT_LE(mesh.positions[p][axis], box.upper[axis] + 1e-12);
          }
    }
  }
}

TEST(CombineRanges, ManyTouchingAndOverlappingIntervalsKeepTheirOwnTetrahedra) {
  for (const Field& f : all_kinds(true, 13)) {
    SCOPED_TRACE(f.name);
    const std::vector<Interval> intervals{{0.2, 0.4}, {0.4, 0.6}, {0.3, 0.8}, {0.9, 0.95}};
    for (const RangeOperator op : kOperators) {
      const IntervalMesh together = combine(f.grid, f.arrays[0], intervals, {{op, &f.arrays[1], {0.2, 0.6}}});
      EXPECT_EQ(unmatched(together), 0);
      expect_closed(together);
      const IntervalMesh all = extract(f.grid, f.arrays[0], intervals);
      for (std::size_t i = 0; i < intervals.size(); ++i) {
        if (op == kOr) {
          EXPECT_NEAR(together.summaries[i].signed_volume, all.summaries[i].signed_volume, 1e-12 * volume(all));
        }
        if (op == kMinus || op == kXor) {
          const IntervalMesh both = combine(f.grid, f.arrays[0], intervals, {{kAnd, &f.arrays[1], {0.2, 0.6}}});
          EXPECT_NEAR(together.summaries[i].signed_volume + both.summaries[i].signed_volume, all.summaries[i].signed_volume,
                      1e-12 * volume(all));
        }
      }
    }
  }
}

// ---- values that are none ----

TEST(CombineRanges, WhereAnArrayHasNoValueIsOutsideOfItsRange) {
  for (const double hole : {kNaN, std::numeric_limits<double>::infinity()})
    for (const bool ties : {false, true})
      for (std::uint64_t seed = 1; seed <= 3; ++seed)
        for (Field& f : all_kinds(ties, seed)) {
          SCOPED_TRACE(f.name);
          std::mt19937_64 random(seed);
          std::vector<double> holed;
          for (std::int64_t p = 0; p < f.grid.point_count(); ++p) holed.push_back(random() % 8 == 0 ? hole : f.arrays[1].at(p));
          const PointArray b = point_array(holed);
          const double all = volume(extract(f.grid, f.arrays[0], {{0.2, 0.8}}));
          const IntervalMesh in = combine(f.grid, f.arrays[0], {{0.2, 0.8}}, {{kAnd, &b, {0.4, 0.6}}});
          const IntervalMesh out = combine(f.grid, f.arrays[0], {{0.2, 0.8}}, {{kMinus, &b, {0.4, 0.6}}});
          const IntervalMesh either = combine(f.grid, f.arrays[0], {{0.2, 0.8}}, {{kOr, &b, {0.4, 0.6}}});
          const IntervalMesh one = combine(f.grid, f.arrays[0], {{0.2, 0.8}}, {{kXor, &b, {0.4, 0.6}}});
          EXPECT_NEAR(volume(in) + volume(out), all, 1e-12 * all);
          EXPECT_NEAR(either.summaries[0].signed_volume, all, 1e-12 * all);
          EXPECT_NEAR(one.summaries[0].signed_volume, volume(out), 1e-12 * all);
          EXPECT_NEAR(one.summaries[1].signed_volume, either.summaries[1].signed_volume, 1e-12 * all);
          for (const IntervalMesh* mesh : {&in, &out, &either, &one}) {
            EXPECT_EQ(unmatched(*mesh), 0);
            expect_closed(*mesh);
            expect_conforming_across_labels(*mesh);
          }
        }
}

TEST(CombineRanges, ChainsOverHolesAgreeWithCuttingOnItsOwn) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    std::mt19937_64 random(seed);
    Field f = tetrahedra(3, seed % 2 == 0, seed);
    SCOPED_TRACE(f.name);
    for (int i = 1; i < 4; ++i) {
      std::vector<double> values;
      for (std::int64_t p = 0; p < f.grid.point_count(); ++p) values.push_back(random() % 6 == 0 ? kNaN : f.arrays[i].at(p));
      f.arrays[i] = point_array(values);
    }
    expect_like_oracle(f, random_chain(f.arrays, 1 + seed % 4, seed % 2 == 0, random));
  }
}

// ---- what is promised besides ----

TEST(CombineRanges, LeavingIdleCellsOutChangesNothing) {
  const Task task;
  for (const bool ties : {false, true})
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      std::mt19937_64 random(seed);
      for (const Field& f : all_kinds(ties, seed)) {
        SCOPED_TRACE(f.name);
        const auto chain = random_chain(f.arrays, 3, ties, random);
        const IntervalMesh quick = combine(f.grid, f.arrays[0], {{0.4, 0.6}}, chain);
        ExtractOptions options;
        options.facets = options.complement = true;
        const std::vector<Interval> intervals{{0.4, 0.6}};
        IntervalMesh base = extract_intervals(f.grid, f.arrays[0], intervals, options, task);
        std::vector<Buffer<double>> fields{base.values};
        for (int i = 1; i < 4; ++i) fields.push_back(carry_values(base, exact_weights(base, f.arrays[0]), f.arrays[i]));
        std::vector<FieldTerm> terms;
        for (const ArrayTerm& term : chain)
          terms.push_back({term.op, static_cast<int>(term.array - f.arrays.data()), term.range});
        const Combined plain = combine_ranges(base, 1, fields, terms, {.facets = true}, task);
        ASSERT_EQ(quick.summaries.size(), plain.mesh.summaries.size());
        for (std::size_t i = 0; i < plain.mesh.summaries.size(); ++i)
          EXPECT_NEAR(quick.summaries[i].signed_volume, plain.mesh.summaries[i].signed_volume, 1e-12 * grid_volume(f.grid));
        if (!f.grid.structured()) continue;  // points are numbered otherwise there: the same parts fall into other tetrahedra
        EXPECT_EQ(quick.tetrahedra.size(), plain.mesh.tetrahedra.size());
        EXPECT_EQ(quick.facets.size(), plain.mesh.facets.size());
      }
    }
}

TEST(CombineRanges, TheResultDoesNotDependOnThreads) {
  const Task task;
  const auto dataset = make_analytic("mixed:9", {}, task);
  std::mt19937_64 random(14);
  const auto arrays = random_arrays(dataset->grid, false, random);
  const auto run = [&] {
    return combine(dataset->grid, arrays[0], {{0.2, 0.6}}, {{kXor, &arrays[1], {0.3, 0.7}}, {kMinus, &arrays[2], {0.4, 0.6}}});
  };
  set_thread_count(1);
  const IntervalMesh one = run();
  set_thread_count(4);
  const IntervalMesh four = run();
  set_thread_count(0);
  EXPECT_EQ(one.positions, four.positions);
  EXPECT_EQ(one.tetrahedra, four.tetrahedra);
  EXPECT_EQ(one.values, four.values);
  EXPECT_EQ(volume(one), volume(four));
  ASSERT_EQ(one.facets.size(), four.facets.size());
  for (std::size_t i = 0; i < one.facets.size(); ++i) ASSERT_EQ(one.facets[i].points, four.facets[i].points);
}

TEST(CombineRanges, CarriedArraysAreLinearInEachTetrahedron) {
  const Task task;
  const auto dataset = make_analytic("mixed:8", {}, task);
  const Grid& grid = dataset->grid;
  std::vector<double> slope, other;
  for (std::int64_t p = 0; p < grid.point_count(); ++p) {
    const Vec3d at = grid.point(p);
    slope.push_back(3 * at.x - 2 * at.y + 0.5 * at.z);
    other.push_back(at.x + at.y + at.z);
  }
  const PointArray b = point_array(slope, "slope"), c = point_array(other, "other");
  const Combined all = combine_all(grid, dataset->arrays[0], {{0.3, 0.6}}, {{kOr, &b, {0.2, 0.7}}, {kMinus, &c, {-0.2, 0.3}}},
                                   {&c, &dataset->arrays[0], &b, &c});
  ASSERT_EQ(all.fields.size(), 5u);
  ASSERT_GT(all.mesh.positions.size(), 1000u);
  for (std::size_t i = 0; i < all.mesh.positions.size(); ++i) {
    const Vec3d at = all.mesh.positions[i];
    ASSERT_NEAR(all.fields[3][i], 3 * at.x - 2 * at.y + 0.5 * at.z, 1e-13);
    ASSERT_NEAR(all.fields[1][i], at.x + at.y + at.z, 1e-13);
  }
  EXPECT_EQ(all.fields[2], all.mesh.values);
  EXPECT_EQ(all.fields[4], all.fields[1]);
}

TEST(CombineRanges, LinearFieldsGiveTheVolumesOfBoxes) {
  const Grid grid = uniform_grid({11, 11, 11}, {}, {0.1, 0.1, 0.1});
  std::vector<double> x, y, z;
  for (std::int64_t p = 0; p < grid.point_count(); ++p) {
    x.push_back(grid.point(p).x);
    y.push_back(grid.point(p).y);
    z.push_back(grid.point(p).z);
  }
  const PointArray fx = point_array(x), fy = point_array(y), fz = point_array(z);
  const Interval a{0.15, 0.65}, b{0.33, 0.83}, c{0.07, 0.57};
  const auto of = [&](const std::vector<ArrayTerm>& terms) { return volume(combine(grid, fx, {a}, terms)); };
  EXPECT_NEAR(of({{kAnd, &fy, b}}), 0.25, 1e-13);
  EXPECT_NEAR(of({{kAnd, &fy, b}, {kAnd, &fz, c}}), 0.125, 1e-13);
  EXPECT_NEAR(of({{kMinus, &fy, b}}), 0.25, 1e-13);
  EXPECT_NEAR(of({{kOr, &fy, b}}), 0.75, 1e-13);
  EXPECT_NEAR(of({{kOr, &fy, b}, {kOr, &fz, c}}), 0.875, 1e-13);
  EXPECT_NEAR(of({{kXor, &fy, b}}), 0.5, 1e-13);
  EXPECT_NEAR(of({{kXor, &fy, b}, {kXor, &fz, c}}), 0.5, 1e-13);
  EXPECT_NEAR(of({{kOr, &fy, b}, {kMinus, &fz, c}}), 0.375, 1e-13);
}

TEST(CombineRanges, BothEndsOfARangeAreInIt) {
  const Grid grid = uniform_grid({3, 3, 3});
  const PointArray a = point_array(std::vector<double>(27, 0.5)), b = point_array(std::vector<std::uint8_t>(27, 255));
  EXPECT_NEAR(volume(combine(grid, a, {{0, 1}}, {{kAnd, &b, {128, 255}}})), 8, 1e-14);
  EXPECT_NEAR(volume(combine(grid, a, {{0, 1}}, {{kAnd, &b, {255, 300}}})), 8, 1e-14);
  EXPECT_EQ(combine(grid, a, {{0, 1}}, {{kMinus, &b, {128, 255}}}).tetrahedra.size(), 0u);
  EXPECT_EQ(combine(grid, a, {{0, 1}}, {{kMinus, &b, {255, 300}}}).tetrahedra.size(), 0u);
  EXPECT_NEAR(volume(combine(grid, b, {{0, 255}}, {{kOr, &a, {0.5, 1}}})), 8, 1e-14) << "A's end, with its complement";
  EXPECT_NEAR(combine(grid, b, {{0, 255}}, {{kOr, &a, {0.5, 1}}}).summaries[0].signed_volume, 8, 1e-14);
}

TEST(CombineRanges, EmptyResultsAreEmptyMeshes) {
  const Field f = tetrahedra(4, false, 15);
  for (const RangeOperator op : {kAnd, kOr, kXor}) {
    const IntervalMesh mesh = combine(f.grid, f.arrays[0], {{5, 6}}, {{op, &f.arrays[1], {7, 8}}});
    EXPECT_TRUE(mesh.tetrahedra.empty() && mesh.positions.empty() && mesh.facets.empty() && mesh.cell_runs.empty());
    EXPECT_EQ(mesh.cells, f.grid.cell_count());
  }
}

TEST(CombineRanges, LeavesHiddenCellsOut) {
  Grid grid = uniform_grid({4, 4, 4});
  std::vector<std::uint8_t> hidden(27);
  hidden[13] = 1;
  grid.hidden_cells = hidden;
  const PointArray a = point_array(std::vector<double>(64, 0.5)), b = point_array(std::vector<double>(64, 2.0));
  const IntervalMesh mesh = combine(grid, a, {{0.7, 1}}, {{kOr, &b, {1, 3}}});
  EXPECT_NEAR(volume(mesh), 26, 1e-12);
  EXPECT_EQ(count_label(mesh, FacetLabel::domain), 2 * (54 + 6));
  EXPECT_EQ(unmatched(mesh), 0);
}

ErrorCode code_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.code();
  }
  return ErrorCode{};
}

TEST(CombineRanges, RefusesWhatIsNoRangeAndWhatDoesNotFit) {
  const Field f = tetrahedra(6, false, 16);
  const auto& a = f.arrays;
  EXPECT_EQ(code_of([&] { combine(f.grid, a[0], {{0, 1}}, {{kAnd, &a[1], {0.6, 0.4}}}); }), ErrorCode::invalid_argument);
  EXPECT_EQ(code_of([&] { combine(f.grid, a[0], {{0, 1}}, {{kAnd, &a[1], {0.4, kNaN}}}); }), ErrorCode::invalid_argument);
  EXPECT_EQ(code_of([&] { combine(f.grid, a[0], {}, {{kAnd, &a[1], {0.4, 0.6}}}); }), ErrorCode::invalid_argument);
  const PointArray shorter = point_array(std::vector<double>(3));
  EXPECT_EQ(code_of([&] { combine(f.grid, a[0], {{0, 1}}, {{kAnd, &shorter, {0.4, 0.6}}}); }), ErrorCode::invalid_argument);

  const Task task;
  ExtractOptions whole;
  whole.complement = true;
  const std::vector<Interval> intervals{{0.2, 0.6}};
  const IntervalMesh base = extract_intervals(f.grid, a[0], intervals, whole, task);
  const std::vector<Buffer<double>> fields{base.values, carry_values(base, exact_weights(base, a[0]), a[1])};
  const std::vector<FieldTerm> terms{{kOr, 1, {0.3, 0.7}}};
  EXPECT_EQ(code_of([&] { combine_ranges(base, 1, fields, terms, {.max_bytes = 100'000}, task); }), ErrorCode::too_large);
  Task cancelled;
  cancelled.cancel();
  EXPECT_EQ(code_of([&] { combine_ranges(base, 1, fields, terms, {}, cancelled); }), ErrorCode::cancelled);
}

}  // namespace
}  // namespace isostrata
