// What lies in a directory that is served stays what is read, whatever is put in its place.
#include "data/files/beneath.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>

#include "data/files.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const char* const kField =
    "# vtk DataFile Version 3.0\nmade by a test\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nORIGIN 0 0 0\nSPACING 1 1 "
    "1\n"
    "POINT_DATA 8\nSCALARS f float 1\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7\n";

/// 0, or why it cannot be opened.
int refused(const fs::path& path) {
  const int opened = open_beneath(path, O_RDONLY);
  if (opened < 0) return errno;
  close(opened);
  return 0;
}

class Beneath : public ::testing::Test {
 protected:
  Beneath() {
    scratch_.write("secret.vtk", kField);
    scratch_.write("root/a/field.vtk", kField);
  }
  fs::path of(const std::string& rest) const { return beneath(scratch_ / "root", rest); }
  const test::Scratch scratch_;
};

TEST_F(Beneath, AMarkChangesNothingForWhoDoesNotLookForIt) {
  EXPECT_EQ(of("a/field.vtk").string(), (scratch_ / "root").string() + "/./a/field.vtk");
  EXPECT_EQ(without_mark(of("a/field.vtk")), scratch_ / "root/a/field.vtk");
  EXPECT_EQ(without_mark("no/mark"), "no/mark");
  EXPECT_TRUE(fs::equivalent(of("a/field.vtk"), scratch_ / "root/a/field.vtk"));
  EXPECT_EQ(refused(of("a/field.vtk")), 0);
  EXPECT_EQ(refused(of("a")), 0);
  EXPECT_EQ(refused(beneath("/", "etc")), 0);
  EXPECT_EQ(refused(of("absent")), ENOENT);
}

TEST_F(Beneath, LinksAreFollowedInsideAndNotOut) {
  const fs::path root = scratch_ / "root";
  fs::create_symlink("a/field.vtk", root / "inside");
  fs::create_symlink(root / "a/field.vtk", root / "inside-from-the-top");
  fs::create_symlink("../secret.vtk", root / "out");
  fs::create_symlink(scratch_ / "secret.vtk", root / "out-from-the-top");
  fs::create_symlink("..", root / "folder-out");
  fs::create_symlink("/proc/self/root", root / "magic");
  EXPECT_EQ(refused(of("inside")), 0);
  EXPECT_EQ(refused(of("inside-from-the-top")), 0);
  for (const char* out : {"out", "out-from-the-top", "folder-out/secret.vtk", "../secret.vtk", "a/../../secret.vtk"})
    EXPECT_EQ(refused(of(out)), EXDEV) << out;
  EXPECT_NE(refused(of("magic/etc/passwd")), 0);
}

TEST_F(Beneath, AListedFileThatIsSwappedForALinkIsNotRead) {
  EXPECT_EQ(test::open(of("a/field.vtk"))->grid.point_count(), 8);
  EXPECT_EQ(test::open(of("a/field.vtk"))->name, (scratch_ / "root/a/field.vtk").string());
  fs::remove(scratch_ / "root/a/field.vtk");
  fs::create_symlink(scratch_ / "secret.vtk", scratch_ / "root/a/field.vtk");
  const Error file = test::refusal(of("a/field.vtk"));
  EXPECT_EQ(file.code(), ErrorCode::not_found);
  EXPECT_THAT(file.what(), HasSubstr("is not followed"));
  // The same of a directory on the way.
  scratch_.write("elsewhere/field.vtk", kField);
  fs::remove_all(scratch_ / "root/a");
  fs::create_directory_symlink(scratch_ / "elsewhere", scratch_ / "root/a");
  EXPECT_THAT(test::refusal(of("a/field.vtk")).what(), HasSubstr("is not followed"));
  // By its plain name, as a person on the command line names it, it is.
  EXPECT_EQ(test::open(scratch_ / "root/a/field.vtk")->grid.point_count(), 8);
}

}  // namespace
}  // namespace isostrata
