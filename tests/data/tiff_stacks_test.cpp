// TIFFs whose first page describes all of them, as ImageJ and OME-TIFF do: channels are arrays, frames are steps, slices have their spacing.
#include <gtest/gtest.h>

#include <algorithm>

#include "data/files.h"
#include "support/mutated_files.h"

namespace isostrata {
namespace {

using test::open;
using test::put;
using test::refusal;
using test::Scratch;

constexpr std::uint32_t kColumns = 3, kRows = 2;

/// The values of page p: 1000 p + x + 10 y, the lowest row is y = 0.
std::string plane(int page, bool big, int raise = 0) {
  std::string bytes;
  for (int y = static_cast<int>(kRows) - 1; y >= 0; --y)
    for (int x = 0; x < static_cast<int>(kColumns); ++x) put(bytes, static_cast<std::uint16_t>(1000 * page + x + 10 * y + raise), big);
  return bytes;
}

struct Stack {
  std::string description;
  int pages = 1;
  bool big = false;
  bool in_one = false;  // one directory, behind which the values of all pages lie
  int raise = 0;
  std::uint16_t unit = 1, compression = 1;
};

/// 4 and 2 pixels on a unit of length.
std::string tiff(const Stack& of) {
  std::string out(of.big ? "MM" : "II");
  const auto u16 = [&](std::uint32_t v) { put(out, static_cast<std::uint16_t>(v), of.big); };
  const auto u32 = [&](std::uint32_t v) { put(out, v, of.big); };
  u16(42), u32(8);
  const int directories = of.in_one ? 1 : of.pages;
  for (int p = 0; p < directories; ++p) {
    const std::string text = p == 0 && !of.description.empty() ? of.description + std::string(1 + of.description.size() % 2, '\0') + std::string(4, '\0') : "";
    const std::uint32_t entries = text.empty() ? 12 : 13;
    const auto data = static_cast<std::uint32_t>(out.size()) + 2 + 12 * entries + 4, strip = data + 16 + static_cast<std::uint32_t>(text.size());
    u16(entries);
    const auto entry = [&](std::uint32_t tag, std::uint32_t type, std::uint32_t count, std::uint32_t value) {
      u16(tag), u16(type), u32(count);
      if (type == 3) u16(value), u16(0);
      else u32(value);
    };
    entry(256, 4, 1, kColumns);
    entry(257, 4, 1, kRows);
    entry(258, 3, 1, 16);
    entry(259, 3, 1, of.compression);
    entry(262, 3, 1, 1);
    if (!text.empty()) entry(270, 2, static_cast<std::uint32_t>(text.size()), data + 16);
    entry(273, 4, 1, strip);
    entry(277, 3, 1, 1);
    entry(278, 4, 1, kRows);
    entry(279, 4, 1, 2 * kColumns * kRows);
    entry(282, 5, 1, data);
    entry(283, 5, 1, data + 8);
    entry(296, 3, 1, of.unit);
    const auto bytes = 2 * kColumns * kRows * static_cast<std::uint32_t>(of.in_one ? of.pages : 1);
    u32(p + 1 < directories ? strip + bytes : 0);
    u32(4), u32(1), u32(2), u32(1);
    out += text;
    for (int page = p; page < (of.in_one ? of.pages : p + 1); ++page) out += plane(page, of.big, of.raise);
  }
  return out;
}

/// Whether the array has the values of these pages, from the lowest slice on.
void expect_pages(const Dataset& data, const std::string& array, const std::vector<int>& pages, double less = 0) {
  ASSERT_EQ(data.grid.dims(), (std::array<std::int64_t, 3>{kColumns, kRows, static_cast<std::int64_t>(pages.size())}));
  const PointArray& values = data.array(std::string_view(array));
  for (std::size_t z = 0; z < pages.size(); ++z)
    for (int y = 0; y < static_cast<int>(kRows); ++y)
      for (int x = 0; x < static_cast<int>(kColumns); ++x)
        EXPECT_EQ(values.at(z * kColumns * kRows + static_cast<std::size_t>(y) * kColumns + static_cast<std::size_t>(x)), 1000 * pages[z] + x + 10 * y - less) << array << ' ' << x << ' ' << y << ' ' << z;
}

Vec3d spacing(const Dataset& data) { return std::get<UniformGrid>(data.grid.shape).spacing; }

const std::string kImageJ = "ImageJ=1.53t\nimages=12\nchannels=2\nslices=3\nframes=2\nhyperstack=true\nmode=composite\nunit=\\u00B5m\nspacing=0.75\nfinterval=5\nloop=false\n";

TEST(TiffStacks, ImageJsChannelsAreArraysItsFramesStepsItsSpacingPlaces) {
  for (const bool big : {false, true})
    for (const bool in_one : {false, true}) {
      SCOPED_TRACE(std::to_string(big) + std::to_string(in_one));
      const Scratch scratch;
      const auto path = scratch.write("h.tif", tiff({.description = kImageJ, .pages = 12, .big = big, .in_one = in_one}));
      for (int step = 0; step < 2; ++step) {
        const auto data = open(path, step);
        EXPECT_EQ(data->times, (std::vector<double>{0, 5}));
        ASSERT_EQ(data->arrays.size(), 2u);
        expect_pages(*data, "channel 0", {6 * step, 6 * step + 2, 6 * step + 4});
        expect_pages(*data, "channel 1", {6 * step + 1, 6 * step + 3, 6 * step + 5});
        EXPECT_EQ(spacing(*data), (Vec3d{0.25, 0.5, 0.75}));
        EXPECT_EQ(axis_title(data->axes, 2), "z (µm)");
        EXPECT_TRUE(test::noted(*data, "times are in sec"));
      }
    }
}

TEST(TiffStacks, AStackOfImageJHasItsSpacingAndSignedNumbersAreThose) {
  const Scratch scratch;
  const std::string description = "ImageJ=1.53t\nimages=3\nslices=3\nunit=nm\nspacing=-2.5\ncf=0\nc0=-32768.0\nc1=1.0\nvunit=Gray Value\n";
  const auto data = open(scratch.write("s.tif", tiff({.description = description, .pages = 3, .raise = 32000})));
  EXPECT_EQ(data->arrays.front().type, ScalarType::int16);
  expect_pages(*data, "Tiff Scalars", {0, 1, 2}, 768);
  EXPECT_EQ(spacing(*data), (Vec3d{0.25, 0.5, 2.5}));
  const auto plain = open(scratch.write("c.tif", tiff({.description = "ImageJ=1.53t\nimages=3\nslices=3\nc0=4\nc1=0.5\n", .pages = 3})));
  expect_pages(*plain, "Tiff Scalars", {0, 1, 2});
  EXPECT_TRUE(test::noted(*plain, "calibration is 4 + 0.5 * value"));
}

std::string ome(const std::string& order, const std::string& more, const std::string& inside) {
  return R"(<?xml version="1.0" encoding="UTF-8"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06"><Image ID="Image:0"><Pixels ID="Pixels:0" Type="uint16" SizeX="3" SizeY="2" SizeZ="3" )"
         R"(SizeC="2" SizeT="2" DimensionOrder=")" + order + "\" " + more + ">" + inside + "</Pixels></Image></OME>";
}

TEST(TiffStacks, OmesPagesAreInTheOrderThatItSays) {
  const std::string sizes = R"(PhysicalSizeX="0.2" PhysicalSizeY="0.4" PhysicalSizeZ="1500" PhysicalSizeZUnit="nm" TimeIncrement="2.5")";
  const std::string channels = R"(<Channel ID="Channel:0:0" Name="DAPI"/><Channel ID="Channel:0:1"/>)";
  for (const auto& [order, step_of] : std::vector<std::pair<std::string, std::array<int, 3>>>{{"XYCZT", {2, 1, 6}}, {"XYZCT", {1, 3, 6}}, {"XYTCZ", {4, 2, 1}}}) {
    SCOPED_TRACE(order);
    const Scratch scratch;
    const auto path = scratch.write("o.ome.tif", tiff({.description = ome(order, sizes, channels + "<TiffData/>"), .pages = 12}));
    for (int t = 0; t < 2; ++t) {
      const auto data = open(path, t);
      EXPECT_EQ(data->times, (std::vector<double>{0, 2.5}));
      for (int c = 0; c < 2; ++c) {
        std::vector<int> pages;
        for (int z = 0; z < 3; ++z) pages.push_back(step_of[0] * z + step_of[1] * c + step_of[2] * t);
        expect_pages(*data, c == 0 ? "DAPI" : "channel 1", pages);
      }
      EXPECT_NEAR(spacing(*data).x, 0.2, 1e-12);
      EXPECT_NEAR(spacing(*data).y, 0.4, 1e-12);
      EXPECT_NEAR(spacing(*data).z, 1.5, 1e-12);
      EXPECT_EQ(axis_title(data->axes, 2), "z (µm)");
    }
  }
}

TEST(TiffStacks, OmesPlanesMayNameTheirPages) {
  std::string planes;
  for (int page = 0; page < 12; ++page)  // backwards
    planes += "<TiffData IFD=\"" + std::to_string(11 - page) + "\" FirstC=\"" + std::to_string(page % 2) + "\" FirstZ=\"" + std::to_string(page / 2 % 3) + "\" FirstT=\"" + std::to_string(page / 6) +
              "\" PlaneCount=\"1\"><UUID FileName=\"before_it_was_renamed.ome.tif\">urn:uuid:1</UUID></TiffData>";
  const Scratch scratch;
  const auto data = open(scratch.write("o.tif", tiff({.description = ome("XYZTC", "", planes), .pages = 12})), 1);
  expect_pages(*data, "channel 0", {5, 3, 1});
  expect_pages(*data, "channel 1", {4, 2, 0});
  const std::string two = "<TiffData IFD=\"0\" PlaneCount=\"6\"><UUID FileName=\"a.tif\">1</UUID></TiffData><TiffData IFD=\"0\" FirstT=\"1\" PlaneCount=\"6\"><UUID FileName=\"b.tif\">2</UUID></TiffData>";
  const auto one_of_two = open(scratch.write("a.tif", tiff({.description = ome("XYCZT", "", two), .pages = 6})));
  expect_pages(*one_of_two, "Tiff Scalars", {0, 1, 2, 3, 4, 5});
  EXPECT_TRUE(test::noted(*one_of_two, "one of the 2 files of an OME-TIFF"));
}

TEST(TiffStacks, ADescriptionThatIsNotOfThePagesIsToldAndThePagesAreSlices) {
  for (const auto& [description, words] : std::vector<std::pair<std::string, std::string>>{
           {kImageJ, "its description speaks of 12 pages, 4 are there"},
           {"ImageJ=1.53t\nimages=4\nchannels=3\nslices=2\n", "says 4 images in 3 channels, 2 slices and 1 frames"},
           {"ImageJ=1.53t\nimages=4\nchannels=0\n", "ImageJ's description says"},
           {"ImageJ=1.53t\nimages=99999999999999999999\nframes=99999999999\n", "ImageJ's description says"},
           {ome("XYCZT", "", "<TiffData/>"), "its description speaks of 12 pages, 4 are there"},
           {ome("XYQZT", "", ""), "makes no sense"},
           {ome("XYCZT", "", "<TiffData IFD=\"3\" FirstZ=\"9\"/>"), "a plane beyond its own"},
           {ome("XYCZT", "", "<TiffData IFD=\"3\" PlaneCount=\"99999999999\"/>"), "speaks of 12 pages"}}) {
    SCOPED_TRACE(description);
    const Scratch scratch;
    const auto data = open(scratch.write("d.tif", tiff({.description = description, .pages = 4})));
    expect_pages(*data, "Tiff Scalars", {0, 1, 2, 3});
    EXPECT_TRUE(test::noted(*data, words)) << (data->notes.empty() ? "" : data->notes.back());
  }
  const Scratch scratch;
  for (const std::string other : {"", "A thing that was scanned", "<OME", "<OME>", R"({"shape": [4, 2, 3]})"}) {
    const auto data = open(scratch.write("d.tif", tiff({.description = other, .pages = 4})));
    expect_pages(*data, "Tiff Scalars", {0, 1, 2, 3});
  }
}

TEST(TiffStacks, OnePageForAllOfThemIsReadOrRefusedInOneLine) {
  const Scratch scratch;
  const std::string whole = tiff({.description = kImageJ, .pages = 12, .big = true, .in_one = true});
  const Error cut = refusal(scratch.write("cut.tif", whole.substr(0, whole.size() - 1)));
  EXPECT_EQ(cut.code(), ErrorCode::bad_data);
  EXPECT_NE(std::string(cut.what()).find("cut.tif: is cut off: 12 planes of ImageJ declared, 144 bytes, 143 present"), std::string::npos) << cut.what();
}

TEST(TiffStacks, MutatedFilesEndInADatasetOrAnError) {
  testing::expect_datasets_or_errors({{"a.tif", tiff({.description = kImageJ, .pages = 12})},
                                      {"b.tif", tiff({.description = kImageJ, .pages = 12, .big = true, .in_one = true})},
                                      {"c.tif", tiff({.description = ome("XYZCT", "", "<TiffData/>"), .pages = 12})}},
                                     20);
}

}  // namespace
}  // namespace isostrata
