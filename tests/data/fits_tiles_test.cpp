// Images of FITS in tiles, packed by the test's own coder of Rice's method, by zlib and not at all.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <tuple>

#include "data/files.h"
#include "data/fits_file.h"
#include "support/mutated_files.h"

namespace isostrata {
namespace {

using test::Cards;
using test::put;
using test::Scratch;

class Bits {
 public:
  void add(std::uint64_t value, int count) {
    for (int b = count - 1; b >= 0; --b) {
      if (used_++ % 8 == 0) text_.push_back('\0');
      text_.back() = static_cast<char>(text_.back() | ((value >> b & 1) << (7 - (used_ - 1) % 8)));
    }
  }
  std::string text() const { return text_; }

 private:
  std::string text_;
  std::size_t used_ = 0;
};

/// Each block by another way: nothing but a mark if all are alike, by splits of 0 to 7 bits, whole.
std::string rice(const std::vector<std::int64_t>& numbers, int width, int block) {
  const int of_split = width == 1 ? 3 : width == 2 ? 4 : 5, whole = width == 1 ? 6 : width == 2 ? 14 : 25, bits = 8 * width;
  const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
  Bits out;
  std::uint64_t last = static_cast<std::uint64_t>(numbers.front()) & mask;
  out.add(last, bits);
  for (std::size_t at = 0, n = 0; at < numbers.size(); at += static_cast<std::size_t>(block), ++n) {
    std::vector<std::uint64_t> codes;
    for (std::size_t i = at; i < std::min(numbers.size(), at + static_cast<std::size_t>(block)); ++i) {
      const std::uint64_t now = static_cast<std::uint64_t>(numbers[i]) & mask, step = (now - last) & mask;
      const bool negative = step >> (bits - 1) & 1;
      codes.push_back(negative ? (~step & mask) << 1 | 1 : step << 1);
      codes.back() &= mask;
      last = now;
    }
    const std::uint64_t most = *std::max_element(codes.begin(), codes.end());
    const int split = static_cast<int>(n % 5);
    if (most == 0) {
      out.add(0, of_split);
    } else if ((most >> split) > 60) {
      out.add(static_cast<std::uint64_t>(whole) + 1, of_split);
      for (const std::uint64_t code : codes) out.add(code, bits);
    } else {
      out.add(static_cast<std::uint64_t>(split) + 1, of_split);
      for (const std::uint64_t code : codes) {
        out.add(0, static_cast<int>(code >> split));
        out.add(1, 1);
        out.add(code & ((std::uint64_t{1} << split) - 1), split);
      }
    }
  }
  return out.text();
}

std::string big_endian(const std::vector<std::int64_t>& numbers, int width, bool first_bytes_first) {
  std::string out;
  for (const std::int64_t number : numbers)
    for (int b = width - 1; b >= 0; --b) out.push_back(static_cast<char>(number >> (8 * b)));
  if (!first_bytes_first) return out;
  std::string apart;
  for (int b = 0; b < width; ++b)
    for (std::size_t i = static_cast<std::size_t>(b); i < out.size(); i += static_cast<std::size_t>(width)) apart.push_back(out[i]);
  return apart;
}

constexpr std::array<int, 3> kAxes{23, 11, 5}, kTile{7, 4, 2};

/// The numbers of each tile, the first axis fastest, in the order of the tiles.
std::vector<std::vector<std::int64_t>> tiles_of(const std::vector<std::int64_t>& numbers) {
  std::vector<std::vector<std::int64_t>> out;
  for (int z = 0; z < kAxes[2]; z += kTile[2])
    for (int y = 0; y < kAxes[1]; y += kTile[1])
      for (int x = 0; x < kAxes[0]; x += kTile[0]) {
        auto& tile = out.emplace_back();
        for (int k = z; k < std::min(z + kTile[2], kAxes[2]); ++k)
          for (int j = y; j < std::min(y + kTile[1], kAxes[1]); ++j)
            for (int i = x; i < std::min(x + kTile[0], kAxes[0]); ++i) tile.push_back(numbers[static_cast<std::size_t>(i + kAxes[0] * (j + kAxes[1] * k))]);
      }
  return out;
}

/// A file whose second header is that of the table; `scaled`: with a column of scales and one of zeros.
std::string packed_file(int bits, const std::vector<std::string>& tiles, Cards more, bool scaled) {
  const std::string row = scaled ? "24" : "8";
  std::string rows, heap;
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    put(rows, static_cast<std::int32_t>(tiles[t].size()), true);
    put(rows, static_cast<std::int32_t>(heap.size()), true);
    if (scaled) put(rows, 0.25 * static_cast<double>(t + 1), true), put(rows, 10.0 * static_cast<double>(t), true);
    heap += tiles[t];
  }
  Cards cards{{"XTENSION", "'BINTABLE'"}, {"BITPIX", "8"}, {"NAXIS", "2"}, {"NAXIS1", row}, {"NAXIS2", std::to_string(tiles.size())}, {"PCOUNT", std::to_string(heap.size())}, {"GCOUNT", "1"},
              {"TFIELDS", scaled ? "3" : "1"}, {"TTYPE1", "'COMPRESSED_DATA'"}, {"TFORM1", "'1PB(99)'"}, {"TTYPE2", "'ZSCALE'"}, {"TFORM2", "'1D'"}, {"TTYPE3", "'ZZERO'"}, {"TFORM3", "'D'"},
              {"ZIMAGE", "T"}, {"ZBITPIX", std::to_string(bits)}, {"ZNAXIS", "3"}};
  for (std::size_t a = 0; a < 3; ++a) {
    cards.emplace_back("ZNAXIS" + std::to_string(a + 1), std::to_string(kAxes[a]));
    cards.emplace_back("ZTILE" + std::to_string(a + 1), std::to_string(kTile[a]));
  }
  cards.insert(cards.end(), more.begin(), more.end());
  return test::header(test::image(8, {})) + test::header(cards) + test::padded(rows + heap, '\0');
}

Cards rice_cards(int width) { return {{"ZCMPTYPE", "'RICE_1'"}, {"ZNAME1", "'BLOCKSIZE'"}, {"ZVAL1", "16"}, {"ZNAME2", "'BYTEPIX'"}, {"ZVAL2", std::to_string(width)}}; }

std::vector<std::string> packed_tiles(const std::vector<std::int64_t>& numbers, int width, const std::string& kind) {
  std::vector<std::string> out;
  for (const auto& tile : tiles_of(numbers))
    out.push_back(kind == "RICE_1" ? rice(tile, width, 16) : kind == "NOCOMPRESS" ? big_endian(tile, width, false) : test::gzip(big_endian(tile, width, kind == "GZIP_2")));
  return out;
}

std::vector<std::int64_t> random_numbers(int width, bool smooth, std::mt19937_64& random) {
  const std::int64_t least = width == 1 ? 0 : -(std::int64_t{1} << (8 * width - 1)), most = width == 1 ? 255 : -least - 1;
  std::vector<std::int64_t> out;
  std::int64_t last = (least + most) / 2;
  for (int i = 0; i < kAxes[0] * kAxes[1] * kAxes[2]; ++i) {
    last = smooth ? std::clamp(last + (i / 60 % 3 == 0 ? 0 : std::uniform_int_distribution<std::int64_t>(-40, 40)(random)), least, most) : std::uniform_int_distribution<std::int64_t>(least, most)(random);
    out.push_back(last);
  }
  return out;
}

TEST(FitsTiles, HoldTheNumbersThatWerePacked) {
  const Scratch scratch;
  for (const unsigned seed : {1u, 2u})
    for (const int width : {1, 2, 4})
      for (const bool smooth : {true, false})
        for (const std::string kind : {"RICE_1", "GZIP_1", "GZIP_2", "NOCOMPRESS"}) {
          SCOPED_TRACE(kind + " of " + std::to_string(width) + " bytes, seed " + std::to_string(seed) + (smooth ? ", smooth" : ""));
          std::mt19937_64 random(seed);
          const auto numbers = random_numbers(width, smooth, random);
          const auto data = test::open(scratch.write("a.fits.fz", packed_file(8 * width, packed_tiles(numbers, width, kind), kind == "RICE_1" ? rice_cards(width) : Cards{{"ZCMPTYPE", "'" + kind + "'"}}, false)));
          ASSERT_EQ(data->grid.point_count(), static_cast<std::int64_t>(numbers.size()));
          std::size_t different = 0;
          for (std::size_t p = 0; p < numbers.size(); ++p) different += data->arrays.front().at(p) != static_cast<double>(numbers[p]);
          EXPECT_EQ(different, 0u);
          EXPECT_EQ(data->arrays.front().name, "intensity");
        }
}

/// The definition gives the last of the ten thousand.
TEST(FitsTiles, RealNumbersAreWhatTheirWholeOnesAndTheDitherSay) {
  std::vector<double> dither;
  std::uint64_t seed = 1;
  for (int i = 0; i < 10'000; ++i) dither.push_back(static_cast<double>(static_cast<float>(static_cast<double>(seed = seed * 16807 % 2147483647) / 2147483647.0)));
  ASSERT_EQ(seed, 1043618065u);
  const Scratch scratch;
  std::mt19937_64 random(3);
  auto numbers = random_numbers(2, true, random);
  numbers[5] = -2147483647;  // no value
  numbers[9] = -2147483646;  // zero
  for (const int first : {1, 9990})
    for (const int bits : {-32, -64})
      for (const std::string how : {"NO_DITHER", "SUBTRACTIVE_DITHER_1", "SUBTRACTIVE_DITHER_2"}) {
        SCOPED_TRACE(how + " from " + std::to_string(first) + ", " + std::to_string(bits));
        Cards cards = rice_cards(4);
        cards.insert(cards.end(), {{"ZQUANTIZ", "'" + how + "'"}, {"ZDITHER0", std::to_string(first)}});
        const auto data = test::open(scratch.write("a.fits.fz", packed_file(bits, packed_tiles(numbers, 4, "RICE_1"), cards, true)));
        std::vector<std::int64_t> places(numbers.size());
        for (std::size_t p = 0; p < places.size(); ++p) places[p] = static_cast<std::int64_t>(p);
        const auto whole = tiles_of(numbers), at = tiles_of(places);
        for (std::size_t t = 0; t < whole.size(); ++t) {
          std::size_t row = (t + static_cast<std::size_t>(first) - 1) % 10'000, next = static_cast<std::size_t>(dither[row] * 500);
          for (std::size_t p = 0; p < whole[t].size(); ++p, ++next) {
            const double scale = 0.25 * static_cast<double>(t + 1), zero = 10.0 * static_cast<double>(t);
            double expected = (static_cast<double>(whole[t][p]) + (how == "NO_DITHER" ? 0 : 0.5 - dither[next])) * scale + zero;
            if (how == "SUBTRACTIVE_DITHER_2" && whole[t][p] == -2147483646) expected = 0;
            const double found = data->arrays.front().at(static_cast<std::size_t>(at[t][p]));
            if (whole[t][p] == -2147483647)
              EXPECT_TRUE(std::isnan(found));
            else
              EXPECT_NEAR(found, expected, bits == -32 ? std::abs(expected) * 1e-7 : std::abs(expected) * 1e-15) << "number " << p << " of tile " << t;
          }
        }
      }
}

TEST(FitsTiles, DamageIsAnErrorAndOtherMethodsAreNamed) {
  const Scratch scratch;
  std::mt19937_64 random(4);
  const auto tiles = packed_tiles(random_numbers(2, true, random), 2, "RICE_1");
  const std::string good = packed_file(16, tiles, rice_cards(2), false);
  auto fewer = tiles, shorter = tiles;
  fewer.pop_back();
  shorter[3] = shorter[3].substr(0, 5);
  for (const auto& [bytes, code, why] : std::vector<std::tuple<std::string, ErrorCode, std::string>>{
           {packed_file(16, fewer, rice_cards(2), false), ErrorCode::bad_data, "35 rows for 36 tiles"},
           {packed_file(16, shorter, rice_cards(2), false), ErrorCode::bad_data, "tile 3 is damaged or cut off"},
           {good.substr(0, good.size() - 2880), ErrorCode::bad_data, "is cut off"},
           {packed_file(16, tiles, {{"ZCMPTYPE", "'HCOMPRESS_1'"}}, false), ErrorCode::unsupported, "by HCOMPRESS_1; expected RICE_1"},
           {packed_file(16, tiles, {{"ZCMPTYPE", "'GZIP_1'"}}, false), ErrorCode::bad_data, "tile 0 is damaged"}}) {
    const Error error = test::refusal(scratch.write("a.fits.fz", bytes));
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
  }
  testing::expect_datasets_or_errors({{"a.fits", good}, {"b.fits", packed_file(-32, packed_tiles(random_numbers(2, true, random), 4, "GZIP_2"), {{"ZCMPTYPE", "'GZIP_2'"}}, true)}}, 60);
}

}  // namespace
}  // namespace isostrata
