#include "data/files/raw_name.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "base/error.h"

namespace isostrata {
namespace {

using Sizes = std::vector<std::int64_t>;

RawName said(const std::string& name, std::uint64_t bytes) {
  const auto raw = raw_name(name, bytes);
  EXPECT_TRUE(raw) << name;
  return raw.value_or(RawName());
}

TEST(RawNames, SaySizesAndTypesAsPeopleWriteThem) {
  const struct {
    std::string name;
    Sizes sizes;
    ScalarType type;
  } cases[] = {{"bonsai_256x256x256_uint8.raw", {256, 256, 256}, ScalarType::uint8},
               {"Foot-64X32x16-Float64.BIN", {64, 32, 16}, ScalarType::float64},
               {"vertebra8_512x512x320_int16.raw", {512, 512, 320}, ScalarType::int16},
               {"head256x256x109.u16", {256, 256, 109}, ScalarType::uint16},
               {"a_10x20x30x5_f32_le.raw", {10, 20, 30, 5}, ScalarType::float32},
               {"slice_640x480_16bit.raw", {640, 480}, ScalarType::uint16},
               {"ct_0.5x0.5x1.25_100x90x80_short.raw", {100, 90, 80}, ScalarType::int16},
               {"ct_2x0.5_100x90x80_short.raw", {100, 90, 80}, ScalarType::int16},
               {"head_120_130_140_int16.raw", {120, 130, 140}, ScalarType::int16},
               {"run7_120_130_140_u8.raw", {120, 130, 140}, ScalarType::uint8}};
  for (const auto& of : cases) {
    std::uint64_t values = 1;
    for (const std::int64_t size : of.sizes) values *= static_cast<std::uint64_t>(size);
    const RawName raw = said(of.name, values * size_of(of.type));
    EXPECT_EQ(raw.sizes, of.sizes) << of.name;
    EXPECT_EQ(raw.type, of.type) << of.name;
    EXPECT_TRUE(raw.says_type) << of.name;
  }
}

TEST(RawNames, WithoutATypeTheBytesTellIt) {
  for (const auto& [width, type] : {std::pair{1u, ScalarType::uint8}, {2u, ScalarType::uint16}, {4u, ScalarType::float32}, {8u, ScalarType::float64}}) {
    const RawName raw = said("a_7x5x3.raw", 105 * width);
    EXPECT_EQ(raw.type, type);
    EXPECT_FALSE(raw.says_type);
    EXPECT_EQ(said("a_7_5_3.raw", 105 * width).type, type);
  }
}

TEST(RawNames, SayTheOrderOfBytesIfTheyDo) {
  EXPECT_EQ(said("a_2x2x2_uint16_be.raw", 16).big_endian, true);
  EXPECT_EQ(said("a_2x2x2_uint16.little.raw", 16).big_endian, false);
  EXPECT_EQ(said("a_2x2x2_uint16.raw", 16).big_endian, std::nullopt);
}

TEST(RawNames, OthersSayNothing) {
  for (const char* name : {"a_2x2x2_uint8.txt", "a.raw", "a_8.raw", "2x.raw", "x2.raw", "1.5x2.5x3.5.raw", "a_1_2_3.raw", "2x2x2x2x2.raw", "a_0x4x2.raw"})
    EXPECT_FALSE(raw_name(name, 8)) << name;
}

TEST(RawNames, WhatTheyPromiseMustBeThere) {
  for (const auto& [name, bytes] : {std::pair{"a_2x2x2_uint16.raw", 8u}, {"a_2x2x2.raw", 9u}, {"a_2x2x2_u8.raw", 0u}, {"a_999999999x999999999x999999999_u8.raw", 8u},
                                    {"a_99999999999999999999x2x2.raw", 8u}, {"a_1099511627776x1099511627776x1099511627776.raw", 8u}}) {
    try {
      if (const auto raw = raw_name(name, bytes)) FAIL() << name << " is taken for " << raw->sizes.size() << " sizes";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_data);
      EXPECT_NE(std::string(error.what()).find("its name says"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace isostrata
