// The PLOT3D reader: one flow written in every dialect is read as the same flow.
#include <gtest/gtest.h>

#include <cmath>

#include "data/files.h"

namespace isostrata {
namespace {

using test::open;
using test::refusal;
using test::Scratch;

using Dialect = testing::Plot3dDialect;

constexpr int kNi = 5, kNj = 4, kNk = 3, kPoints = kNi * kNj * kNk;

double coordinate(int axis, int p, int block) {
  const int i = p % kNi, j = p / kNi % kNj, k = p / (kNi * kNj);
  return axis == 0 ? i + 10 * block : axis == 1 ? j + 0.25 * i : k + 0.125 * j;
}
double value(int variable, int p, int block) { return 100 * variable + p + 0.5 + 1000 * block; }
int blank(int p) { return p == 0 ? 0 : p == 7 ? -1 : 1; }

std::vector<testing::Plot3dPart> parts(const Dialect& dialect) {
  std::vector<testing::Plot3dPart> out(dialect.multi ? 2 : 1);
  for (int b = 0; b < static_cast<int>(out.size()); ++b) {
    auto& part = out[static_cast<std::size_t>(b)];
    part.dims = {kNi, kNj, kNk};
    part.variables.resize(5);
    for (int p = 0; p < kPoints; ++p) {
      part.points.push_back({coordinate(0, p, b), coordinate(1, p, b), coordinate(2, p, b)});
      part.blanking.push_back(blank(p));
      for (int v = 0; v < 5; ++v) part.variables[static_cast<std::size_t>(v)].push_back(value(v, p, b));
    }
  }
  return out;
}

std::string grid_file(const Dialect& dialect) { return testing::plot3d_grid(dialect, parts(dialect)); }
std::string solution_file(const Dialect& dialect) { return testing::plot3d_solution(dialect, parts(dialect)); }

std::vector<Dialect> dialects() {
  std::vector<Dialect> all;
  for (const bool multi : {false, true})
    for (const bool blanking : {false, true}) {
      all.push_back({true, false, true, multi, blanking, 0});
      for (const bool big : {false, true})
        for (const bool doubles : {false, true})
          for (const int marker : {0, 4, 8}) all.push_back({false, big, doubles, multi, blanking, marker});
    }
  return all;
}

TEST(Plot3d, EveryDialectIsTheSameFlow) {
  const Scratch scratch;
  for (const Dialect& dialect : dialects()) {
    scratch.write("f.q", solution_file(dialect));
    const auto data = open(scratch.write("f.xyz", grid_file(dialect)));
    const int blocks = dialect.multi ? 2 : 1;
    ASSERT_EQ(data->grid.point_count(), blocks * kPoints) << dialect.name();
    ASSERT_EQ(data->grid.cell_count(), blocks * 4 * 3 * 2) << dialect.name();
    EXPECT_EQ(data->array("Density").type, dialect.doubles ? ScalarType::float64 : ScalarType::float32) << dialect.name();
    for (int b = 0; b < blocks; ++b)
      for (int p = 0; p < kPoints; ++p) {
        const int at = b * kPoints + p;
        ASSERT_EQ(data->grid.point(at), (Vec3d{coordinate(0, p, b), coordinate(1, p, b), coordinate(2, p, b)}))
            << dialect.name() << " " << p;
        const auto id = static_cast<std::size_t>(at);
        ASSERT_EQ(data->array("Density").at(id), value(0, p, b)) << dialect.name();
        ASSERT_EQ(data->array("Momentum_x").at(id), value(1, p, b)) << dialect.name();
        ASSERT_EQ(data->array("Momentum_z").at(id), value(3, p, b)) << dialect.name();
        ASSERT_EQ(data->array("StagnationEnergy").at(id), value(4, p, b)) << dialect.name();
        if (dialect.blanking) {
          ASSERT_EQ(data->array("IBlank").at(id), blank(p)) << dialect.name();
        }
      }
    // Only the first cell of each block uses point 0, the one whose blanking is 0.
    for (std::int64_t cell = 0; cell < data->grid.cell_count(); ++cell)
      EXPECT_EQ(data->grid.hidden(cell), dialect.blanking && cell % 24 == 0) << dialect.name() << " " << cell;
  }
}

TEST(Plot3d, BlankingWithoutZeroHidesNoCell) {
  const Scratch scratch;
  const Dialect dialect{.big = true, .blanking = true};
  auto with = parts(dialect);
  for (int& blank : with[0].blanking) blank = blank == 0 ? 1 : blank;  // -1 is a wall or a neighbour's number: part of the volume
  scratch.write("f.q", solution_file(dialect));
  const auto data = open(scratch.write("f.xyz", testing::plot3d_grid(dialect, with)));
  EXPECT_TRUE(data->grid.hidden_cells.empty());
  EXPECT_EQ(data->array("IBlank").lower, -1);
}

TEST(Plot3d, TwoDimensionalGridsLieInThePlane) {
  const Scratch scratch;
  for (Dialect dialect : dialects()) {
    dialect.dimensions = 2;
    auto flat = parts(dialect);
    for (auto& part : flat) {
      part.dims[2] = 1;
      part.points.resize(kNi * kNj);
      part.blanking.resize(kNi * kNj);
      part.variables.resize(4);
      for (auto& variable : part.variables) variable.resize(kNi * kNj);
    }
    scratch.write("f.q", testing::plot3d_solution(dialect, flat));
    const auto data = open(scratch.write("f.xyz", testing::plot3d_grid(dialect, flat)));
    ASSERT_EQ(data->grid.point_count(), static_cast<std::int64_t>(flat.size()) * kNi * kNj) << dialect.name();
    for (std::size_t p = 0; p < kNi * kNj; ++p) {
      const Vec3d& at = flat[0].points[p];
      ASSERT_EQ(data->grid.point(static_cast<std::int64_t>(p)), (Vec3d{at.x, at.y, 0})) << dialect.name();
      ASSERT_EQ(data->array("Momentum_y").at(p), value(2, static_cast<int>(p), 0)) << dialect.name();
      ASSERT_EQ(data->array("StagnationEnergy").at(p), value(3, static_cast<int>(p), 0)) << dialect.name();
    }
  }
}

TEST(Plot3d, OverflowsFurtherVariablesHaveNames) {
  const Scratch scratch;
  for (const Dialect& dialect : dialects()) {
    if (dialect.marker == 0) continue;
    auto more = parts(dialect);
    for (int b = 0; b < static_cast<int>(more.size()); ++b)
      for (int v = 5; v < 9; ++v) {
        auto& variable = more[static_cast<std::size_t>(b)].variables.emplace_back();
        for (int p = 0; p < kPoints; ++p) variable.push_back(value(v, p, b));
      }
    scratch.write("f.q", testing::plot3d_overflow(dialect, more, 2));
    const auto data = open(scratch.write("f.xyz", grid_file(dialect)));
    EXPECT_EQ(data->array("Density").at(3), value(0, 3, 0)) << dialect.name();
    EXPECT_EQ(data->array("StagnationEnergy").at(3), value(4, 3, 0)) << dialect.name();
    EXPECT_EQ(data->array("Gamma").at(3), value(5, 3, 0)) << dialect.name();
    EXPECT_EQ(data->array("Species Density 1").at(3), value(6, 3, 0)) << dialect.name();
    EXPECT_EQ(data->array("Species Density 2").at(3), value(7, 3, 0)) << dialect.name();
    EXPECT_EQ(data->array("Turb Field Quantity 1").at(3), value(8, 3, 0)) << dialect.name();
  }
}

TEST(Plot3d, FunctionFilesGoWithASolutionOrWithout) {
  for (const Dialect& dialect : dialects()) {
    if (dialect.blanking) continue;  // these are in the grid's file
    const Scratch scratch;
    const auto grid = scratch.write("f.xyz", grid_file(dialect));
    auto functions = parts(dialect);
    for (auto& part : functions) part.variables.erase(part.variables.begin());
    const auto file = scratch.write("f.f", testing::plot3d_functions(dialect, functions));
    for (const auto& opened : {grid, file}) {
      const auto data = open(opened);
      EXPECT_EQ(data->array("Function 0").at(5), value(1, 5, 0)) << dialect.name();
      EXPECT_EQ(data->array("Function 3").at(5), value(4, 5, 0)) << dialect.name();
      if (dialect.multi) {
        EXPECT_EQ(data->array("Function 3").at(kPoints + 5), value(4, 5, 1)) << dialect.name();
      }
    }
    scratch.write("f.q", solution_file(dialect));
    const auto both = open(grid);
    EXPECT_EQ(both->array("Density").at(5), value(0, 5, 0)) << dialect.name();
    EXPECT_EQ(both->array("Function 3").at(5), value(4, 5, 0)) << dialect.name();
  }
}

TEST(Plot3d, MomentumIsAVectorWithAMagnitude) {
  const Scratch scratch;
  scratch.write("f.q", solution_file({}));
  const auto data = open(scratch.write("f.xyz", grid_file({})));
  const PointArray& magnitude = data->array("Momentum");
  EXPECT_EQ(magnitude.components, 3);
  EXPECT_EQ(magnitude.component, "magnitude");
  EXPECT_EQ(data->array("Momentum_y").component, "y");
  EXPECT_EQ(data->array("Density").component, "");
  for (std::size_t p = 0; p < kPoints; ++p) {
    const Vec3d m{data->array("Momentum_x").at(p), data->array("Momentum_y").at(p), data->array("Momentum_z").at(p)};
    EXPECT_NEAR(magnitude.at(p), length(m), 1e-6 * (1 + length(m)));
  }
}

TEST(Plot3d, SolutionMayBeInAnotherDialectThanItsGrid) {
  const Scratch scratch;
  scratch.write("f.q", solution_file({.big = true, .doubles = false, .marker = 4}));
  const auto data = open(scratch.write("f.xyz", grid_file({.doubles = true})));
  EXPECT_EQ(data->array("Density").at(3), value(0, 3, 0));
}

TEST(Plot3d, SectorPaddingIsIgnoredAndOtherTrailingBytesAreNot) {
  const Scratch scratch;
  const auto grid = scratch.write("fxyz.bin", grid_file({}));
  std::string padded = solution_file({});
  padded.resize((padded.size() + 511) / 512 * 512, 'x');
  scratch.write("fq.bin", padded);
  EXPECT_EQ(open(grid)->array("Density").at(3), value(0, 3, 0));
  scratch.write("fq.bin", solution_file({}) + "more");
  EXPECT_EQ(refusal(grid).code(), ErrorCode::bad_data);
}

TEST(Plot3d, FindsTheSolutionByName) {
  for (const auto& [grid, solution] : std::vector<std::pair<std::string, std::string>>{{"axyz.bin", "aq.bin"},
                                                                                       {"A.XYZ", "A.Q"},
                                                                                       {"b.x", "b.q"},
                                                                                       {"c.g", "c.q"},
                                                                                       {"d.p3d", "d.q"},
                                                                                       {"e.grd", "e.q"},
                                                                                       {"xyz_case.xyz", "xyz_case.q"}}) {
    const Scratch scratch;
    scratch.write(solution, solution_file({}));
    EXPECT_EQ(open(scratch.write(grid, grid_file({})))->array("Density").at(3), value(0, 3, 0)) << grid;
    EXPECT_EQ(open(scratch / solution)->array("Density").at(3), value(0, 3, 0)) << solution;
  }
}

TEST(Plot3d, ReadsTextWithRepeatsCommasAndFortranExponents) {
  const Scratch scratch;
  const auto grid = scratch.write("t.xyz", "2 2 2\n0 1,0 1 0 1 0 1\n2*0 2*1 2*0 2*1\n4*0.0D+00 4*1.5d0\n");
  scratch.write("t.q", "2 2 2 4*0 1 2 3 4 5 6 7 8 24*0 8*+2.5E-1");
  const auto data = open(grid);
  EXPECT_EQ(data->grid.point(7), (Vec3d{1, 1, 1.5}));
  EXPECT_EQ(data->array("Density").at(6), 7);
  EXPECT_EQ(data->array("StagnationEnergy").upper, 0.25);
}

TEST(Plot3d, RefusesWithOneClearSentence) {
  const Scratch scratch;
  const auto said = [&](const std::filesystem::path& file, ErrorCode code, const std::string& part) {
    const Error error = refusal(file);
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what() << " should say " << part;
  };
  const auto grid = scratch.write("f.xyz", grid_file({}));
  said(grid, ErrorCode::not_found, "looked for f.q");
  scratch.write("f.q", solution_file({}).substr(0, 700));
  said(grid, ErrorCode::bad_data, "f.q: 5x4x3 points with 5 values each declared");
  scratch.write("f.q", "");
  said(grid, ErrorCode::bad_data, "f.q: is empty");
  scratch.write("f.q", solution_file({}));
  scratch.write("f.xyz", grid_file({}).substr(0, 500));
  said(grid, ErrorCode::bad_data, "5x4x3 points declared");
  scratch.write("f.xyz", "5 4 three");
  said(grid, ErrorCode::bad_data, "word 3 is 'three'");
  scratch.write("f.xyz", "2 2 2 99999999999*0");
  said(grid, ErrorCode::too_large, "limit");
  std::string hostile;
  for (int i = 0; i < 3; ++i) test::put(hostile, std::int32_t{0x7fffffff});
  scratch.write("f.xyz", hostile + std::string(1000, '\x01'));
  said(grid, ErrorCode::bad_data, "fit no PLOT3D dialect");
  said(scratch.write("lone.q", solution_file({})), ErrorCode::not_found, "no PLOT3D grid file");
}

}  // namespace
}  // namespace isostrata
