// What layers hold, from the command line: the same numbers as JSON, as a table and as extract says them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "support/run_json.h"

namespace {

using namespace isostrata::testing;
using ::testing::HasSubstr;
namespace json = boost::json;

std::string said(const std::string& arguments) {
  const CommandResult result = run_isostrata(arguments);
  EXPECT_EQ(result.status, 0) << arguments << ": " << result.err;
  return result.out;
}

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> all;
  std::istringstream text(line);
  for (std::string cell; std::getline(text, cell, ',');) all.push_back(cell);
  return all;
}

TEST(MeasureCommand, SaysWhatExtractSaysAndMore) {
  const std::string layers = "tets:9 --interval 0.3:0.5 --interval 0.5:0.7";
  const json::value extracted = json_of("extract " + layers);
  const json::value measured = json_of("measure " + layers + " --of distance");
  const json::array& rows = measured.at("steps").at(0).at("layers").as_array();
  ASSERT_EQ(rows.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const json::value& row = rows[i];
    const double volume = number(row.at("volume"));
    EXPECT_NEAR(volume, number(extracted.at("intervals").at(i).at("volume")), 1e-12);
    EXPECT_EQ(number(row.at("tetrahedra")), number(extracted.at("intervals").at(i).at("tetrahedra")));
    EXPECT_EQ(number(row.at("volume_error")), 0) << "tetrahedra are cut exactly";
    EXPECT_NEAR(number(row.at("of").at("distance").at("integral")), volume * number(row.at("of").at("distance").at("mean")), 1e-12);
    EXPECT_GE(number(row.at("of").at("distance").at("mean")), number(row.at("lower")));
    EXPECT_LE(number(row.at("of").at("distance").at("mean")), number(row.at("upper")));
  }
  EXPECT_NEAR(number(rows[0].at("area").at("contact")), number(rows[1].at("area").at("contact")), 1e-12);
}

TEST(MeasureCommand, PrintsATableOfEveryStep) {
  const std::string arguments = "measure cylinder:16x16x9x3 --array Density --interval 0.98:1 --all-steps --of Energy";
  std::istringstream table(said(arguments + " --csv"));
  std::string line;
  ASSERT_TRUE(std::getline(table, line));
  const std::vector<std::string> names = cells(line);
  EXPECT_EQ(names.front(), "time");
  EXPECT_EQ(names.back(), "\"Energy integral\"");
  const json::value document = json_of(arguments);
  ASSERT_EQ(document.at("steps").as_array().size(), 3u);
  for (const json::value& step : document.at("steps").as_array()) {
    ASSERT_TRUE(std::getline(table, line));
    const std::vector<std::string> row = cells(line);
    ASSERT_EQ(row.size(), names.size());
    const json::value& layer = step.at("layers").at(0);
    EXPECT_EQ(std::stod(row[0]), number(step.at("time")));
    EXPECT_DOUBLE_EQ(std::stod(row[5]), number(layer.at("volume")));
    EXPECT_DOUBLE_EQ(std::stod(row.back()), number(layer.at("of").at("Energy").at("integral")));
  }
  EXPECT_FALSE(std::getline(table, line));
}

TEST(MeasureCommand, ACentroidThatRoundingAloneKeepsFromZeroIsZeroAsText) {
  const json::value measured = json::parse(said("measure sphere:24 --interval 0:0.2 --json"));
  for (const json::value& at : measured.at("steps").at(0).at("layers").at(0).at("centroid").as_array()) EXPECT_LT(std::abs(number(at)), 1e-14);
  EXPECT_THAT(said("measure sphere:24 --interval 0:0.2"), HasSubstr("centroid  0, 0, 0\n"));
}

TEST(MeasureCommand, OfAFlatGridIsItsArea) {
  const TemporaryFolder folder;
  folder.write("flat.nrrd", "NRRD0004\ntype: double\ndimension: 2\nsizes: 3 2\nencoding: ascii\n\n0 1 2 0 1 2\n");
  const json::value row = json_of("measure '" + (folder / "flat.nrrd").string() + "' --interval 0.5:1.5").at("steps").at(0).at("layers").at(0);
  EXPECT_EQ(number(row.at("volume")), 0);
  EXPECT_NEAR(number(row.at("area").at("domain")), 1, 1e-12);
}

TEST(MeasureCommand, SaysThatNothingLiesInALayer) {
  const CommandResult result = run_isostrata("measure torus:8 --interval 5:6");
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.out, HasSubstr("5:6: nothing lies in it"));
  EXPECT_THAT(result.err, HasSubstr("nothing lies in 5:6"));
}

TEST(SectionCommand, PrintsAndWritesAreasThatMeet) {
  const TemporaryFolder folder;
  const std::string layers = "section tets:9 --interval 0.2:0.4 --interval 0.4:0.6 --of distance --plane ";
  const json::value plain = json_of(layers + "0.05,0.1,0.2,1,2,3");
  EXPECT_EQ(number(plain.at("unmatched_edges")), 0);
  ASSERT_EQ(plain.at("layers").as_array().size(), 2u);
  for (const json::value& row : plain.at("layers").as_array()) {
    EXPECT_GT(number(row.at("area")), 0.05);
    EXPECT_GT(number(row.at("triangles")), 10);
  }
  // What is written is opened again as a mesh of areas: the same areas, and the values within the layers.
  const std::string out = (folder / "cut.vtu").string();
  said(layers + "z=0.2 --out '" + out + "'");
  const json::value info = json_of("info '" + out + "'");
  EXPECT_NEAR(number(info.at("bounds").at(2).at(0)), 0.2, 1e-12);
  EXPECT_NEAR(number(info.at("bounds").at(2).at(1)), 0.2, 1e-12);
  said(layers + "z=0.2 --out '" + (folder / "cut.vtp").string() + "'");
  EXPECT_THAT(read_text(folder / "cut.vtp"), HasSubstr("<Polys>"));
  for (const char* wrong : {"1,2,3", "0,0,0,0,0,0", "0,0,0,0,0,x", "w=1", "z=", "0,0,0,0,0,1,2"}) {
    const CommandResult result = run_isostrata("section torus:8 --interval 0:1 --plane " + std::string(wrong));
    EXPECT_EQ(result.status, 1) << wrong;
    EXPECT_THAT(result.err, HasSubstr("expected x,y,z,nx,ny,nz")) << wrong;
  }
}

TEST(ComponentsCommand, ListsPlantedPiecesByTheirSize) {
  // Three cubes of ones among zeros, of 1, 8 and 27 points.
  const TemporaryFolder folder;
  std::string values;
  for (int z = 0; z < 12; ++z)
    for (int y = 0; y < 12; ++y)
      for (int x = 0; x < 12; ++x) {
        const auto in = [&](int at, int size) { return x >= at && x < at + size && y >= at && y < at + size && z >= at && z < at + size; };
        values += in(1, 1) || in(4, 2) || in(8, 3) ? "1 " : "0 ";
      }
  folder.write("cubes.nrrd", "NRRD0004\ntype: float\ndimension: 3\nsizes: 12 12 12\nencoding: ascii\n\n" + values + "\n");
  const std::string file = "'" + (folder / "cubes.nrrd").string() + "' --interval 0.5:1";
  const json::value pieces = json_of("components " + file).at("components");
  ASSERT_EQ(pieces.as_array().size(), 3u);
  const double at[] = {8, 4, 1}, upper[] = {10.5, 5.5, 1.5};
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const json::value& piece = pieces.at(i);
    EXPECT_NEAR(number(piece.at("bounds").at(0).at(0)), at[i] - 0.5, 1e-6);
    EXPECT_NEAR(number(piece.at("bounds").at(0).at(1)), upper[i], 1e-6);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(number(piece.at("anchor").at(axis)), at[i] - 0.5);
      EXPECT_LE(number(piece.at("anchor").at(axis)), upper[i]);
    }
    sum += number(piece.at("volume"));
  }
  const json::value whole = json_of("measure " + file).at("steps").at(0).at("layers").at(0);
  EXPECT_NEAR(sum, number(whole.at("volume")), 1e-9);
  EXPECT_EQ(json_of("components " + file + " --min-volume 5").at("components").as_array().size(), 2u);
  EXPECT_THAT(said("components " + file + " --min-volume 5"), HasSubstr("2 pieces, 1 smaller ones left out"));
  EXPECT_EQ(json_of("measure " + file + " --by component").at("steps").at(0).at("layers").as_array().size(), 3u);
}

}  // namespace
