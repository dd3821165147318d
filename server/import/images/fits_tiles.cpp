#include "import/images/fits_tiles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "import/bytes/swap_bytes.h"
#include "import/bytes/unpack_bytes.h"
#include "import/images/fits_rice.h"
#include "import/limits/memory_limit.h"

namespace isostrata {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::int32_t kNoValue = -2147483647, kZero = -2147483646;  // in whole numbers for real ones
constexpr std::size_t kRandoms = 10'000;

/// The numbers that dithering has added, appendix I of the definition.
const std::vector<float>& dither_numbers() {
  static const std::vector<float> numbers = [] {
    std::vector<float> out(kRandoms);
    constexpr double kFactor = 16807, kModulus = 2147483647;
    double seed = 1;
    for (float& one : out) {
      seed = std::fmod(kFactor * seed, kModulus);
      one = static_cast<float>(seed / kModulus);
    }
    return out;
  }();
  return numbers;
}

template <class T>
T big_endian(Bytes from) {
  std::array<std::byte, sizeof(T)> bytes;
  std::copy_n(from.begin(), sizeof(T), bytes.begin());
  swap_bytes(bytes, sizeof(T));
  T value{};
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

struct Column {
  std::size_t at = 0;  // in a row
  char type = 'B';     // of its values, or of those in the heap
  bool wide = false;   // Q: numbers of 8 bytes say where these are
};

class Tiles {
 public:
  Tiles(Bytes file, const FitsHeader& table, const FitsHeader& image, const ReadRequest& request) : table_(table), image_(image), name_(request.file.filename().string()), width_(static_cast<std::size_t>(std::abs(image.bits()) / 8)) {
    if (table.axes().size() != 2 || table.data() > file.size() || table.data_bytes() > file.size() - table.data()) bad("is cut off, or its table is none");
    row_ = static_cast<std::size_t>(table.axes()[0]);
    rows_ = table.axes()[1];
    data_ = file.subspan(table.data(), table.data_bytes());
    const std::int64_t heap = table.whole("THEAP", table.axes()[0] * table.axes()[1]);
    if (heap < 0 || static_cast<std::uint64_t>(heap) > data_.size()) bad("THEAP " + std::to_string(heap) + " leaves its table");
    heap_ = data_.subspan(static_cast<std::size_t>(heap));
    find_columns();
    shape(request, file.size());
  }

  FitsData run() {
    auto [storage, to] = allocate<std::byte>(static_cast<std::size_t>(bytes_));
    const std::size_t axes = image_.axes().size();
    std::vector<std::int64_t> first(axes, 0), size(axes);
    for (std::int64_t t = 0; t < rows_; ++t) {
      std::size_t pixels = 1;
      for (std::size_t a = 0; a < axes; ++a) {
        size[a] = std::min(tile_[a], image_.axes()[a] - first[a]);
        pixels *= static_cast<std::size_t>(size[a]);
      }
      std::vector<std::byte> values = tile(t, pixels);
      swap_bytes(values, width_);
      lay(values, first, size, to);
      for (std::size_t a = 0; a < axes && (first[a] += tile_[a]) >= image_.axes()[a]; ++a) first[a] = 0;
    }
    return {to, storage};
  }

 private:
  [[noreturn]] void bad(const std::string& why) const { throw Error(ErrorCode::bad_data, name_ + ": an image that is packed in tiles: " + why); }

  void find_columns() {
    std::size_t at = 0;
    for (std::int64_t n = 1; n <= std::min<std::int64_t>(table_.whole("TFIELDS", 0), 999); ++n) {
      const std::string form = table_.text("TFORM" + std::to_string(n)), type = table_.text("TTYPE" + std::to_string(n));
      const auto letter = form.find_first_not_of("0123456789");
      if (letter == std::string::npos) bad("a column of TFORM '" + form.substr(0, 20) + "'");
      const std::size_t count = letter == 0 ? 1 : static_cast<std::size_t>(std::min(std::atol(form.substr(0, std::min<std::size_t>(letter, 9)).c_str()), 100'000'000L));
      const bool apart = form[letter] == 'P' || form[letter] == 'Q';
      const Column column{at, apart && letter + 1 < form.size() ? form[letter + 1] : form[letter], form[letter] == 'Q'};
      at += count * (apart ? (column.wide ? 16 : 8) : width_of(column.type));
      if (type == "COMPRESSED_DATA" && apart) packed_ = column;
      if (type == "GZIP_COMPRESSED_DATA" && apart) gzipped_ = column;
      if (type == "UNCOMPRESSED_DATA" && apart) plain_ = column;
      if (type == "ZSCALE" && column.type == 'D') scale_ = column;
      if (type == "ZZERO" && column.type == 'D') zero_ = column;
      if (type == "ZBLANK" && column.type == 'J') blank_ = column;
    }
    if (at > row_) bad("its columns have " + std::to_string(at) + " bytes, its rows " + std::to_string(row_));
    if (!packed_) bad("it has no column COMPRESSED_DATA");
  }

  static std::size_t width_of(char type) { return type == 'I' ? 2 : type == 'J' || type == 'E' ? 4 : type == 'K' || type == 'D' || type == 'C' || type == 'P' ? 8 : type == 'M' || type == 'Q' ? 16 : 1; }

  void shape(const ReadRequest& request, std::size_t stored) {
    std::int64_t tiles = 1, pixels = 1, in_tile = 1;
    for (std::size_t a = 0; a < image_.axes().size(); ++a) {
      const std::int64_t size = image_.axes()[a], own = table_.whole("ZTILE" + std::to_string(a + 1), a == 0 ? size : 1);
      if (own < 1 || size < 1) bad("tiles of " + std::to_string(own) + " points along an axis of " + std::to_string(size));
      tile_.push_back(std::min(own, size));
      tiles = checked_product({tiles, (size - 1) / tile_.back() + 1}, name_);
      pixels = checked_product({pixels, size}, name_);
      in_tile = checked_product({in_tile, tile_.back()}, name_);
    }
    if (tiles != rows_) bad(std::to_string(rows_) + " rows for " + std::to_string(tiles) + " tiles");
    bytes_ = static_cast<std::uint64_t>(checked_product({pixels, static_cast<std::int64_t>(width_)}, name_));
    check_bytes(request, bytes_, name_);
    check_unpacked(bytes_, stored, name_);
    kind_ = table_.text("ZCMPTYPE");
    if (kind_ != "RICE_1" && kind_ != "RICE_ONE" && kind_ != "GZIP_1" && kind_ != "GZIP_2" && kind_ != "NOCOMPRESS")
      throw Error(ErrorCode::unsupported, name_ + ": an image that is packed in tiles by " + kind_.substr(0, 20) + "; expected RICE_1, GZIP_1 or GZIP_2: unpack it (funpack)");
    for (int n = 1; n <= 9; ++n) {
      const std::string key = table_.text("ZNAME" + std::to_string(n)), value = "ZVAL" + std::to_string(n);
      if (key == "BLOCKSIZE") block_ = static_cast<int>(std::clamp<std::int64_t>(table_.whole(value, 32), 0, 1 << 20));
      if (key == "BYTEPIX") rice_width_ = static_cast<int>(std::clamp<std::int64_t>(table_.whole(value, 4), 0, 9));
    }
    const std::string quantised = table_.text("ZQUANTIZ");
    dither_ = quantised == "SUBTRACTIVE_DITHER_1" || quantised == "SUBTRACTIVE_DITHER_2";
    keeps_zero_ = quantised == "SUBTRACTIVE_DITHER_2";
    seed_ = table_.whole("ZDITHER0", 1);
    if (!table_.text("ZBLANK").empty()) no_value_ = table_.whole("ZBLANK", 0);
  }

  Bytes cell(std::int64_t row, const Column& column, std::size_t bytes) const { return data_.subspan(static_cast<std::size_t>(row) * row_ + column.at, bytes); }

  /// What a row has in the heap.
  Bytes in_heap(std::int64_t row, const std::optional<Column>& column) const {
    if (!column) return {};
    const std::size_t half = column->wide ? 8 : 4;
    const Bytes says = cell(row, *column, 2 * half);
    const std::uint64_t count = column->wide ? big_endian<std::uint64_t>(says) : big_endian<std::uint32_t>(says), at = column->wide ? big_endian<std::uint64_t>(says.subspan(half)) : big_endian<std::uint32_t>(says.subspan(half));
    std::uint64_t bytes = 0;
    if (__builtin_mul_overflow(count, width_of(column->type), &bytes) || at > heap_.size() || bytes > heap_.size() - at) bad("tile " + std::to_string(row) + " leaves the table: it is cut off, or damaged");
    return heap_.subspan(static_cast<std::size_t>(at), static_cast<std::size_t>(bytes));
  }

  std::vector<std::byte> gunzip(Bytes from, std::size_t most, std::int64_t row) const {
    std::vector<std::byte> out(most);
    const std::size_t made = inflate_all(from, out);
    if (made > most) bad("tile " + std::to_string(row) + " is damaged");
    out.resize(made);
    return out;
  }

  /// The bytes of a tile of `pixels` numbers, the first bytes of all first if so; in the machine's order.
  std::vector<std::byte> numbers(std::vector<std::byte> bytes, std::size_t pixels, bool first_bytes_first, std::int64_t row) const {
    const std::size_t width = pixels ? bytes.size() / pixels : 0;
    if (width * pixels != bytes.size() || (width != 1 && width != 2 && width != 4 && width != 8)) bad("tile " + std::to_string(row) + " has " + std::to_string(bytes.size()) + " bytes for " + std::to_string(pixels) + " numbers");
    if (first_bytes_first) {
      const std::vector<std::byte> apart = bytes;
      for (std::size_t b = 0; b < width; ++b)
        for (std::size_t p = 0; p < pixels; ++p) bytes[p * width + b] = apart[b * pixels + p];
    }
    swap_bytes(bytes, width);
    return bytes;
  }

  /// In the machine's order.
  std::vector<std::byte> tile(std::int64_t row, std::size_t pixels) const {
    if (const Bytes raw = in_heap(row, plain_); !raw.empty()) return as_stored(numbers({raw.begin(), raw.end()}, pixels, false, row), pixels, row);
    if (const Bytes raw = in_heap(row, gzipped_); !raw.empty()) return as_stored(numbers(gunzip(raw, pixels * 8, row), pixels, false, row), pixels, row);
    const Bytes packed = in_heap(row, packed_);
    const bool real = image_.bits() < 0, quantised = real && scale_ && zero_;
    std::vector<std::byte> bytes;
    if (kind_.starts_with("RICE")) {
      std::vector<std::int32_t> whole(pixels);
      if (!unpack_rice(packed, rice_width_, block_, whole)) bad("tile " + std::to_string(row) + " is damaged or cut off");
      bytes.resize(pixels * 4);
      std::memcpy(bytes.data(), whole.data(), bytes.size());
    } else {
      bytes = kind_ == "NOCOMPRESS" ? numbers({packed.begin(), packed.end()}, pixels, false, row) : numbers(gunzip(packed, pixels * 8, row), pixels, kind_ == "GZIP_2", row);
    }
    return quantised ? meant(bytes, pixels, row) : as_stored(std::move(bytes), pixels, row);
  }

  /// Numbers of the image's own width: of whole ones the lower bytes.
  std::vector<std::byte> as_stored(std::vector<std::byte> bytes, std::size_t pixels, std::int64_t row) const {
    const std::size_t width = pixels ? bytes.size() / pixels : width_;
    if (width == width_) return bytes;
    if (image_.bits() < 0 || width < width_) bad("tile " + std::to_string(row) + " has numbers of " + std::to_string(width) + " bytes; expected " + std::to_string(width_));
    std::vector<std::byte> out(pixels * width_);
    for (std::size_t p = 0; p < pixels; ++p) std::memcpy(out.data() + p * width_, bytes.data() + p * width, width_);  // little-endian, as every machine that this is built for
    return out;
  }

  /// Real numbers of the whole ones that stand for them.
  std::vector<std::byte> meant(const std::vector<std::byte>& bytes, std::size_t pixels, std::int64_t row) const {
    if (bytes.size() != pixels * 4) bad("tile " + std::to_string(row) + " has numbers that are not of 4 bytes");
    const double scale = big_endian<double>(cell(row, *scale_, 8)), zero = big_endian<double>(cell(row, *zero_, 8));
    const std::int64_t none = blank_ ? big_endian<std::int32_t>(cell(row, *blank_, 4)) : no_value_.value_or(kNoValue);
    const auto& randoms = dither_numbers();
    std::size_t of_tile = static_cast<std::size_t>(((row + seed_ - 1) % static_cast<std::int64_t>(kRandoms) + static_cast<std::int64_t>(kRandoms)) % static_cast<std::int64_t>(kRandoms)), next = static_cast<std::size_t>(randoms[of_tile] * 500);
    std::vector<std::byte> out(pixels * width_);
    for (std::size_t p = 0; p < pixels; ++p) {
      std::int32_t whole = 0;
      std::memcpy(&whole, bytes.data() + 4 * p, 4);
      double value = dither_ ? (static_cast<double>(whole) - static_cast<double>(randoms[next]) + 0.5) * scale + zero : static_cast<double>(whole) * scale + zero;
      if (whole == none) value = std::numeric_limits<double>::quiet_NaN();
      else if (keeps_zero_ && whole == kZero) value = 0;
      if (width_ == 4) {
        const auto single = static_cast<float>(value);
        std::memcpy(out.data() + 4 * p, &single, 4);
      } else {
        std::memcpy(out.data() + 8 * p, &value, 8);
      }
      if (++next == kRandoms) {
        of_tile = (of_tile + 1) % kRandoms;
        next = static_cast<std::size_t>(randoms[of_tile] * 500);
      }
    }
    return out;
  }

  /// Puts a tile where it belongs, a row of it at a time.
  void lay(const std::vector<std::byte>& values, const std::vector<std::int64_t>& first, const std::vector<std::int64_t>& size, std::span<std::byte> to) const {
    const std::size_t row = static_cast<std::size_t>(size[0]) * width_;
    std::vector<std::int64_t> at(size.size(), 0);
    for (std::size_t done = 0; done < values.size(); done += row) {
      std::int64_t place = 0;
      for (std::size_t a = size.size(); a-- > 0;) place = place * image_.axes()[a] + first[a] + at[a];
      std::memcpy(to.data() + static_cast<std::size_t>(place) * width_, values.data() + done, row);
      for (std::size_t a = 1; a < size.size() && ++at[a] == size[a]; ++a) at[a] = 0;
    }
  }

  const FitsHeader &table_, &image_;
  const std::string name_;
  const std::size_t width_;
  Bytes data_, heap_;
  std::size_t row_ = 0;
  std::int64_t rows_ = 0;
  std::optional<Column> packed_, gzipped_, plain_, scale_, zero_, blank_;
  std::vector<std::int64_t> tile_;
  std::uint64_t bytes_ = 0;
  std::string kind_;
  int block_ = 32, rice_width_ = 4;
  bool dither_ = false, keeps_zero_ = false;
  std::int64_t seed_ = 1;
  std::optional<std::int64_t> no_value_;
};

}  // namespace

FitsData unpack_fits_tiles(std::span<const std::byte> file, const FitsHeader& table, const FitsHeader& image, const ReadRequest& request) { return Tiles(file, table, image, request).run(); }

}  // namespace isostrata
