// The PLOT3D reader: one flow written in every dialect is read as the same flow.
#include <gtest/gtest.h>

#include <cmath>

#include "data/files.h"

namespace isostrata {
namespace {

using test::open;
using test::refusal;
using test::Scratch;

struct Dialect {
  bool text = false, big = false, doubles = false, multi = false, blanking = false;
  int marker = 0;

  std::string name() const {
    return std::string(text  ? "text"
                       : big ? "big"
                             : "little") +
           (doubles ? "_f64" : "_f32") + (multi ? "_multi" : "_single") + (blanking ? "_iblank" : "") +
           (marker ? "_records" + std::to_string(marker) : "");
  }
};

/// Writes Fortran-like output in a dialect.
class Writer {
 public:
  explicit Writer(const Dialect& dialect) : dialect_(dialect) {}
  void integer(int value) {
    if (dialect_.text)
      record_ += " " + std::to_string(value);
    else
      test::put(record_, static_cast<std::int32_t>(value), dialect_.big);
  }
  void real(double value) {
    if (dialect_.text) {
      char word[40];
      std::snprintf(word, sizeof word, " %.17g", value);
      record_ += word;
    } else if (dialect_.doubles) {
      test::put(record_, value, dialect_.big);
    } else {
      test::put(record_, static_cast<float>(value), dialect_.big);
    }
  }
  void end_record() {
    const auto mark = [&] {
      if (dialect_.text) return;
      if (dialect_.marker == 4) test::put(bytes, static_cast<std::uint32_t>(record_.size()), dialect_.big);
      if (dialect_.marker == 8) test::put(bytes, static_cast<std::uint64_t>(record_.size()), dialect_.big);
    };
    mark();
    bytes += record_;
    mark();
    if (dialect_.text) bytes += "\n";
    record_.clear();
  }
  std::string bytes;

 private:
  Dialect dialect_;
  std::string record_;
};

constexpr int kNi = 5, kNj = 4, kNk = 3, kPoints = kNi * kNj * kNk;

double coordinate(int axis, int p, int block) {
  const int i = p % kNi, j = p / kNi % kNj, k = p / (kNi * kNj);
  return axis == 0 ? i + 10 * block : axis == 1 ? j + 0.25 * i : k + 0.125 * j;
}
double value(int variable, int p, int block) { return 100 * variable + p + 0.5 + 1000 * block; }
int blank(int p) { return p == 0 ? 0 : p == 7 ? -1 : 1; }

void header(Writer& writer, const Dialect& dialect, int blocks) {
  if (dialect.multi) {
    writer.integer(blocks);
    writer.end_record();
  }
  for (int b = 0; b < blocks; ++b)
    for (const int n : {kNi, kNj, kNk}) writer.integer(n);
  writer.end_record();
}

std::string grid_file(const Dialect& dialect) {
  Writer writer(dialect);
  const int blocks = dialect.multi ? 2 : 1;
  header(writer, dialect, blocks);
  for (int b = 0; b < blocks; ++b) {
    for (int axis = 0; axis < 3; ++axis)
      for (int p = 0; p < kPoints; ++p) writer.real(coordinate(axis, p, b));
    if (dialect.blanking)
      for (int p = 0; p < kPoints; ++p) writer.integer(blank(p));
    writer.end_record();
  }
  return writer.bytes;
}

std::string solution_file(const Dialect& dialect) {
  Writer writer(dialect);
  const int blocks = dialect.multi ? 2 : 1;
  header(writer, dialect, blocks);
  for (int b = 0; b < blocks; ++b) {
    for (const double constant : {0.8, 1.5, 1e6, 2.25}) writer.real(constant);
    writer.end_record();
    for (int variable = 0; variable < 5; ++variable)
      for (int p = 0; p < kPoints; ++p) writer.real(value(variable, p, b));
    writer.end_record();
  }
  return writer.bytes;
}

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
