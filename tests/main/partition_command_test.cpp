// `isostrata partition`: what it writes is the dataset that it was, and what it cannot write it says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <filesystem>
#include <set>

#include "support/run_isostrata.h"
#include "support/sample_files.h"
#include "support/shared_data.h"

namespace {

using namespace isostrata::testing;
using ::testing::HasSubstr;
namespace fs = std::filesystem;
namespace json = boost::json;

std::string in_quotes(const fs::path& path) { return "'" + path.string() + "'"; }

json::object json_of(const std::string& command) {
  const CommandResult result = run_isostrata(command + " --json");
  EXPECT_EQ(result.status, 0) << command << ": " << result.err;
  return result.status == 0 ? json::parse(result.out).as_object() : json::object();
}

/// The list of the parts.
fs::path partition(const std::string& file, int parts, const fs::path& folder, const std::string& more = "") {
  const json::object made = json_of("partition " + file + " --parts " + std::to_string(parts) + " --out " + in_quotes(folder) + more);
  return made.empty() ? fs::path() : fs::path(std::string(made.at("list").as_string()));
}

/// Of the first array of floats the middle third.
std::string middle_third(const json::object& info) {
  for (const json::value& array : info.at("arrays").as_array()) {
    if (!array.at("type").as_string().starts_with("float")) continue;
    const double lower = array.at("range").at(0).to_number<double>(), upper = array.at("range").at(1).to_number<double>();
    return " --array " + in_quotes(std::string(array.at("name").as_string())) + " --interval " + std::to_string(lower + (upper - lower) / 3) + ":" +
           std::to_string(upper - (upper - lower) / 3);
  }
  return "";
}

/// What `info` and `extract` say of the parts is what they say of the file.
void expect_same(const std::string& file, const fs::path& list, const std::string& more = "") {
  const json::object a = json_of("info " + file + more), b = json_of("info " + in_quotes(list));
  ASSERT_FALSE(a.empty() || b.empty());
  for (const char* name : {"grid", "dims", "cells", "points", "hidden_cells", "cell_types", "bounds"})
    EXPECT_EQ(a.contains(name) ? a.at(name) : json::value(), b.contains(name) ? b.at(name) : json::value()) << name;
  ASSERT_EQ(a.at("arrays").as_array().size(), b.at("arrays").as_array().size());
  for (std::size_t i = 0; i < a.at("arrays").as_array().size(); ++i)
    for (const char* name : {"name", "type", "step_range", "nan_count"}) EXPECT_EQ(a.at("arrays").at(i).at(name), b.at("arrays").at(i).at(name)) << name;
  const std::string layer = middle_third(a);
  const json::object one = json_of("extract " + file + more + layer), parts = json_of("extract " + in_quotes(list) + layer);
  ASSERT_FALSE(one.empty() || parts.empty());
  for (const char* name : {"cells", "active_cells", "tetrahedra", "points", "boundary_facets", "unmatched_facets"}) EXPECT_EQ(one.at(name), parts.at(name)) << name;
  EXPECT_GT(one.at("tetrahedra").to_number<int>(), 0);
  const auto volume = [](const json::object& of) { return of.at("intervals").at(0).at("volume").to_number<double>(); };
  EXPECT_NEAR(volume(one), volume(parts), 1e-12 * volume(one));
}

TEST(PartitionCommand, PartsOfEveryKindOfGridAreReadAsTheFile) {
  const TemporaryFolder folder;
  int number = 0;
  std::set<std::string> endings;
  for (const SampleFile& file : write_sample_files(folder)) {
    SCOPED_TRACE(file.path.filename().string());
    const fs::path list = partition(in_quotes(file.path), 3, folder / ("parts" + std::to_string(++number)));
    ASSERT_FALSE(list.empty());
    endings.insert(list.extension());
    expect_same(in_quotes(file.path), list);
  }
  EXPECT_EQ(endings, (std::set<std::string>{".pvti", ".pvtr", ".pvts", ".pvtu"}));
}

TEST(PartitionCommand, AnyNumberOfPartsHoldsEachCellOnce) {
  const TemporaryFolder folder;
  for (const char* data : {"torus:12", "mixed:7", "cylinder:24x9x7"})
    for (const int parts : {1, 2, 5, 8}) {
      SCOPED_TRACE(std::string(data) + " in " + std::to_string(parts));
      const std::string out = (folder / (std::string(data, 3) + std::to_string(parts))).string();
      const json::object made = json_of(std::string("partition ") + data + " --parts " + std::to_string(parts) + " --out " + in_quotes(out));
      std::int64_t own = 0;
      for (const json::value& part : made.at("parts").as_array()) own += part.at("own_cells").to_number<std::int64_t>();
      EXPECT_EQ(own, made.at("cells").to_number<std::int64_t>());
      EXPECT_EQ(made.at("parts").as_array().size(), static_cast<std::size_t>(parts));
      expect_same(data, fs::path(std::string(made.at("list").as_string())));
    }
}

TEST(PartitionCommand, WhatARegionAndAStrideCutOutIsParted) {
  const TemporaryFolder folder;
  const std::string cut = " --region 1:14,:,3: --stride 1,2,1";
  expect_same("torus:16", partition("torus:16", 4, folder / "cut", cut), cut);
}

/// Two cubes beside each other whose common points are there twice, with the same values: a crack, along which nothing is joined.
TEST(PartitionCommand, PointsThatTheFileHasTwiceStayTwo) {
  const TemporaryFolder folder;
  VtuText vtu;
  std::vector<double> values;
  for (int bar = 0; bar < 2; ++bar)
    for (int k = 0; k < 2; ++k)
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 5; ++i) vtu.points.push_back({double(i), double(j + bar), double(k)}), values.push_back(i + 0.25 * (j + bar));
  for (int bar = 0; bar < 2; ++bar)
    for (int i = 0; i < 4; ++i) {
      const auto id = [&](int a, int b, int c) { return std::int64_t{20 * bar + i + a + 5 * (b + 2 * c)}; };
      vtu.add(12, {id(0, 0, 0), id(1, 0, 0), id(1, 1, 0), id(0, 1, 0), id(0, 0, 1), id(1, 0, 1), id(1, 1, 1), id(0, 1, 1)});
    }
  vtu.point_array("f", "Float64", values);
  const auto file = folder.write("crack.vtu", vtu.text());
  for (const int parts : {2, 3, 4, 8}) expect_same(in_quotes(file), partition(in_quotes(file), parts, folder / ("crack" + std::to_string(parts))));
}

void expect_refusal(const std::string& command, int status, const std::string& says) {
  const CommandResult result = run_isostrata(command);
  EXPECT_EQ(result.status, status) << command << ": " << result.err;
  EXPECT_EQ(result.out, "") << command;
  EXPECT_THAT(result.err, HasSubstr(says)) << command;
}

TEST(PartitionCommand, WhatCannotBeDoneIsSaidAndLeavesNothingBehind) {
  const TemporaryFolder folder;
  const auto out = folder / "out";
  const std::string to = " --out " + in_quotes(out);
  expect_refusal("partition torus:8 --parts 0" + to, 2, "--parts");
  expect_refusal("partition torus:8 --parts 1.5" + to, 2, "--parts");
  expect_refusal("partition torus:8" + to, 2, "--parts is required");
  expect_refusal("partition torus:3 --parts 9" + to, 1, "--parts 9: more than the 8 cells of torus:3");
  const auto flat = folder.write("flat.vti", vti_text({0, 0, 0}, {3, 3, 1}, data_array("f", "Float32", std::vector<float>(9))));
  expect_refusal("partition " + in_quotes(flat) + " --parts 2" + to, 1, "a flat grid is not parted");
  expect_refusal("partition " + in_quotes(folder / "none.vtu") + " --parts 2" + to, 1, "no such file");
  EXPECT_FALSE(fs::exists(out));
  folder.write("full/other", "x");
  expect_refusal("partition torus:8 --parts 2 --out " + in_quotes(folder / "full"), 1, "is not empty");
  expect_refusal("partition torus:8 --parts 2 --out " + in_quotes(folder / "full/other"), 1, "cannot be made: File exists");
  expect_refusal("partition torus:8 --parts 2 --out " + in_quotes(folder / "no/such"), 1, "cannot be made: No such file or directory");
  expect_refusal("partition torus:8 --parts 2 --out /proc/self/parts", 1, "cannot be made");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "full"), {}), 1);
}

/// A disk that is full in the middle: a limit on the size of a file stands for it.
TEST(PartitionCommand, WhatWasWrittenUntilTheDiskWasFullGoesAgain) {
  const TemporaryFolder folder;
  const CommandResult result = run_isostrata("partition torus:48 --parts 2 --out " + in_quotes(folder / "out"), "ulimit -f 64;");
  EXPECT_EQ(result.status, 1);
  EXPECT_THAT(result.err, HasSubstr("out/torus-48_0.vti"));
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(SharedDataPartitionCommand, MeasuredAndComputedDataAreReadAsTheFile) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  const TemporaryFolder folder;
  for (const char* name : {"plot3d_bluntfin/bluntfinxyz.bin", "ug_fire/fire_ug.vtu", "exo_can/can.vtu", "ug_post_tets/post.vtk"}) {
    SCOPED_TRACE(name);
    const std::string file = in_quotes(shared_data() / name);
    expect_same(file, partition(file, 4, folder / fs::path(name).stem()));
  }
}

}  // namespace
