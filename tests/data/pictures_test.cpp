// Pictures that the tests write byte by byte, by TIFF 6.0: what their values are, of every type, and what is refused. VTK's reader gave other values for
// several of these, and others at each run.
#include <gtest/gtest.h>

#include <type_traits>

#include "data/files.h"
#include "data/files/list_folder.h"

namespace isostrata {
namespace {

using test::open;
using test::refusal;
using test::Scratch;

constexpr std::uint32_t kColumns = 5, kRows = 3;

struct Page {
  std::uint32_t columns = kColumns, rows = kRows;
  std::uint16_t bits = 16, samples = 1, format = 1;  // 1: unsigned, 2: signed, 3: real
  std::uint16_t orientation = 1, unit = 1;           // 2: inches
  std::uint16_t meaning = 1;                         // 0: 0 is white
  std::string pixels;
};

/// Value c + 10 x + 100 y of channel c, counted from the lowest row.
double value(int x, int y, int c) { return c + 10 * x + 100 * y; }

template <class T>
Page page_of(std::uint16_t samples, double scale = 1) {
  Page page;
  page.bits = 8 * sizeof(T);
  page.samples = samples;
  page.format = std::is_floating_point_v<T> ? 3 : std::is_signed_v<T> ? 2 : 1;
  for (int row = static_cast<int>(kRows) - 1; row >= 0; --row)
    for (int x = 0; x < static_cast<int>(kColumns); ++x)
      for (int c = 0; c < samples; ++c) test::put(page.pixels, static_cast<T>(scale * value(x, row, c)), false);
  return page;
}

std::string tiff(const std::vector<Page>& pages) {
  std::string out("II*\0", 4);
  const auto u16 = [&](std::uint32_t v) { test::put(out, static_cast<std::uint16_t>(v), false); };
  const auto u32 = [&](std::uint32_t v) { test::put(out, v, false); };
  u32(8);
  for (std::size_t p = 0; p < pages.size(); ++p) {
    const Page& page = pages[p];
    constexpr std::uint32_t kEntries = 13;
    const auto data = static_cast<std::uint32_t>(out.size()) + 2 + 12 * kEntries + 4;  // what follows the directory
    const std::uint32_t lists = 2 * page.samples, pixels = data + 2 * lists + 16;
    u16(kEntries);
    const auto entry = [&](std::uint32_t tag, std::uint32_t type, std::uint32_t count, std::uint32_t of) { u16(tag), u16(type), u32(count), u32(of); };
    const auto list = [&](std::uint32_t tag, std::uint32_t of, std::uint32_t at) {
      entry(tag, 3, page.samples, page.samples == 1 ? of : page.samples == 2 ? of << 16 | of : at);
    };
    entry(256, 4, 1, page.columns);
    entry(257, 4, 1, page.rows);
    list(258, page.bits, data);
    entry(259, 3, 1, 1);
    entry(262, 3, 1, page.samples >= 3 ? 2 : page.meaning);
    entry(273, 4, 1, pixels);
    entry(274, 3, 1, page.orientation);
    entry(277, 3, 1, page.samples);
    entry(278, 4, 1, page.rows);
    entry(279, 4, 1, static_cast<std::uint32_t>(page.pixels.size()));
    entry(282, 5, 1, data + 2 * lists);
    entry(283, 5, 1, data + 2 * lists + 8);
    entry(296, 3, 1, page.unit);
    const auto next = static_cast<std::uint32_t>(out.size());
    u32(0);
    for (int i = 0; i < page.samples; ++i) u16(page.bits);
    for (int i = 0; i < page.samples; ++i) u16(page.format);
    u32(254), u32(10), u32(127), u32(10);  // 25.4 and 12.7 pixels an inch
    out += page.pixels;
    if (out.size() % 2) out += '\0';
    if (p + 1 < pages.size()) {
      std::string at;
      test::put(at, static_cast<std::uint32_t>(out.size()), false);
      out.replace(next, 4, at);
    }
  }
  return out;
}

/// With the entry of the samples' type, which the list above leaves out of pages of whole numbers without a sign.
std::string with_format(std::string file, const Page& page) {
  // The resolution's unit gives up its place: tag 339 is the last.
  const std::size_t at = 8 + 2 + 12 * 12;
  std::string entry;
  for (const std::uint16_t v : {std::uint16_t{339}, std::uint16_t{3}}) test::put(entry, v, false);
  test::put(entry, std::uint32_t{page.samples}, false);
  const std::uint32_t list = 8 + 2 + 12 * 13 + 4 + 2u * page.samples;
  test::put(entry, page.samples == 1 ? std::uint32_t{page.format} : page.samples == 2 ? std::uint32_t{page.format} << 16 | page.format : list, false);
  return file.replace(at, 12, entry);
}

template <class T>
void expect_values(const Dataset& dataset, int samples, double scale, std::int64_t slices = 1) {
  const auto& grid = std::get<UniformGrid>(dataset.grid.shape);
  EXPECT_EQ(grid.dims, (std::array<std::int64_t, 3>{kColumns, kRows, slices}));
  const std::size_t first = samples > 1 ? 1 : 0;  // behind their length
  ASSERT_EQ(dataset.arrays.size(), first + static_cast<std::size_t>(samples));
  for (int c = 0; c < samples; ++c)
    for (int y = 0; y < static_cast<int>(kRows); ++y)
      for (int x = 0; x < static_cast<int>(kColumns); ++x)
        EXPECT_EQ(dataset.arrays[first + static_cast<std::size_t>(c)].at(static_cast<std::size_t>(x + static_cast<int>(kColumns) * y)), static_cast<double>(static_cast<T>(scale * value(x, y, c))))
            << x << ' ' << y << ' ' << c;
}

template <class T>
void expect_type(double scale) {
  for (const std::uint16_t samples : {1, 3, 4}) {
    SCOPED_TRACE(std::to_string(8 * sizeof(T)) + " bits, " + std::to_string(samples) + " channels");
    const Scratch scratch;
    const Page page = page_of<T>(samples, scale);
    const auto dataset = open(scratch.write("a.tif", with_format(tiff({page}), page)));
    expect_values<T>(*dataset, samples, scale);
  }
}

TEST(Pictures, ValuesOfEveryTypeAreAsTheyAreStored) {
  expect_type<std::uint8_t>(1 / 2.0);
  expect_type<std::int8_t>(-1 / 2.0);
  expect_type<std::uint16_t>(200);
  expect_type<std::int16_t>(-100);
  expect_type<std::uint32_t>(1e7);
  expect_type<std::int32_t>(-5e6);
  expect_type<float>(0.125);
  expect_type<double>(1e-3);
}

TEST(Pictures, TwelveBitsAreTwelveBits) {
  Page page;
  page.bits = 12;
  for (int row = static_cast<int>(kRows) - 1; row >= 0; --row) {
    std::string bits;
    for (int x = 0; x < static_cast<int>(kColumns); ++x)
      for (int b = 11; b >= 0; --b) bits += static_cast<char>(static_cast<int>(17 * value(x, row, 0)) >> b & 1);
    bits.resize((bits.size() + 7) / 8 * 8);
    for (std::size_t i = 0; i < bits.size(); i += 8) {
      int byte = 0;
      for (std::size_t b = 0; b < 8; ++b) byte = 2 * byte + bits[i + b];
      page.pixels += static_cast<char>(byte);
    }
  }
  const Scratch scratch;
  const auto dataset = open(scratch.write("a.tif", tiff({page})));
  EXPECT_EQ(dataset->arrays.at(0).type, ScalarType::uint16);
  expect_values<int>(*dataset, 1, 17);
}

TEST(Pictures, PagesAreSlicesAsFarAsTheyAreLikeTheFirst) {
  const Page page = page_of<std::uint16_t>(1);
  Page thumbnail;
  thumbnail.columns = thumbnail.rows = 1;
  thumbnail.pixels = std::string(2, '\0');
  const Scratch scratch;
  const auto dataset = open(scratch.write("a.tif", tiff({page, thumbnail, page})));
  expect_values<int>(*dataset, 1, 1, 2);
  ASSERT_EQ(dataset->notes.size(), 1u);
  EXPECT_NE(dataset->notes[0].find("1 pages of another size"), std::string::npos) << dataset->notes[0];
}

TEST(Pictures, RowsBeginAtTheTopUnlessTheFileSaysOtherwise) {
  Page page = page_of<std::uint16_t>(1);
  page.orientation = 4;
  const Scratch scratch;
  const auto dataset = open(scratch.write("a.tif", tiff({page})));
  EXPECT_EQ(dataset->arrays[0].at(0), value(0, static_cast<int>(kRows) - 1, 0));
}

TEST(Pictures, PixelsOnAnInchArePointsInMillimetres) {
  Page page = page_of<std::uint16_t>(1);
  page.unit = 2;
  const Scratch scratch;
  const auto dataset = open(scratch.write("a.tif", tiff({page})));
  const auto& grid = std::get<UniformGrid>(dataset->grid.shape);
  EXPECT_NEAR(grid.spacing.x, 1, 1e-6);
  EXPECT_NEAR(grid.spacing.y, 2, 1e-6);
}

TEST(Pictures, SlicesWhoseDistanceNobodySaysAreAsFarApartAsPixels) {
  Page page = page_of<std::uint16_t>(1);
  page.unit = 2;
  const Scratch scratch;
  for (const int n : {1, 2, 3}) scratch.write("s_" + std::to_string(n) + ".tif", tiff({page}));
  scratch.write("pages.tif", tiff({page, page, page}));
  for (const char* name : {"pages.tif", "s_*.tif"}) {
    const auto dataset = open(scratch / name);
    EXPECT_EQ(std::get<UniformGrid>(dataset->grid.shape).spacing, (Vec3d{1, 1, 1}));
    EXPECT_EQ(dataset->notes.at(0), "pixels are 1 x 2 mm apart, which says nothing of slices: all points are 1 apart");
  }
}

TEST(Pictures, BytesOfWhich0IsWhiteAreAsTheyAreStored) {
  const Scratch scratch;
  Page bytes = page_of<std::uint8_t>(1, 0.5), words = page_of<std::uint16_t>(1);
  bytes.meaning = words.meaning = 0;
  expect_values<std::uint8_t>(*open(scratch.write("bytes.tif", tiff({bytes}))), 1, 0.5);
  expect_values<std::uint16_t>(*open(scratch.write("words.tif", tiff({words}))), 1, 1);
}

TEST(Pictures, AFileThatEndsBetweenItsPagesIsRefused) {
  const Scratch scratch;
  const Page page = page_of<std::uint16_t>(1);
  const std::string whole = tiff({page, page, page, page});
  for (const std::size_t part : {30, 55, 60, 80, 90}) {
    SCOPED_TRACE(part);
    const Error error = refusal(scratch.write("cut.tif", whole.substr(0, whole.size() * part / 100)));
    EXPECT_EQ(error.code(), ErrorCode::bad_data);
    EXPECT_EQ(std::string(error.what()).find("cut.tif: "), 0u) << error.what();
  }
  const Error between = refusal(scratch.write("cut.tif", whole.substr(0, whole.size() / 2)));
  EXPECT_EQ(std::string(between.what()), "cut.tif: is cut off: page 3 lies beyond its end");
}

TEST(Pictures, NumberedFilesAreSlicesOfOneSize) {
  const Scratch scratch;
  const Page page = page_of<std::uint16_t>(3);
  for (const int n : {9, 10, 11}) scratch.write("slice_" + std::to_string(n) + ".tif", tiff({page}));
  expect_values<int>(*open(scratch / "slice_*.tif"), 3, 1, 3);
  scratch.write("slice_12.tif", tiff({page_of<std::uint16_t>(1)}));
  const Error error = refusal(scratch / "slice_*.tif");
  EXPECT_EQ(error.code(), ErrorCode::bad_data);
  EXPECT_EQ(std::string(error.what()).find("slice_12.tif: 5 x 3 pixels of 1 components; the first slice, slice_9.tif, has 5 x 3 pixels of 3 components"), 0u)
      << error.what();
}

TEST(Pictures, ATiffMayHaveAnyName) {
  const Scratch scratch;
  const std::string whole = tiff({page_of<std::uint16_t>(1)});
  for (const char* name : {"plain", "a.btf", "a.tf8", "a.dat", "a.p3d", "IM.0001"}) {
    SCOPED_TRACE(name);
    expect_values<int>(*open(scratch.write(name, whole)), 1, 1);
  }
  expect_values<int>(*open(scratch.write("a.tif.gz", test::gzip(whole))), 1, 1);
  const FolderListing listing = list_folder(scratch.path());
  EXPECT_EQ(listing.entries.size(), 7u);
  EXPECT_TRUE(listing.passed_over.empty());
  for (const auto& [name, words] : {std::pair{"a.lsm", "a.lsm: this is a microscope's own format; save it as OME-Zarr or OME-TIFF"},
                                    std::pair{"a.stk", "a.stk: this is a microscope's own format"}}) {
    const Error error = refusal(scratch.write(name, whole));
    EXPECT_EQ(error.code(), ErrorCode::unsupported);
    EXPECT_EQ(std::string(error.what()).find(words), 0u) << error.what();
  }
}

TEST(Pictures, WhatIsDamagedIsRefusedByItsNameInOneLine) {
  const Scratch scratch;
  const Page page = page_of<std::uint16_t>(3);
  const std::string whole = tiff({page});
  Page large = page;
  large.columns = large.rows = 1u << 20;
  for (const auto& [name, bytes] : {std::pair<std::string, std::string>{"short.tif", whole.substr(0, whole.size() - 40)},
                                    {"directory.tif", whole.substr(0, 60)},
                                    {"large.tif", tiff({large})}}) {
    const Error error = refusal(scratch.write(name, bytes));
    EXPECT_EQ(std::string(error.what()).find(name + ": "), 0u) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find(scratch.path().string()), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace isostrata
