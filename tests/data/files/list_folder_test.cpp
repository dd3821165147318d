// Folders as scientists have them: what is listed, what is one entry, and what is passed over with which reason.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "data/files.h"
#include "data/files/beneath.h"
#include "data/files/file_series.h"
#include "data/files/list_folder.h"
#include "support/vtk_text.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using test::Scratch;

std::string image(double value = 0, const std::string& more = "") {
  std::vector<double> values;
  for (int i = 0; i < 8; ++i) values.push_back(value + i);
  return testing::vtk_file("ImageData", "<ImageData WholeExtent=\"0 1 0 1 0 1\" Origin=\"0 0 0\" Spacing=\"1 1 1\">" + more +
                                            "<Piece Extent=\"0 1 0 1 0 1\"><PointData>" + testing::data_array("f", "Float64", values) +
                                            "</PointData></Piece></ImageData>");
}

std::string at_time(double time) {
  return "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">" + std::to_string(time) +
         "</DataArray></FieldData>";
}

std::map<std::string, int> names(const FolderListing& listing) {
  std::map<std::string, int> out;
  for (const FolderEntry& entry : listing.entries) out[entry.name] = entry.files;
  return out;
}

std::int64_t passed(const FolderListing& listing, const std::string& reason) {
  for (const PassedOver& of : listing.passed_over)
    if (of.reason.find(reason) != std::string::npos) return of.files;
  return 0;
}

using Groups = std::vector<std::pair<std::string, std::size_t>>;
Groups grouped(const std::vector<std::string>& names) {
  Groups out;
  for (const NameGroup& group : group_by_number(names)) out.emplace_back(group.name, group.members.size());
  return out;
}

TEST(GroupByNumber, EveryNameIsInExactlyOneGroupAndItsPatternFindsItsFiles) {
  std::mt19937 random(20041);
  for (int round = 0; round < 50; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const Scratch scratch;
    std::set<std::string> all;
    const auto pick = [&](int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); };
    for (int i = 0; i < 30; ++i) {
      std::string name(1, static_cast<char>('a' + pick(2)));
      for (int part = pick(3); part >= 0; --part) name += (pick(2) ? "_" : "") + std::string(static_cast<std::size_t>(pick(2)), '0') + std::to_string(pick(12));
      all.insert(name + (pick(2) ? ".vtu" : ".h5"));
    }
    for (const std::string& name : all) scratch.write(name, "x");
    std::multiset<std::string> seen;
    for (const NameGroup& group : group_by_number({all.begin(), all.end()})) {
      seen.insert(group.members.begin(), group.members.end());
      if (group.members.size() == 1) continue;
      std::vector<std::string> found;
      for (const SeriesFile& file : series_files(scratch / group.name)) found.push_back(file.path.filename().string());
      for (const std::string& member : group.members) EXPECT_NE(std::find(found.begin(), found.end(), member), found.end()) << group.name << " " << member;
    }
    EXPECT_EQ(seen, std::multiset<std::string>(all.begin(), all.end()));
  }
}

TEST(GroupByNumber, TheLastNumberCountsStepsAndThoseBeforeItKeepSeriesApart) {
  EXPECT_EQ(grouped({"p_1.vtu", "p_2.vtu", "p_10.vtu"}), (Groups{{"p_*.vtu", 3}}));
  EXPECT_EQ(grouped({"run1_001.vtu", "run1_007.vtu", "run2_001.vtu", "run2_002.vtu"}), (Groups{{"run1_*.vtu", 2}, {"run2_*.vtu", 2}}));
  EXPECT_EQ(grouped({"s_0001_t_0.5.vtk", "s_0002_t_0.75.vtk", "s_0003_t_1.0.vtk"}), (Groups{{"s_*_t_*.*.vtk", 3}}));
  EXPECT_EQ(grouped({"re100_1.vtu", "re100_2.vtu"}), (Groups{{"re100_*.vtu", 2}}));
  EXPECT_EQ(grouped({"a.h5", "b.h5", "mesh2.vtu"}), (Groups{{"a.h5", 1}, {"b.h5", 1}, {"mesh2.vtu", 1}}));
  EXPECT_EQ(grouped({"can.e", "can.e-s0002", "can.e-s0003", "other.e"}), (Groups{{"can.e-s*", 3}, {"other.e", 1}}));
  EXPECT_EQ(grouped({"dump.0001", "dump.0002"}), (Groups{{"dump.*", 2}}));
  EXPECT_EQ(group_by_number({"p_10.vtu", "p_9.vtu"}).front().members, (std::vector<std::string>{"p_9.vtu", "p_10.vtu"}));
}

TEST(EqualStepsOfNames, FindEachFileAndNoOtherNumber) {
  std::mt19937 random(20147);
  const auto pick = [&](int least, int most) { return std::uniform_int_distribution<int>(least, most)(random); };
  for (int round = 0; round < 50; ++round) {
    const int first = pick(0, 300), stride = pick(1, 40), files = pick(2, 60), digits = pick(1, 6);
    std::vector<std::string> names;
    for (int i = 0; i < files; ++i) {
      std::string number = std::to_string(first + i * stride);
      number.insert(0, std::max<std::size_t>(number.size(), digits) - number.size(), '0');
      names.push_back("t2_" + number + ".vtu");
    }
    const EqualSteps steps = equal_steps("t2_*.vtu", names);
    std::map<int, int> places;
    for (int i = 0; i < files; ++i) places[first + i * stride] = i;
    for (int number = 0; number < first + (files + 2) * stride; ++number)
      EXPECT_EQ(steps.place_of(static_cast<std::uint64_t>(number), files), places.contains(number) ? places[number] : -1) << names.front() << " by " << stride << ": " << number;
    EXPECT_EQ(steps.digits, static_cast<int>(names.front().size() - 7));
  }
}

TEST(EqualStepsOfNames, OfOtherNumbersThereAreNone) {
  EXPECT_EQ(equal_steps("p_*.vtu", {"p_1.vtu", "p_2.vtu", "p_4.vtu"}).stride, 0u);
  EXPECT_EQ(equal_steps("p_*.vtu", {"p_1.vtu"}).stride, 0u);
  EXPECT_EQ(equal_steps("p_*.vtu", {"p_1.vtu", "p_01.vtu"}).stride, 0u);
  EXPECT_EQ(equal_steps("p_*_*.vtu", {"p_1_1.vtu", "p_2_2.vtu"}).stride, 0u);
  EXPECT_EQ(equal_steps("can.e-s*", {"can.e", "can.e-s0002"}).stride, 0u);
}

TEST(GroupByNumber, ADecimalNumberIsOneNumber) {
  EXPECT_EQ(grouped({"U_0.05.vtk", "U_0.1.vtk", "U_0.15.vtk", "U_0.2.vtk", "U_1.0.vtk", "U_1.05.vtk", "U_10.0.vtk"}), (Groups{{"U_*.*.vtk", 7}}));
  EXPECT_EQ(group_by_number({"U_0.05.vtk", "U_0.1.vtk", "U_0.15.vtk", "U_1.0.vtk"}).front().members, (std::vector<std::string>{"U_0.05.vtk", "U_0.1.vtk", "U_0.15.vtk", "U_1.0.vtk"}));
  EXPECT_EQ(grouped({"U_0.00.vtk", "U_0.25.vtk", "U_0.50.vtk", "U_0.75.vtk", "U_1.00.vtk", "U_1.25.vtk", "U_1.50.vtk", "U_1.75.vtk"}), (Groups{{"U_*.*.vtk", 8}}));
  EXPECT_EQ(grouped({"U_0.13.vtk", "U_0.57.vtk", "U_1.02.vtk", "U_2.33.vtk"}), (Groups{{"U_*.*.vtk", 4}}));
  EXPECT_EQ(grouped({"U_0.vtk", "U_0.5.vtk", "U_1.vtk", "U_1.5.vtk", "U_10.vtk"}), (Groups{{"U_*.vtk", 5}}));
  EXPECT_EQ(grouped({"run_1_t_0.05.vtk", "run_1_t_0.1.vtk", "run_2_t_0.05.vtk", "run_2_t_0.1.vtk"}), (Groups{{"run_1_t_*.*.vtk", 2}, {"run_2_t_*.*.vtk", 2}}));
}

TEST(GroupByNumber, ADotMayKeepTwoNumbersApart) {
  EXPECT_EQ(grouped({"data.0001.vtk", "data.0002.vtk"}), (Groups{{"data.*.vtk", 2}}));
  EXPECT_EQ(grouped({"re100.0001.vtk", "re100.0002.vtk", "re100.0010.vtk"}), (Groups{{"re100.*.vtk", 3}}));
  EXPECT_EQ(grouped({"part_1.0001.vtk", "part_1.0002.vtk", "part_2.0001.vtk", "part_2.0002.vtk"}), (Groups{{"part_1.*.vtk", 2}, {"part_2.*.vtk", 2}}));
  EXPECT_EQ(grouped({"run_1.2_step_0003.vti", "run_1.2_step_0004.vti", "run_1.4_step_0003.vti", "run_1.4_step_0005.vti"}), (Groups{{"run_1.2_step_*.vti", 2}, {"run_1.4_step_*.vti", 2}}));
  EXPECT_EQ(grouped({"plume_1.512.vti", "plume_2.512.vti", "plume_10.512.vti"}), (Groups{{"plume_*.512.vti", 3}}));
  EXPECT_EQ(grouped({"a.1.1.vtk", "a.1.2.vtk", "a.2.1.vtk", "a.2.2.vtk"}), (Groups{{"a.1.*.vtk", 2}, {"a.2.*.vtk", 2}}));
  std::vector<std::string> counted;
  for (int run = 1; run <= 2; ++run)
    for (int step = 1; step <= 11; ++step) counted.push_back("run_" + std::to_string(run) + "." + std::to_string(step) + ".vtk");
  EXPECT_EQ(grouped(counted), (Groups{{"run_1.*.vtk", 11}, {"run_2.*.vtk", 11}}));
}

TEST(GroupByNumber, WhetherADotIsOfADecimalTheWholeGroupSays) {
  const auto named = [](std::initializer_list<const char*> numbers) {
    std::vector<std::string> names;
    for (const char* number : numbers) names.push_back("t_" + std::string(number) + ".vtk");
    return names;
  };
  const auto first_members = [&](std::initializer_list<const char*> numbers) { return group_by_number(named(numbers)).front().members; };
  // Counters: 1.10 beside 1.1 is not a decimal; neither are numbers that count in equal steps behind the dot and are not evenly spaced with it.
  EXPECT_EQ(grouped(named({"1.9", "1.10", "1.11"})), (Groups{{"t_1.*.vtk", 3}}));
  EXPECT_EQ(first_members({"1.9", "1.10", "1.11"}).back(), "t_1.11.vtk");
  EXPECT_EQ(grouped(named({"1.5", "1.15", "1.25", "2.5", "2.15", "2.25"})), (Groups{{"t_1.*.vtk", 3}, {"t_2.*.vtk", 3}}));
  EXPECT_EQ(first_members({"0.8", "0.9", "0.11", "0.12"}), (std::vector<std::string>{"t_0.8.vtk", "t_0.9.vtk", "t_0.11.vtk", "t_0.12.vtk"}));
  // Decimals: evenly spaced, or as many places each.
  EXPECT_EQ(grouped(named({"0.25", "0.5", "0.75", "1.25", "1.5", "1.75"})), (Groups{{"t_*.*.vtk", 6}}));
  EXPECT_EQ(grouped(named({"0.125", "0.25", "0.375", "0.5", "0.625"})), (Groups{{"t_*.*.vtk", 5}}));
  EXPECT_EQ(grouped(named({"1.50", "1.15", "2.50", "3.25"})), (Groups{{"t_*.*.vtk", 4}}));
  EXPECT_EQ(first_members({"1.50", "1.15", "2.50", "3.25"}).front(), "t_1.15.vtk");
}

TEST(GroupByNumber, ADateAndItsTimeOfDayCountAsOne) {
  EXPECT_EQ(grouped({"wrfout_d01_2020-01-30_12:00:00", "wrfout_d01_2020-01-31_00:00:00", "wrfout_d01_2020-02-01_00:00:00", "wrfout_d02_2020-01-31_00:00:00", "wrfout_d02_2020-01-31_06:00:00"}),
            (Groups{{"wrfout_d01_2020-*-*_*:00:00", 3}, {"wrfout_d02_2020-01-31_*:00:00", 2}}));
  EXPECT_EQ(group_by_number({"t_2020-02-01.nc", "t_2020-01-31.nc", "t_2019-12-31.nc"}).front().members, (std::vector<std::string>{"t_2019-12-31.nc", "t_2020-01-31.nc", "t_2020-02-01.nc"}));
  EXPECT_EQ(grouped({"r_20200131_0600.tif", "r_20200131_1200.tif", "r_20200201_0000.tif", "r_20200201_0600.tif"}), (Groups{{"r_*_*.tif", 4}}));
  EXPECT_EQ(grouped({"a_2000-13-01.nc", "a_2000-13-02.nc", "a_2000-14-01.nc", "a_2000-14-02.nc"}), (Groups{{"a_2000-13-*.nc", 2}, {"a_2000-14-*.nc", 2}}));  // no month
}

TEST(GroupByNumber, AMinusAndAnExponentAreOfTheNumber) {
  for (const auto& [numbers, members] : std::vector<std::pair<std::vector<std::string>, std::vector<std::string>>>{
           {{"-0.5", "0", "0.5", "-1.5"}, {"t_-1.5.vtk", "t_-0.5.vtk", "t_0.vtk", "t_0.5.vtk"}},
           {{"1", "-1", "0", "-2"}, {"t_-2.vtk", "t_-1.vtk", "t_0.vtk", "t_1.vtk"}},
           {{"1e-3", "1.5e-3", "0.01", "1e+2"}, {"t_1e-3.vtk", "t_1.5e-3.vtk", "t_0.01.vtk", "t_1e+2.vtk"}}}) {
    const Scratch scratch;
    std::vector<std::string> names;
    for (const std::string& number : numbers) scratch.write(names.emplace_back("t_" + number + ".vtk"), "");
    const auto groups = group_by_number(names);
    ASSERT_EQ(groups.size(), 1u);
    EXPECT_EQ(groups.front().name, "t_*.vtk");
    EXPECT_EQ(groups.front().members, members);
    std::vector<std::string> found;
    for (const SeriesFile& file : series_files(scratch / "t_*.vtk")) found.push_back(file.path.filename().string());
    EXPECT_EQ(found, members);
  }
  // A hyphen, and letters that are not an exponent.
  EXPECT_EQ(group_by_number({"run-1.vtk", "run-2.vtk"}).front().name, "run-*.vtk");
  EXPECT_EQ(group_by_number({"x_1e3.vtk", "x_2e3.vtk"}).front().name, "x_*e3.vtk");
  EXPECT_EQ(group_by_number({"a_2020-01-31.vtk", "a_2020-02-01.vtk"}).front().name, "a_2020-*-*.vtk");
}

TEST(NumberedFiles, DecimalNumbersAreTheirTimesInTheListingAndByAPattern) {
  const Scratch scratch;
  const std::vector<std::string> written{"0.05", "0.1", "0.15", "0.2", "1.0", "1.05", "10.0"};
  const std::vector<double> times{0.05, 0.1, 0.15, 0.2, 1, 1.05, 10};
  for (std::size_t i = 0; i < written.size(); ++i) scratch.write("U_" + written[i] + ".vti", image(static_cast<double>(i)));
  EXPECT_EQ(names(list_folder(scratch.path())), (std::map<std::string, int>{{"U_*.*.vti", 7}}));
  for (const char* pattern : {"U_*.*.vti", "U_*.vti"})
    for (int step = 0; step < 7; ++step) {
      const auto data = test::open(scratch / pattern, step);
      EXPECT_EQ(data->times, times);
      EXPECT_EQ(data->array("f").lower, step);
    }
  EXPECT_EQ(test::open(scratch / "U_0.*.vti")->times, (std::vector<double>{1, 2, 5, 15}));
  for (const std::string more : {"V_0", "V_0.5", "V_1", "V_1.5"}) scratch.write(more + ".vti", image());
  EXPECT_EQ(test::open(scratch / "V_*.vti")->times, (std::vector<double>{0, 0.5, 1, 1.5}));
  for (const std::string more : {"w_-0.5", "w_0", "w_5e-1", "w_-1.5"}) scratch.write(more + ".vti", image());
  EXPECT_EQ(test::open(scratch / "w_*.vti")->times, (std::vector<double>{-1.5, -0.5, 0, 0.5}));
  for (const std::string more : {"p_1", "p_2", "p_1.0001", "p_1.0002", "p_2.0001", "p_2.0002"}) scratch.write(more + ".vti", image());
  EXPECT_EQ(test::open(scratch / "p_*.vti")->times, (std::vector<double>{1, 2}));
  EXPECT_EQ(names(list_folder(scratch.path())), (std::map<std::string, int>{{"U_*.*.vti", 7}, {"V_*.vti", 4}, {"p_*.vti", 2}, {"p_1.*.vti", 2}, {"p_2.*.vti", 2}, {"w_*.vti", 4}}));
}

TEST(NumberedFiles, AreStepsInTheOrderOfTheirNumbersWithGaps) {
  const Scratch scratch;
  for (const int n : {3, 20, 100}) scratch.write("plume_" + std::to_string(n) + ".vti", image(n));
  for (int step = 0; step < 3; ++step) {
    const auto data = test::open(scratch / "plume_*.vti", step);
    EXPECT_EQ(data->times, (std::vector<double>{3, 20, 100}));
    EXPECT_EQ(data->step, step);
    EXPECT_EQ(data->array("f").lower, data->times.at(static_cast<std::size_t>(step)));
  }
  OpenOptions beyond;
  beyond.step = 3;
  EXPECT_EQ(test::refusal(scratch / "plume_*.vti", beyond).code(), ErrorCode::not_found);
  EXPECT_EQ(test::refusal(scratch / "other_*.vti").code(), ErrorCode::not_found);
  scratch.write("plume_101.vti", image(101));  // the simulation goes on
  EXPECT_EQ(test::open(scratch / "plume_*.vti", 3)->array("f").lower, 101);
}

TEST(NumberedFiles, ALastOneThatIsNoFileYetIsLeftOutWithAWord) {
  const Scratch scratch;
  for (const int n : {1, 2}) scratch.write("p_" + std::to_string(n) + ".vti", image(n));
  scratch.write("p_3.vti", "");
  const auto data = test::open(scratch / "p_*.vti", 1);
  EXPECT_EQ(data->times, (std::vector<double>{1, 2}));
  EXPECT_NE(std::find(data->notes.begin(), data->notes.end(), "the last file is left out: p_3.vti: is empty"), data->notes.end());
  scratch.write("p_3.vti", image(3));
  EXPECT_EQ(test::open(scratch / "p_*.vti", 2)->array("f").lower, 3);
}

TEST(NumberedFiles, OneThatIsSwappedForALinkOutOfTheServedFolderIsNotFollowed) {
  const Scratch scratch;
  for (const int n : {1, 2}) scratch.write("data/in/p_" + std::to_string(n) + ".vti", image(n));
  const fs::path outside = scratch.write("outside.vti", image(77));
  const fs::path pattern = beneath(fs::canonical(scratch / "data"), "in/p_*.vti");
  ASSERT_EQ(test::open(pattern, 1)->array("f").lower, 2);
  fs::remove(scratch / "data/in/p_2.vti");
  fs::create_symlink(outside, scratch / "data/in/p_2.vti");
  for (const int step : {0, 1}) {
    OpenOptions options;
    options.step = step;
    const Error refused = test::refusal(pattern, options);
    EXPECT_EQ(refused.code(), ErrorCode::not_found);
    EXPECT_NE(std::string(refused.what()).find("a link out of the directory"), std::string::npos) << refused.what();
  }
  fs::remove(scratch / "data/in/p_2.vti");
  fs::create_symlink("../elsewhere.vti", scratch / "data/in/p_2.vti");  // one that stays inside is followed
  scratch.write("data/elsewhere.vti", image(5));
  EXPECT_EQ(test::open(pattern, 0)->array("f").lower, 1);
}

TEST(NumberedFiles, HaveTheTimesThatTheySay) {
  const Scratch scratch;
  for (const int n : {1, 2, 3}) scratch.write("a" + std::to_string(n) + ".vti", image(n, at_time(0.25 * n * n)));
  EXPECT_EQ(test::open(scratch / "a*.vti", 2)->times, (std::vector<double>{0.25, 1, 2.25}));
  // Where one of them says none, or they do not increase, the numbers count.
  scratch.write("a4.vti", image(4));
  EXPECT_EQ(test::open(scratch / "a*.vti")->times, (std::vector<double>{1, 2, 3, 4}));
  scratch.write("a4.vti", image(4, at_time(0.1)));
  EXPECT_EQ(test::open(scratch / "a*.vti")->times, (std::vector<double>{1, 2, 3, 4}));
}

TEST(NumberedFiles, HaveTheTimesOfLegacyFilesAsEachOfThemAlone) {
  const Scratch scratch;
  const std::string head = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nFIELD FieldData 1\nTIME 1 1 double\n";
  for (const int n : {1, 2}) {
    std::string text = head + std::to_string(1.5 * n) +
                       "\nDIMENSIONS 2 2 2\nSPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 8\nSCALARS f float 1\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7\n";
    scratch.write("l" + std::to_string(n) + ".vtk", text);
    for (auto at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 2)) text.insert(at, "\r");
    scratch.write("windows" + std::to_string(n) + ".vtk", text);
  }
  for (const std::string name : {"l", "windows"}) {
    EXPECT_EQ(test::open(scratch / (name + "*.vtk"), 1)->times, (std::vector<double>{1.5, 3})) << name;
    EXPECT_EQ(test::open(scratch / (name + "2.vtk"))->times, (std::vector<double>{3})) << name;
  }
}

// A range has 11 digits: those of seconds since 1970 are whole ones.
TEST(NumberedFiles, HaveTheTimesThatAreAppendedToTheLastDigit) {
  const Scratch scratch;
  const std::vector<double> times{1500000000.125, 1500000000.25};
  for (std::size_t n = 0; n < 2; ++n) {
    std::string appended("\10\0\0\0\0\0\0\0", 8);
    appended.append(reinterpret_cast<const char*>(&times[n]), 8);
    std::string text = image(0, "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"appended\" RangeMin=\"1500000000.1\" "
                                "RangeMax=\"1500000000.1\" offset=\"0\"/></FieldData>");
    text.insert(text.find("</VTKFile>"), "<AppendedData encoding=\"raw\">_" + appended + "</AppendedData>");
    scratch.write("a" + std::to_string(n) + ".vti", text);
  }
  EXPECT_EQ(test::open(scratch / "a*.vti")->times, times);
  EXPECT_EQ(test::open(scratch / "a1.vti")->times, (std::vector<double>{times[1]}));
}

/// NumPy's, version 1: two by two bytes.
std::string npy(char value) {
  std::string head = "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 2), }";
  head += std::string(118 - 1 - head.size(), ' ') + "\n";
  return std::string("\x93NUMPY\x01\0\x76\0", 10) + head + std::string(4, value);
}

TEST(NumberedFiles, OfNumPyHaveOneArrayUnderOneName) {
  const Scratch scratch;
  for (int n = 1; n <= 3; ++n) {
    scratch.write("p_" + std::to_string(n) + ".npy", npy(static_cast<char>(n)));
    scratch.write("q_" + std::to_string(n) + ".npy.gz", test::gzip(npy(static_cast<char>(n))));
    scratch.write("only/" + std::to_string(n) + ".npy", npy(static_cast<char>(n)));
  }
  scratch.write("run.npy.series", R"({"files":[{"name":"p_1.npy","time":0},{"name":"p_2.npy","time":1}]})");
  for (const auto& [source, name] : std::map<std::string, std::string>{{"p_*.npy", "p"}, {"q_*.npy.gz", "q"}, {"only/*.npy", "values"}, {"run.npy.series", "run"}})
    for (int step = 0; step < 2; ++step) EXPECT_EQ(test::open(scratch / source, step)->array(name).lower, step + 1) << source;
  EXPECT_EQ(test::open(scratch / "p_1.npy")->arrays.front().name, "p_1");
}

TEST(NumberedFiles, AListOfParaViewsSaysItsOwnTimes) {
  const Scratch scratch;
  for (const int n : {0, 1}) scratch.write("in/s_" + std::to_string(n) + ".vti", image(10 * n));
  const auto list = scratch.write("s.vti.series", R"({"file-series-version":"1.0","files":[{"name":"in/s_1.vti","time":7.5},{"name":"in/s_0.vti","time":2}]})");
  EXPECT_EQ(test::open(list, 0)->times, (std::vector<double>{2, 7.5}));
  EXPECT_EQ(test::open(list, 1)->array("f").lower, 10);
  for (const std::string bad : {"{}", "[]", "{\"files\":[]}", "{\"files\":[{}]}", "{\"files\":[{\"name\":\"in/s_0.vti\",\"time\":\"x\"}]}", "{"})
    EXPECT_EQ(test::refusal(scratch.write("bad.vti.series", bad)).code(), ErrorCode::bad_data) << bad;
  EXPECT_EQ(test::refusal(scratch.write("self.vti.series", R"({"files":[{"name":"self.vti.series","time":0}]})")).code(), ErrorCode::bad_data);
}

TEST(ListFolder, AMessyFolderIsSeriesDataSetsAndReasons) {
  const Scratch scratch;
  for (const int n : {1, 2, 5}) scratch.write("data/plume_" + std::to_string(n) + ".vti", image(n));
  scratch.write("data/single.vti", image());
  scratch.write("data/damaged.vtu", "not XML at all");
  for (const int n : {0, 1}) scratch.write("data/whole/part_" + std::to_string(n) + ".vtu", testing::vtk_file("UnstructuredGrid", "<UnstructuredGrid/>"));
  scratch.write("data/whole.pvtu", testing::vtk_file("PUnstructuredGrid", "<PUnstructuredGrid><Piece Source=\"whole/part_0.vtu\"/>"
                                                                          "<Piece Source=\"whole/part_1.vtu\"/></PUnstructuredGrid>"));
  scratch.write("data/raw.nhdr", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: raw.raw\n");
  scratch.write("data/raw.raw", "12345678");
  scratch.write("data/alone.raw", "12345678");
  scratch.write("data/case/system/controlDict", "FoamFile {}");
  scratch.write("data/case/constant/polyMesh/points", "");
  scratch.write("data/case/0/p", "");
  for (int k = 0; k < 4; ++k) scratch.write("data/scan/slice" + std::to_string(k), std::string(128, '\0') + "DICM" + std::string(20, '\0'));
  for (const int n : {1, 2, 3}) scratch.write("data/ct_" + std::to_string(n) + ".png", "x");
  scratch.write("data/photo.png", "x");
  scratch.write("data/surface.stl", "solid");
  scratch.write("data/surface.vtp", testing::vtk_file("PolyData", "<PolyData/>"));
  scratch.write("data/surface.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\n");
  scratch.write("data/walls.vtm", testing::vtk_file("vtkMultiBlockDataSet", "<vtkMultiBlockDataSet><DataSet index=\"0\" file=\"walls/floor.vtp\"/></vtkMultiBlockDataSet>"));
  scratch.write("data/finxyz.bin", "x");
  scratch.write("data/finq.bin", "x");
  for (const char* name : {"notes.txt", "run.py", "job.log", "make_grid.py"}) scratch.write("data/" + std::string(name), "text");
  scratch.write("data/.hidden.vti", image());
  scratch.write("outside.vti", image());
  fs::create_symlink(scratch / "outside.vti", scratch / "data/link.vti");
  fs::create_symlink("nowhere.vti", scratch / "data/dangling.vti");
  ASSERT_EQ(mkfifo((scratch / "data/pipe.vti").c_str(), 0600), 0);
  fs::create_directory_symlink(scratch / "data", scratch / "data/again");

  const FolderListing listing = list_folder(scratch / "data");
  EXPECT_EQ(names(listing), (std::map<std::string, int>{{"plume_*.vti", 3}, {"single.vti", 1}, {"damaged.vtu", 1}, {"whole.pvtu", 1}, {"raw.nhdr", 1},
                                                        {"case", 1}, {"scan", 4}, {"ct_*.png", 3}, {"finxyz.bin", 1}}));
  for (const FolderEntry& entry : listing.entries)
    if (entry.name == "case") {
      EXPECT_EQ(entry.bytes, std::string("FoamFile {}").size()) << "of all files of the case";
    }
  EXPECT_EQ(passed(listing, "belongs to another file"), 3);  // two pieces and the data of a header
  EXPECT_EQ(passed(listing, "numbers without a header"), 1);
  EXPECT_EQ(passed(listing, "a surface") + passed(listing, "this is a surface"), 3);  // by their names, and by what is in them
  EXPECT_EQ(passed(listing, "a list of surfaces"), 1);
  EXPECT_EQ(passed(listing, "one picture"), 1);
  EXPECT_EQ(passed(listing, "PLOT3D solution"), 1);
  EXPECT_EQ(passed(listing, "text") + passed(listing, "a program or its settings"), 4);
  EXPECT_EQ(passed(listing, "hidden"), 1);
  EXPECT_EQ(passed(listing, "leads out of the folder"), 1);
  EXPECT_EQ(passed(listing, "leads nowhere"), 1);
  EXPECT_EQ(passed(listing, "a pipe"), 1);
  EXPECT_FALSE(listing.cut_off);
  for (const FolderEntry& entry : listing.entries)
    if (entry.name == "plume_*.vti") {
      EXPECT_EQ(entry.bytes, image(1).size() + image(2).size() + image(5).size());
      EXPECT_GT(entry.changed, 1'600'000'000'000);
    }
  EXPECT_TRUE(list_folder(scratch / "data", 3).cut_off);
}

/// A grid of n points along each axis between 0 and 1.
std::string cube(int n, const std::string& values = "0 ") {
  const std::string extent = "0 " + std::to_string(n - 1) + " 0 " + std::to_string(n - 1) + " 0 " + std::to_string(n - 1), spacing = std::to_string(1.0 / (n - 1));
  std::string text;
  for (int i = 0; i < n * n * n; ++i) text += values;
  return testing::vtk_file("ImageData", "<ImageData WholeExtent=\"" + extent + "\" Origin=\"0 0 0\" Spacing=\"" + spacing + " " + spacing + " " + spacing +
                                            "\"><Piece Extent=\"" + extent + "\"><PointData><DataArray type=\"Float32\" Name=\"f\" format=\"ascii\">" + text +
                                            "</DataArray></PointData></Piece></ImageData>");
}

TEST(ListFolder, OneThingInSeveralResolutionsIsNoSeries) {
  const Scratch scratch;
  for (const int n : {8, 16, 32}) scratch.write("torus_" + std::to_string(n) + ".vti", cube(n));
  for (const auto& [name, bytes] : std::map<std::string, int>{{"etopo5.cdf", 37000}, {"etopo20.cdf", 2300}, {"etopo40.cdf", 590}, {"labels-1mm.nii.gz", 47934}, {"labels-2mm.nii.gz", 8341}})
    scratch.write(name, (name.ends_with("gz") ? "\x1f\x8b" : "CDF\x01") + std::string(static_cast<std::size_t>(bytes), 'x'));
  EXPECT_EQ(names(list_folder(scratch.path())), (std::map<std::string, int>{{"torus_8.vti", 1}, {"torus_16.vti", 1}, {"torus_32.vti", 1}, {"etopo5.cdf", 1}, {"etopo20.cdf", 1},
                                                                           {"etopo40.cdf", 1}, {"labels-1mm.nii.gz", 1}, {"labels-2mm.nii.gz", 1}}));
  const auto finest = test::open(scratch / "torus_*.vti", 2);  // who names the pattern gets each in its own box
  EXPECT_EQ(finest->grid.dims(), (std::array<std::int64_t, 3>{32, 32, 32}));
  EXPECT_NEAR(finest->bounds.upper.x, 1, 1e-4);
}

TEST(ListFolder, AMeshThatIsRefinedAFewStepsThatGrowAndALongSeriesStaySeries) {
  const Scratch scratch;
  for (const int n : {1, 2, 3}) scratch.write("mesh_" + std::to_string(n) + ".vtu", testing::vtk_file("UnstructuredGrid", "<UnstructuredGrid/>" + std::string(static_cast<std::size_t>(1000 << n), ' ')));
  for (const int n : {1, 2, 3}) scratch.write("plume_" + std::to_string(n) + ".vti", cube(4, "0." + std::string(static_cast<std::size_t>(10 << n), '0') + "1 "));  // as packed values grow
  for (int n = 2; n < 20; ++n) scratch.write("growing_" + std::to_string(n) + ".npy", "\x93NUMPY" + std::string(std::size_t{1} << n, 'x'));
  for (const int n : {1, 2, 3}) scratch.write("last_is_short_" + std::to_string(n) + ".nc", "CDF\x01" + std::string(n == 3 ? 1000 : 8000, 'x'));
  for (const int n : {1, 2, 3}) scratch.write("adapted_" + std::to_string(n) + ".msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + std::string(static_cast<std::size_t>(1000 << n), ' '));
  EXPECT_EQ(names(list_folder(scratch.path())), (std::map<std::string, int>{{"adapted_*.msh", 3}, {"mesh_*.vtu", 3}, {"plume_*.vti", 3}, {"growing_*.npy", 18}, {"last_is_short_*.nc", 3}}));
}

TEST(FolderLister, AStepThatIsBeingWrittenIsNoOtherResolution) {
  const Scratch scratch;
  for (const int n : {1, 2}) scratch.write("f_" + std::to_string(n) + ".npy", "\x93NUMPY" + std::string(n == 2 ? 100 : 1000, 'x'));
  FolderLister lister(fs::canonical(scratch.path()));
  EXPECT_EQ(names(lister.list({(fs::canonical(scratch.path()) / "f_2.npy").string()})), (std::map<std::string, int>{{"f_*.npy", 2}}));
}

/// The beginning of a PNG, as far as its size.
std::string png(int width, int height) {
  std::string head("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
  for (const int side : {width, height})
    for (int shift = 24; shift >= 0; shift -= 8) head += static_cast<char>(side >> shift);
  return head + "\x08\0\0\0\0";
}

TEST(ListFolder, AProgramThatNamesTheElementIsNoXmlVtk) {
  const Scratch scratch;
  scratch.write("server.ts", "// reads files\nconst first = '<VTKFile type=\"ImageData\">';\n");
  scratch.write("quoted.xml", "<page><VTKFile type=\"ImageData\"/></page>");
  scratch.write("declared.vti", "<?xml version=\"1.0\"?>\n<!-- made by -- us -->\n<!DOCTYPE x>\n" + image());
  const FolderListing listing = list_folder(scratch.path());
  EXPECT_EQ(names(listing), (std::map<std::string, int>{{"declared.vti", 1}}));
  EXPECT_EQ(passed(listing, "a program or its settings"), 1);
}

TEST(ListFolder, NumberedPicturesOfSeveralSizesAreNoStack) {
  const Scratch scratch;
  for (const int n : {1, 2, 3}) {
    scratch.write("slice_" + std::to_string(n) + ".png", png(300, 200));
    scratch.write("shot_" + std::to_string(n) + ".png", png(300, 200 + n));
    scratch.write("map_" + std::to_string(n) + ".pgm", "P5\n# " + std::to_string(n) + "\n" + std::to_string(10 * n) + " 20\n255\n");
  }
  const FolderListing listing = list_folder(scratch.path());
  EXPECT_EQ(names(listing), (std::map<std::string, int>{{"slice_*.png", 3}}));
  EXPECT_EQ(passed(listing, "several sizes"), 6);
}

bool same(const FolderListing& a, const FolderListing& b) {
  const auto entry = [](const FolderEntry& e) { return std::tuple(e.name, e.source, e.kind, e.bytes, e.changed, e.files, e.mark, e.marks); };
  const auto reason = [](const PassedOver& p) { return std::tuple(p.reason, p.files, p.examples); };
  return std::equal(a.entries.begin(), a.entries.end(), b.entries.begin(), b.entries.end(),
                    [&](const auto& x, const auto& y) { return entry(x) == entry(y); }) &&
         std::equal(a.passed_over.begin(), a.passed_over.end(), b.passed_over.begin(), b.passed_over.end(),
                    [&](const auto& x, const auto& y) { return reason(x) == reason(y); }) &&
         a.cut_off == b.cut_off;
}

TEST(FolderLister, WhatItIsToldToLookAtAgainIsListedAsByANewLook) {
  std::mt19937 random(16);
  const auto pick = [&](int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); };
  const Scratch scratch;
  scratch.write("in/first.vti", image());
  FolderLister lister(fs::canonical(scratch.path()));
  lister.list();
  for (int round = 0; round < 200; ++round) {
    const std::string folder = std::array{"in", "in/deep", "other"}[static_cast<std::size_t>(pick(3))];
    const fs::path path = scratch / (folder + "/" + std::array{"a_1.vti", "a_2.vti", "a_3.vti", "whole.pvtu", "notes.txt"}[static_cast<std::size_t>(pick(5))]);
    const std::set<fs::path> touched{path.parent_path(), path.parent_path().parent_path(), scratch.path()};
    switch (pick(4)) {
      case 0:
        fs::remove(path);
        break;
      case 1:
        if (pick(4) == 0) fs::remove_all(path.parent_path());
        break;
      case 2:
        if (const fs::path to = path.parent_path() / "a_7.vti"; fs::exists(path)) fs::rename(path, to);
        break;
      default:
        scratch.write(path.lexically_relative(scratch.path()).string(),
                      path.extension() == ".pvtu"
                          ? testing::vtk_file("PUnstructuredGrid", "<PUnstructuredGrid><Piece Source=\"a_" + std::to_string(1 + pick(3)) + ".vti\"/></PUnstructuredGrid>")
                          : image(round));
    }
    for (const fs::path& of : touched) lister.look_again(fs::weakly_canonical(of));
    ASSERT_TRUE(same(lister.list(), list_folder(scratch.path()))) << "seed 16, round " << round << ", " << path;
  }
}

TEST(FolderLister, ASeriesHasGrownIfItsOldMarkIsTheBeginningOfTheNewOnes) {
  const Scratch scratch;
  for (const int n : {8, 9}) scratch.write("p_" + std::to_string(n) + ".vti", image(n));
  const auto entry = [&] { return list_folder(scratch.path()).entries.at(0); };
  const FolderEntry two = entry();
  ASSERT_EQ(two.marks.size(), 2u);
  EXPECT_EQ(two.mark, two.marks.back());
  EXPECT_EQ(two.mark, mark_on_disk(two.source, 2));
  scratch.write("p_10.vti", image(10));
  EXPECT_EQ(entry().marks.at(1), two.mark);
  EXPECT_EQ(mark_on_disk(two.source, 2), two.mark);
  EXPECT_EQ(mark_on_disk(two.source, 4), 0u);
  scratch.write("p_9.vti", image(99));
  EXPECT_NE(entry().marks.at(1), two.mark);
  EXPECT_NE(mark_on_disk(two.source, 2), two.mark);
}

TEST(FolderLister, TellsWhichFilesOfASeriesAreBeingWritten) {
  const Scratch scratch;
  for (const int n : {1, 2, 3}) scratch.write("p_" + std::to_string(n) + ".vti", image(n));
  FolderLister lister(fs::canonical(scratch.path()));
  const FolderEntry entry = lister.list({fs::canonical(scratch / "p_3.vti").string()}).entries.at(0);
  EXPECT_TRUE(entry.writing);
  EXPECT_EQ(entry.files, 3);
  EXPECT_EQ(entry.settled, 2);
  lister.look_again(fs::canonical(scratch.path()));
  EXPECT_FALSE(lister.list().entries.at(0).writing);
}

TEST(ListFolder, WhatIsListedOpens) {
  const Scratch scratch;
  for (const int n : {1, 2}) scratch.write("p" + std::to_string(n) + ".vti", image(n));
  scratch.write("whole.vtm", testing::vtk_file("vtkMultiBlockDataSet", "<vtkMultiBlockDataSet><Block index=\"0\" name=\"fluid\"><DataSet index=\"0\" "
                                                                       "file=\"in/a.vti\"/></Block><Block index=\"1\" name=\"wall\"/></vtkMultiBlockDataSet>"));
  scratch.write("in/a.vti", image(5));
  const FolderListing listing = list_folder(scratch.path());
  EXPECT_EQ(names(listing), (std::map<std::string, int>{{"p*.vti", 2}, {"whole.vtm", 1}}));
  for (const FolderEntry& entry : listing.entries) EXPECT_EQ(open_dataset(entry.source, {}, Task())->grid.point_count(), 8) << entry.name;
}

/// A box of one cell from x to x + 1 with a point array and a cell array.
std::string box(int x, const std::string& point_array, double at_points, const std::string& cell_array, double in_cell) {
  std::vector<double> values;
  for (int i = 0; i < 8; ++i) values.push_back(at_points + x + i % 2);
  return testing::vtk_file("ImageData", "<ImageData WholeExtent=\"0 1 0 1 0 1\" Origin=\"" + std::to_string(x) + " 0 0\" Spacing=\"1 1 1\">" +
                                            "<Piece Extent=\"0 1 0 1 0 1\"><PointData>" + testing::data_array("f", "Float64", values) +
                                            testing::data_array(point_array, "Float32", values) + "</PointData><CellData>" +
                                            testing::data_array(cell_array, "Int32", std::vector<int>{static_cast<int>(in_cell)}) +
                                            "</CellData></Piece></ImageData>");
}

TEST(Blocks, AnArrayThatOneBlockLacksStaysWhereItIs) {
  const Scratch scratch;
  scratch.write("a.vti", box(0, "temperature", 0, "material", 3));
  scratch.write("b.vti", box(1, "pressure", 0, "porosity", 5));
  const auto data = test::open(scratch.write(
      "whole.vtm", testing::vtk_file("vtkMultiBlockDataSet", "<vtkMultiBlockDataSet><Block index=\"0\" name=\"fluid\"><DataSet index=\"0\" file=\"a.vti\"/>"
                                                             "</Block><DataSet index=\"1\" name=\"wall\" file=\"b.vti\"/></vtkMultiBlockDataSet>")));
  ASSERT_EQ(data->grid.point_count(), 12);  // the four between them are common: what one does not know the other one does
  ASSERT_EQ(data->grid.cell_count(), 2);
  int at_left = 0, at_right = 0;
  for (std::int64_t p = 0; p < 12; ++p) {
    const double x = data->grid.point(p).x;
    const auto at = static_cast<std::size_t>(p);
    EXPECT_EQ(data->array("f").at(at), x);
    for (const auto& [name, from, to, value] : {std::tuple("temperature", 0.0, 1.0, x), std::tuple("pressure", 1.0, 2.0, x),
                                                std::tuple("material", 0.0, 1.0, 3.0), std::tuple("porosity", 1.0, 2.0, 5.0)}) {
      if (x >= from && x <= to)
        EXPECT_EQ(data->array(name).at(at), value) << name << " at x = " << x;
      else
        EXPECT_TRUE(std::isnan(data->array(name).at(at))) << name << " at x = " << x;
    }
    at_left += x == 0;
    at_right += x == 2;
  }
  EXPECT_EQ(at_left, 4);
  EXPECT_EQ(at_right, 4);
  EXPECT_EQ(data->array("temperature").nan_count, 4);
  EXPECT_NE(std::find(data->notes.begin(), data->notes.end(), "blocks: fluid, wall"), data->notes.end());
  EXPECT_NE(std::find(data->notes.begin(), data->notes.end(), "array 'temperature' has no values in 1 of 2 blocks"), data->notes.end());
}

}  // namespace
}  // namespace isostrata
