// MRC files that the tests write byte by byte, by MRC2014.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>

#include "data/files.h"
#include "support/mutated_files.h"

namespace isostrata {
namespace {

using test::open;
using test::put;
using test::refusal;
using test::Scratch;

constexpr int kX = 4, kY = 3, kZ = 2;

struct Map {
  int mode = 2;
  bool big = false;
  std::array<int, 3> axes{1, 2, 3}, start{0, 0, 0};
  std::array<float, 3> cell{8, 1.5f, 1}, angles{90, 90, 90}, origin{0, 0, 0};
  int group = 1, sheets = kZ, volumes = 1, more = 0;
};

std::string header(const Map& of) {
  std::string out;
  const auto whole = [&](int value) { put(out, static_cast<std::int32_t>(value), of.big); };
  const auto real = [&](float value) { put(out, value, of.big); };
  for (const int n : {kX, kY, kZ * of.volumes, of.mode, of.start[0], of.start[1], of.start[2], kX, kY, of.sheets}) whole(n);
  for (const float n : of.cell) real(n);
  for (const float n : of.angles) real(n);
  for (const int n : of.axes) whole(n);
  for (int n = 20; n <= 22; ++n) real(0);
  whole(of.group), whole(of.more);
  for (int n = 25; n <= 49; ++n) whole(0);
  for (const float n : of.origin) real(n);
  out += "MAP ";
  out += of.big ? std::string("\x11\x11\0\0", 4) : std::string("\x44\x44\0\0", 4);
  out.resize(1024 + static_cast<std::size_t>(of.more), '\0');
  return out;
}

template <class T>
std::string map(const Map& of, const std::function<T(int)>& number) {
  std::string out = header(of);
  for (int n = 0; n < kX * kY * kZ * of.volumes; ++n) put(out, number(n), of.big);
  return out;
}

template <class T>
void expect_numbers(const Map& of, ScalarType type) {
  SCOPED_TRACE(std::to_string(of.mode) + (of.big ? " big" : ""));
  const Scratch scratch;
  const auto data = open(scratch.write("a.mrc", map<T>(of, [](int n) { return static_cast<T>(n - 3); })));
  EXPECT_EQ(data->grid.dims(), (std::array<std::int64_t, 3>{kX, kY, kZ}));
  EXPECT_EQ(data->array("density").type, type);
  for (int n = 0; n < kX * kY * kZ; ++n) EXPECT_EQ(data->array("density").at(static_cast<std::size_t>(n)), static_cast<double>(static_cast<T>(n - 3)));
  EXPECT_EQ(std::get<UniformGrid>(data->grid.shape).spacing, (Vec3d{2, 0.5, 0.5}));
}

TEST(Mrc, NumbersOfEveryModeAndOrderAreThoseOfTheFile) {
  for (const bool big : {false, true})
    for (const int more : {0, 80, 33}) {
      expect_numbers<std::int8_t>({.mode = 0, .big = big, .more = more}, ScalarType::int8);
      expect_numbers<std::int16_t>({.mode = 1, .big = big, .more = more}, ScalarType::int16);
      expect_numbers<float>({.mode = 2, .big = big, .more = more}, ScalarType::float32);
      expect_numbers<std::uint16_t>({.mode = 6, .big = big, .more = more}, ScalarType::uint16);
    }
  const Scratch scratch;
  const auto halves = open(scratch.write("a.map", map<std::uint16_t>({.mode = 12}, [](int n) { return static_cast<std::uint16_t>(n == 5 ? 0x3c00 : 0xc000); })));
  EXPECT_EQ(halves->array("density").at(4), -2);
  EXPECT_EQ(halves->array("density").at(5), 1);
}

TEST(Mrc, PlacesAreThoseOfTheCellWhicheverAxisRunsFastest) {
  const Scratch scratch;
  const auto number = [](int n) { return static_cast<float>(n); };
  const auto moved = open(scratch.write("a.mrc", map<float>({.start = {-2, 4, 1}}, number)));
  EXPECT_EQ(moved->bounds.lower, (Vec3d{-4, 2, 0.5}));
  const auto said = open(scratch.write("b.mrc", map<float>({.start = {-2, 4, 1}, .origin = {7, 8, 9}}, number)));
  EXPECT_EQ(said->bounds.lower, (Vec3d{7, 8, 9}));
  // Sections along x, columns along z: the first axis of the file runs along the cell's third.
  const auto turned = open(scratch.write("c.mrc", map<float>({.axes = {3, 1, 2}, .start = {1, 0, 0}}, number)));
  EXPECT_EQ(turned->bounds.lower, (Vec3d{0, 0, 0.5}));
  EXPECT_EQ(turned->bounds.upper, (Vec3d{4, 0.5, 2}));
  int found = 0;
  for (std::int64_t p = 0; p < turned->grid.point_count(); ++p) {
    if (turned->grid.point(p) != Vec3d{2, 0.5, 1}) continue;
    EXPECT_EQ(turned->arrays.front().at(static_cast<std::size_t>(p)), 1 + kX * (1 + kY * 1));
    ++found;
  }
  EXPECT_EQ(found, 1);
  const auto oblique = open(scratch.write("d.mrc", map<float>({.angles = {90, 90, 120}}, number)));
  EXPECT_NEAR(oblique->grid.point(kX).x, -0.25, 1e-9);
  EXPECT_NEAR(oblique->grid.point(kX).y, 0.5 * std::sqrt(0.75), 1e-9);
}

TEST(Mrc, VolumesOneAfterTheOtherAreSteps) {
  const Scratch scratch;
  const auto path = scratch.write("a.mrc", map<float>({.group = 401, .volumes = 3}, [](int n) { return static_cast<float>(n); }));
  EXPECT_EQ(open(path)->times, (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(open(path, 2)->arrays.front().at(0), 2 * kX * kY * kZ);
}

TEST(Mrc, WhatIsDamagedOrNotReadIsRefusedByItsNameInOneLine) {
  const Scratch scratch;
  const std::string good = map<float>({}, [](int n) { return static_cast<float>(n); });
  for (const auto& [bytes, why] : std::vector<std::pair<std::string, std::string>>{{good.substr(0, 500), "ends within its header"},
                                                                                   {good.substr(0, 1100), "96 bytes of numbers declared, 76 present"},
                                                                                   {map<float>({.mode = 4}, [](int) { return 0.0f; }), "MRC of mode 4"},
                                                                                   {map<float>({.axes = {1, 1, 2}}, [](int) { return 0.0f; }), "numbers the axes 1, 1, 2"}}) {
    const Error error = refusal(scratch.write("a.mrc", bytes));
    EXPECT_NE(std::string(error.what()).find("a.mrc: "), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
  }
  testing::expect_datasets_or_errors({{"a.mrc", good}}, 40);
}

}  // namespace
}  // namespace isostrata
