// Files that were read once and are mapped the next time.
#include "data/open/import_cache.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <span>
#include <sstream>

#include "data/files.h"
#include "data/files/source_files.h"
#include "data/open/import_door.h"
#include "data/open/sandbox.h"
#include "support/places.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using test::Scratch;

struct CachedImport : ::testing::Test {
  Scratch data, where;
  ImportCache cache;
  OpenOptions options;
  fs::path file;

  CachedImport() {
    cache.folder = where / "cache";
    cache.least_seconds = 0;
    options.importer = fs::path(isostrata::places::binaries()) / "isostrata-import";
    file = write("a", 4);
  }
  /// NAME.nhdr with its numbers beside it.
  fs::path write(const std::string& name, int points, char first = 0) {
    std::string values;
    for (int i = 0; i < 4 * points; ++i) values += static_cast<char>(first + i);
    data.write(name + ".raw", values);
    return data.write(name + ".nhdr", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 " + std::to_string(points) +
                                          "\nencoding: raw\ndata file: " + name + ".raw\n");
  }
  std::shared_ptr<const Dataset> open() const { return open_import_cached(file, options, cache, Task()); }
  /// Whether the reader is not needed: it is replaced, in place, by one that fails.
  bool opens_without_reader() {
    const fs::path reader = where / "reader";
    std::ofstream(reader) << "#!/bin/sh\nexec '" << options.importer.string() << "' \"$@\"\n";
    fs::permissions(reader, fs::perms::owner_all);
    const auto time = fs::last_write_time(reader);
    OpenOptions with = options;
    with.importer = reader;
    open_import_cached(file, with, cache, Task());
    const auto bytes = fs::file_size(reader);
    std::ofstream(reader) << "#!/bin/sh\nexit 1\n" << std::string(bytes - 17, '#');
    fs::last_write_time(reader, time);
    try {
      return open_import_cached(file, with, cache, Task()) != nullptr;
    } catch (const Error&) {
      return false;
    }
  }
  std::vector<fs::path> entries() const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(cache.folder)) found.push_back(entry.path());
    return found;
  }
};

void expect_same(const Dataset& a, const Dataset& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.cell_types, b.cell_types);
  EXPECT_EQ(a.bounds.lower, b.bounds.lower);
  EXPECT_EQ(a.bounds.upper, b.bounds.upper);
  ASSERT_EQ(a.arrays.size(), b.arrays.size());
  for (std::size_t i = 0; i < a.arrays.size(); ++i) {
    EXPECT_EQ(a.arrays[i].name, b.arrays[i].name);
    EXPECT_EQ(a.arrays[i].lower, b.arrays[i].lower);
    EXPECT_EQ(a.arrays[i].upper, b.arrays[i].upper);
    EXPECT_EQ(a.arrays[i].nan_count, b.arrays[i].nan_count);
    for (std::size_t p = 0; p < 16; ++p) EXPECT_EQ(a.arrays[i].at(p), b.arrays[i].at(p));
  }
}

TEST_F(CachedImport, TheSecondOpeningNeedsNoReaderAndIsTheSame) {
  const auto first = open();
  EXPECT_TRUE(opens_without_reader());
  expect_same(*open(), *first);
  expect_same(*open_import(file, options, Task()), *first);
}

TEST_F(CachedImport, EveryFileThatWasReadCounts) {
  open();
  ASSERT_EQ(open()->arrays[0].upper, 15);
  const auto time = fs::last_write_time(data / "a.raw");
  std::ofstream(data / "a.raw") << std::string(16, 'z');
  fs::last_write_time(data / "a.raw", time + std::chrono::seconds(1));
  EXPECT_EQ(open()->arrays[0].lower, 'z') << "the header is as it was, its numbers are not";
}

TEST_F(CachedImport, WhatIsReadFastIsNotKept) {
  cache.least_seconds = 60;
  open();
  EXPECT_EQ(use_of(cache).entries, 0);
  EXPECT_TRUE(entries().empty());
}

TEST_F(CachedImport, WhatWasUsedLongestAgoMakesRoom) {
  open();
  const std::uint64_t one = use_of(cache).bytes;
  cache.max_bytes = 2 * one + one / 2;
  file = write("b", 4);
  open();
  file = write("c", 4);
  for (const fs::path& entry : entries()) {  // "a" was used after "b"
    std::ostringstream text;
    text << std::ifstream(entry / "origin.txt").rdbuf();
    if (text.str().find("b.nhdr") != std::string::npos)
      fs::last_write_time(entry / "origin.txt", fs::file_time_type::clock::now() - std::chrono::hours(1));
  }
  open();
  EXPECT_EQ(use_of(cache).entries, 2);
  EXPECT_LE(use_of(cache).bytes, cache.max_bytes);
  file = data / "a.nhdr";
  EXPECT_TRUE(opens_without_reader());
}

TEST_F(CachedImport, DamagedEntriesAreReadAgain) {
  for (const char* name : {"array_0.bin", "measures.json", "origin.txt", "manifest.json", "placement.bin"}) {
    SCOPED_TRACE(name);
    open();
    ASSERT_EQ(entries().size(), 1u);
    fs::resize_file(entries()[0] / name, 3);
    expect_same(*open(), *open_import(file, options, Task()));
    clear(cache);
  }
}

TEST_F(CachedImport, AfterTheMachineStartedAnewAnEntryIsCheckedOnceMore) {
  open();
  const auto first = open_import(file, options, Task());
  ASSERT_EQ(entries().size(), 1u);
  const fs::path measures = entries()[0] / "measures.json";
  std::ostringstream text;
  text << std::ifstream(measures).rdbuf();
  std::string other = text.str();
  const auto boot = other.find("\"boot\":\"") + 8;
  other[boot] = other[boot] == 'f' ? 'e' : 'f';
  std::ofstream(measures) << other;
  expect_same(*open(), *first);
  std::ostringstream again;
  again << std::ifstream(measures).rdbuf();
  EXPECT_EQ(again.str(), text.str()) << "it was good, and is now of this start";

  std::ofstream(measures) << other;
  std::ofstream(entries()[0] / "array_0.bin") << std::string(16, '\0');  // what was not on the disk yet
  expect_same(*open(), *first);
}

TEST_F(CachedImport, WhatAKilledReaderLeftGoes) {
  open();
  const fs::path left = cache.folder / "new-abcdef";
  fs::create_directory(left);
  std::ofstream(left / "array_0.bin") << "half";
  fs::last_write_time(left, fs::file_time_type::clock::now() - std::chrono::hours(1));
  file = write("b", 4);
  open();
  EXPECT_FALSE(fs::exists(left));
  EXPECT_EQ(use_of(cache).entries, 2);
}

TEST_F(CachedImport, AFolderThatOthersCanWriteIsNotBelieved) {
  fs::create_directory(cache.folder);
  chmod(cache.folder.c_str(), 0777);
  EXPECT_EQ(open()->arrays[0].upper, 15);
  EXPECT_TRUE(entries().empty());
}

TEST_F(CachedImport, AFolderThatCannotBeWrittenIsAsNone) {
  cache.folder = "/proc/nothing/here";
  EXPECT_EQ(open()->arrays[0].upper, 15);
}

TEST_F(CachedImport, MappedDataOutlivesItsEntry) {
  const auto dataset = open();
  clear(cache);
  EXPECT_EQ(use_of(cache).entries, 0);
  EXPECT_EQ(dataset->arrays[0].at(15), 15);
}

TEST_F(CachedImport, FailuresAreThoseOfTheReaderAndLeaveNothing) {
  file = data.write("bad.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 9\nencoding: raw\n\nshort");
  EXPECT_THROW(open(), Error);
  EXPECT_TRUE(entries().empty());
  file = data / "nothing.nrrd";
  EXPECT_THROW(open(), Error);
}

struct KeptWorks : CachedImport {
  static std::vector<std::byte> bytes(const std::string& text) {
    const auto of = std::as_bytes(std::span(text));
    return {of.begin(), of.end()};
  }
  KeptWork work(const std::string& what = "picture 1") const { return KeptWork(file, what, cache); }
  void SetUp() override {
    if (sandbox_support().landlock <= 0) GTEST_SKIP() << "this machine cannot keep a reader out of the cache: nothing is kept";
  }
};

TEST_F(KeptWorks, AreFoundByTheFileAsItIsAndByWhatTheyAre) {
  EXPECT_EQ(work().find(), std::nullopt);
  work().keep(bytes("a picture"));
  EXPECT_EQ(work().find(), bytes("a picture"));
  EXPECT_EQ(work("picture 2").find(), std::nullopt);
  work("picture 2").keep(bytes(""));
  EXPECT_EQ(work("picture 2").find(), bytes(""));
  EXPECT_EQ(use_of(cache).entries, 2);
  const auto time = fs::last_write_time(data / "a.raw");
  fs::last_write_time(data / "a.raw", time + std::chrono::seconds(1));
  EXPECT_EQ(work().find(), std::nullopt) << "a file beside it that it is read from is another";
}

TEST_F(KeptWorks, OfAFileThatChangesMeanwhileAreNotKept) {
  const KeptWork begun = work();
  std::ofstream(data / "a.raw") << "other bytes";
  begun.keep(bytes("of what was there"));
  EXPECT_EQ(work().find(), std::nullopt);
  EXPECT_EQ(begun.find(), std::nullopt);
  EXPECT_EQ(use_of(cache).entries, 0);
}

TEST_F(KeptWorks, AreGoneWhereTheyAreDamagedAndMakeRoomAsImportsDo) {
  work().keep(bytes("a picture"));
  std::ofstream(entries().at(0) / "work.bin", std::ios::binary) << "12345678a pictura";
  EXPECT_EQ(work().find(), std::nullopt);
  EXPECT_TRUE(entries().empty());
  work().keep(bytes("a picture"));
  cache.max_bytes = use_of(cache).bytes + 100;
  work("picture 2").keep(bytes("another"));
  EXPECT_EQ(use_of(cache).entries, 1);
  EXPECT_EQ(work("picture 2").find(), bytes("another"));
  file = data / "nothing.nrrd";
  EXPECT_THROW(work(), Error);
}

TEST(SourceFiles, AreAllThatAReaderMayOpen) {
  Scratch data;
  data.write("piece.vtu", "<VTKFile type=\"UnstructuredGrid\"></VTKFile>");
  const fs::path whole = data.write("whole.pvtu", "<VTKFile type=\"PUnstructuredGrid\"><Piece Source=\"piece.vtu\"/></VTKFile>");
  const fs::path steps = data.write("steps.pvd", "<VTKFile type=\"Collection\"><DataSet file=\"whole.pvtu\"/></VTKFile>");
  const auto lines = source_files(steps);
  ASSERT_TRUE(lines);
  for (const char* name : {"steps.pvd ", "whole.pvtu ", "piece.vtu "}) EXPECT_NE(lines->find(name), std::string::npos) << name;
  EXPECT_EQ(source_files(data / "nothing.vtu"), std::nullopt);
}

TEST(SourceFiles, OfACaseOfOpenFoamAreThoseOfItsProcessorsRegionsToo) {
  Scratch data;
  data.write("case/system/controlDict", "FoamFile {}");
  data.write("case/processor0/constant/heater/polyMesh/points", "points");
  data.write("case/processor0/0.5/heater/T", "one");
  for (const char* name : {"case/processor0/0.5/heater/T", "case/processor0/constant/heater/polyMesh/points"}) {
    const auto before = source_files(data / "case");
    ASSERT_TRUE(before);
    data.write(name, "other values");
    EXPECT_NE(source_files(data / "case"), before) << name;
  }
}

}  // namespace
}  // namespace isostrata
