// What nobody should write into a file, and what is said to it: a defined result or one clear line, never a crash.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include "support/run_isostrata.h"
#include "support/refined_cubes.h"
#include "support/run_json.h"
#include "support/truncated_cubes.h"
#include "support/voronoi_cells.h"
#include "support/vtk_text.h"

namespace {

using namespace isostrata::testing;
using isostrata::Vec3d;
using ::testing::HasSubstr;
namespace json = boost::json;

json::value extracted(const std::filesystem::path& file, const std::string& arguments) { return json_of("extract '" + file.string() + "' " + arguments); }

/// Exit 0, nothing unmatched, this volume.
void expect_volume(const std::filesystem::path& file, const std::string& arguments, double volume) {
  const json::value document = extracted(file, arguments);
  ASSERT_TRUE(document.is_object());
  EXPECT_NEAR(signed_volume(document), volume, 1e-9) << file << " " << arguments;
  EXPECT_EQ(number(document.at("unmatched_facets")), 0) << file << " " << arguments;
}

/// Exit 1, nothing on standard output, one line on standard error that says this.
void expect_refusal(const std::filesystem::path& file, const std::string& arguments, const std::string& says) {
  const CommandResult result = run_isostrata("extract '" + file.string() + "' " + arguments + " --json");
  EXPECT_EQ(result.status, 1) << file << ": " << result.err;
  EXPECT_EQ(result.out, "") << file;
  EXPECT_THAT(result.err, HasSubstr(says)) << file;
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
}

/// A raw NRRD of doubles with unit cells.
std::string nrrd(std::array<int, 3> points, const std::vector<double>& values) {
  std::string text = "NRRD0004\ntype: double\ndimension: 3\nsizes: " + std::to_string(points[0]) + " " +
                     std::to_string(points[1]) + " " + std::to_string(points[2]) + "\nendian: little\nencoding: raw\n\n";
  const std::size_t header = text.size();
  text.resize(header + values.size() * sizeof(double));
  std::memcpy(text.data() + header, values.data(), values.size() * sizeof(double));
  return text;
}

VtuText unit_cube() {
  VtuText vtu;
  for (const double z : {0.0, 1.0})
    for (const auto& [x, y] : std::vector<std::pair<double, double>>{{0, 0}, {1, 0}, {1, 1}, {0, 1}})
      vtu.points.push_back({x, y, z});
  vtu.add(12, {0, 1, 2, 3, 4, 5, 6, 7});
  vtu.point_array("f", "Float64", std::vector<double>{0, 0, 0, 0, 1, 1, 1, 1});
  return vtu;
}

TEST(BadInput, ValuesThatAreNotFiniteEmptyTheirCells) {
  const TemporaryFolder folder;
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, -infinity}) {
    std::vector<double> values(125, 0.5);
    values[62] = bad;  // the middle
    expect_volume(folder.write("n.nrrd", nrrd({5, 5, 5}, values)), "--interval 0:0.7 --interval 0.7:2", 64 - 8);
  }
  expect_volume(folder.write("n.nrrd", nrrd({5, 5, 5}, std::vector<double>(125, nan))), "--interval 0:1", 0);
}

TEST(BadInput, PositionsThatAreNotFiniteAreRefused) {
  const TemporaryFolder folder;
  for (const char* word : {"nan", "inf", "-inf", "1e999"}) {
    folder.write("g.xyz", std::string("2 2 2\n0 1 0 1 0 1 0 1\n0 0 1 1 0 0 1 1\n0 0 0 0 1 1 1 ") + word + "\n");
    folder.write("g.q", "2 2 2\n0 0 0 0\n1 2 3 4 5 6 7 8\n8*0\n8*0\n8*0\n8*1\n");
    const CommandResult result = run_isostrata("extract '" + (folder / "g.xyz").string() + "' --interval 0:1");
    EXPECT_EQ(result.status, 1) << word;
    EXPECT_THAT(result.err, HasSubstr("g.xyz")) << word;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  }
}

TEST(BadInput, GridsWithoutCellsAreNamed) {
  const TemporaryFolder folder;
  const auto expect_none = [](const std::filesystem::path& file) {
    const CommandResult result = run_isostrata("extract '" + file.string() + "' --interval 0:1");
    EXPECT_EQ(result.status, 1) << file;
    EXPECT_THAT(result.err, HasSubstr("no cells with a volume or an area")) << file;
  };
  for (const std::array<int, 3> dims : {std::array{5, 1, 1}, std::array{1, 1, 1}})
    expect_none(folder.write("n.nrrd", nrrd(dims, std::vector<double>(static_cast<std::size_t>(dims[0]), 0.5))));
  VtuText vtu = unit_cube();
  vtu.types.clear();
  vtu.connectivity.clear();
  vtu.offsets.clear();
  expect_none(folder.write("p.vtu", vtu.text()));
  expect_refusal(folder.write("e.vtu", VtuText().text()), "--interval 0:1", "e.vtu: ");
}

TEST(BadInput, ResultsOfEmptyMeshesCanBeWritten) {
  const TemporaryFolder folder;
  const auto file = folder.write("n.nrrd", nrrd({3, 3, 3}, std::vector<double>(27, 0.5)));
  for (const char* out : {"m.vtu", "m.ply", "m.stl"}) {
    expect_volume(file, "--interval 5:6 --out '" + (folder / out).string() + "'", 0);
    EXPECT_TRUE(std::filesystem::exists(folder / out)) << out;
  }
}

TEST(BadInput, OneCellConstantFieldsAndIntervalsOutside) {
  const TemporaryFolder folder;
  const auto cube = folder.write("c.vtu", unit_cube().text());
  expect_volume(cube, "--interval 0.25:0.5", 0.25);
  expect_volume(cube, "--interval 2:3", 0);
  expect_volume(cube, "--interval -3:-2", 0);
  expect_volume(cube, "--interval -1e300:1e300", 1);
  const auto constant = folder.write("n.nrrd", nrrd({3, 3, 3}, std::vector<double>(27, 0.5)));
  expect_volume(constant, "--interval 0:1", 8);
  expect_volume(constant, "--interval 0.5:1", 8);  // all values on the lower end
  expect_volume(constant, "--interval 0:0.5", 8);  // all on the upper end, closed
  const json::value both = extracted(constant, "--interval 0:0.5 --interval 0.5:1");
  ASSERT_TRUE(both.is_object());
  EXPECT_EQ(number(both.at("intervals").as_array()[0].at("tetrahedra")), 0)
      << "the shared value belongs to the one that begins there";
  EXPECT_NEAR(signed_volume(both), 8, 1e-12);
}

TEST(BadInput, ManyValuesOnAnIsovalueTileTheirGrid) {
  const TemporaryFolder folder;
  std::vector<double> values;
  for (int p = 0; p < 6 * 6 * 6; ++p) values.push_back(p * 7919 % 4);
  expect_volume(folder.write("n.nrrd", nrrd({6, 6, 6}, values)), "--interval 0:1 --interval 1:2 --interval 2:3", 125);
}

TEST(BadInput, IndicesAndOffsetsOutOfRangeAreRefused) {
  const TemporaryFolder folder;
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  const auto refused = [&](const char* what, const auto& change, const std::string& says) {
    SCOPED_TRACE(what);
    VtuText vtu = unit_cube();
    change(vtu);
    expect_refusal(folder.write("c.vtu", vtu.text()), "--interval 0:1", says);
  };
  refused(
      "point past the last", [](VtuText& v) { v.connectivity[3] = 8; }, "uses point 8 of 8");
  refused(
      "negative point", [](VtuText& v) { v.connectivity[3] = -1; }, "uses point -1 of 8");
  refused(
      "huge point", [](VtuText& v) { v.connectivity[3] = kMost; }, "of 8");
  refused(
      "offset past the connectivity", [](VtuText& v) { v.offsets[0] = 9; }, "c.vtu: ");
  refused(
      "offset whose successor overflows", [](VtuText& v) { v.offsets[0] = kMost; }, "c.vtu: ");
  refused(
      "negative offset", [](VtuText& v) { v.offsets[0] = std::numeric_limits<std::int64_t>::min(); }, "c.vtu: ");
  refused(
      "fewer points than the type has", [](VtuText& v) { v.offsets[0] = 7; }, "c.vtu: ");
  refused(
      "faces that overflow",
      [](VtuText& v) {
        v.types[0] = 42;
        v.any_polyhedron = true;
        v.faces = {kMost, 4, 0, 1, 2, 3};
        v.face_offsets = {6};
      },
      "c.vtu: ");
}

TEST(BadInput, SurfacesAmongSolidsAreLeftOut) {
  const TemporaryFolder folder;
  VtuText vtu = unit_cube();
  vtu.add(9, {0, 1, 2, 3});
  vtu.add(5, {0, 1, 2});
  vtu.add(1, {0});
  vtu.cell_array("c", "Float64", std::vector<double>{7, 1, 2, 3});
  const auto file = folder.write("c.vtu", vtu.text());
  expect_volume(file, "--interval 0.25:0.5", 0.25);
  expect_volume(file, "--array c --interval 6.5:7.5", 1);
}

TEST(BadInput, PolyhedraOfAllSortsConformAndTile) {
  const TemporaryFolder folder;
  for (const auto& mesh : {isostrata::test::truncated_cubes({3, 3, 3}, 31), isostrata::test::refined_cubes({3, 3, 3}, 31, 0.06),
                           isostrata::test::voronoi_cells({3, 3, 3}, 31)}) {
    VtuText vtu;
    vtu.points = mesh.points;
    std::vector<double> values;
    for (const auto& cell : mesh.cells) vtu.add_polyhedron(cell);
    for (const Vec3d& p : mesh.points) values.push_back(p.x + p.y + p.z);
    vtu.point_array("f", "Float64", values);
    const auto file = folder.write("p.vtu", vtu.text());
    expect_volume(file, "--interval 0:9", 27);
    expect_volume(file, "--interval 0:2.5 --interval 2.5:4 --interval 4:9", 27);
    expect_volume(file, "--interval 0:4.5", 13.5);  // half of the cube: the field is linear and stays so at added points
  }
}

TEST(BadInput, ConvexPointSetsConformAndTileHoweverSmallTheirFacesAre) {
  const TemporaryFolder folder;
  for (const double depth : {0.3, 5e-5}) {
    const auto mesh = isostrata::test::truncated_cubes({2, 3, 2}, 33, depth);
    VtuText vtu;
    vtu.points = mesh.points;
    for (const auto& cell : mesh.cells) {
      std::set<std::int64_t> ids;
      for (const auto& face : cell) ids.insert(face.begin(), face.end());
      vtu.add(41, {ids.begin(), ids.end()});
    }
    std::vector<double> values;
    for (const Vec3d& p : mesh.points) values.push_back(p.x + p.y + p.z);
    vtu.point_array("f", "Float64", values);
    const auto file = folder.write("set.vtu", vtu.text());
    expect_volume(file, "--interval 0:9", 12);
    expect_volume(file, "--interval 0:2.5 --interval 2.5:4 --interval 4:9 --verify", 12);
  }
}

TEST(BadInput, HiddenCellsAreNoPartOfAnything) {
  const TemporaryFolder folder;
  const std::vector<double> values(4 * 4 * 4, 0.5);
  std::vector<int> cells(27), points(64);
  cells[13] = 32;  // hidden
  cells[0] = 1;    // another piece has it
  points[63] = 2;  // hidden: its one cell
  points[5] = 1;   // duplicated: no matter
  const std::string field = data_array("f", "Float64", values);
  const std::string point_arrays = field + data_array("vtkGhostType", "UInt8", points);
  const std::string cell_arrays = data_array("vtkGhostType", "UInt8", cells);
  for (const auto& file : {folder.write("h.vti", vti_text({0, 0, 0}, {4, 4, 4}, point_arrays, cell_arrays)),
                           folder.write("h.vts", vts_text({4, 4, 4}, point_arrays, cell_arrays))}) {
    const json::value document = extracted(file, "--interval 0:1");
    ASSERT_TRUE(document.is_object());
    EXPECT_NEAR(signed_volume(document), 24, 1e-12);
    EXPECT_EQ(number(document.at("boundary_facets").at("domain")), 2 * (54 + 6))
        << "the hidden cells' neighbours bound the domain";
    EXPECT_EQ(number(document.at("unmatched_facets")), 0);
  }
}

}  // namespace
