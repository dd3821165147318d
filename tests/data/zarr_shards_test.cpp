// Shards of Zarr 3 that the tests write byte by byte, by the specification of the codec "sharding_indexed", and what else changes the numbers of a chunk: differences,
// shuffled bytes, halves, packed numbers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <tuple>

#include "data/files.h"
#include "support/mutated_files.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using test::gzip;
using test::open;
using test::put;
using test::refusal;
using test::Scratch;

constexpr int kX = 5, kY = 3, kZ = 4;                          // of the array
constexpr std::array<int, 3> kShard{2, 4, 4}, kChunk{1, 2, 2};  // z, y, x; those at the array's end reach beyond it
constexpr int kChunks = 8;                                      // of a shard

double value(int x, int y, int z) { return x + 10 * y + 100 * z; }

/// How shards are written.
struct Form {
  bool first = false, sum = true, big_index = false, turned = false, packed = false;
  std::set<int> missing;  // chunks of each shard
  std::string codecs() const {
    const std::string little = R"({"name":"bytes","configuration":{"endian":"little"}})";
    const std::string index = big_index ? R"({"name":"bytes","configuration":{"endian":"big"}})" : little;
    return R"([{"name":"sharding_indexed","configuration":{"chunk_shape":[1,2,2],"codecs":[)" + std::string(turned ? R"({"name":"transpose","configuration":{"order":[2,1,0]}},)" : "") + little +
           (packed ? R"(,{"name":"gzip","configuration":{"level":1}},{"name":"crc32c"})" : "") + R"(],"index_codecs":[)" + index + (sum ? R"(,{"name":"crc32c"})" : "") + R"(],"index_location":")" +
           (first ? "start" : "end") + R"("}}])";
  }
};

std::string crc32c(const std::string& bytes) {  // bit by bit, as RFC 3720 defines it
  std::uint32_t crc = ~0u;
  for (const unsigned char byte : bytes)
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (((crc ^ (byte >> bit)) & 1) ? 0x82f63b78u : 0u);
  std::string out;
  put(out, ~crc);
  return out;
}

std::string metadata(const std::string& codecs) {
  return R"({"zarr_format":3,"node_type":"array","shape":[4,3,5],"data_type":"uint16","chunk_grid":{"name":"regular","configuration":{"chunk_shape":[2,4,4]}},)"
         R"("chunk_key_encoding":{"name":"default","configuration":{"separator":"/"}},"fill_value":7,"codecs":)" + codecs + R"(,"attributes":{},"dimension_names":["z","y","x"]})";
}

std::string chunk(const Form& form, int z0, int y0, int x0) {
  std::string bytes;
  const auto add = [&](int z, int y, int x) { put(bytes, static_cast<std::uint16_t>(value(x0 + x, y0 + y, z0 + z))); };
  if (form.turned)
    for (int x = 0; x < kChunk[2]; ++x)
      for (int y = 0; y < kChunk[1]; ++y) add(0, y, x);
  else
    for (int y = 0; y < kChunk[1]; ++y)
      for (int x = 0; x < kChunk[2]; ++x) add(0, y, x);
  if (!form.packed) return bytes;
  bytes = gzip(bytes);
  return bytes + crc32c(bytes);
}

/// The chunks lie backwards, with a gap before each: the index alone says where they are.
std::string shard(const Form& form, int z0, int x0) {
  const std::size_t index_bytes = 16 * kChunks + (form.sum ? 4 : 0);
  std::string data;
  std::array<std::array<std::uint64_t, 2>, kChunks> index;
  index.fill({~0ull, ~0ull});
  for (int n = kChunks - 1; n >= 0; --n) {
    if (form.missing.contains(n)) continue;
    data += "gap";
    const std::string bytes = chunk(form, z0 + n / 4, n / 2 % 2 * kChunk[1], x0 + n % 2 * kChunk[2]);
    index[static_cast<std::size_t>(n)] = {data.size() + (form.first ? index_bytes : 0), bytes.size()};
    data += bytes;
  }
  std::string table;
  for (const auto& [from, count] : index) put(table, from, form.big_index), put(table, count, form.big_index);
  if (form.sum) table += crc32c(table);
  return form.first ? table + data : data + table;
}

fs::path write(const Scratch& scratch, const Form& form) {
  scratch.write("s.zarr/zarr.json", metadata(form.codecs()));
  for (int z = 0; z < 2; ++z)
    for (int x = 0; x < 2; ++x) scratch.write("s.zarr/c/" + std::to_string(z) + "/0/" + std::to_string(x), shard(form, z * kShard[0], x * kShard[2]));
  return scratch / "s.zarr";
}

void expect_values(const Dataset& data, const std::set<int>& missing = {}) {
  ASSERT_EQ(data.grid.dims(), (std::array<std::int64_t, 3>{kX, kY, kZ}));
  for (int z = 0; z < kZ; ++z)
    for (int y = 0; y < kY; ++y)
      for (int x = 0; x < kX; ++x) {
        const bool there = !missing.contains(z % 2 * 4 + y / 2 * 2 + x % 4 / 2);
        EXPECT_EQ(data.arrays.front().at(static_cast<std::size_t>(x + kX * (y + kY * z))), there ? value(x, y, z) : 7) << x << ' ' << y << ' ' << z;
      }
}

void expect_refused(const fs::path& path, ErrorCode code, const std::string& why) {
  const Error error = refusal(path);
  EXPECT_EQ(error.code(), code) << error.what();
  EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << "expected: " << why << "\ngot: " << error.what();
  EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
}

TEST(ZarrShards, TheSameArrayIsTheSameByEveryWayToWriteItsShards) {
  for (const Form& form : std::vector<Form>{{}, {.first = true}, {.sum = false}, {.first = true, .sum = false}, {.big_index = true}, {.turned = true}, {.packed = true}, {.first = true, .turned = true, .packed = true}}) {
    SCOPED_TRACE(form.codecs());
    const Scratch scratch;
    expect_values(*open(write(scratch, form)));
  }
}

TEST(ZarrShards, ChunksThatAreNotInAShardHoldTheFillValueAndAreCounted) {
  const Scratch scratch;
  const Form form{.packed = true, .missing = {0, 5}};
  const auto data = open(write(scratch, form));
  expect_values(*data, form.missing);
  const auto counted = [](const Dataset& of, const std::string& words) {
    return std::any_of(of.notes.begin(), of.notes.end(), [&](const std::string& note) { return note.starts_with(words); });
  };
  EXPECT_TRUE(counted(*data, "6 of 24 chunks"));  // of the second shard along x the array has three columns of chunks less
  fs::remove(scratch / "s.zarr/c/1/0/1");
  EXPECT_TRUE(counted(*open(scratch / "s.zarr"), "9 of 24 chunks"));
}

TEST(ZarrShards, DamagedShardsAreRefusedByTheirFileInOneLine) {
  const Form form{.sum = false}, summed;
  const std::string good = shard(form, 0, 0);
  const auto index = [&](std::size_t entry, std::uint64_t from, std::uint64_t count) {
    std::string bytes, to = good;
    put(bytes, from), put(bytes, count);
    return to.replace(good.size() - 16 * (kChunks - entry), 16, bytes);
  };
  for (const auto& [bytes, why] : std::vector<std::pair<std::string, std::string>>{{"", "expected an index of 128"},
                                                                                   {good.substr(0, 100), "expected an index of 128"},
                                                                                   {index(3, 1u << 20, 8), "its index names 8 bytes from 1048576 on"},
                                                                                   {index(3, 0, 1u << 20), "its index names 1048576 bytes from 0 on"},
                                                                                   {index(3, ~0ull - 1, 8), "its index names"},
                                                                                   {index(3, 0, ~0ull), "its index names"},
                                                                                   {index(3, ~0ull, 8), "its index names"},
                                                                                   {index(3, 0, 0), "c/0/0/0, chunk 3 of the shard: has 0 bytes; expected 8"},
                                                                                   {index(3, 0, 9), "c/0/0/0, chunk 3 of the shard: has 9 bytes; expected 8"},
                                                                                   {index(3, 0, good.size()), "names more bytes than the"}}) {
    SCOPED_TRACE(why);
    const Scratch scratch;
    write(scratch, form);
    scratch.write("s.zarr/c/0/0/0", bytes);
    expect_refused(scratch / "s.zarr", ErrorCode::bad_data, why);
    expect_refused(scratch / "s.zarr", ErrorCode::bad_data, "s.zarr/c/0/0/0");
  }
  const Scratch scratch;
  write(scratch, summed);
  std::string damaged = shard(summed, 0, 0);
  damaged[damaged.size() - 10] = static_cast<char>(damaged[damaged.size() - 10] + 1);
  scratch.write("s.zarr/c/0/0/0", damaged);
  expect_refused(scratch / "s.zarr", ErrorCode::bad_data, "s.zarr/c/0/0/0, the index of the shard: is damaged: its sum (crc32c)");
  const Form packed{.packed = true};
  write(scratch, packed);
  damaged = shard(packed, 0, 0);
  damaged[15] = static_cast<char>(damaged[15] + 1);
  scratch.write("s.zarr/c/0/0/0", damaged);
  expect_refused(scratch / "s.zarr", ErrorCode::bad_data, "chunk 7 of the shard: is damaged");
}

TEST(ZarrShards, MetadataThatMakesNoSenseIsRefusedByName) {
  const std::string good = Form().codecs();
  const auto replaced = [&](const std::string& what, const std::string& by) { return std::string(good).replace(good.find(what), what.size(), by); };
  for (const auto& [codecs, code, why] : std::vector<std::tuple<std::string, ErrorCode, std::string>>{
           {replaced("\"chunk_shape\"", "\"shape\""), ErrorCode::bad_data, "expected 'chunk_shape'"},
           {replaced("[1,2,2]", "[1,3,2]"), ErrorCode::bad_data, "shards of 4 points along axis 1 do not divide into chunks of 3"},
           {replaced("[1,2,2]", "[1,2]"), ErrorCode::bad_data, "shards of 3 axes with chunks of 2"},
           {replaced("\"end\"", "\"middle\""), ErrorCode::bad_data, "'index_location' is 'middle'"},
           {replaced("\"index_codecs\"", "\"codecs_of_index\""), ErrorCode::bad_data, "'index_codecs' has no 'bytes'"},
           {replaced("{\"name\":\"crc32c\"}", "{\"name\":\"gzip\"}"), ErrorCode::unsupported, "the index of its shards is packed by 'gzip'"},
           {"[" + good.substr(1, good.size() - 2) + ",{\"name\":\"gzip\"}]", ErrorCode::unsupported, "before or after 'sharding_indexed'"},
           {replaced("\"codecs\":[", "\"codecs\":[{\"name\":\"sharding_indexed\",\"configuration\":{}},"), ErrorCode::unsupported, "shards within shards"}}) {
    SCOPED_TRACE(why);
    const Scratch scratch;
    write(scratch, {});
    scratch.write("s.zarr/zarr.json", metadata(codecs));
    expect_refused(scratch / "s.zarr", code, why);
  }
}

TEST(ZarrShards, AShardThatIsNearlyEmptyMayNotFillADisk) {
  const Scratch scratch;
  std::string of = metadata(Form{.sum = false}.codecs());
  const auto replace = [&](const std::string& what, const std::string& by) { of.replace(of.find(what), what.size(), by); };
  replace("[4,3,5]", "[1000,1000,1000]");
  replace("[2,4,4]", "[1000,1000,1000]");
  replace("[1,2,2]", "[500,500,500]");
  scratch.write("e.zarr/zarr.json", of);
  scratch.write("e.zarr/c/0/0/0", std::string(128, '\xff'));
  expect_refused(scratch / "e.zarr", ErrorCode::too_large, "8 of 8 chunks are not there");
}

TEST(ZarrShards, MutatedFoldersEndInADatasetOrAnError) {
  int refused = 0;
  for (unsigned round = 0; round < 60; ++round) {
    std::mt19937 random(round + 815);
    const Scratch scratch;
    const Form form{.first = round % 4 < 2, .sum = round % 8 < 2, .packed = round % 3 == 0};
    write(scratch, form);
    if (round % 2) scratch.write("s.zarr/zarr.json", testing::mutated(metadata(form.codecs()), random));
    else scratch.write("s.zarr/c/0/0/0", testing::mutated(shard(form, 0, 0), random));
    OpenOptions options;
    options.max_bytes = 256u << 20;
    options.timeout_s = 20;
    try {
      open_dataset((scratch / "s.zarr").string(), options, Task());
    } catch (const Error& error) {
      EXPECT_NE(error.code(), ErrorCode::internal) << "round " << round << ": " << error.what();
      for (const char* never : {"ended after", "crashed", "\n"}) EXPECT_EQ(std::string(error.what()).find(never), std::string::npos) << "round " << round << ": " << error.what();
      ++refused;
    }
  }
  EXPECT_GT(refused, 15);
}

/// One chunk of 2 x 2 x 2 numbers.
fs::path write_one(const Scratch& scratch, const std::string& dtype, const std::string& more, const std::string& bytes, const std::string& attributes = "{}") {
  scratch.write("n.zarr/.zarray", R"({"zarr_format":2,"shape":[2,2,2],"chunks":[2,2,2],"dtype":")" + dtype + R"(","compressor":null,"order":"C",)" + more + "}");
  scratch.write("n.zarr/.zattrs", attributes);
  if (!bytes.empty()) scratch.write("n.zarr/0.0.0", bytes);
  return scratch / "n.zarr";
}

std::vector<double> values_of(const Dataset& data) {
  std::vector<double> out;
  for (std::size_t p = 0; p < 8; ++p) out.push_back(data.arrays.front().at(p));
  return out;
}

TEST(ZarrNumbers, HalvesAreTheFloatsThatTheyStandFor) {
  const Scratch scratch;
  std::string bytes;
  for (const std::uint16_t bits : {0x0000, 0x3c00, 0xc000, 0x7bff, 0x0001, 0x0400, 0x3555, 0xfc00}) put(bytes, bits);
  const auto data = open(write_one(scratch, "<f2", R"("fill_value":1.5,"filters":null)", bytes));
  EXPECT_EQ(data->arrays.front().type, ScalarType::float32);
  EXPECT_EQ(values_of(*data), (std::vector<double>{0, 1, -2, 65504, 0x1p-24, 0x1p-14, 0.333251953125, -std::numeric_limits<double>::infinity()}));
  fs::remove(scratch / "n.zarr/0.0.0");
  EXPECT_EQ(values_of(*open(scratch / "n.zarr")), std::vector<double>(8, 1.5));
}

TEST(ZarrNumbers, DifferencesAreSummedUpAndShuffledBytesPutInOrder) {
  const Scratch scratch;
  std::string differences;
  for (const int step : {60000, 10, -5, 20, 20, 20, -60000, 1}) put(differences, static_cast<std::uint16_t>(step), true);
  std::vector<double> expected{60000, 60010, 60005, 60025, 60045, 60065, 65, 66};
  EXPECT_EQ(values_of(*open(write_one(scratch, ">u2", R"("fill_value":0,"filters":[{"id":"delta","dtype":">u2"}])", differences))), expected);
  std::string shuffled;
  for (std::size_t b = 0; b < 2; ++b)
    for (std::size_t i = 0; i < 8; ++i) shuffled += differences[2 * i + b];
  EXPECT_EQ(values_of(*open(write_one(scratch, ">u2", R"("fill_value":0,"filters":[{"id":"delta","dtype":">u2"},{"id":"shuffle","elementsize":2}])", shuffled))), expected);
}

TEST(ZarrNumbers, ScaledNumbersAreWhatTheyWereMadeOfAlsoAsDifferences) {
  const Scratch scratch;
  std::string bytes, differences;
  int before = 0;
  for (const int stored : {0, 1, -2, 333, -32768, 32767, 6, 7}) {
    put(bytes, static_cast<std::int16_t>(stored), true);
    put(differences, static_cast<std::int16_t>(stored - before), true);
    before = stored;
  }
  std::vector<double> expected;
  for (const int stored : {0, 1, -2, 333, -32768, 32767, 6, 7}) expected.push_back(stored / 10.0 + 1000);
  const std::string filter = R"({"id":"fixedscaleoffset","dtype":"<f8","astype":">i2","scale":10,"offset":1000})";
  const auto data = open(write_one(scratch, "<f8", R"("fill_value":-1.5,"filters":[)" + filter + "]", bytes));
  EXPECT_EQ(data->arrays.front().type, ScalarType::float64);
  EXPECT_EQ(values_of(*data), expected);
  fs::remove(scratch / "n.zarr/0.0.0");
  EXPECT_EQ(values_of(*open(scratch / "n.zarr")), std::vector<double>(8, -1.5));
  EXPECT_EQ(values_of(*open(write_one(scratch, "<f8", R"("fill_value":0,"filters":[)" + filter + R"(,{"id":"delta","dtype":">i2"}])", differences))), expected);
}

TEST(ZarrNumbers, RoundedOnesAreReadAsTheyAre) {
  const Scratch scratch;
  std::string bytes;
  for (int i = 0; i < 8; ++i) put(bytes, 0.125f * static_cast<float>(i));
  const std::string filters = R"("fill_value":0,"filters":[{"id":"quantize","digits":3,"dtype":"<f4","astype":"<f4"},{"id":"bitround","keepbits":5}])";
  EXPECT_EQ(values_of(*open(write_one(scratch, "<f4", filters, bytes))), (std::vector<double>{0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875}));
}

TEST(ZarrNumbers, PackedNumbersAreWhatTheyStandForAndTheFillValueIsNone) {
  const Scratch scratch;
  std::string bytes;
  for (const int stored : {0, 1, 2, 3, -32768, 5, 6, 7}) put(bytes, static_cast<std::int16_t>(stored));
  const std::string attributes = R"({"scale_factor":0.5,"add_offset":100,"_ARRAY_DIMENSIONS":["z","y","x"]})";
  const auto data = open(write_one(scratch, "<i2", R"("fill_value":-32768,"filters":null)", bytes, attributes));
  EXPECT_EQ(data->arrays.front().nan_count, 1);
  EXPECT_EQ(data->arrays.front().at(3), 101.5);
  EXPECT_EQ(data->arrays.front().at(7), 103.5);
  fs::remove(scratch / "n.zarr/0.0.0");
  EXPECT_EQ(open(scratch / "n.zarr")->arrays.front().nan_count, 8);
}

}  // namespace
}  // namespace isostrata
