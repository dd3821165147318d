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

TEST(DatasetList, WhatIsNoFileOfASeriesFindsNone) {
  for (const char* word : {"wave_x.vtu", "wave_e", "wave_0042.vti", "wave_00a42.vtu", "awave_1.vtu", "run2_0001.vtu", "step_1_time.vtu", "_0042_x"})
    EXPECT_EQ(found(word), Names{}) << word;
  EXPECT_EQ(found("7"), Names{"still_7.vtu"});  // a number alone would find every series
  EXPECT_EQ(found("42"), Names{});
  EXPECT_EQ(found("*"), (Names{"phi_*.vtu", "run/wave_*.vtu", "run1_*.vtu", "step_*_time_*.vtu"}));
  EXPECT_EQ(found("wave.vtu"), Names{"wave.vtu"});
}

}  // namespace
}  // namespace isostrata
