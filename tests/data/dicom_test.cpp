// DICOM that the tests write element by element: where frames lie that share one place, doses, copies, and patterns of slices.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "data/files.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using test::open;
using test::put;
using test::refusal;
using test::Scratch;

constexpr int kColumns = 3, kRows = 2;

void element(std::string& out, std::uint16_t group, std::uint16_t number, const std::string& kind, std::string value) {
  if (value.size() % 2) value += kind == "UI" ? '\0' : ' ';
  put(out, group, false), put(out, number, false);
  out += kind;
  if (kind == "OW")
    put(out, std::uint16_t{0}, false), put(out, static_cast<std::uint32_t>(value.size()), false);
  else
    put(out, static_cast<std::uint16_t>(value.size()), false);
  out += value;
}

std::string word(std::uint16_t number) {
  std::string out;
  put(out, number, false);
  return out;
}

struct Picture {
  std::string uid = "1.2.3.1", place = "0\\0\\10", modality = "CT";
  int frames = 1, instance = 1, first = 0;  // the first value; each frame is 100 above the one before
  std::vector<std::pair<std::uint16_t, std::string>> of_dose{};  // elements of group 3004
  std::string between{};
};

std::string dicom(const Picture& of) {
  std::string out = std::string(128, '\0') + "DICM";
  element(out, 2, 0x10, "UI", "1.2.840.10008.1.2.1");
  element(out, 8, 0x18, "UI", of.uid);
  element(out, 8, 0x60, "CS", of.modality);
  element(out, 0x18, 0x50, "DS", "2");
  if (!of.between.empty()) element(out, 0x18, 0x88, "DS", of.between);
  element(out, 0x20, 0xe, "UI", "1.2.3");
  element(out, 0x20, 0x13, "IS", std::to_string(of.instance));
  element(out, 0x20, 0x32, "DS", of.place);
  element(out, 0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0");
  element(out, 0x28, 2, "US", word(1));
  if (of.frames > 1) element(out, 0x28, 8, "IS", std::to_string(of.frames));
  element(out, 0x28, 0x10, "US", word(kRows));
  element(out, 0x28, 0x11, "US", word(kColumns));
  element(out, 0x28, 0x30, "DS", "1\\1");
  element(out, 0x28, 0x100, "US", word(16));
  element(out, 0x28, 0x101, "US", word(16));
  element(out, 0x28, 0x103, "US", word(0));
  for (const auto& [number, value] : of.of_dose) element(out, 0x3004, number, number == 2 ? "CS" : "DS", value);
  std::string pixels;
  for (int frame = 0; frame < of.frames; ++frame)
    for (int p = 0; p < kColumns * kRows; ++p) put(pixels, static_cast<std::uint16_t>(of.first + 100 * frame + p), false);
  element(out, 0x7fe0, 0x10, "OW", pixels);
  return out;
}

Picture slice(int k) { return {.uid = "1.2.3." + std::to_string(k + 1), .place = "0\\0\\" + std::to_string(2 * k), .instance = k + 1, .first = 100 * k}; }

TEST(Dicom, FramesOfADoseLieAtTheirOffsetsAndAreScaled) {
  const Scratch scratch;
  for (const std::string offsets : {"0\\3\\6\\9", "10\\13\\16\\19"}) {
    const auto data = open(scratch.write("dose.dcm", dicom({.modality = "RTDOSE", .frames = 4, .of_dose = {{2, "GY"}, {0xc, offsets}, {0xe, "0.01"}}})));
    EXPECT_EQ(data->bounds.lower.z, 10);
    EXPECT_EQ(data->bounds.upper.z, 19);
    EXPECT_EQ(data->arrays.front().lower, 0);
    EXPECT_NEAR(data->arrays.front().upper, 3.05, 1e-6);
    EXPECT_EQ(data->arrays.front().unit, "Gy");
  }
}

TEST(Dicom, FramesWithOnePlaceLieAsFarApartAsTheFileSays) {
  const Scratch scratch;
  EXPECT_EQ(open(scratch.write("nm.dcm", dicom({.modality = "NM", .frames = 4, .between = "3"})))->bounds.upper.z, 19);
  const auto down = open(scratch.write("down.dcm", dicom({.modality = "NM", .frames = 4, .between = "-3"})));
  EXPECT_EQ(down->bounds.lower.z, 1);
  EXPECT_EQ(down->bounds.upper.z, 10);
  EXPECT_EQ(open(scratch.write("thick.dcm", dicom({.frames = 4})))->bounds.upper.z, 16);
}

TEST(Dicom, ASliceThatIsThereTwiceCountsOnce) {
  const Scratch scratch;
  for (int k = 0; k < 4; ++k) scratch.write("scan/IM" + std::to_string(k), dicom(slice(k)));
  scratch.write("scan/IM0 copy", dicom(slice(0)));
  for (const fs::path& path : {scratch / "scan", scratch / "scan/IM0 copy"}) {
    const auto data = open(path);
    EXPECT_EQ(data->grid.dims(), (std::array<std::int64_t, 3>{kColumns, kRows, 4}));
    EXPECT_EQ(data->times.size(), 1u);
    EXPECT_TRUE(test::noted(*data, "1 files are left out: they are copies of others"));
  }
  Picture other = slice(2);
  other.uid = "1.2.3.99";
  scratch.write("scan/other", dicom(other));
  const Error error = refusal(scratch / "scan");
  EXPECT_NE(std::string(error.what()).find("(IM2 and other have one place)"), std::string::npos) << error.what();
}

TEST(Dicom, APatternOfSlicesIsOneVolume) {
  const Scratch scratch;
  for (int k = 0; k < 4; ++k) scratch.write("I" + std::to_string(10 + k) + ".DCM", dicom(slice(3 - k)));
  scratch.write("J10.DCM", dicom(slice(9)));
  const auto data = open(scratch / "I*.DCM");
  EXPECT_EQ(data->grid.dims(), (std::array<std::int64_t, 3>{kColumns, kRows, 4}));
  EXPECT_EQ(data->times, (std::vector<double>{0}));
  EXPECT_EQ(data->bounds.upper.z, 6);
  EXPECT_EQ(data->arrays.front().at(kColumns * kRows * 3), 300);
}

}  // namespace
}  // namespace isostrata
