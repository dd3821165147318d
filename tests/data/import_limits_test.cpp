// What the import child is started with, and how much it may take.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>

#include "data/files.h"
#include "data/open/sandbox.h"
#include "support/exodus_file.h"
#include "support/places.h"

namespace isostrata {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// What an importer that is this script says in its error.
std::string told_by(const std::string& script) {
  const test::Scratch scratch;
  const auto program = scratch.write("reader", "#!/bin/sh\n" + script + "\n");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  OpenOptions options;
  options.importer = program;
  return test::refusal(scratch.write("x.vti", "x"), options).what();
}

TEST(ImportLimits, TheChildSeesAtMostFiveVariables) {
  setenv("ISOSTRATA_TOKEN", "a secret", 1);
  const std::string seen = told_by("echo \"error unsupported $(tr '\\0' ' ' < /proc/$$/environ)\" >&2; exit 1");
  unsetenv("ISOSTRATA_TOKEN");
  EXPECT_THAT(seen, Not(HasSubstr("a secret")));
  EXPECT_THAT(seen, HasSubstr("HDF5_USE_FILE_LOCKING=FALSE"));
#ifndef ISOSTRATA_SANITIZED
  EXPECT_LE(std::count(seen.begin(), seen.end(), '='), 5) << seen;
#endif
}

TEST(ImportLimits, TheChildIsToldHowStrictToBe) {
  EXPECT_EQ(told_by("echo \"error unsupported $6\" >&2; exit 1"), to_string(sandbox()));
}

#ifndef ISOSTRATA_SANITIZED
/// By a child of this process, whose memory the kernel tells.
OpenOptions by_child() {
  OpenOptions options;
  options.importer = std::filesystem::path(places::binaries()) / "isostrata-import";
  return options;
}

// 400 million points would be 9.6 GB.
TEST(ImportLimits, ASmallFileThatDeclaresGigabytesTakesNoneOfThem) {
  testing::ExodusFile file;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) file.points.push_back({double(i), double(j), double(k)});
  file.blocks = {{"HEX8", 8, {1, 2, 4, 3, 5, 6, 8, 7}, 0}};
  std::string bytes = file.bytes();
  const std::string name("num_nodes\0\0\0", 12);
  const auto at = bytes.find(name);
  ASSERT_NE(at, std::string::npos);
  const std::uint32_t many = 400'000'000;
  for (std::size_t i = 0; i < 4; ++i) bytes[at + name.size() + i] = static_cast<char>(many >> (24 - 8 * i));
  const test::Scratch scratch;
  const Error error = test::refusal(scratch.write("x.e", bytes), by_child());
  EXPECT_TRUE(error.code() == ErrorCode::too_large || error.code() == ErrorCode::bad_data) << error.what();
  EXPECT_THAT(error.what(), Not(HasSubstr("crashed"))) << "it says what is wrong";
  rusage children{};
  getrusage(RUSAGE_CHILDREN, &children);
  EXPECT_LT(children.ru_maxrss, 1300 << 10) << "KiB of the largest child of this test";
}

// Eight thousand million numbers and more. VTK's readers ask for all of the memory first; the limit of address space, which follows the file's
// size, is what says no: a bound of ours before each of them would have to know what each of their formats may pack and leave out.
TEST(ImportLimits, WhatDeclaresMoreThanThereIsTakesNoneOfItWhateverTheFormat) {
  const std::string image = "<ImageData WholeExtent=\"0 1999 0 1999 0 1999\" Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece Extent=\"0 1999 0 1999 0 1999\"><PointData>"
                            "<DataArray type=\"Float64\" Name=\"a\" format=\"ascii\">1 2 3</DataArray></PointData></Piece></ImageData>";
  const std::string grid = "<UnstructuredGrid><Piece NumberOfPoints=\"2000000000\" NumberOfCells=\"1000000000\"><Points>"
                           "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0</DataArray></Points><Cells>"
                           "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">1</DataArray>"
                           "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">1</DataArray></Cells></Piece></UnstructuredGrid>";
  const auto xml = [](const std::string& type, const std::string& inner) {
    return "<?xml version=\"1.0\"?><VTKFile type=\"" + type + "\" version=\"1.0\" byte_order=\"LittleEndian\">" + inner + "</VTKFile>";
  };
  const std::string legacy = "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET ";
  const test::Scratch scratch;
  for (const auto& [name, text] :
       {std::pair{"image.vti", xml("ImageData", image)}, std::pair{"grid.vtu", xml("UnstructuredGrid", grid)},
        std::pair{"points.vtk", legacy + "STRUCTURED_POINTS\nDIMENSIONS 2000 2000 2000\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 8000000000\nSCALARS f float 1\n"
                                         "LOOKUP_TABLE default\n1234"},
        std::pair{"grid.vtk", legacy + "UNSTRUCTURED_GRID\nPOINTS 1000000000 double\n1234"},
        std::pair{"a.nrrd", std::string("NRRD0004\ntype: double\ndimension: 3\nsizes: 2000 2000 2000\nencoding: raw\nendian: little\n\n12345678")},
        std::pair{"a.mha", std::string("ObjectType = Image\nNDims = 3\nDimSize = 2000 2000 2000\nElementType = MET_DOUBLE\nElementDataFile = LOCAL\n12345678")},
        std::pair{"a.slc", std::string("11111\n2000 2000 2000 8 1 1 1 0 0 0 X 0 0 0 0 X")}}) {
    const Error error = test::refusal(scratch.write(name, text), by_child());
    EXPECT_TRUE(error.code() == ErrorCode::too_large || error.code() == ErrorCode::bad_data) << name << ": " << error.what();
    EXPECT_THAT(error.what(), Not(HasSubstr("crashed"))) << name;
  }
  rusage children{};
  getrusage(RUSAGE_CHILDREN, &children);
  EXPECT_LT(children.ru_maxrss, 1300 << 10) << "KiB of the largest child of this test";
}
#endif

}  // namespace
}  // namespace isostrata
