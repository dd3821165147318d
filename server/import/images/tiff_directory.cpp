#include "import/images/tiff_directory.h"

#include <algorithm>
#include <bit>

namespace isostrata {
namespace {

/// Numbers of a file, whatever its byte order; 0 beyond its end.
class Numbers {
 public:
  explicit Numbers(std::span<const std::byte> file) : file_(file), big_endian_(file.size() > 2 && file[0] == std::byte{'M'}) {}
  bool big_endian() const { return big_endian_; }
  bool holds(std::uint64_t at, std::uint64_t bytes) const { return at <= file_.size() && bytes <= file_.size() - at; }
  std::uint64_t at(std::uint64_t place, int bytes) const {
    std::uint64_t value = 0;
    if (!holds(place, static_cast<std::uint64_t>(bytes))) return 0;
    for (int b = 0; b < bytes; ++b) value = value << 8 | std::to_integer<std::uint64_t>(file_[place + static_cast<std::uint64_t>(big_endian_ ? b : bytes - 1 - b)]);
    return value;
  }

 private:
  std::span<const std::byte> file_;
  bool big_endian_;
};

constexpr std::uint64_t kLongestDescription = std::uint64_t{64} << 20;

int bytes_of(std::uint64_t type) {
  switch (type) {
    case 3: return 2;                    // SHORT
    case 4: return 4;                    // LONG
    case 5: return 8;                    // RATIONAL
    case 12: case 16: case 18: return 8;  // DOUBLE, LONG8, IFD8
    default: return 1;
  }
}

/// Of TIFF and of BigTIFF.
struct Widths {
  explicit Widths(bool big) : entry(big ? 20 : 12), count(big ? 8 : 2), word(big ? 8 : 4) {}
  const std::uint64_t entry, count, word;
};

constexpr std::uint64_t kMostEntries = 4096, kMostGeo = 4096;

}  // namespace

bool leads_beyond_end(std::span<const std::byte> file, std::size_t read) {
  const Numbers numbers(file);
  const bool big = numbers.at(2, 2) == 43;
  const Widths widths(big);
  std::uint64_t at = big ? numbers.at(8, 8) : numbers.at(4, 4);
  for (std::size_t d = 0; d < read && at != 0; ++d) {
    const std::uint64_t entries = numbers.at(at, static_cast<int>(widths.count));
    if (entries > kMostEntries) return false;
    at = numbers.at(at + widths.count + entries * widths.entry, static_cast<int>(widths.word));
  }
  return at != 0 && !numbers.holds(at, widths.count + numbers.at(at, static_cast<int>(widths.count)) * widths.entry + widths.word);
}

std::optional<TiffDirectory> first_tiff_directory(std::span<const std::byte> file) {
  const Numbers numbers(file);
  const bool big = numbers.at(2, 2) == 43;
  if (file.size() < 16 || (!big && numbers.at(2, 2) != 42)) return std::nullopt;
  const Widths widths(big);
  const std::uint64_t directory = big ? numbers.at(8, 8) : numbers.at(4, 4), entry_bytes = widths.entry, count_bytes = widths.count, word = widths.word;
  if (!numbers.holds(directory, count_bytes)) return std::nullopt;
  const std::uint64_t entries = numbers.at(directory, static_cast<int>(count_bytes));
  if (entries > kMostEntries || !numbers.holds(directory + count_bytes, entries * entry_bytes + word)) return std::nullopt;
  TiffDirectory out;
  out.big_endian = numbers.big_endian();
  out.last = numbers.at(directory + count_bytes + entries * entry_bytes, static_cast<int>(word)) == 0;
  for (std::uint64_t e = 0; e < entries; ++e) {
    const std::uint64_t at = directory + count_bytes + e * entry_bytes, type = numbers.at(at + 2, 2), count = numbers.at(at + 4, static_cast<int>(word));
    const auto width = static_cast<std::uint64_t>(bytes_of(type));
    if (count > file.size()) return std::nullopt;
    const std::uint64_t value = at + 4 + word, place = count * width > word ? numbers.at(value, static_cast<int>(word)) : value;
    if (!numbers.holds(place, count * width)) return std::nullopt;
    const std::uint64_t first = numbers.at(place, static_cast<int>(width));
    const auto quotient = [&] {
      const auto below = static_cast<double>(numbers.at(place + 4, 4));
      return type == 5 && below > 0 ? static_cast<double>(numbers.at(place, 4)) / below : 0;
    };
    const auto text = [&] { return std::string(reinterpret_cast<const char*>(file.data()) + place, static_cast<std::size_t>(std::min(count, kLongestDescription))); };
    const auto reals = [&] {
      std::vector<double> values;
      for (std::uint64_t i = 0; type == 12 && i < std::min(count, kMostGeo); ++i) values.push_back(std::bit_cast<double>(numbers.at(place + 8 * i, 8)));
      return values;
    };
    switch (numbers.at(at, 2)) {
      case 259: out.compression = static_cast<int>(first); break;
      case 270: out.description = text(); break;
      case 273: out.strips = count, out.first_strip = first; break;
      case 282: out.x_resolution = quotient(); break;
      case 283: out.y_resolution = quotient(); break;
      case 284: out.layout = static_cast<int>(first); break;
      case 296: out.resolution_unit = static_cast<int>(first); break;
      case 33550: out.pixel_scale = reals(); break;
      case 33922: out.tie_points = reals(); break;
      case 34264: out.transformation = reals(); break;
      case 34735:
        for (std::uint64_t i = 0; type == 3 && i < std::min(count, kMostGeo); ++i) out.geo_keys.push_back(static_cast<std::uint16_t>(numbers.at(place + 2 * i, 2)));
        break;
      case 42113: out.no_data = text(); break;
      default: break;
    }
  }
  out.description.erase(std::find(out.description.begin(), out.description.end(), '\0'), out.description.end());
  return out;
}

}  // namespace isostrata
