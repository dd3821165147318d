// Files that one process has read and the next one maps.
#include <gtest/gtest.h>

#include "data/files.h"
#include "data/open/import_door.h"
#include "support/places.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using test::Scratch;

struct KeptImport : ::testing::Test {
  Scratch data, keep;
  fs::path file;
  OpenOptions options;
  KeptImport() {
    write(4);
    options.importer = fs::path(isostrata::places::binaries()) / "isostrata-import";
  }
  void write(int points) {
    std::string text = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 " + std::to_string(points) + "\nencoding: raw\n\n";
    for (int i = 0; i < 4 * points; ++i) text += static_cast<char>(i);
    file = data.write("a.nrrd", text);
  }
  std::size_t kept() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(keep.path()), fs::directory_iterator()));
  }
  std::shared_ptr<const Dataset> open() const { return open_import_keeping(file, options, keep.path(), Task()); }
  /// What a killed process leaves: the directory, without whoever would remove it.
  void leave_behind() {
    const auto dataset = open();
    fs::copy(keep.path(), data / "copy", fs::copy_options::recursive);
  }
  void find_again() { fs::copy(data / "copy", keep.path(), fs::copy_options::recursive); }
};

TEST_F(KeptImport, FilesStayAsLongAsTheirDataset) {
  auto dataset = open();
  EXPECT_EQ(kept(), 1u);
  const auto again = open();
  EXPECT_EQ(again->array(again->arrays[0].name).at(15), 15);
  dataset.reset();
  EXPECT_EQ(again->array(again->arrays[0].name).at(15), 15) << "what is mapped stays";
  EXPECT_EQ(kept(), 0u);
}

TEST_F(KeptImport, WhatAnotherProcessLeftIsMappedWithoutAChild) {
  leave_behind();
  EXPECT_EQ(kept(), 0u);
  find_again();
  options.importer = "/bin/false";
  const auto dataset = open();
  EXPECT_EQ(dataset->grid.point_count(), 16);
  EXPECT_EQ(dataset->name, file.string());
  options.step = 1;
  EXPECT_THROW(open(), Error) << "another step is another import";
}

TEST_F(KeptImport, AFileThatWasChangedIsReadAgain) {
  leave_behind();
  find_again();
  write(5);
  EXPECT_EQ(open()->grid.point_count(), 20);
}

TEST_F(KeptImport, WhatIsDamagedIsReadAgain) {
  leave_behind();
  find_again();
  for (const auto& entry : fs::recursive_directory_iterator(keep.path()))
    if (entry.path().filename() == "array_0.bin") fs::resize_file(entry.path(), 3);
  EXPECT_EQ(open()->grid.point_count(), 16);
}

}  // namespace
}  // namespace isostrata
