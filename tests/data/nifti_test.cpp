// NIfTI 1 that the tests write byte by byte: scales that are none, pairs of files, and names that say nothing.
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>

#include "data/files.h"
#include "data/files/list_folder.h"

namespace isostrata {
namespace {

using test::open;
using test::put;
using test::refusal;
using test::Scratch;

/// 2 x 3 x 4 numbers of 16 bits.
std::string header(const std::string& mark, float offset, float slope = 0, float intercept = 0) {
  std::string out(348, '\0');
  const auto set = [&](std::size_t at, auto number) {
    std::string bytes;
    put(bytes, number, false);
    out.replace(at, bytes.size(), bytes);
  };
  const auto real = [&](std::size_t at, float number) { set(at, std::bit_cast<std::uint32_t>(number)); };
  set(0, std::uint32_t{348});
  std::size_t at = 40;
  for (const std::uint16_t size : {3, 2, 3, 4, 1, 1, 1, 1}) set(at, size), at += 2;
  set(70, std::uint16_t{4}), set(72, std::uint16_t{16});
  for (at = 76; at < 76 + 8 * 4; at += 4) real(at, 1);
  real(108, offset), real(112, slope), real(116, intercept);
  return out.replace(344, 4, mark + '\0');
}

std::string values() {
  std::string out;
  for (std::uint16_t v = 0; v < 24; ++v) put(out, v, false);
  return out;
}

void expect_values(const Dataset& data) {
  EXPECT_EQ(data.grid.dims(), (std::array<std::int64_t, 3>{2, 3, 4}));
  const PointArray& array = data.arrays.front();
  EXPECT_EQ(array.nan_count, 0);
  for (std::size_t v = 0; v < 24; ++v) EXPECT_EQ(array.at(v), static_cast<double>(v));
}

TEST(Nifti, ASlopeThatIsNotFiniteScalesNothing) {
  const Scratch scratch;
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN(), kInfinite = std::numeric_limits<float>::infinity();
  for (const float slope : {0.0f, 1.0f, kNone, kInfinite})
    for (const float intercept : {0.0f, kNone}) expect_values(*open(scratch.write("a.nii", header("n+1", 352, slope, intercept) + std::string(4, '\0') + values())));
  const auto scaled = open(scratch.write("b.nii", header("n+1", 352, 2, kNone) + std::string(4, '\0') + values()));
  EXPECT_EQ(scaled->arrays.front().upper, 46);
}

TEST(Nifti, APairIsOneDatasetByEitherName) {
  const Scratch scratch;
  scratch.write("in/brain.hdr", header("ni1", 0));
  scratch.write("in/brain.img", values());
  expect_values(*open(scratch / "in/brain.hdr"));
  expect_values(*open(scratch / "in/brain.img"));
  const FolderListing listing = list_folder(scratch / "in");
  ASSERT_EQ(listing.entries.size(), 1u);
  EXPECT_EQ(listing.entries.front().name, "brain.hdr");
  EXPECT_EQ(listing.entries.front().kind, FileKind::nifti);
  const Error alone = refusal(scratch.write("alone.hdr", header("ni1", 0)));
  EXPECT_EQ(std::string(alone.what()), "alone.hdr: the header of a pair of NIfTI files; expected alone.img with its values beside it");
  scratch.write("cut.hdr", header("ni1", 0));
  const Error cut = refusal(scratch.write("cut.img", values().substr(0, 40)));
  EXPECT_EQ(std::string(cut.what()), "cut.img: is cut off: 48 bytes declared by cut.hdr, 40 present");
  EXPECT_EQ(refusal(scratch.write("analyze.hdr", header("", 0))).code(), ErrorCode::unsupported);
  EXPECT_EQ(refusal(scratch.write("raw.img", values())).code(), ErrorCode::unsupported);
}

TEST(Nifti, IsKnownByItsMarkWhateverItsName) {
  const Scratch scratch;
  for (const char* name : {"brain", "brain.dat"}) expect_values(*open(scratch.write(name, header("n+1", 352) + std::string(4, '\0') + values())));
}

}  // namespace
}  // namespace isostrata
