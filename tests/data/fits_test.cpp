// FITS that the tests write byte by byte, by version 4.0 of its definition.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "data/files.h"
#include "data/fits_file.h"
#include "support/mutated_files.h"

namespace isostrata {
namespace {

using test::open;
using test::put;
using test::refusal;
using test::Scratch;

using test::Cards;
using test::header;
using test::image;
using test::padded;

template <class T>
std::string numbers(const std::vector<double>& values) {
  std::string out;
  for (const double value : values) put(out, static_cast<T>(value), true);
  return padded(out, '\0');
}

std::vector<double> counted(int count, double first = 0, double step = 1) {
  std::vector<double> out;
  for (int i = 0; i < count; ++i) out.push_back(first + step * i);
  return out;
}

void expect_values(const PointArray& array, const std::vector<double>& expected) {
  for (std::size_t p = 0; p < expected.size(); ++p) EXPECT_TRUE(std::isnan(expected[p]) ? std::isnan(array.at(p)) : array.at(p) == expected[p]) << p << ": " << array.at(p) << ", expected " << expected[p];
}

TEST(Fits, ValuesOfEveryTypeAreThoseOfTheFile) {
  const Scratch scratch;
  const auto read = [&](const Cards& cards, const std::string& bytes) { return open(scratch.write("a.fits", header(cards) + bytes)); };
  const std::vector<int> axes{4, 3, 2};
  const auto check = [&](const Dataset& data, ScalarType type, const std::vector<double>& expected) {
    EXPECT_EQ(data.grid.dims(), (std::array<std::int64_t, 3>{4, 3, 2}));
    EXPECT_EQ(data.arrays.front().type, type);
    expect_values(data.arrays.front(), expected);
  };
  const std::vector<double> values = counted(24);
  check(*read(image(8, axes), numbers<std::uint8_t>(values)), ScalarType::uint8, values);
  check(*read(image(16, axes), numbers<std::int16_t>(counted(24, -5))), ScalarType::int16, counted(24, -5));
  check(*read(image(32, axes), numbers<std::int32_t>(counted(24, -1e6))), ScalarType::int32, counted(24, -1e6));
  check(*read(image(64, axes), numbers<std::int64_t>(values)), ScalarType::int64, values);
  check(*read(image(-32, axes), numbers<float>(counted(24, 0.5))), ScalarType::float32, counted(24, 0.5));
  check(*read(image(-64, axes), numbers<double>(counted(24, 0.1))), ScalarType::float64, counted(24, 0.1));
  check(*read(image(16, axes, {{"BZERO", "32768"}, {"BSCALE", "1"}}), numbers<std::int16_t>(counted(24, -32768, 2000))), ScalarType::uint16, counted(24, 0, 2000));
  check(*read(image(8, axes, {{"BZERO", "-128"}}), numbers<std::uint8_t>(counted(24, 120))), ScalarType::int8, counted(24, -8));
  check(*read(image(16, axes, {{"BZERO", "1.0D2"}, {"BSCALE", "0.5"}}), numbers<std::int16_t>(values)), ScalarType::float32, counted(24, 100, 0.5));
  std::vector<double> holes = values;
  holes[7] = std::numeric_limits<double>::quiet_NaN();
  check(*read(image(32, axes, {{"BLANK", "7"}}), numbers<std::int32_t>(values)), ScalarType::float64, holes);
}

TEST(Fits, AxesOfOnePointAreNoneStokesAreArraysAndTimesSteps) {
  const Scratch scratch;
  const Cards stokes{{"CTYPE1", "'RA---SIN'"}, {"CTYPE2", "'DEC--SIN'"}, {"CTYPE3", "'STOKES  '"}, {"CTYPE4", "'FREQ'"}, {"CDELT1", "-0.001"}, {"CDELT4", "1E6"},
                     {"CUNIT1", "'deg'"}, {"CUNIT4", "'Hz'"}, {"CRVAL3", "1"}, {"CDELT3", "1"}, {"CRPIX3", "1"}, {"BUNIT", "'Jy/beam' / it's a comment"}};
  const auto data = open(scratch.write("a.fits", header(image(-32, {3, 2, 2, 2}, stokes)) + numbers<float>(counted(24))));
  EXPECT_EQ(data->grid.dims(), (std::array<std::int64_t, 3>{3, 2, 2}));
  EXPECT_EQ(std::get<UniformGrid>(data->grid.shape).spacing, (Vec3d{1, 1, 1})) << "degrees and a frequency have no common length";
  ASSERT_EQ(data->arrays.size(), 2u);
  expect_values(data->array("Stokes I"), {0, 1, 2, 3, 4, 5, 12, 13, 14, 15, 16, 17});
  expect_values(data->array("Stokes Q"), {6, 7, 8, 9, 10, 11, 18, 19, 20, 21, 22, 23});
  for (const char* array : {"Stokes I", "Stokes Q"}) EXPECT_EQ(data->array(array).unit, "Jy/beam");
  EXPECT_TRUE(test::noted(*data, "RA---SIN in deg, DEC--SIN, FREQ in Hz"));
  const Cards film{{"CTYPE4", "'TIME'"}, {"CRVAL4", "10"}, {"CDELT4", "2.5"}, {"CRPIX4", "1"}};
  const auto path = scratch.write("b.fits", header(image(16, {3, 2, 1, 2}, film)) + numbers<std::int16_t>(counted(12)));
  EXPECT_EQ(open(path)->times, (std::vector<double>{10, 12.5}));
  expect_values(open(path, 1)->arrays.front(), counted(6, 6));
}

TEST(Fits, StraightAxesOfOneUnitArePlaces) {
  const Scratch scratch;
  const Cards places{{"CDELT1", "0.5"}, {"CDELT2", "-0.25"}, {"CDELT3", "2"}, {"CRVAL1", "10"}, {"CRPIX1", "3"}, {"CRVAL2", "1"}, {"CRPIX2", "1"}, {"CRPIX3", "1"}, {"CUNIT1", "'kpc'"}, {"CUNIT2", "'kpc'"}, {"CUNIT3", "'kpc'"}};
  const auto data = open(scratch.write("a.fits", header(image(-64, {4, 3, 2}, places)) + numbers<double>(counted(24))));
  EXPECT_EQ(data->bounds.lower, (Vec3d{9, 0.5, 0}));
  EXPECT_EQ(data->bounds.upper, (Vec3d{10.5, 1, 2}));
  for (const Axis& axis : data->axes) EXPECT_EQ(axis.unit, "kpc");
  int found = 0;
  for (std::int64_t p = 0; p < 24; ++p) {
    if (data->grid.point(p) != Vec3d{9, 0.5, 0}) continue;
    EXPECT_EQ(data->arrays.front().at(static_cast<std::size_t>(p)), 8) << "the third row";
    ++found;
  }
  EXPECT_EQ(found, 1);
}

TEST(Fits, TheFirstImageIsReadWhereverItStandsAlsoInGzip) {
  const Scratch scratch;
  const Cards table{{"XTENSION", "'BINTABLE'"}, {"BITPIX", "8"}, {"NAXIS", "2"}, {"NAXIS1", "3"}, {"NAXIS2", "5"}, {"PCOUNT", "0"}, {"GCOUNT", "1"}};
  Cards extension = image(16, {4, 3, 2}, {{"PCOUNT", "0"}, {"GCOUNT", "1"}, {"EXTNAME", "'it''s dust'"}});
  extension[0] = {"XTENSION", "'IMAGE   '"};
  const std::string bytes = header(image(8, {})) + header(table) + padded(std::string(15, 'x'), '\0') + header(extension) + numbers<std::int16_t>(counted(24));
  expect_values(open(scratch.write("a.fits", bytes))->array("it's dust"), counted(24));
  expect_values(open(scratch.write("a.fits.gz", test::gzip(bytes)))->array("it's dust"), counted(24));
}

TEST(Fits, WhatIsDamagedOrNotReadIsRefusedByItsNameInOneLine) {
  const Scratch scratch;
  const std::string good = header(image(-32, {4, 3, 2})) + numbers<float>(counted(24));
  Cards packed{{"XTENSION", "'BINTABLE'"}, {"BITPIX", "8"}, {"NAXIS", "2"}, {"NAXIS1", "3"}, {"NAXIS2", "5"}, {"ZIMAGE", "T"}};
  for (const auto& [bytes, code, why] : std::vector<std::tuple<std::string, ErrorCode, std::string>>{
           {good.substr(0, 300), ErrorCode::bad_data, "ends within its header"},
           {good.substr(0, 2900), ErrorCode::bad_data, "96 bytes of values declared, 20 present"},
           {header(image(12, {4, 3, 2})) + std::string(2880, '\0'), ErrorCode::bad_data, "BITPIX 12"},
           {header(image(16, {4, -3, 2})) + std::string(2880, '\0'), ErrorCode::bad_data, "makes no sense"},
           {header(image(16, {2000000000, 2000000000, 2000000000})), ErrorCode::bad_data, "makes no sense"},
           {header(image(16, {2, 2, 2, 2})) + std::string(2880, '\0'), ErrorCode::unsupported, "more than three axes"},
           {header(image(8, {})), ErrorCode::unsupported, "it has no image"},
           {header(image(8, {})) + header(packed) + std::string(2880, '\0'), ErrorCode::bad_data, "packed in tiles has no points"},
           {"CARD", ErrorCode::bad_data, "expected 'SIMPLE  ='"}}) {
    const Error error = refusal(scratch.write("a.fits", bytes));
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find("a.fits"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
  }
  testing::expect_datasets_or_errors({{"a.fits", good}, {"b.fits", header(image(16, {3, 2, 2, 2}, {{"CTYPE4", "'STOKES'"}, {"BLANK", "3"}})) + numbers<std::int16_t>(counted(24))}}, 60);
}

}  // namespace
}  // namespace isostrata
