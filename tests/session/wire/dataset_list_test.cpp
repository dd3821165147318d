#include "session/wire/dataset_list.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace isostrata {
namespace {

std::vector<std::string> found(const std::string& search) {
  std::vector<CatalogueEntry> entries;
  for (const char* name : {"run/wave_*.vtu", "run1_*.vtu", "phi_*.vtu", "step_*_time_*.vtu", "still_7.vtu", "wave.vtu"})
    entries.push_back({.id = name, .name = name, .source = name});
  v1::ListDatasets wanted;
  wanted.set_search(search);
  const v1::DatasetList list = list_datasets(Catalogue::from_entries(std::move(entries)), wanted);
  std::vector<std::string> names;
  for (const auto& entry : list.datasets()) names.push_back(entry.name());
  return names;
}

using Names = std::vector<std::string>;

TEST(DatasetList, ASeriesIsFoundByTheNameOfOneOfItsFiles) {
  EXPECT_EQ(found("wave_0042.vtu"), Names{"run/wave_*.vtu"});
  EXPECT_EQ(found("WAVE_0042"), Names{"run/wave_*.vtu"});
  EXPECT_EQ(found("run/wave_0"), Names{"run/wave_*.vtu"});
  EXPECT_EQ(found("run1_0001.vtu"), Names{"run1_*.vtu"});
  EXPECT_EQ(found("phi_-0.5.vtu"), Names{"phi_*.vtu"});
  EXPECT_EQ(found("phi_1.5e-3.vtu"), Names{"phi_*.vtu"});
  EXPECT_EQ(found("step_0001_time_0.25.vtu"), Names{"step_*_time_*.vtu"});
  EXPECT_EQ(found("run 0042.vtu"), (Names{"run/wave_*.vtu", "run1_*.vtu"}));  // each word, wherever
}

/// "NAME STEP" of what is found.
Names found_with_steps(const std::string& search) {
  const auto series = [](const char* name, std::uint64_t first, std::uint64_t stride, int digits, int files) {
    return CatalogueEntry{.id = name, .name = name, .source = name, .files = files, .numbers = {first, stride, digits}, .parts = files};
  };
  std::vector<CatalogueEntry> entries{series("run/wave_*.vtu", 0, 10, 4, 100), series("t*.vtk", 1, 1, 1, 12), series("day_1200_*.nc", 5, 5, 2, 3)};
  entries.push_back({.id = "a7", .name = "a7.vtu", .source = "a7.vtu"});
  entries.push_back(series("slice*.png", 0, 1, 3, 500));
  entries.back().one_step = true;
  v1::ListDatasets wanted;
  wanted.set_search(search);
  const v1::DatasetList list = list_datasets(Catalogue::from_entries(std::move(entries)), wanted);
  Names names;
  for (const auto& entry : list.datasets()) names.push_back(entry.name() + " " + std::to_string(entry.found_step()));
  return names;
}

TEST(DatasetList, EveryFileOfASeriesFindsItsOwnStep) {
  for (int i = 0; i < 100; ++i) {
    std::string number = std::to_string(10 * i);
    number.insert(0, 4 - number.size(), '0');
    const Names one{"run/wave_*.vtu " + std::to_string(i + 1)};
    EXPECT_EQ(found_with_steps("wave_" + number + ".vtu"), one);
    EXPECT_EQ(found_with_steps("WAVE_" + number), one);
    EXPECT_EQ(found_with_steps("wave " + number), one);
  }
}

TEST(DatasetList, ANumberAloneFindsTheSeriesThatHaveAFileOfItIfNoNameHasIt) {
  EXPECT_EQ(found_with_steps("0990"), (Names{"run/wave_*.vtu 100"}));
  EXPECT_EQ(found_with_steps("990"), (Names{"run/wave_*.vtu 100"}));
  EXPECT_EQ(found_with_steps("1000"), Names{});   // beyond the last file
  EXPECT_EQ(found_with_steps("995"), Names{});    // between two
  EXPECT_EQ(found_with_steps("7"), (Names{"a7.vtu 0"}));
  EXPECT_EQ(found_with_steps("10"), (Names{"day_1200_*.nc 2", "run/wave_*.vtu 2", "slice*.png 0", "t*.vtk 10"}));
  EXPECT_EQ(found_with_steps("1200"), (Names{"day_1200_*.nc 0"}));
  EXPECT_EQ(found_with_steps("99999999999999999999999"), Names{});
  EXPECT_EQ(found_with_steps("slice123.png"), (Names{"slice*.png 0"}));  // a slice is not a step
}

TEST(DatasetList, WhatMayBeTheBeginningOfALongerNumberIsNoStep) {
  EXPECT_EQ(found_with_steps("wave_00"), (Names{"run/wave_*.vtu 0"}));
  EXPECT_EQ(found_with_steps("wave_0"), (Names{"run/wave_*.vtu 0"}));
  EXPECT_EQ(found_with_steps("t1"), (Names{"t*.vtk 1"}));
  EXPECT_EQ(found_with_steps("t13"), (Names{"t*.vtk 0"}));
}

TEST(DatasetList, WhatIsNoFileOfASeriesFindsNone) {
  for (const char* word : {"wave_x.vtu", "wave_e", "wave_0042.vti", "wave_00a42.vtu", "awave_1.vtu", "run2_0001.vtu", "step_1_time.vtu", "_0042_x"})
    EXPECT_EQ(found(word), Names{}) << word;
  EXPECT_EQ(found("7"), Names{"still_7.vtu"});
  EXPECT_EQ(found("42"), Names{});
  EXPECT_EQ(found("*"), (Names{"phi_*.vtu", "run/wave_*.vtu", "run1_*.vtu", "step_*_time_*.vtu"}));
  EXPECT_EQ(found("wave.vtu"), Names{"wave.vtu"});
}

}  // namespace
}  // namespace isostrata
