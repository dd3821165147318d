// --sandbox where the kernel, or a container's filter, lacks a part of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "support/run_isostrata.h"

namespace {

using namespace isostrata::testing;
using ::testing::HasSubstr;

/// `isostrata ARGUMENTS` as on a kernel without Landlock.
CommandResult without_landlock(const std::string& arguments, const std::string& environment = "") {
  return run_program("isostrata-sandbox-escape",
                     "--without landlock '" + std::string(isostrata::places::binaries()) + "/isostrata' " + arguments, environment);
}

class SandboxOption : public ::testing::Test {
 protected:
  void SetUp() override {
    if (without_landlock("--version").status == 3) GTEST_SKIP() << "this machine takes no seccomp filter";
    file_ = (folder_ / "a.vtk").string();
    folder_.write("a.vtk", "# vtk DataFile Version 3.0\nmade by a test\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nORIGIN 0 0 0\n"
                           "SPACING 1 1 1\nPOINT_DATA 8\nSCALARS f float 1\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7\n");
  }
  TemporaryFolder folder_;
  std::string file_;
};

TEST_F(SandboxOption, RequiredAFileIsReadWithAllOfItOrNotAtAll) {
  EXPECT_EQ(run_isostrata("info --json '" + file_ + "'").status, 0);
  EXPECT_EQ(without_landlock("info --json '" + file_ + "'").status, 0);
  EXPECT_EQ(without_landlock("info --json --sandbox off '" + file_ + "'").status, 0);
  for (const CommandResult& result : {without_landlock("info --sandbox require '" + file_ + "'"),
                                      without_landlock("info '" + file_ + "'", "ISOSTRATA_SANDBOX=require"),
                                      without_landlock("extract --sandbox require --interval 0:1 '" + file_ + "'")}) {
    EXPECT_EQ(result.status, 1);
    EXPECT_THAT(result.err, HasSubstr("lacks Landlock"));
  }
  EXPECT_EQ(without_landlock("info --sandbox require torus:8").status, 0) << "no file is read";
}

TEST_F(SandboxOption, ServeRequiresItBeyondThisMachine) {
  const std::string at_once = " --state-dir none --port 0 --idle-timeout 1 '" + file_ + "'";
  const CommandResult open = without_landlock("serve --host 0.0.0.0" + at_once);
  EXPECT_EQ(open.status, 1);
  EXPECT_THAT(open.err, HasSubstr("lacks Landlock"));
  EXPECT_THAT(open.err, HasSubstr("--sandbox try"));
  const CommandResult allowed = without_landlock("serve --host 0.0.0.0 --sandbox try" + at_once);
  EXPECT_EQ(allowed.status, 0) << allowed.err;
  const CommandResult here = without_landlock("serve" + at_once);
  EXPECT_EQ(here.status, 0) << here.err;
  for (const std::string& log : {allowed.err, here.err}) EXPECT_THAT(log, HasSubstr("files are read without Landlock"));
  EXPECT_THAT(run_isostrata("serve --sandbox off" + at_once).err, HasSubstr("--sandbox off: a broken or hostile file"));
}

// EnSight's reader opens whatever a case names; Landlock keeps it in the case's folder, and without it the importer's own open does.
TEST_F(SandboxOption, AFileThatNamesOneOutsideHasItNotReadWithLandlockOrWithout) {
  std::string cell = "made by a test\na box\nnode id assign\nelement id assign\npart\n         1\nbox\ncoordinates\n         8\n";
  for (const char* axis : {"01100110", "00110011", "00001111"})
    for (const char* at = axis; *at; ++at) cell += *at == '0' ? " 0.00000e+00\n" : " 1.00000e+00\n";
  cell += "hexa8\n         1\n         1         2         3         4         5         6         7         8\n";
  std::string values = "f\npart\n         1\ncoordinates\n";
  for (int i = 0; i < 8; ++i) values += " 1.00000e+00\n";
  for (const char* folder : {"inside", "outside"}) {
    folder_.write(std::string(folder) + "/box.geo", cell);
    folder_.write(std::string(folder) + "/box.scl", values);
  }
  std::filesystem::create_directory_symlink(folder_ / "outside", folder_ / "inside/door");
  const std::string mine = "'" + folder_.write("inside/mine.case", "FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: box.geo\nVARIABLE\nscalar per node: f box.scl\n").string() + "'";
  const std::string theirs = "'" + folder_.write("inside/theirs.case", "FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: door/box.geo\nVARIABLE\nscalar per node: f box.scl\n").string() + "'";
  if (const CommandResult result = run_isostrata("info " + mine); result.status != 0) GTEST_SKIP() << "this VTK does not read EnSight: " << result.err;
  EXPECT_EQ(without_landlock("info " + mine).status, 0);
  EXPECT_EQ(without_landlock("info --sandbox off " + theirs).status, 0) << "else it proves nothing";
  EXPECT_EQ(run_isostrata("info " + theirs).status, 1);
#ifndef ISOSTRATA_SANITIZED  // a sanitizer has the place of open itself
  EXPECT_EQ(without_landlock("info " + theirs).status, 1);
#endif
}

TEST_F(SandboxOption, AnotherWordIsWrongUsage) {
  EXPECT_EQ(run_isostrata("info --sandbox maybe torus:8").status, 2);
  EXPECT_EQ(run_isostrata("info '" + file_ + "'", "ISOSTRATA_SANDBOX=maybe").status, 1);
}

TEST_F(SandboxOption, DoctorSaysWhatIsMissing) {
  const CommandResult result = without_landlock("doctor");
  EXPECT_THAT(result.out, HasSubstr("this machine lacks Landlock"));
}

}  // namespace
