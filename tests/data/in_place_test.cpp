// Large raw values are mapped where they lie; everything else is copied as before.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <bit>
#include <chrono>
#include <cstring>
#include <fstream>

#include "data/dataset/dataset_bytes.h"
#include "data/files.h"
#include "data/open/import_cache.h"
#include "data/open/import_door.h"
#include "data/values/histogram.h"
#include "data/values/kept_facts.h"
#include "data/values/source_mapping.h"
#include "support/places.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using test::Scratch;

constexpr std::int64_t kPlane = 1024 * 512, kLayers = 130;  // 65 MiB of bytes, mostly a hole in the file

struct InPlace : ::testing::Test {
  Scratch data;
  OpenOptions options;
  InPlace() { options.importer = fs::path(isostrata::places::binaries()) / "isostrata-import"; }

  /// `head`, then zeros but for one value in the first and in the last layer.
  template <class T>
  fs::path write(const std::string& name, const std::string& head, T first, T last, std::int64_t layers = kLayers) {
    const fs::path path = data / name;
    std::ofstream out(path, std::ios::binary);
    out << head;
    const auto put = [&](std::int64_t at, T value) {
      out.seekp(static_cast<std::streamoff>(head.size()) + at * static_cast<std::int64_t>(sizeof(T)));
      out.write(reinterpret_cast<const char*>(&value), sizeof value);
    };
    put(5, first);
    put(kPlane * layers - 7, last);
    put(kPlane * layers - 1, T{});
    return path;
  }
  std::string nrrd(const std::string& type, const std::string& more = "", std::int64_t layers = kLayers) {
    return "NRRD0004\ntype: " + type + "\ndimension: 3\nsizes: 1024 512 " + std::to_string(layers) + "\nencoding: raw\n" + more + "\n";
  }
  /// A header of 34 layers of floats whose length leaves this remainder of 4.
  std::string floats(std::size_t remainder) {
    std::string head;
    for (std::string fill; (head = nrrd("float", "endian: little\nx:=" + fill + "\n", 34)).size() % 4 != remainder;) fill += 'x';
    return head;
  }
  bool is_in_place(const Dataset& dataset) {
    return std::visit([](auto values) { return is_in_source(values.data()); }, dataset.arrays.at(0).values);
  }
  void expect_facts(const fs::path& file, bool in_place, double lower, double upper, std::int64_t layers = kLayers) {
    const auto dataset = open_import(file, options, Task());
    ASSERT_EQ(dataset->arrays.size(), 1u) << file;
    EXPECT_EQ(dataset->grid.dims(), (std::array<std::int64_t, 3>{1024, 512, layers})) << file;
    EXPECT_EQ(dataset->arrays[0].lower, lower) << file;
    EXPECT_EQ(dataset->arrays[0].upper, upper) << file;
    EXPECT_EQ(dataset->arrays[0].at(5), lower) << file;
    EXPECT_EQ(dataset->arrays[0].at(static_cast<std::size_t>(kPlane * layers - 7)), upper) << file;
    EXPECT_EQ(is_in_place(*dataset), in_place) << file;
    EXPECT_TRUE(!in_place || dataset_bytes(*dataset) < 1u << 20) << file << ": " << dataset_bytes(*dataset) << " bytes";
  }
  std::string vti(std::int64_t layers, const std::string& type, const std::string& order, const std::string& offset) {
    const std::string extent = "0 1023 0 511 0 " + std::to_string(layers - 1);
    return "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"" + order + "\" header_type=\"UInt64\">\n<ImageData WholeExtent=\"" +
           extent + "\" Origin=\"1 2 3\" Spacing=\"0.5 1 2\">\n<Piece Extent=\"" + extent + "\">\n<PointData Scalars=\"f\"><DataArray type=\"" + type +
           "\" Name=\"f\" format=\"appended\" offset=\"" + offset +
           "\"/></PointData>\n<CellData></CellData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n";
  }
  /// The head, spaces so that values are aligned, the mark, the array's length.
  std::string with_length(std::string head, std::uint64_t bytes, std::size_t off = 0) {
    while ((head.size() + 1) % 8 != off) head += ' ';
    head += '_';
    head.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    return head;
  }
};

TEST_F(InPlace, RawNrrdIsMappedWhereItLies) {
  expect_facts(write<std::int8_t>("bytes.nrrd", nrrd("int8"), -3, 9), true, -3, 9);
  expect_facts(write<float>("floats.nrrd", floats(0), -2.5f, 7.25f, 34), true, -2.5, 7.25, 34);
  const fs::path raw = write<std::uint8_t>("detached.raw", "", 0, 200);
  data.write("detached.nhdr", nrrd("uint8", "data file: detached.raw\n"));
  expect_facts(data / "detached.nhdr", true, 0, 200);
}

TEST_F(InPlace, WhatIsNotAsInMemoryIsCopied) {
  expect_facts(write<float>("odd.nrrd", floats(1), -2.5f, 7.25f, 34), false, -2.5, 7.25, 34);
  const auto swapped = [](float value) { return std::bit_cast<float>(__builtin_bswap32(std::bit_cast<std::uint32_t>(value))); };
  expect_facts(write<float>("big.nrrd", nrrd("float", "endian: big\n", 34), swapped(-2.5f), swapped(7.25f), 34), false, -2.5, 7.25, 34);
  expect_facts(write<std::int8_t>("small.nrrd", nrrd("int8", "", 4), -3, 9, 4), false, -3, 9, 4);
}

TEST_F(InPlace, WhatIsUnpackedBesideTheFileIsCopied) {
  const testing::OwnTemporaryPlace temporary;
  const fs::path file = temporary.path() / "packed.nrrd.gz";
  const std::string head = nrrd("int8");
  gzFile out = gzopen(file.c_str(), "wb1");
  ASSERT_TRUE(out);
  gzwrite(out, head.data(), static_cast<unsigned>(head.size()));
  std::vector<char> layer(static_cast<std::size_t>(kPlane));
  for (std::int64_t k = 0; k < kLayers; ++k) {
    layer[5] = k == 0 ? -3 : 0;
    layer[layer.size() - 7] = k + 1 == kLayers ? 9 : 0;
    gzwrite(out, layer.data(), static_cast<unsigned>(layer.size()));
  }
  gzclose(out);
  expect_facts(file, false, -3, 9);
}

TEST_F(InPlace, AppendedRawImagesAreMappedAndLieWhereVtkPlacesThem) {
  const std::uint64_t bytes = static_cast<std::uint64_t>(kPlane * kLayers);
  const fs::path file = write<std::int8_t>("image.vti", with_length(vti(kLayers, "Int8", "LittleEndian", "0"), bytes), -3, 9);
  expect_facts(file, true, -3, 9);
  const auto dataset = open_import(file, options, Task());
  EXPECT_EQ(dataset->arrays[0].name, "f");
  EXPECT_EQ(dataset->bounds.lower, (Vec3d{1, 2, 3}));
  EXPECT_EQ(dataset->bounds.upper, (Vec3d{1 + 511.5, 2 + 511, 3 + 2.0 * (kLayers - 1)}));
  const std::uint64_t words = static_cast<std::uint64_t>(kPlane * 66 * 2);
  expect_facts(write<std::int16_t>("words.vti", with_length(vti(66, "Int16", "LittleEndian", "0"), words), -300, 900, 66), true, -300, 900, 66);
  expect_facts(write<std::int16_t>("odd.vti", with_length(vti(66, "Int16", "LittleEndian", "0"), words, 1), -300, 900, 66), false, -300, 900, 66);
}

TEST_F(InPlace, CellsOfAnImageAreMappedAndTheirMeansAreThoseOfTheDefinition) {
  constexpr std::uint64_t kCells = 1023 * 511 * std::uint64_t{kLayers - 1}, kPoints = static_cast<std::uint64_t>(kPlane * kLayers);
  std::string head = vti(kLayers, "Int8", "LittleEndian", "0");
  const std::string array = head.substr(head.find("<DataArray"), head.find("</PointData>") - head.find("<DataArray"));
  head.replace(head.find("<PointData"), head.find("</CellData>") - head.find("<PointData"), "<CellData Scalars=\"f\">" + array);
  for (const std::size_t off : {0u, 4u}) {  // bytes may lie anywhere
    const std::string whole = with_length(head, kCells, off);
    const fs::path file = data / "cells.vti";
    std::ofstream(file, std::ios::binary) << whole;
    fs::resize_file(file, whole.size() + kCells);
    std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
    out.seekp(static_cast<std::streamoff>(whole.size())).put(8);
    out.seekp(static_cast<std::streamoff>(whole.size() + kCells - 1)).put(-64);
    out.close();
    const auto dataset = open_import(file, options, Task());
    ASSERT_EQ(dataset->arrays.size(), 1u);
    const PointArray& of = dataset->arrays[0];
    ASSERT_TRUE(of.cells);
    EXPECT_TRUE(std::visit([](auto values) { return is_in_source(values.data()); }, of.cells->values));
    EXPECT_EQ(std::visit([](auto values) { return values.size(); }, of.cells->values), kCells);
    EXPECT_EQ(of.cells->lower, -64);
    EXPECT_EQ(of.cells->upper, 8);
    EXPECT_EQ(of.type, ScalarType::float32);
    EXPECT_EQ(of.at(0), 8);  // a corner has one cell
    EXPECT_EQ(of.at(1), 4);  // an edge two
    EXPECT_EQ(of.at(1 + 1024), 2);
    EXPECT_EQ(of.at(1 + 1024 + kPlane), 1);
    EXPECT_EQ(of.at(kPoints - 1), -64);
    EXPECT_EQ(of.at(kPoints - 2 - 1024), -16);
    EXPECT_EQ(of.at(kPoints - 2 - 1024 - kPlane), -8);
    EXPECT_EQ(of.lower, -64);
    EXPECT_EQ(of.upper, 8);
    EXPECT_LT(dataset_bytes(*dataset), 4 * kPoints + (1u << 20)) << "the means alone";
  }
}

TEST_F(InPlace, VectorsOfAnImageBesideCellsAreWhatVtksReaderMakesOfThem) {
  constexpr std::int64_t kFew = 12;
  constexpr std::uint64_t kPoints = static_cast<std::uint64_t>(kPlane * kFew), kCells = 1023 * 511 * std::uint64_t{kFew - 1};
  std::vector<float> vectors(3 * kPoints);
  std::vector<std::int16_t> cells(2 * kCells);
  for (std::size_t i = 0; i < vectors.size(); ++i) vectors[i] = static_cast<float>(i % 1013) - 500.25f;
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = static_cast<std::int16_t>(i * i % 30011);
  const std::uint64_t bytes = vectors.size() * sizeof(float), cell_bytes = cells.size() * sizeof(std::int16_t);
  const auto written = [&](const std::string& name, const std::string& last, std::size_t off) {
    std::string head = vti(kFew, "Float32\" NumberOfComponents=\"3", "LittleEndian", "0");
    head.replace(head.find("<CellData>"), 10, "<CellData><DataArray type=\"Int16\" NumberOfComponents=\"2\" Name=\"c\" format=\"appended\" offset=\"" + std::to_string(8 + bytes) + "\"/>" + last);
    const fs::path file = data / name;
    std::ofstream out(file, std::ios::binary);
    out << with_length(head, bytes, off);
    out.write(reinterpret_cast<const char*>(vectors.data()), static_cast<std::streamsize>(bytes));
    out.write(reinterpret_cast<const char*>(&cell_bytes), sizeof cell_bytes);
    out.write(reinterpret_cast<const char*>(cells.data()), static_cast<std::streamsize>(cell_bytes));
    return open_import(file, options, Task());
  };
  // A second array as text in the file, which only VTK's reader takes; it comes last.
  const auto ours = written("ours.vti", "", 0), odd = written("odd.vti", "", 3);
  const auto by_vtk = written("vtk.vti", "<DataArray type=\"UInt8\" Name=\"text\" format=\"ascii\" NumberOfComponents=\"1\">" + [&] {
    std::string zeros(2 * kCells, ' ');
    for (std::size_t i = 0; i < kCells; ++i) zeros[2 * i] = '0';
    return zeros;
  }() + "</DataArray>", 0);
  ASSERT_EQ(by_vtk->arrays.size(), 8u);
  for (const auto& dataset : {ours, odd}) {
    ASSERT_EQ(dataset->arrays.size(), 7u);
    for (std::size_t a = 0; a < 7; ++a) {
      EXPECT_EQ(dataset->arrays[a].name, by_vtk->arrays[a].name);
      EXPECT_TRUE(std::visit([](auto a, auto b) { return std::equal(a.begin(), a.end(), b.begin(), b.end()); }, dataset->arrays[a].values, by_vtk->arrays[a].values)) << dataset->arrays[a].name;
      ASSERT_EQ(dataset->arrays[a].cells == nullptr, by_vtk->arrays[a].cells == nullptr);
      if (dataset->arrays[a].cells) {
        EXPECT_TRUE(std::visit([](auto a, auto b) { return std::equal(a.begin(), a.end(), b.begin(), b.end()); }, dataset->arrays[a].cells->values, by_vtk->arrays[a].cells->values));
      }
    }
  }
}

TEST_F(InPlace, OffsetsAndLengthsThatMakeNoSenseAreErrorsAndNoMaps) {
  const std::uint64_t bytes = static_cast<std::uint64_t>(kPlane * kLayers);
  const auto refused = [&](const std::string& name, const std::string& head) {
    const fs::path file = write<std::int8_t>(name, head, -3, 9);
    try {
      const auto dataset = open_import(file, options, Task());
      EXPECT_FALSE(is_in_place(*dataset)) << name;  // VTK's reader makes what it can of it
    } catch (const Error& error) {
      EXPECT_TRUE(error.code() == ErrorCode::bad_data || error.code() == ErrorCode::too_large) << name << ": " << error.what();
    }
  };
  refused("far.vti", with_length(vti(kLayers, "Int8", "LittleEndian", "18446744073709551000"), bytes));
  refused("beyond.vti", with_length(vti(kLayers, "Int8", "LittleEndian", "99999999999"), bytes));
  refused("length.vti", with_length(vti(kLayers, "Int8", "LittleEndian", "0"), bytes + 8));
  refused("huge.vti", with_length(vti(kLayers, "Int8", "LittleEndian", "0"), ~std::uint64_t{0}));
  const fs::path file = write<std::int8_t>("short.nrrd", nrrd("int8"), -3, 9);
  fs::resize_file(file, fs::file_size(file) - 1);
  try {
    open_import(file, options, Task());
    FAIL() << "one byte is missing";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_data);
    EXPECT_NE(std::string(error.what()).find("present"), std::string::npos) << error.what();
  }
}

TEST_F(InPlace, MetaImagesAreMappedUnlessTheirBytesAreSwapped) {
  const std::string head = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nElementSpacing = 0.5 1 2\nDimSize = 1024 512 ";
  write<std::int8_t>("bytes.raw", "", -3, 9);
  data.write("bytes.mhd", head + std::to_string(kLayers) + "\nElementType = MET_CHAR\nElementDataFile = bytes.raw\n");
  expect_facts(data / "bytes.mhd", true, -3, 9);
  EXPECT_EQ(open_import(data / "bytes.mhd", options, Task())->bounds.upper.z, 2.0 * (kLayers - 1));
  // Few people write the line BinaryData: without it the values are binary, for VTK's reader (of small files) as well.
  const std::string least = "ObjectType = Image\nNDims = 3\nDimSize = ", values = "\nElementType = MET_CHAR\nElementDataFile = bytes.raw\n";
  data.write("least.mhd", least + "1024 512 " + std::to_string(kLayers) + values);
  expect_facts(data / "least.mhd", true, -3, 9);
  data.write("small.mhd", least + "4 4 4" + values);
  const auto small = open_import(data / "small.mhd", options, Task()), whole = open_import(data / "least.mhd", options, Task());
  EXPECT_FALSE(is_in_place(*small));
  for (std::size_t p = 0; p < 64; ++p) EXPECT_EQ(small->arrays[0].at(p), whole->arrays[0].at(p));
  const auto swapped = [](std::int16_t value) { return static_cast<std::int16_t>(__builtin_bswap16(static_cast<std::uint16_t>(value))); };
  write<std::int16_t>("words.raw", "", -300, 900, 66);
  data.write("words.mhd", head + "66\nElementType = MET_SHORT\nElementDataFile = words.raw\n");
  expect_facts(data / "words.mhd", true, -300, 900, 66);
  write<std::int16_t>("swapped.raw", "", swapped(-300), swapped(900), 66);
  std::string msb = head;
  msb.replace(msb.find("False"), 5, "True");
  data.write("swapped.mhd", msb + "66\nElementType = MET_SHORT\nElementDataFile = swapped.raw\n");
  expect_facts(data / "swapped.mhd", false, -300, 900, 66);
  EXPECT_EQ(open_import(data / "words.mhd", options, Task())->arrays[0].name, open_import(data / "swapped.mhd", options, Task())->arrays[0].name);
}

TEST_F(InPlace, NumpyArraysAreMappedIfTheirOrderAndTheirBytesAreOurs) {
  const auto npy = [](const std::string& descr, const std::string& fortran, const std::string& shape) {
    std::string header = "{'descr': '" + descr + "', 'fortran_order': " + fortran + ", 'shape': (" + shape + "), }";
    header.resize(117, ' ');
    header += '\n';  // the numbers begin at 128
    return std::string("\x93NUMPY\1\0", 8) + static_cast<char>(header.size()) + std::string(1, 0) + header;
  };
  const std::string layers = std::to_string(kLayers) + ", 512, 1024";
  expect_facts(write<std::int8_t>("bytes.npy", npy("|i1", "False", layers), -3, 9), true, -3, 9);
  expect_facts(write<float>("floats.npy", npy("<f4", "False", "34, 512, 1024"), -3, 9, 34), true, -3, 9, 34);
  const auto swapped = [](std::int16_t value) { return static_cast<std::int16_t>(__builtin_bswap16(static_cast<std::uint16_t>(value))); };
  expect_facts(write<std::int16_t>("swapped.npy", npy(">i2", "False", "66, 512, 1024"), swapped(-300), swapped(900), 66), false, -300, 900, 66);
  EXPECT_FALSE(is_in_place(*open_import(write<std::int8_t>("fortran.npy", npy("|i1", "True", "1024, 512, " + std::to_string(kLayers)), -3, 9), options, Task())));
  EXPECT_FALSE(is_in_place(*open_import(write<std::int8_t>("vectors.npy", npy("|i1", "False", std::to_string(kLayers) + ", 512, 512, 2"), -3, 9), options, Task())));
}

TEST_F(InPlace, AFileThatIsCutShortEndsWhoReadsItWithItsName) {
  const fs::path file = write<std::uint8_t>("cut.nrrd", nrrd("uint8"), 1, 9);
  int says[2];
  ASSERT_EQ(pipe(says), 0);
  const auto dataset = open_import(file, options, Task());
  ASSERT_TRUE(is_in_place(*dataset));
  const pid_t child = fork();
  if (child == 0) {
    dup2(says[1], STDERR_FILENO);
    if (truncate(file.c_str(), 4096) != 0) _exit(9);
    volatile double sum = 0;
    for (std::size_t p = 0; p < static_cast<std::size_t>(kPlane * kLayers); p += 4096) sum = sum + dataset->arrays[0].at(p);
    _exit(0);
  }
  close(says[1]);
  std::string text;
  char buffer[400];
  for (ssize_t got = 0; (got = read(says[0], buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(got));
  close(says[0]);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 1) << status;
#ifndef ISOSTRATA_SANITIZED  // whose handler comes first
  EXPECT_NE(text.find("cut.nrrd: was cut short"), std::string::npos) << text;
#endif
}

TEST_F(InPlace, AFileMappedInPlaceTakesNoPlaceInTheCacheAndIsOpenedByItsMeasures) {
  const fs::path file = write<std::uint8_t>("kept.nrrd", nrrd("uint8"), 1, 9);
  Scratch where;
  ImportCache cache;
  cache.folder = where / "cache";
  cache.least_seconds = 0;
  cache.max_bytes = 32 << 20;  // less than the file
  const auto first = open_import_cached(file, options, cache, Task());
  EXPECT_TRUE(is_in_place(*first));
  EXPECT_EQ(use_of(cache).entries, 1);
  EXPECT_LT(use_of(cache).bytes, 1u << 20);
  const auto second = open_import_cached(file, options, cache, Task());
  EXPECT_TRUE(is_in_place(*second));
  EXPECT_EQ(second->arrays[0].upper, 9);
  std::fstream change(file, std::ios::in | std::ios::out | std::ios::binary);
  change.seekp(-3, std::ios::end);
  change.put(77);
  change.close();
  fs::last_write_time(file, fs::last_write_time(file) + std::chrono::seconds(1));
  EXPECT_EQ(open_import_cached(file, options, cache, Task())->arrays[0].upper, 77) << "a file that was changed is another one";
}

struct KeptFacts : ::testing::Test {
  Scratch where;
  PointArray array;
  KeptFacts() {
    auto values = std::make_shared<std::vector<std::uint8_t>>(1000);
    for (std::size_t i = 0; i < values->size(); ++i) (*values)[i] = static_cast<std::uint8_t>(i * i % 251);
    array.type = ScalarType::uint8;
    array.values = std::span<const std::uint8_t>(*values);
    array.storage = values;
    measure_range(array);
  }
  static std::vector<std::byte> bytes(const std::string& text) {
    const auto of = std::as_bytes(std::span(text));
    return {of.begin(), of.end()};
  }
};

TEST_F(KeptFacts, ComeBackAsTheyWereAndOnlyForThatArray) {
  keep_fact(array, "a", bytes("nowhere to lie"));
  EXPECT_FALSE(kept_fact(array, "a"));
  set_place_of_facts(array.storage, where.path(), "array_0.");
  EXPECT_FALSE(kept_fact(array, "a"));
  keep_fact(array, "a", bytes("known"));
  EXPECT_EQ(kept_fact(array, "a"), bytes("known"));
  EXPECT_FALSE(kept_fact(array, "b"));
  PointArray other = array;
  other.storage = std::make_shared<int>(0);
  EXPECT_FALSE(kept_fact(other, "a"));
}

TEST_F(KeptFacts, HalfOfOneIsNone) {
  set_place_of_facts(array.storage, where.path(), "array_0.");
  keep_fact(array, "a", bytes("all of it"));
  const fs::path file = where / "array_0.a";
  fs::resize_file(file, fs::file_size(file) - 1);
  EXPECT_FALSE(kept_fact(array, "a"));
  keep_fact(array, "a", bytes("all of it"));
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(9).put('X');
  EXPECT_FALSE(kept_fact(array, "a"));
  fs::resize_file(file, 3);
  EXPECT_FALSE(kept_fact(array, "a"));
}

TEST_F(KeptFacts, AKeptHistogramIsThatOfTheValues) {
  const auto counted = histogram(array, array.lower, array.upper, 64);
  EXPECT_EQ(kept_histogram(array, array.lower, array.upper, 64), counted);
  set_place_of_facts(array.storage, where.path(), "array_0.");
  EXPECT_EQ(kept_histogram(array, array.lower, array.upper, 64), counted);
  EXPECT_TRUE(fs::exists(where / "array_0.histogram-64"));
  const std::vector<std::uint64_t> told(64, 5);
  keep_fact(array, "histogram-64", std::as_bytes(std::span(told)));
  EXPECT_EQ(kept_histogram(array, array.lower, array.upper, 64), told) << "what is kept is not counted again";
  EXPECT_EQ(kept_histogram(array, array.lower, array.upper, 32), histogram(array, array.lower, array.upper, 32));
  EXPECT_EQ(kept_histogram(array, 10, 20, 64), histogram(array, 10, 20, 64)) << "of a part of the range nothing is kept";
}

}  // namespace
}  // namespace isostrata
