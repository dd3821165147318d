// Grids whose cells have an area and no volume, from file to picture.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <fstream>

#include "support/run_isostrata.h"

namespace {

using namespace isostrata::testing;
using ::testing::HasSubstr;

void write(const std::filesystem::path& path, const std::string& text) { std::ofstream(path) << text; }

/// x over the unit square of 3 x 3 points, and a cell array.
const std::string kSquare =
    "# vtk DataFile Version 3.0\nsquare\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 3 1\nORIGIN 0 0 0\nSPACING 0.5 0.5 1\n"
    "CELL_DATA 4\nSCALARS number int 1\nLOOKUP_TABLE default\n1 2 3 4\n"
    "POINT_DATA 9\nSCALARS x double 1\nLOOKUP_TABLE default\n0 0.5 1 0 0.5 1 0 0.5 1\n";

/// A triangle, a quadrilateral and a pentagon beside each other, and a line that is skipped.
const std::string kMesh =
    "# vtk DataFile Version 3.0\nmesh\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 double\n"
    "0 0 0  1 0 0  1 1 0  0 1 0  2 0 0  2 1 0  0.5 2 0  2.5 0.5 0\n"
    "CELLS 4 17\n4 0 1 2 3\n3 3 2 6\n4 1 4 5 2\n2 4 7\nCELL_TYPES 4\n9\n5\n7\n3\n"
    "POINT_DATA 8\nSCALARS y double 1\nLOOKUP_TABLE default\n0 0 1 1 0 1 2 0.5\n";

TEST(FlatGrids, AreCutAsAreas) {
  const TemporaryFolder folder;
  write(folder / "square.vtk", kSquare);
  const CommandResult result =
      run_isostrata("extract '" + (folder / "square.vtk").string() + "' --array x --interval 0.2:0.7 --json --verify");
  ASSERT_EQ(result.status, 0) << result.err;
  const auto document = boost::json::parse(result.out);
  EXPECT_EQ(document.at("cells").to_number<int>(), 4);
  EXPECT_NEAR(document.at("intervals").at(0).at("area").as_double(), 0.5, 1e-12);
  EXPECT_THAT(run_isostrata("extract '" + (folder / "square.vtk").string() + "' --array x --interval 0.2:0.7").out,
              HasSubstr("4 of 4 cells active"));
}

TEST(FlatGrids, OfTrianglesQuadrilateralsAndPolygonsAreReadAndWritten) {
  const TemporaryFolder folder;
  write(folder / "mesh.vtk", kMesh);
  const CommandResult info = run_isostrata("info '" + (folder / "mesh.vtk").string() + "'");
  EXPECT_THAT(info.out, HasSubstr("quadrilateral 1"));
  EXPECT_THAT(info.out, HasSubstr("triangle 3"));
  const auto out = (folder / "part.vtu").string();
  const CommandResult result = run_isostrata("extract '" + (folder / "mesh.vtk").string() + "' --interval 0.5:1.5 --json --out '" + out + "'");
  ASSERT_EQ(result.status, 0) << result.err;
  const double area = boost::json::parse(result.out).at("intervals").at(0).at("area").as_double();
  EXPECT_NEAR(area, 0.5 + 0.5 + 0.75 * 0.5, 1e-12);  // half of each square, and the triangle up to half of its height
  // What was written is a flat grid again, of the same area.
  const CommandResult again = run_isostrata("extract '" + out + "' --array y --interval -1:3 --json");
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_NEAR(boost::json::parse(again.out).at("intervals").at(0).at("area").as_double(), area, 1e-12);
}

TEST(FlatGrids, AreDrawnInTheirColoursFromTheBroadSide) {
  const TemporaryFolder folder;
  const auto picture = (folder / "a.png").string();
  const CommandResult result = run_isostrata("render diamond:9 --interval 0:2,color=#ff0000,opacity=1 --size 40x40 --json --out '" + picture + "'");
  ASSERT_EQ(result.status, 0) << result.err;
  const auto eye = boost::json::parse(result.out).at("camera").at("eye").as_array();
  EXPECT_EQ(eye[0].to_number<double>(), 0);
  EXPECT_EQ(eye[1].to_number<double>(), 0);
  const CommandResult raster =
      run_isostrata("render diamond:9 --interval 0:2,color=#ff0000,opacity=1 --size 40x40 --device surfaceless --renderer raster --out '" +
                    (folder / "b.png").string() + "'");
  ASSERT_EQ(raster.status, 0) << raster.err;
  EXPECT_EQ(read_text(folder / "a.png"), read_text(folder / "b.png"));
  const CommandResult less =
      run_isostrata("render diamond:9 --interval 0:0.5,color=#ff0000,opacity=1 --size 40x40 --out '" + (folder / "c.png").string() + "'");
  ASSERT_EQ(less.status, 0) << less.err;
  EXPECT_NE(read_text(folder / "a.png"), read_text(folder / "c.png"));
}

TEST(FlatGrids, SayWhatIsNotThereForThem) {
  const CommandResult combined = run_isostrata("extract diamond:9 --interval 0:1 --and value=0.2:0.4");
  EXPECT_EQ(combined.status, 1);
  EXPECT_THAT(combined.err, HasSubstr("its cells have an area and no volume"));
}

TEST(FlatGrids, AGridWithoutCellsIsNamed) {
  const TemporaryFolder folder;
  write(folder / "line.vtk",
        "# vtk DataFile Version 3.0\nline\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 1 1\nORIGIN 0 0 0\nSPACING 1 1 1\n"
        "POINT_DATA 3\nSCALARS f double 1\nLOOKUP_TABLE default\n0 1 2\n");
  const CommandResult result = run_isostrata("extract '" + (folder / "line.vtk").string() + "' --interval 0:1");
  EXPECT_EQ(result.status, 1);
  EXPECT_THAT(result.err, HasSubstr("no cells with a volume or an area"));
}

}  // namespace
