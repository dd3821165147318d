// The manifest of a partition: written and read it is the same, and no other one is taken for it.
#include "data/parts/partition.h"

#include <gtest/gtest.h>

#include <random>

#include "data/dataset/analytic.h"

namespace isostrata {
namespace {

DatasetParts sample(int parts) {
  const auto whole = make_analytic("torus:9", {}, Task());
  DatasetParts out = partition_of(*whole, make_regions(whole->grid, parts));
  for (int i = 0; i < parts; ++i) out.parts.push_back({"torus_" + std::to_string(i) + ".vti", {i, 0, 1}, 100 + i, 50 + i, 40 + i});
  return out;
}

TEST(Partition, IsReadAsItWasWritten) {
  for (const int parts : {1, 2, 7, 64}) {
    DatasetParts of = sample(parts);
    of.arrays.push_back({"none \"at\" all", ScalarType::uint16, 1, 0, 12});
    of.origin.x = 0.1 + 0.2;
    const std::string text = to_text(of);
    const DatasetParts read = parse_partition(text, "p");
    EXPECT_EQ(to_text(read), text);
    EXPECT_EQ(read.regions, of.regions);
    EXPECT_EQ(read.origin, of.origin);
    EXPECT_EQ(read.arrays.at(0).upper, of.arrays.at(0).upper);
    EXPECT_GT(read.arrays.at(1).lower, read.arrays.at(1).upper);
  }
}

std::string refusal(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  text.replace(at, what.size(), by);
  try {
    parse_partition(text, "name.parts.json");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_data);
    return error.what();
  }
  return "";
}

TEST(Partition, WhatIsWrongIsNamed) {
  const std::string text = to_text(sample(3));
  const auto says = [](const std::string& message, const std::string& part) { return message.starts_with("name.parts.json: ") && message.find(part) != std::string::npos; };
  EXPECT_PRED2(says, refusal(text, "{", ""), "not well-formed");
  EXPECT_PRED2(says, refusal(text, "\"format\":1", "\"format\":2"), "'format'");
  EXPECT_PRED2(says, refusal(text, "\"planes\":[", "\"planes\":[5,"), "'planes'");
  EXPECT_PRED2(says, refusal(text, "\"axis\":", "\"axis\":9"), "'axis'");
  EXPECT_PRED2(says, refusal(text, "torus_1.vti", "../torus_1.vti"), "not a file beside the list");
  EXPECT_PRED2(says, refusal(text, "\"type\":\"float32\"", "\"type\":\"float\""), "is of type 'float'");
  EXPECT_PRED2(says, refusal(text, "\"spacing\":[", "\"spacing\":[1,"), "'spacing'");
  EXPECT_PRED2(says, refusal(text, "\"own_cells\":40", "\"own_cells\":-1"), "'own_cells'");
  // The first plane has part 0 below and the second plane above.
  EXPECT_PRED2(says, refusal(text, "\"below\":-1", "\"below\":0"), "leads back");
  EXPECT_PRED2(says, refusal(text, "\"below\":-1", "\"below\":-2"), "not a tree");
}

TEST(Partition, AnotherByteAnywhereIsAnotherPartitionOrAnError) {
  const std::string text = to_text(sample(5));
  std::mt19937 random(8);
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string other = text;
    other[random() % other.size()] = static_cast<char>(random() % 256);
    if (random() % 4 == 0) other.resize(random() % other.size());
    try {
      const DatasetParts read = parse_partition(other, "p");
      EXPECT_EQ(read.parts.size(), read.regions.nodes.size() + 1);
      for (std::size_t region = 0; region < read.parts.size(); ++region) region_box(read.regions, static_cast<int>(region));  // every walk ends
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_data) << error.what();
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
}

/// Of 2^16 parts, each beside the next: deep as a list.
TEST(Partition, PlanesInALongRowAreRefused) {
  DatasetParts of = sample(1);
  for (int i = 0; i < 40000; ++i) {
    of.regions.nodes.push_back({0, static_cast<double>(i), ~i, i + 1 < 40000 ? i + 1 : ~40000});
    of.parts.push_back(of.parts.front());
  }
  EXPECT_THROW(parse_partition(to_text(of), "p"), Error);
}

}  // namespace
}  // namespace isostrata
