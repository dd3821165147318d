#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cstddef>
#include <map>

#include "support/run_isostrata.h"

namespace {

using namespace isostrata::testing;

TEST(TablesCommand, PrintsThePapersWholeNumbers) {
  const CommandResult result = run_isostrata("tables --json");
  ASSERT_EQ(result.status, 0) << result.err;
  const boost::json::value document = boost::json::parse(result.out);
  std::map<std::string, boost::json::object> rows;
  for (const auto& row : document.at("tables").as_array()) rows[std::string(row.at("cell").as_string())] = row.as_object();
  const auto expect = [&](const char* cell, int dimension, int vertices, int cases, int total, int max) {
    ASSERT_TRUE(rows.contains(cell)) << result.out;
    const auto& row = rows[cell];
    EXPECT_EQ(row.at("dimension"), dimension) << cell;
    EXPECT_EQ(row.at("vertices"), vertices) << cell;
    EXPECT_EQ(row.at("cases"), cases) << cell;
    EXPECT_EQ(row.at("total_simplices"), total) << cell;
    EXPECT_EQ(row.at("max"), max) << cell;
    EXPECT_DOUBLE_EQ(row.at("average").as_double(), double(total) / cases) << cell;
  };
  expect("tetrahedron", 3, 4, 81, 321, 6);
  expect("hexahedron", 3, 8, 6561, 78336, 18);
  expect("4-simplex", 4, 5, 243, 2031, 14);
  expect("5-simplex", 5, 6, 729, 12593, 30);
  EXPECT_TRUE(rows.contains("pyramid"));
  EXPECT_TRUE(rows.contains("wedge"));
}

TEST(TablesCommand, ShowsCellsOfMoreDimensionsBySample) {
  const CommandResult result = run_isostrata("tables --cell cube4 --cell prism4 --cell simplex5 --cases 700 --seed 3 --json");
  ASSERT_EQ(result.status, 0) << result.err;
  const boost::json::value document = boost::json::parse(result.out);
  const auto& rows = document.at("tables").as_array();
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].at("cases"), 43046721);
  EXPECT_EQ(rows[0].at("counted"), 700);
  EXPECT_EQ(rows[0].at("dimension"), 4);
  EXPECT_GT(rows[0].at("average").as_double(), 40);
  EXPECT_EQ(rows[1].at("vertices"), 8);
  EXPECT_EQ(rows[1].at("counted"), 700);
  EXPECT_EQ(rows[2].at("counted"), 700);
}

TEST(TablesCommand, DrawsTheCubeOfThePapersFigure2) {
  const TemporaryFolder folder;
  // Vertices above and below the interval in turns: as the paper says, no cube needs more tetrahedra when it is split into five first.
  const std::string cube = "tables --cell hexahedron --case 02022020 ";
  const CommandResult words = run_isostrata(cube);
  ASSERT_EQ(words.status, 0) << words.err;
  const auto simplices = std::count(words.out.begin(), words.out.end(), '\n') - 1;
  EXPECT_GT(simplices, 4);
  const CommandResult drawn = run_isostrata(cube + "--out '" + (folder / "cube.svg").string() + "'");
  ASSERT_EQ(drawn.status, 0) << drawn.err;
  const std::string svg = read_text(folder / "cube.svg");
  const auto count = [&](const std::string& what) {
    std::ptrdiff_t n = 0;
    for (auto at = svg.find(what); at != std::string::npos; at = svg.find(what, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("<line"), 12);
  EXPECT_EQ(count("fill=\"black\""), 4);
  EXPECT_EQ(count("<polygon"), 4 * simplices);
}

TEST(TablesCommand, RefusesCasesThatAreNone) {
  EXPECT_NE(run_isostrata("tables --cell tetrahedron --case 81").err.find("a number from 0 to 80"), std::string::npos);
  EXPECT_EQ(run_isostrata("tables --cell tetrahedron --case 0123").status, 1);
  EXPECT_EQ(run_isostrata("tables --case 4").status, 2);
  EXPECT_EQ(run_isostrata("tables --cell wedge --case 4 --out case.png").status, 2);
}

TEST(TablesCommand, RefusesCellsThatItDoesNotKnow) {
  const CommandResult unknown = run_isostrata("tables --cell cube7");
  EXPECT_EQ(unknown.status, 1);
  EXPECT_NE(unknown.err.find("no cell 'cube7'; there are tetrahedron"), std::string::npos) << unknown.err;
  EXPECT_EQ(run_isostrata("tables --cases 10").status, 2);
  EXPECT_EQ(run_isostrata("tables --cell cube4 --cases 0").status, 2);
}

TEST(TablesCommand, PrintsATableForPeople) {
  const CommandResult result = run_isostrata("tables");
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.out.find("hexahedron"), std::string::npos);
  EXPECT_NE(result.out.find("78336"), std::string::npos);
}

}  // namespace
