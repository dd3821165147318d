#include "data/parts/region.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "data/dataset/analytic.h"
#include "data/files.h"
#include "data/open/import_cache.h"
#include "data/values/kept_facts.h"
#include "support/places.h"

namespace isostrata {
namespace {

using test::Scratch;
constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

Region region(const std::string& box, const std::string& stride = "1") {
  Region of;
  set_box(of, box);
  set_stride(of, stride);
  return of;
}

TEST(RegionText, IsReadAsItWasWritten) {
  for (const auto& [box, stride] : {std::pair{":,:,:", "1"}, {"3:9,:,:12", "1"}, {"0:0,1:,:", "2"}, {":,:,:", "1,2,3"}, {"5:6,7:8,9:10", "4,4,4"}}) {
    const Region of = region(box, stride);
    EXPECT_EQ(region_of(to_string(of)), of) << to_string(of);
  }
  EXPECT_EQ(to_string(region("0:31,:,:", "2,2,2")), ":31,:,:*2");
  for (const char* wrong : {"", ":,:", ":,:,:*", ":,:,:*0", ":,:,:*1,2", "a:,:,:"}) EXPECT_THROW(region_of(wrong), Error) << wrong;
}

/// Every point of the part is the whole's, in place and value.
void expect_part(const Dataset& part, const Dataset& whole, const Region& of) {
  const auto n = part.grid.dims(), all = whole.grid.dims();
  ASSERT_EQ(part.arrays.size(), whole.arrays.size());
  std::int64_t p = 0;
  for (std::int64_t k = 0; k < n[2]; ++k)
    for (std::int64_t j = 0; j < n[1]; ++j)
      for (std::int64_t i = 0; i < n[0]; ++i, ++p) {
        const std::int64_t q = of.first[0] + i * of.stride[0] + all[0] * (of.first[1] + j * of.stride[1] + all[1] * (of.first[2] + k * of.stride[2]));
        for (std::size_t a = 0; a < part.arrays.size(); ++a)
          ASSERT_EQ(part.arrays[a].at(static_cast<std::size_t>(p)), whole.arrays[a].at(static_cast<std::size_t>(q))) << p;
        for (int axis = 0; axis < 3; ++axis) ASSERT_NEAR(part.grid.point(p)[axis], whole.grid.point(q)[axis], 1e-12) << p;
      }
  double lower = INFINITY, upper = -INFINITY;
  for (std::int64_t i = 0; i < part.grid.point_count(); ++i) {
    lower = std::min(lower, part.arrays[0].at(static_cast<std::size_t>(i)));
    upper = std::max(upper, part.arrays[0].at(static_cast<std::size_t>(i)));
  }
  EXPECT_EQ(part.arrays[0].lower, lower);
  EXPECT_EQ(part.arrays[0].upper, upper);
  EXPECT_EQ(part.bounds.lower, part.grid.bounds().lower);
}

TEST(Region, APartHasTheWholesPointsAndValues) {
  for (const std::string name : {"torus:20", "cylinder:12x16x8"}) {
    const auto whole = make_analytic(name, {}, Task{});
    for (const Region& of : {region("2:9,:,3:6"), region(":,:,:", "3"), region("1:,0:7,2:7", "2,3,1"), region("4:4,:,:"), region(":,1:99,:")}) {
      const auto part = part_of(*whole, of, kNoLimit, Task{});
      expect_part(*part, *whole, of);
    }
    EXPECT_EQ(part_of(*whole, region("2:9,:,3:6", "3,1,2"), kNoLimit, Task{})->grid.dims()[0], 3);
  }
}

TEST(Region, ACellThatSpansAHiddenOneIsHidden) {
  auto whole = std::make_shared<Dataset>(*make_analytic("torus:9", {}, Task{}));
  std::vector<std::uint8_t> hidden(8 * 8 * 8);
  hidden[3 + 8 * (4 + 8 * 5)] = 1;
  whole->grid.hidden_cells = hidden;
  const auto part = part_of(*whole, region(":,:,:", "2"), kNoLimit, Task{});
  ASSERT_EQ(part->grid.cell_count(), 64);
  for (std::int64_t c = 0; c < 64; ++c) EXPECT_EQ(part->grid.hidden(c), c == 1 + 4 * (2 + 4 * 2)) << c;
}

TEST(Region, ACoarserOneHasTheWholesRangesAndIsKeptWithTheImport) {
  const auto whole = make_analytic("cylinder:12x16x8", {}, Task{});
  const std::string name = whole->arrays[1].name;
  const std::array<std::int64_t, 3> stride{2, 3, 1};
  const auto check = [&](const Dataset& coarse, const std::string& which) {
    ASSERT_EQ(coarse.arrays.size(), 1u) << which;
    const auto n = coarse.grid.dims(), all = whole->grid.dims();
    ASSERT_EQ(n, (std::array<std::int64_t, 3>{(all[0] - 1) / 2 + 1, (all[1] - 1) / 3 + 1, all[2]})) << which;
    for (std::int64_t p = 0; p < coarse.grid.point_count(); ++p) {
      const std::int64_t i = p % n[0], j = p / n[0] % n[1], k = p / (n[0] * n[1]), q = 2 * i + all[0] * (3 * j + all[1] * k);
      ASSERT_EQ(coarse.arrays[0].at(static_cast<std::size_t>(p)), whole->arrays[1].at(static_cast<std::size_t>(q))) << which << ": " << p;
      for (int axis = 0; axis < 3; ++axis) ASSERT_NEAR(coarse.grid.point(p)[axis], whole->grid.point(q)[axis], 1e-12) << which << ": " << p;
    }
    EXPECT_EQ(coarse.arrays[0].lower, whole->arrays[1].lower) << which;
    EXPECT_EQ(coarse.arrays[0].upper, whole->arrays[1].upper) << which;
    EXPECT_EQ(coarse.bounds.upper, whole->bounds.upper) << which;
  };
  const std::vector<std::string> names{name};
  check(*coarser(*whole, stride, names, Task{}), "of an array without a place");
  Scratch where;
  set_place_of_facts(whole->arrays[1].storage, where.path(), "array_1.");
  check(*coarser(*whole, stride, names, Task{}), "found");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(where.path()), {}), 1);
  check(*coarser(*whole, stride, names, Task{}), "kept");
  check(*coarser(*whole, {2, 3, 1}, names, Task{}), "kept, again");
  const auto other = coarser(*whole, {3, 3, 1}, names, Task{});
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(where.path()), {}), 2) << "another stride is another file";
  const std::vector<std::string> none{"no such"};
  EXPECT_THROW(coarser(*whole, stride, none, Task{}), Error);
}

TEST(Region, OfAFileIsReadWithoutALookAtTheRest) {
  Scratch data;
  std::string values;
  for (int i = 0; i < 16 * 16 * 16; ++i) values += static_cast<char>(i % 100);
  const auto file = data.write("a.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 16 16 16\nencoding: raw\n\n" + values);
  OpenOptions options;
  options.importer = std::filesystem::path(isostrata::places::binaries()) / "isostrata-import";
  const auto whole = open_dataset(file.string(), options, Task());
  const Region of = region("3:8,2:5,:", "1,1,5");
  expect_part(*open_part(file.string(), options, of, Task()), *whole, of);
  Scratch where;
  ImportCache cache;
  cache.folder = where / "cache";
  cache.least_seconds = 0;
  EXPECT_EQ(find_import_cached(file, options, cache), nullptr);
  open_import_cached(file, options, cache, Task());
  const auto kept = find_import_cached(file, options, cache);
  ASSERT_TRUE(kept);
  expect_part(*part_of(*kept, of, kNoLimit, Task()), *whole, of);
}

TEST(Region, WhatIsNoRegionIsRefusedWithWhatWasExpected) {
  const auto refused = [](const auto& act, ErrorCode code, const std::string& part) {
    try {
      act();
      ADD_FAILURE() << part;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  for (const std::string text : {"", "1:2", "1:2,3:4", "2:1,:,:", "a:b,:,:", "1-2,:,:", "-1:2,:,:", "1:2,:,:,:"})
    refused([&] { region(text); }, ErrorCode::invalid_argument, "expected FIRST:LAST");
  for (const std::string text : {"", "0", "-1", "1,2", "1.5"}) refused([&] { region(":,:,:", text); }, ErrorCode::invalid_argument, "expected N");
  const auto torus = make_analytic("torus:8", {}, Task{}), tets = make_analytic("tets:4", {}, Task{});
  refused([&] { part_of(*torus, region("8:9,:,:"), kNoLimit, Task{}); }, ErrorCode::invalid_argument, "points 0 to 7");
  refused([&] { part_of(*tets, region("0:1,:,:"), kNoLimit, Task{}); }, ErrorCode::unsupported, "structured");
  refused([&] { part_of(*torus, region(":,:,:"), 100, Task{}); }, ErrorCode::too_large, "stride");
}

}  // namespace
}  // namespace isostrata
