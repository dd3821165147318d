// The NRRD reader: every way to write the same volume gives the same volume.
#include <bzlib.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <random>
#include <regex>
#include <sstream>

#include "data/files.h"

namespace isostrata {
namespace {

using test::gzip;
using test::open;
using test::refusal;
using test::Scratch;

constexpr int kX = 4, kY = 3, kZ = 5;

/// 4x3x5 values that tell every place from every other.
std::vector<std::uint16_t> values() {
  std::vector<std::uint16_t> out;
  for (int i = 0; i < kX * kY * kZ; ++i) out.push_back(static_cast<std::uint16_t>(1000 + 37 * i));
  return out;
}

std::string raw(bool big = false) {
  std::string bytes;
  for (const std::uint16_t value : values()) test::put(bytes, value, big);
  return bytes;
}

std::string bzip2(std::string in) {
  std::string out(in.size() * 2 + 1000, '\0');
  auto size = static_cast<unsigned>(out.size());
  BZ2_bzBuffToBuffCompress(out.data(), &size, in.data(), static_cast<unsigned>(in.size()), 9, 0, 0);
  out.resize(size);
  return out;
}

std::string hex(const std::string& in) {
  std::string out;
  for (std::size_t i = 0; i < in.size(); ++i) {
    char two[3];
    std::snprintf(two, sizeof two, "%02x", static_cast<unsigned char>(in[i]));
    out += two;
    if (i % 11 == 10) out += "\n";
  }
  return out;
}

std::string header(const std::string& more, const std::string& encoding = "raw", const std::string& endian = "little") {
  return "NRRD0004\n# made by a test\ntype: uint16\ndimension: 3\nsizes: 4 3 5\nencoding: " + encoding + "\nendian: " + endian +
         "\n" + more;
}

void expect_volume(const std::filesystem::path& file) {
  const auto data = open(file);
  ASSERT_EQ(data->grid.dims(), (std::array<std::int64_t, 3>{kX, kY, kZ})) << file;
  const PointArray& array = data->array("scalars");
  ASSERT_EQ(array.type, ScalarType::uint16) << file;
  for (std::size_t i = 0; i < values().size(); ++i) ASSERT_EQ(array.at(i), values()[i]) << file << " at " << i;
}

TEST(Nrrd, EncodingsAgree) {
  const Scratch scratch;
  std::string text;
  for (const auto value : values()) text += std::to_string(value) + (value % 3 ? " " : "\n");
  expect_volume(scratch.write("raw.nrrd", header("\n") + raw()));
  expect_volume(scratch.write("big.nrrd", header("\n", "raw", "big") + raw(true)));
  expect_volume(scratch.write("text.nrrd", header("\n", "text") + text));
  expect_volume(scratch.write("ascii.nrrd", header("\n", "ASCII") + text));
  expect_volume(scratch.write("hex.nrrd", header("\n", "hex") + hex(raw())));
  expect_volume(scratch.write("gzip.nrrd", header("\n", "gzip") + gzip(raw())));
  expect_volume(scratch.write("gz.nrrd", header("\n", "gz", "big") + gzip(raw(true))));
  expect_volume(scratch.write("bzip2.nrrd", header("\n", "bzip2") + bzip2(raw())));
}

TEST(Nrrd, SamplesHaveTheirUnit) {
  const Scratch scratch;
  EXPECT_EQ(open(scratch.write("raw.nrrd", header("sample units: m/s\n\n") + raw()))->arrays.front().unit, "m/s");
  EXPECT_EQ(open(scratch.write("none.nrrd", header("\n") + raw()))->arrays.front().unit, "");
}

TEST(Nrrd, GzipOfSeveralMembersIsOneStream) {
  const Scratch scratch;
  expect_volume(scratch.write("members.nrrd", header("\n", "gzip") + gzip(raw().substr(0, 31)) + gzip(raw().substr(31))));
}

TEST(Nrrd, HeaderMayHaveCarriageReturns) {
  const Scratch scratch;
  std::string text = header("\n"), dos;
  for (const char c : text) dos += c == '\n' ? "\r\n" : std::string(1, c);
  expect_volume(scratch.write("dos.nrrd", dos + raw()));
}

TEST(Nrrd, SkipsAgree) {
  const Scratch scratch;
  expect_volume(scratch.write("bytes.nrrd", header("byte skip: 3\n\n") + "abc" + raw()));
  expect_volume(scratch.write("lines.nrrd", header("line skip: 2\n\n") + "one\ntwo\n" + raw()));
  expect_volume(scratch.write("both.nrrd", header("lineskip: 1\nbyteskip: 2\n\n") + "one\nab" + raw()));
  expect_volume(scratch.write("end.nrrd", header("byte skip: -1\n\n") + "some unknown header" + raw()));
  expect_volume(scratch.write("before-end.nrrd", header("byte skip: -5\n\n") + "some unknown header" + raw() + "tail"));
  expect_volume(scratch.write("gzip-line.nrrd", header("line skip: 1\n\n", "gzip") + "a line\n" + gzip(raw())));
  expect_volume(scratch.write("gzip-bytes.nrrd", header("byte skip: 4\n\n", "gzip") + gzip("head" + raw())));
  expect_volume(scratch.write("gzip-end.nrrd", header("byte skip: -1\n\n", "gzip") + gzip("352 bytes of NIfTI, say" + raw())));
}

TEST(Nrrd, DetachedDataAgree) {
  const Scratch scratch;
  scratch.write("v.raw", raw());
  scratch.write("deep/v.raw", raw());
  for (int k = 0; k < kZ; ++k)
    scratch.write("slice" + std::to_string(k) + ".raw", raw().substr(static_cast<std::size_t>(k) * kX * kY * 2, kX * kY * 2));
  for (int k = 0; k < kZ; ++k)
    scratch.write((k == 0 ? "s0" : "s00") + std::to_string(10 - k) + ".raw",
                  raw().substr(static_cast<std::size_t>(k) * kX * kY * 2, kX * kY * 2));
  expect_volume(scratch.write("a.nhdr", header("data file: v.raw\n")));
  expect_volume(scratch.write("b.nhdr", header("datafile: ./deep/v.raw\n\n")));
  expect_volume(scratch.write("c.nhdr", header("data file: LIST\nslice0.raw\nslice1.raw\nslice2.raw\nslice3.raw\nslice4.raw\n")));
  expect_volume(scratch.write("d.nhdr", header("data file: slice%d.raw 0 4 1\n")));
  expect_volume(scratch.write("e.nhdr", header("data file: s%03d.raw 10 6 -1 2\n")));
}

TEST(Nrrd, DetachedDataStayBelowTheirDirectory) {
  const Scratch scratch;
  const auto outside = scratch.write("secret.raw", raw());
  for (const std::string& name :
       std::vector<std::string>{"../secret.raw", outside.string(), "../../../../../../etc/passwd", "in/../../secret.raw"}) {
    const Error error = refusal(scratch.write("in/x.nhdr", header("data file: " + name + "\n")));
    EXPECT_EQ(error.code(), ErrorCode::bad_data) << name << ": " << error.what();
    EXPECT_NE(std::string(error.what()).find("own directory"), std::string::npos) << error.what();
  }
  std::filesystem::create_symlink(outside, scratch / "in/link.raw");
  EXPECT_EQ(refusal(scratch.write("in/x.nhdr", header("data file: link.raw\n"))).code(), ErrorCode::bad_data);
}

TEST(Nrrd, SpacingsAndDirectionsPlaceThePoints) {
  const Scratch scratch;
  const auto at = [&](const std::string& fields) {
    const auto data = open(scratch.write("x.nrrd", header(fields + "\n") + raw()));
    return std::pair{std::string(data->grid.kind_name()), data->grid.point(1 + kX * (2 + kY * 3))};
  };
  EXPECT_EQ(at("spacings: 2 3 0.5\n"), (std::pair<std::string, Vec3d>{"uniform", {2, 6, 1.5}}));
  EXPECT_EQ(at("spacings: nan 3 0.5\nspace origin: (1,2,3)\n"), (std::pair<std::string, Vec3d>{"uniform", {2, 8, 4.5}}));
  EXPECT_EQ(at("axis mins: 0 0 10\naxis maxs: 3 4 50\n"), (std::pair<std::string, Vec3d>{"uniform", {1, 4, 40}}));
  EXPECT_EQ(at("space: left-posterior-superior\nspace directions: (2,0,0) (0,-1,0) (0,0,4)\nspace origin: (1,1,1)\n"),
            (std::pair<std::string, Vec3d>{"uniform", {3, -1, 13}}));
  EXPECT_EQ(at("space dimension: 3\nspace directions: (1,0.5,0) (-0.5,1,0) (0,0,1)\nspace origin: (10,0,0)\n"),
            (std::pair<std::string, Vec3d>{"curvilinear", {10, 2.5, 3}}));
}

// A scan that is stored slice by slice from one side of the head: a uniform grid, which would take 24 bytes a point as a curvilinear one.
TEST(Nrrd, AxesThatRunAlongOthersAreAUniformGridWithItsValuesInPlace) {
  const Scratch scratch;
  for (const std::string directions : {"(0,2,0) (1,0,0) (0,0,4)", "(0,0,4) (-1,0,0) (0,2,0)", "(0,-2,0) (0,0,4) (1,0,0)"}) {
    const auto data = open(scratch.write("x.nrrd", header("space dimension: 3\nspace directions: " + directions + "\nspace origin: (7,8,9)\n\n") + raw()));
    EXPECT_EQ(std::string(data->grid.kind_name()), "uniform");
    const auto plain = open(scratch.write("z.nrrd", header("\n") + raw()));
    std::array<Vec3d, 3> step;
    std::istringstream text(std::regex_replace(directions, std::regex("[(),]"), " "));
    for (Vec3d& of : step) text >> of.x >> of.y >> of.z;
    std::map<std::array<double, 3>, double> there;
    for (std::int64_t p = 0; p < data->grid.point_count(); ++p) {
      const Vec3d at = data->grid.point(p);
      there[{at.x, at.y, at.z}] = data->arrays.front().at(static_cast<std::size_t>(p));
    }
    for (std::int64_t p = 0; p < plain->grid.point_count(); ++p) {
      const Vec3d index = plain->grid.point(p), at = Vec3d{7, 8, 9} + step[0] * index.x + step[1] * index.y + step[2] * index.z;
      ASSERT_TRUE(there.contains({at.x, at.y, at.z})) << directions << " point " << p;
      EXPECT_EQ((there[{at.x, at.y, at.z}]), plain->arrays.front().at(static_cast<std::size_t>(p))) << directions << " point " << p;
    }
  }
}

std::string four(const std::string& sizes, const std::string& kinds) {
  std::string bytes = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: " + sizes + "\nkinds: " + kinds + "\nencoding: raw\n\n";
  for (int i = 0; i < 2 * 3 * 4 * 5; ++i) bytes += static_cast<char>(i);
  return bytes;
}

TEST(Nrrd, ComponentsMayBeTheFastestAxisOrTheSlowest) {
  const Scratch scratch;
  const auto first = open(scratch.write("first.nrrd", four("2 3 4 5", "vector domain domain domain")));
  EXPECT_EQ(first->grid.dims(), (std::array<std::int64_t, 3>{3, 4, 5}));
  EXPECT_EQ(first->array("scalars_x").at(7), 14);
  EXPECT_EQ(first->array("scalars_y").at(7), 15);
  EXPECT_NEAR(first->array("scalars").at(7), std::hypot(14.0, 15.0), 1e-5);
  const auto last = open(scratch.write("last.nrrd", four("3 4 5 2", "space space space list")));
  EXPECT_EQ(last->array("scalars_x").at(7), 7);
  EXPECT_EQ(last->array("scalars_y").at(7), 67);
}

TEST(Nrrd, TimeBecomesSteps) {
  const Scratch scratch;
  const auto file = scratch.write("t.nrrd", four("3 4 5 2", "space space space time"));
  EXPECT_EQ(open(file)->times, (std::vector<double>{0, 1}));
  EXPECT_EQ(open(file, 1)->array("scalars").at(7), 67);
  const auto inner = scratch.write("inner.nrrd", four("3 2 4 5", "space time space space"));
  EXPECT_EQ(open(inner, 1)->array("scalars").at(4), 10);  // x 1, y 1, t 1
  OpenOptions beyond;
  beyond.step = 2;
  EXPECT_EQ(refusal(file, beyond).code(), ErrorCode::not_found);
}

TEST(Nrrd, TypesKeepTheirValues) {
  const Scratch scratch;
  const auto one = [&](const std::string& type, auto value) {
    std::string bytes = "NRRD0001\ntype: " + type + "\ndimension: 1\nsizes: 2\nendian: little\nencoding: raw\n\n";
    test::put(bytes, value);
    test::put(bytes, decltype(value){});
    return open(scratch.write("x.nrrd", bytes))->array("scalars").at(0);
  };
  EXPECT_EQ(one("signed char", std::int8_t{-5}), -5);
  EXPECT_EQ(one("uchar", std::uint8_t{200}), 200);
  EXPECT_EQ(one("short", std::int16_t{-3000}), -3000);
  EXPECT_EQ(one("unsigned short int", std::uint16_t{60000}), 60000);
  EXPECT_EQ(one("int32", std::int32_t{-70000}), -70000);
  EXPECT_EQ(one("uint", std::uint32_t{4000000000u}), 4000000000.0);
  EXPECT_EQ(one("long long", std::int64_t{-(1ll << 40)}), -std::pow(2, 40));
  EXPECT_EQ(one("uint64_t", std::uint64_t{1ull << 52}), std::pow(2, 52));
  EXPECT_EQ(one("float", 1.5f), 1.5);
  EXPECT_EQ(one("double", -1e300), -1e300);
}

TEST(Nrrd, RefusesWithOneClearSentence) {
  const Scratch scratch;
  const auto said = [&](const std::string& bytes, ErrorCode code, const std::string& part) {
    const Error error = refusal(scratch.write("bad.nrrd", bytes));
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what() << " should say " << part;
    EXPECT_NE(std::string(error.what()).find("bad.nrrd"), std::string::npos) << error.what();
  };
  said(header("\n") + raw().substr(0, 50), ErrorCode::bad_data,
       "4x3x5 uint16 declared, which is 120 bytes in this file; 50 present");
  said(header("\n", "gzip") + gzip(raw()).substr(0, 30), ErrorCode::bad_data, "present");
  said(header("\n", "gzip") + "no gzip at all", ErrorCode::bad_data, "gzip");
  said(header("\n", "bzip2") + "no bzip2 at all", ErrorCode::bad_data, "bzip2");
  said(header("\n", "hex") + "zz", ErrorCode::bad_data, "hex");
  said(header("\n", "text") + "1 2 seventy", ErrorCode::bad_data, "value 3");
  said(header("\n", "text") + "1 2 70000", ErrorCode::bad_data, "value 3");
  said(header("\n", "zstd") + raw(), ErrorCode::unsupported, "zstd");
  said(header("nonsense\n\n") + raw(), ErrorCode::bad_data, "nonsense");
  said(header("spacings: 1 0 1\n\n") + raw(), ErrorCode::bad_data, "spacing");
  said(header("spacings: 1 2\n\n") + raw(), ErrorCode::bad_data, "spacings");
  said(header("space directions: (1,0) none (0,1)\nkinds: space space space\n\n") + raw(), ErrorCode::bad_data, "some axes");
  said(header("space directions: (1,x,0) (0,1,0) (0,0,1)\n\n") + raw(), ErrorCode::bad_data, "space directions");
  said("NRRD0004\ntype: uint16\ndimension: 3\nsizes: 4 3 5\nencoding: raw\n\n" + raw(), ErrorCode::bad_data, "endian");
  said("NRRD0004\ntype: colour\ndimension: 3\nsizes: 4 3 5\nencoding: raw\n\n", ErrorCode::bad_data, "type 'colour'");
  said("NRRD0004\ntype: block\ndimension: 3\nsizes: 4 3 5\nencoding: raw\n\n", ErrorCode::unsupported, "block");
  said("NRRD0004\ntype: uint8\ndimension: 5\nsizes: 2 2 2 2 2\nkinds: space space space space space\nencoding: raw\n\n",
       ErrorCode::unsupported, "axes");
  said("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 -3 5\nencoding: raw\n\n", ErrorCode::bad_data, "sizes");
  said("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4000000000 4000000000 4000000000\nencoding: raw\n\n", ErrorCode::bad_data,
       "sizes");
  said("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 400000 400000 4\nencoding: raw\n\n", ErrorCode::too_large, "limit");
  said("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4000 4000 10\nencoding: gzip\n\n" + gzip("few"), ErrorCode::bad_data,
       "3 present");
  said("NRRD0009\ntype: uint8\n\n", ErrorCode::bad_data, "NRRD000");
  said("NRRD0004\ntype: uint8\n", ErrorCode::bad_data, "");
}

}  // namespace
}  // namespace isostrata
