// Folders of Zarr that the tests write byte by byte: what is damaged, hostile or not read. What Zarr's own library writes is in foreign_formats_test.cpp.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "data/files.h"
#include "data/files/list_folder.h"
#include "data/files/recognise.h"
#include "data/files/source_files.h"
#include "data/files/zarr_folder.h"
#include "support/mutated_files.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using test::gzip;
using test::open;
using test::refusal;
using test::Scratch;

constexpr int kX = 3, kY = 2, kZ = 4, kLayers = 3;  // of the array; layers of a chunk, so that the second has two beyond the end

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  if (at == std::string::npos) ADD_FAILURE() << "no " << what << " in " << text;
  return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

const std::string kArray = R"({"zarr_format":2,"shape":[4,2,3],"chunks":[3,2,3],"dtype":"<u2","compressor":null,"fill_value":7,"order":"C","filters":null})";
const std::string kArray3 = R"({"zarr_format":3,"node_type":"array","shape":[4,2,3],"data_type":"uint16","chunk_grid":{"name":"regular","configuration":{"chunk_shape":[3,2,3]}},)"
                            R"("chunk_key_encoding":{"name":"default","configuration":{"separator":"/"}},"fill_value":7,"codecs":[{"name":"bytes","configuration":{"endian":"little"}}],"attributes":{}})";
const std::string kScales = R"({"multiscales":[{"version":"0.4","axes":[{"name":"z","type":"space"},{"name":"y","type":"space"},{"name":"x","type":"space"}],)"
                            R"("datasets":[{"path":"0","coordinateTransformations":[{"type":"scale","scale":[4,2,1]}]}]}]})";

/// Value x + 10 y + 100 z at each place of a chunk, also beyond the array's end.
std::string chunk(int first_layer, bool big = false) {
  std::string bytes;
  for (int z = first_layer; z < first_layer + kLayers; ++z)
    for (int y = 0; y < kY; ++y)
      for (int x = 0; x < kX; ++x) test::put(bytes, static_cast<std::uint16_t>(x + 10 * y + 100 * z), big);
  return bytes;
}

/// An array that is as it should be, but for the metadata.
fs::path write_array(const Scratch& scratch, const std::string& metadata = kArray, const std::string& name = "a.zarr") {
  scratch.write(name + "/.zarray", metadata);
  scratch.write(name + "/0.0.0", chunk(0));
  scratch.write(name + "/1.0.0", chunk(kLayers));
  return scratch / name;
}

fs::path write_array_3(const Scratch& scratch, const std::string& metadata, const std::string& first, const std::string& second) {
  scratch.write("a.zarr/zarr.json", metadata);
  scratch.write("a.zarr/c/0/0/0", first);
  scratch.write("a.zarr/c/1/0/0", second);
  return scratch / "a.zarr";
}

fs::path write_image(const Scratch& scratch, const std::string& attributes = kScales) {
  scratch.write("i.zarr/.zgroup", R"({"zarr_format":2})");
  scratch.write("i.zarr/.zattrs", attributes);
  write_array(scratch, kArray, "i.zarr/0");
  return scratch / "i.zarr";
}

void expect_values(const Dataset& data) {
  ASSERT_EQ(data.grid.dims(), (std::array<std::int64_t, 3>{kX, kY, kZ}));
  for (std::int64_t p = 0; p < data.grid.point_count(); ++p)
    EXPECT_EQ(data.arrays.front().at(static_cast<std::size_t>(p)), static_cast<double>(p % kX + 10 * (p / kX % kY) + 100 * (p / (kX * kY)))) << p;
}

/// The sum bit by bit, as RFC 3720 defines it.
std::string with_crc32c(const std::string& bytes) {
  std::uint32_t crc = ~0u;
  for (const unsigned char byte : bytes)
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (((crc ^ (byte >> bit)) & 1) ? 0x82f63b78u : 0u);
  std::string out = bytes;
  test::put(out, ~crc);
  return out;
}

std::string codecs(const std::string& list) { return replaced(kArray3, R"([{"name":"bytes","configuration":{"endian":"little"}}])", "[" + list + "]"); }

void expect_refused(const fs::path& path, ErrorCode code, const std::string& file, const std::string& why, const OpenOptions& options = {}) {
  const Error error = refusal(path, options);
  EXPECT_EQ(error.code(), code) << error.what();
  EXPECT_NE(std::string(error.what()).find(file), std::string::npos) << error.what();
  EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << "expected: " << why << "\ngot: " << error.what();
}

TEST(Zarr, TheSameArrayIsTheSameInBothVersionsAndByEveryWayToWriteIt) {
  const std::string little = R"({"name":"bytes","configuration":{"endian":"little"}})";
  {
    const Scratch scratch;
    expect_values(*open(write_array(scratch)));
  }
  const std::string big = R"({"name":"bytes","configuration":{"endian":"big"}})";
  using Packed = std::array<std::string, 3>;
  for (const auto& [metadata, first, second] : std::vector<Packed>{
           {kArray3, chunk(0), chunk(kLayers)},
           {codecs(big), chunk(0, true), chunk(kLayers, true)},
           {codecs(little + R"(,{"name":"gzip","configuration":{"level":1}})"), gzip(chunk(0)), gzip(chunk(kLayers))},
           {codecs(little + R"(,{"name":"gzip"})"), gzip(chunk(0).substr(0, 10)) + gzip(chunk(0).substr(10)), gzip(chunk(kLayers))},
           {codecs(little + R"(,{"name":"crc32c"})"), with_crc32c(chunk(0)), with_crc32c(chunk(kLayers))},
           {codecs(little + R"(,{"name":"gzip"},{"name":"crc32c"})"), with_crc32c(gzip(chunk(0))), with_crc32c(gzip(chunk(kLayers)))},
           {codecs(little + R"(,{"name":"crc32c"},{"name":"gzip"})"), gzip(with_crc32c(chunk(0))), gzip(with_crc32c(chunk(kLayers)))}}) {
    SCOPED_TRACE(metadata);
    const Scratch scratch;
    expect_values(*open(write_array_3(scratch, metadata, first, second)));
  }
}

TEST(Zarr, MissingChunksHoldTheFillValueAndAreCounted) {
  const Scratch scratch;
  const fs::path path = write_array(scratch);
  fs::remove(path / "1.0.0");
  const auto data = open(path);
  for (int p = 0; p < kX * kY; ++p) EXPECT_EQ(data->arrays.front().at(static_cast<std::size_t>(p + kX * kY * kLayers)), 7);
  EXPECT_EQ(data->arrays.front().at(17), 212);
  EXPECT_TRUE(std::any_of(data->notes.begin(), data->notes.end(), [](const std::string& note) { return note.starts_with("1 of 2 chunks"); }));
}

TEST(Zarr, AFillValueMayBeNoNumberWithOrWithoutQuotes) {
  for (const auto& [word, fill] : {std::pair{"NaN", std::nan("")}, std::pair{R"("NaN")", std::nan("")}, std::pair{"-Infinity", -std::numeric_limits<double>::infinity()},
                                   std::pair{R"("Infinity")", std::numeric_limits<double>::infinity()}, std::pair{"-2.5e3", -2500.0}}) {
    SCOPED_TRACE(word);
    const Scratch scratch;
    const std::string real = replaced(replaced(kArray, "<u2", "<f4"), "\"fill_value\":7", R"("name":"\" NaN","fill_value":)" + std::string(word));
    scratch.write("a.zarr/.zarray", replaced(real, "[3,2,3]", "[2,2,3]"));
    scratch.write("a.zarr/0.0.0", std::string(2 * kX * kY * 4, '\0'));
    const double found = open(scratch / "a.zarr")->arrays.front().at(20);
    EXPECT_TRUE(std::isnan(fill) ? std::isnan(found) : found == fill) << found;
  }
}

TEST(Zarr, MetadataThatMakesNoSenseIsRefusedByName) {
  using Case = std::array<std::string, 3>;  // what of the metadata, by what, the words of the error
  for (const auto& [what, by, why] : std::vector<Case>{
           {"[4,2,3]", "[0,2,3]", "'shape' has 0"},
           {"[4,2,3]", "[-4,2,3]", "'shape' has -4"},
           {"[4,2,3]", "[4.5,2,3]", "'shape' has 4.5"},
           {"[4,2,3]", "[]", "expected 'shape'"},
           {"[4,2,3]", "7", "expected 'shape'"},
           {"[4,2,3]", "[1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1]", "expected 'shape'"},
           {"[4,2,3]", "[4000000000000000000,4000000000000000000,3]", "makes no sense"},
           {"[3,2,3]", "[0,2,3]", "'chunks' has 0"},
           {"[3,2,3]", "[3,2]", "3 axes with chunks of 2"},
           {"[3,2,3]", "[3000000000,3000000000,3000000000]", "makes no sense"},
           {"\"<u2\"", "null", "expected 'dtype'"},
           {"\"C\"", "\"K\"", "expected C or F"},
           {"null}", R"(null,"dimension_separator":"x"})", "expected . or /"},
           {":7,", ":70000,", "'fill_value' is 70000"},
           {":7,", ":-1,", "'fill_value' is -1"},
           {":7,", ":1.5,", "'fill_value' is 1.5"},
           {":7,", R"(:"NaN",)", "'fill_value' is"},
           {":2,", ":3,", "expected 'zarr_format' 2"},
           {"null}", "null", "is not valid JSON"},
           {"7", std::string(100, '[') + std::string(100, ']'), "is not valid JSON"}}) {
    SCOPED_TRACE(by);
    const Scratch scratch;
    expect_refused(write_array(scratch, replaced(kArray, what, by)), ErrorCode::bad_data, "a.zarr/.zarray", why);
  }
  const Scratch scratch;
  expect_refused(write_array(scratch, "[1]"), ErrorCode::bad_data, "a.zarr/.zarray", "expected an object");
  expect_refused(write_array(scratch, std::string((16u << 20) + 1, ' ')), ErrorCode::bad_data, "a.zarr/.zarray", "expected at most");
}

TEST(Zarr, WhatIsNotReadIsRefusedByItsName) {
  using Case = std::array<std::string, 3>;
  for (const auto& [what, by, why] : std::vector<Case>{{"\"<u2\"", "\"<c8\"", "'c8'"},
                                                       {"\"<u2\"", "\"|S12\"", "S12"},
                                                       {"\"<u2\"", R"([["r","<u1"],["g","<u1"]])", "one number in each point"},
                                                       {"\"compressor\":null", R"("compressor":{"id":"lzma"})", "'lzma'"},
                                                       {"\"filters\":null", R"("filters":[{"id":"delta"}])", "the filter 'delta'"},
                                                       {"\"filters\":null", R"("filters":[{"id":"fixedscaleoffset","astype":"|u1","scale":10,"offset":0}])", "expected whole numbers of real ones"},
                                                       {"\"filters\":null", R"("filters":[{"id":"categorize"}])", "the filter 'categorize'"}}) {
    SCOPED_TRACE(by);
    const Scratch scratch;
    expect_refused(write_array(scratch, replaced(kArray, what, by)), ErrorCode::unsupported, "a.zarr/.zarray", why);
  }
  const std::string bytes = R"({"name":"bytes","configuration":{"endian":"little"}})";
  for (const auto& [what, by, why] : std::vector<Case>{
           {"\"uint16\"", "\"complex64\"", "'complex64'"},
           {"\"regular\"", "\"rectangular\"", "a chunk_grid 'rectangular'"},
           {"\"default\"", "\"fanout\"", "a chunk_key_encoding 'fanout'"},
           {"\"attributes\"", R"("storage_transformers":[{"name":"x"}],"attributes")", "storage_transformers"},
           {bytes, bytes + R"(,{"name":"pcodec"})", "'pcodec'"},
           {bytes, bytes + R"(,{"name":"gzip"},{"name":"zstd"})", "packed twice"}}) {
    SCOPED_TRACE(by);
    const Scratch scratch;
    expect_refused(write_array_3(scratch, replaced(kArray3, what, by), chunk(0), chunk(kLayers)), ErrorCode::unsupported, "a.zarr/zarr.json", why);
  }
  for (const auto& [what, by, why] : std::vector<Case>{{bytes, R"({"name":"bytes"})", "no order of bytes"},
                                                       {bytes, R"({"name":"gzip"})", "comes before 'bytes'"},
                                                       {bytes, R"({"name":"transpose","configuration":{"order":[0,1,1]}},)" + bytes, "no list of all axes"},
                                                       {"[" + bytes + "]", "[]", "expected 'codecs'"}}) {
    SCOPED_TRACE(by);
    const Scratch scratch;
    expect_refused(write_array_3(scratch, replaced(kArray3, what, by), chunk(0), chunk(kLayers)), ErrorCode::bad_data, "a.zarr/zarr.json", why);
  }
}

TEST(Zarr, SizesBeyondTheLimitAreRefusedBeforeAnyMemoryIsTaken) {
  const Scratch scratch;
  OpenOptions options;
  options.max_bytes = 256u << 20;
  for (const auto& [what, by] : {std::pair{"[4,2,3]", "[1000000,1000,1000]"}, std::pair{"[3,2,3]", "[1000000,1000,1000]"}, std::pair{"[3,2,3]", "[1000000000000,2,3]"}})
    expect_refused(write_array(scratch, replaced(kArray, what, by)), ErrorCode::too_large, "a.zarr", "the limit is", options);
  const std::string many = replaced(replaced(kArray, "[4,2,3]", "[4000,2000,2]"), "[3,2,3]", "[1,1,1]");
  const std::string empty = replaced(replaced(kArray, "[4,2,3]", "[1000,1000,1000]"), "[3,2,3]", "[100,100,100]");
  options.max_bytes = std::uint64_t{4} << 30;
  const fs::path path = write_array(scratch, empty);
  for (const char* file : {"0.0.0", "1.0.0"}) fs::remove(path / file);
  expect_refused(path, ErrorCode::too_large, "a.zarr/.zarray", "1000 of 1000 chunks are not there", options);
  expect_refused(write_array(scratch, many), ErrorCode::too_large, "a.zarr/.zarray", "16000000 chunks", options);
}

TEST(Zarr, DamagedChunksAreRefusedByTheirFile) {
  const auto packed = [](const std::string& id) { return replaced(kArray, "\"compressor\":null", R"("compressor":{"id":")" + id + "\"}"); };
  std::string blosc(16, '\0');  // version, format of the inner codec, flags, width, bytes, bytes of a block, bytes packed
  blosc[0] = blosc[1] = blosc[3] = 2;
  for (const auto& [at, value] : {std::pair{4, 0x40000000u}, std::pair{8, 0x1000u}, std::pair{12, 16u}})
    for (int b = 0; b < 4; ++b) blosc[static_cast<std::size_t>(at + b)] = static_cast<char>(value >> (8 * b));
  const std::string bomb = gzip(std::string(100u << 20, '\0')), zstd_of_4_gb("\x28\xb5\x2f\xfd\xe0\x00\x00\x00\x00\x01\x00\x00\x00\x03\x00\x00", 16);
  for (const auto& [metadata, bytes, why] : std::vector<std::array<std::string, 3>>{{kArray, chunk(0).substr(1), "has 35 bytes; expected 36"},
                                                                                    {kArray, chunk(0) + "x", "has 37 bytes; expected 36"},
                                                                                    {kArray, "", "has 0 bytes; expected 36"},
                                                                                    {kArray, std::string(2u << 20, 'x'), "expected at most"},
                                                                                    {packed("gzip"), bomb, "expected 36 bytes packed by gzip"},
                                                                                    {packed("zlib"), gzip(chunk(0)).substr(0, 20), "damaged or cut off"},
                                                                                    {packed("gzip"), gzip(chunk(0).substr(2)), "found 34"},
                                                                                    {packed("gzip"), gzip(chunk(0)) + gzip("x"), "expected 36"},
                                                                                    {packed("zstd"), zstd_of_4_gb, "expected 36 bytes packed by zstd"},
                                                                                    {packed("zstd"), chunk(0), "packed by zstd"},
                                                                                    {packed("blosc"), blosc, "packed by blosc"},
                                                                                    {packed("blosc"), "x", "packed by blosc"},
                                                                                    {packed("lz4"), std::string("\xff\xff\xff\x7f", 4) + chunk(0), "packed by lz4"},
                                                                                    {packed("lz4"), std::string("\x24\0\0\0", 4) + chunk(0), "packed by lz4"},
                                                                                    {packed("bz2"), "BZh9" + chunk(0), "packed by bz2"}}) {
    SCOPED_TRACE(why);
    const Scratch scratch;
    const fs::path path = write_array(scratch, metadata);
    fs::remove(path / "1.0.0");
    scratch.write("a.zarr/0.0.0", bytes);
    expect_refused(path, ErrorCode::bad_data, "a.zarr/0.0.0", why);
  }
  const Scratch scratch;
  std::string sum = with_crc32c(chunk(0));
  sum[3] ^= 1;
  const std::string metadata = codecs(R"({"name":"bytes","configuration":{"endian":"little"}},{"name":"crc32c"})");
  expect_refused(write_array_3(scratch, metadata, sum, ""), ErrorCode::bad_data, "a.zarr/c/0/0/0", "its sum");
  fs::remove(scratch / "a.zarr/c/0/0/0");
  fs::create_directory(scratch / "a.zarr/c/0/0/0");
  expect_refused(scratch / "a.zarr", ErrorCode::bad_data, "a.zarr/c/0/0/0", "not a regular file");
}

TEST(Zarr, NothingOutsideOfTheFolderIsRead) {
  for (const char* strictness : {"try", "off"}) {
    SCOPED_TRACE(strictness);
    setenv("ISOSTRATA_SANDBOX", strictness, 1);
    const Scratch scratch;
    write_array(scratch, kArray, "outside");
    for (const std::string path : {"..", "../..", "../outside", "0/../../outside", "/etc"}) {
      const std::string scales = replaced(kScales, "\"path\":\"0\"", "\"path\":\"" + path + "\"");
      expect_refused(write_image(scratch, scales), ErrorCode::bad_data, ".zattrs", "below its own directory");
    }
    write_image(scratch);
    fs::remove_all(scratch / "i.zarr/0");
    fs::create_directory_symlink(scratch / "outside", scratch / "i.zarr/0");
    expect_refused(scratch / "i.zarr", ErrorCode::bad_data, "i.zarr/0", "by a link");
    write_array(scratch);
    fs::remove(scratch / "a.zarr/1.0.0");
    fs::create_symlink(scratch / "outside/1.0.0", scratch / "a.zarr/1.0.0");
    expect_refused(scratch / "a.zarr", ErrorCode::bad_data, "a.zarr/1.0.0", "by a link");
    fs::remove(scratch / "a.zarr/1.0.0");
    scratch.write("a.zarr/elsewhere", chunk(kLayers));
    fs::create_symlink("elsewhere", scratch / "a.zarr/1.0.0");  // a link that stays inside
    expect_values(*open(scratch / "a.zarr"));
  }
  unsetenv("ISOSTRATA_SANDBOX");
}

TEST(Zarr, AnImageSaysWhatIsWrongWithItsAxesAndPlaces) {
  using Case = std::array<std::string, 3>;
  for (const auto& [what, by, why] : std::vector<Case>{
           {R"("path":"0",)", "", "no 'path'"},
           {R"("path":"0")", R"("path":"9")", "expected .zarray or zarr.json in it"},
           {"[4,2,1]", "[4,2]", "no list of 3 numbers"},
           {"[4,2,1]", R"([4,2,"1"])", "something that is not a number"},
           {"[4,2,1]", "[4,2,0]", "a space direction of (0,0,0)"},
           {R"({"name":"z","type":"space"},)", "", "no list of 2 numbers"},
           {R"("name":"z",)", "", "an axis has no name"},
           {R"("datasets")", R"("data")", "has no 'datasets'"}}) {
    SCOPED_TRACE(by + why);
    const Scratch scratch;
    expect_refused(write_image(scratch, replaced(kScales, what, by)), ErrorCode::bad_data, "i.zarr", why);
  }
  const Scratch fewer;
  const std::string unplaced = replaced(kScales, R"({"type":"scale","scale":[4,2,1]})", "");
  expect_refused(write_image(fewer, replaced(unplaced, R"({"name":"z","type":"space"},)", "")), ErrorCode::bad_data, "i.zarr/0/.zarray", "'multiscales' names 2");
  for (const auto& [what, by, why] : std::vector<Case>{{R"("type":"scale")", R"("type":"rotation")", "'rotation'"},
                                                       {R"("z","type":"space")", R"("z","type":"wavelength")", "the axis 'z' has 4 places"},
                                                       {R"("z","type":"space"},{"name":"y","type":"space")", R"("z","type":"time"},{"name":"y","type":"time")", "two axes of time"}}) {
    SCOPED_TRACE(by);
    const Scratch scratch;
    expect_refused(write_image(scratch, replaced(kScales, what, by)), ErrorCode::unsupported, "i.zarr", why);
  }
}

TEST(Zarr, ALevelHasItsPlaceFromTheFolderAboveUnlessALinkLeadsOut) {
  for (const char* strictness : {"try", "off"}) {
    SCOPED_TRACE(strictness);
    setenv("ISOSTRATA_SANDBOX", strictness, 1);
    const Scratch scratch;
    write_image(scratch);
    EXPECT_EQ(open(scratch / "i.zarr/0")->bounds.upper, (Vec3d{kX - 1, 2 * (kY - 1), 4 * (kZ - 1)}));
    fs::rename(scratch / "i.zarr/.zattrs", scratch / "secret");
    fs::create_symlink(scratch / "secret", scratch / "i.zarr/.zattrs");
    const auto alone = open(scratch / "i.zarr/0");
    EXPECT_EQ(alone->bounds.upper, (Vec3d{kX - 1, kY - 1, kZ - 1}));
    EXPECT_TRUE(std::any_of(alone->notes.begin(), alone->notes.end(), [](const std::string& note) { return note.starts_with("an array alone"); }));
  }
  unsetenv("ISOSTRATA_SANDBOX");
}

TEST(Zarr, FoldersThatAreNoImageSayWhatToOpen) {
  const Scratch scratch;
  scratch.write("p.zarr/.zattrs", R"({"plate":{"wells":[]}})");
  expect_refused(scratch / "p.zarr", ErrorCode::unsupported, "p.zarr", "a plate of wells");
  scratch.write("g.zarr/.zgroup", R"({"zarr_format":2})");
  write_array(scratch, kArray, "g.zarr/temperature");
  expect_refused(scratch / "g.zarr", ErrorCode::unsupported, "g.zarr", "open one of them: g.zarr/temperature");
  fs::create_directory(scratch / "e.zarr");
  expect_refused(scratch / "e.zarr", ErrorCode::bad_data, "e.zarr", "expected .zarray, .zattrs or zarr.json");
  expect_refused(scratch.write("f.zarr", "x"), ErrorCode::bad_data, "f.zarr", "expected a folder");
  expect_refused(scratch.write("z.zarr.zip", "PK"), ErrorCode::unsupported, "z.zarr.zip", "unpack it into a folder");
  write_image(scratch);
  scratch.write("b.zarr/.zattrs", R"({"bioformats2raw.layout":3})");
  fs::rename(scratch / "i.zarr", scratch / "b.zarr/0");
  expect_values(*open(scratch / "b.zarr"));
}

TEST(Zarr, MutatedFoldersEndInADatasetOrAnError) {
  const std::string packed = replaced(kArray, "\"compressor\":null", R"("compressor":{"id":"gzip"})");
  int opened = 0, refused = 0;
  for (unsigned round = 0; round < 120; ++round) {
    std::mt19937 random(round + 4711);
    const Scratch scratch;
    std::vector<std::pair<std::string, std::string>> files;
    if (round % 2)
      files = {{".zattrs", kScales}, {"0/.zarray", packed}, {"0/0.0.0", gzip(chunk(0))}, {"0/1.0.0", gzip(chunk(kLayers))}};
    else
      files = {{"zarr.json", kArray3}, {"c/0/0/0", chunk(0)}, {"c/1/0/0", chunk(kLayers)}};
    auto& [name, bytes] = files[round / 2 % files.size()];
    bytes = testing::mutated(bytes, random);
    for (const auto& [file, contents] : files) scratch.write("m.zarr/" + file, contents);
    OpenOptions options;
    options.max_bytes = 256u << 20;
    options.timeout_s = 20;
    try {
      open_dataset((scratch / "m.zarr").string(), options, Task());
      ++opened;
    } catch (const Error& error) {
      EXPECT_NE(error.code(), ErrorCode::internal) << "round " << round << ": " << error.what();
      for (const char* never : {"ended after", "crashed", "\n"}) EXPECT_EQ(std::string(error.what()).find(never), std::string::npos) << "round " << round << ": " << error.what();
      ++refused;
    }
  }
  std::printf("  120 mutated folders: %d opened, %d refused\n", opened, refused);
  EXPECT_EQ(opened + refused, 120);
  EXPECT_GT(refused, 30);
}

TEST(Zarr, AFolderIsOneEntryWhoseMetadataIsFollowedAndWhoseInsideIsNot) {
  const Scratch scratch;
  write_image(scratch);
  write_array(scratch, kArray, "bare");
  write_array(scratch, kArray, "group/one");
  scratch.write("group/.zgroup", R"({"zarr_format":2})");
  const auto entry = [&](const std::string& name) {
    const FolderListing listing = list_folder(scratch.path());
    EXPECT_EQ(listing.entries.size(), 3u);
    for (const FolderEntry& of : listing.entries) {
      EXPECT_EQ(of.kind, FileKind::zarr) << of.name;
      EXPECT_EQ(of.files, 1);
      if (of.name == name) return of;
    }
    ADD_FAILURE() << name << " is not listed";
    return FolderEntry{};
  };
  entry("bare");
  entry("group/one");
  const FolderEntry before = entry("i.zarr");
  EXPECT_EQ(entry("i.zarr").mark, before.mark);
  scratch.write("i.zarr/.zattrs", kScales + "\n");
  const FolderEntry after = entry("i.zarr");
  EXPECT_NE(after.mark, before.mark);
  EXPECT_TRUE(after.writing);  // until it was quiet for a while
  scratch.write("i.zarr/1/.zarray", kArray);
  const FolderEntry more = entry("i.zarr");
  EXPECT_NE(more.mark, after.mark);
  std::uint64_t bytes = 0;
  for (const auto& file : fs::recursive_directory_iterator(scratch / "i.zarr"))
    if (file.is_regular_file()) bytes += file.file_size();
  EXPECT_EQ(more.bytes, bytes) << "chunks too";
  scratch.write("i.zarr/0/0.0.0", chunk(0) + "x");
  EXPECT_EQ(entry("i.zarr").bytes, bytes + 1);
  EXPECT_NE(entry("i.zarr").mark, more.mark);
}

TEST(Zarr, WhatIsKeptOfAFolderIsForgottenWithAnyOfItsChunks) {
  const Scratch scratch;
  write_array_3(scratch, kArray3, chunk(0), chunk(kLayers));
  const auto before = source_files(scratch / "a.zarr");
  ASSERT_TRUE(before);
  EXPECT_EQ(source_files(scratch / "a.zarr"), before);
  scratch.write("a.zarr/c/1/0/0", chunk(kLayers) + "x");  // four folders down
  EXPECT_NE(source_files(scratch / "a.zarr"), before);
}

}  // namespace
}  // namespace isostrata
