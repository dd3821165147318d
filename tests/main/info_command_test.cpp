// `isostrata info`, as scripts use it.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "support/places.h"
#include "support/sample_files.h"
#include "support/shared_data.h"

namespace {

namespace json = boost::json;

struct Ran {
  int status = -1;
  std::string out;
};

/// Standard error goes to standard output where `both`.
Ran info(const std::string& arguments, bool both = false, const std::string& before = "") {
  const std::string command = before + isostrata::places::binaries() + "/isostrata info " + arguments + (both ? " 2>&1" : " 2>/dev/null");
  Ran ran;
  std::FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) return ran;
  char buffer[4096];
  while (const std::size_t got = std::fread(buffer, 1, sizeof buffer, pipe)) ran.out.append(buffer, got);
  const int status = pclose(pipe);
  ran.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return ran;
}

Ran in_folder(const std::string& folder, const std::string& arguments) { return info(arguments, true, "cd '" + folder + "' && "); }

using isostrata::testing::shared_data;

TEST(InfoCommand, DescribesAnalyticDataAsJson) {
  const Ran ran = info("torus:16 --json");
  ASSERT_EQ(ran.status, 0);
  const json::value document = json::parse(ran.out);
  EXPECT_EQ(document.at("grid").as_string(), "uniform");
  EXPECT_EQ(document.at("points").as_int64(), 4096);
  EXPECT_EQ(document.at("cells").as_int64(), 3375);
  EXPECT_EQ(document.at("cell_types").at("hexahedron").as_int64(), 3375);
  EXPECT_EQ(document.at("bounds"), json::parse("[[-1.0,1.0],[-1.0,1.0],[-1.0,1.0]]"));
  const json::value& array = document.at("arrays").as_array().at(0);
  EXPECT_EQ(array.at("name").as_string(), "distance");
  EXPECT_EQ(array.at("association").as_string(), "point");
  EXPECT_EQ(array.at("type").as_string(), "float32");
  EXPECT_EQ(array.at("components").as_int64(), 1);
  EXPECT_EQ(array.at("nan_count").as_int64(), 0);
  EXPECT_LT(array.at("range").at(0).as_double(), array.at("range").at(1).as_double());
  EXPECT_EQ(document.at("times"), json::parse("[0.0]"));
}

TEST(InfoCommand, CountsCellsOfEveryType) {
  const json::value types = json::parse(info("mixed:9 --json").out).at("cell_types");
  for (const char* type : {"tetrahedron", "pyramid", "wedge", "hexahedron"}) EXPECT_GT(types.at(type).as_int64(), 0) << type;
}

TEST(InfoCommand, ListsTimesAndTakesAStep) {
  const json::value document = json::parse(info("cylinder:8x8x4x5 --step 3 --json").out);
  EXPECT_EQ(document.at("times").as_array().size(), 5u);
  EXPECT_EQ(document.at("step").as_int64(), 3);
}

TEST(InfoCommand, IsReadableWithoutJson) {
  const Ran ran = info("tets:5");
  EXPECT_EQ(ran.status, 0);
  EXPECT_NE(ran.out.find("tetrahedron 384"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("distance"), std::string::npos) << ran.out;
}

TEST(InfoCommand, FailsWithOneLineAndStatusOne) {
  for (const char* arguments : {"/no/such/file.vtk", "torus:0", "torus:8 --step 5", "/dev/null"}) {
    const Ran ran = info(arguments, true);
    EXPECT_EQ(ran.status, 1) << arguments;
    EXPECT_EQ(std::count(ran.out.begin(), ran.out.end(), '\n'), 1) << ran.out;
    EXPECT_TRUE(info(arguments).out.empty()) << arguments;
  }
}

TEST(InfoCommand, WrongUsageIsStatusTwo) {
  EXPECT_EQ(info("").status, 2);
  EXPECT_EQ(info("torus --nonsense").status, 2);
}

TEST(InfoCommand, DescribesAFile) {
  const isostrata::testing::TemporaryFolder folder;
  const auto file = isostrata::testing::write_sample_plot3d(folder).path;
  const json::value document = json::parse(info("'" + file.string() + "' --json").out);
  EXPECT_EQ(document.at("cells").as_int64(), 12 * 3 * 4 + 3 * 3 * 4);
  EXPECT_EQ(document.at("cell_types").at("hexahedron").as_int64(), 180);
  std::vector<std::string> names;
  for (const json::value& array : document.at("arrays").as_array()) names.emplace_back(array.at("name").as_string());
  for (const char* name : {"Density", "Momentum", "Momentum_x", "StagnationEnergy"})
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
}

TEST(InfoCommand, SaysUnits) {
  const isostrata::testing::TemporaryFolder folder;
  const std::string file = folder.write("heat.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nsample units: K\n\nabcdefgh").string();
  EXPECT_NE(info("'" + file + "'").out.find("scalars (K) "), std::string::npos);
  EXPECT_EQ(json::parse(info("--json '" + file + "'").out).at("arrays").at(0).at("unit").as_string(), "K");
}

TEST(InfoCommand, FollowsALinkThatIsNamedWithADot) {
  namespace fs = std::filesystem;
  const isostrata::testing::TemporaryFolder folder;
  folder.write("data/field.nhdr", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n1 2 3 4 5 6 7 8\n");
  folder.write("here/step_1.nhdr", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n1 2 3 4 5 6 7 9\n");
  fs::create_symlink("../data/field.nhdr", folder / "here/link.nhdr");
  fs::create_symlink("../data/field.nhdr", folder / "here/step_2.nhdr");
  const std::string here = (folder / "here").string();
  for (const std::string& file : {std::string("./link.nhdr"), std::string("./././link.nhdr"), std::string("../here/./link.nhdr"), here + "/./link.nhdr"}) {
    const Ran ran = in_folder(here, "'" + file + "'");
    EXPECT_EQ(ran.status, 0) << file << ": " << ran.out;
    EXPECT_NE(ran.out.find("[1, 8]"), std::string::npos) << ran.out;
  }
  EXPECT_NE(in_folder(here, "'./step_*.nhdr'").out.find("[1, 9]"), std::string::npos);
  EXPECT_NE(in_folder(here, ".").out.find("1 data sets"), std::string::npos);
  folder.write("here/torus", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n1 2 3 4 5 6 7 9\n");
  EXPECT_NE(in_folder(here, "./torus").out.find("[1, 9]"), std::string::npos);
}

TEST(SharedDataInfo, ReadsTheBluntFin) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  const auto file = shared_data() / "plot3d_bluntfin" / "bluntfinxyz.bin";
  const json::value document = json::parse(info("'" + file.string() + "' --json").out);
  EXPECT_EQ(document.at("grid").as_string(), "curvilinear");
  EXPECT_EQ(document.at("cells").as_int64(), 37479);
  const json::value& density = document.at("arrays").as_array().at(0);
  EXPECT_EQ(density.at("name").as_string(), "Density");
  EXPECT_NEAR(density.at("range").at(1).as_double(), 4.9775, 1e-5);
}

}  // namespace
