#include "data/files/picture_size.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>

namespace isostrata {
namespace {

using Size = std::optional<std::pair<int, int>>;

Size sized(std::uint64_t width, std::uint64_t height) {
  constexpr std::uint64_t kMost = 1u << 30;
  if (width == 0 || height == 0 || width > kMost || height > kMost) return std::nullopt;
  return std::pair(static_cast<int>(width), static_cast<int>(height));
}

/// `count` bytes from `at`; 0 if they lie beyond the end.
std::uint64_t number(const std::string& bytes, std::uint64_t at, int count, bool big_endian) {
  if (at > bytes.size() || bytes.size() - at < static_cast<std::uint64_t>(count)) return 0;
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i)
    value |= std::uint64_t{static_cast<unsigned char>(bytes[at + static_cast<std::uint64_t>(i)])} << (8 * (big_endian ? count - 1 - i : i));
  return value;
}

/// TIFF 6.0, section 2: a directory of entries of 12 bytes, tag 256 the width, 257 the height. (BigTIFF's directory is another.)
Size of_tiff(std::ifstream& in, std::string head) {
  const bool big_endian = head.starts_with("MM");
  if (number(head, 2, 2, big_endian) != 42) return std::nullopt;
  std::uint64_t at = number(head, 4, 4, big_endian);
  if (at + 2 > head.size()) {  // the directory often stands behind the pixels
    in.clear();
    in.seekg(static_cast<std::streamoff>(at));
    in.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
    at = 0;
  }
  std::uint64_t width = 0, height = 0;
  const std::uint64_t entries = number(head, at, 2, big_endian);
  for (std::uint64_t i = 0, entry = at + 2; i < entries && entry + 12 <= head.size(); ++i, entry += 12) {
    const std::uint64_t tag = number(head, entry, 2, big_endian), value = number(head, entry + 8, number(head, entry + 2, 2, big_endian) == 3 ? 2 : 4, big_endian);
    if (tag == 256) width = value;
    if (tag == 257) height = value;
  }
  return sized(width, height);
}

/// Netpbm: P1 to P6, then two numbers; a # begins a comment to the end of its line.
Size of_pnm(const std::string& head) {
  std::istringstream words(head.substr(2, 1024));
  std::uint64_t sides[2] = {0, 0};
  for (int found = 0; found < 2;) {
    if ((words >> std::ws).peek() == '#') {
      std::string comment;
      std::getline(words, comment);
      continue;
    }
    if (!(words >> sides[found++])) return std::nullopt;
  }
  return sized(sides[0], sides[1]);
}

}  // namespace

Size picture_size(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string head(64 << 10, '\0');
  in.read(head.data(), 8192);
  head.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  if (head.starts_with("\x89PNG\r\n\x1a\n")) return sized(number(head, 16, 4, true), number(head, 20, 4, true));
  if (head.starts_with("BM")) {
    const auto rows = static_cast<std::int32_t>(number(head, 22, 4, false));  // below 0: from the top
    return sized(number(head, 18, 4, false), rows < 0 ? -static_cast<std::int64_t>(rows) : rows);
  }
  if (head.size() > 2 && head[0] == 'P' && head[1] >= '1' && head[1] <= '6') return of_pnm(head);
  if (head.starts_with("II") || head.starts_with("MM")) return of_tiff(in, std::move(head));
  return std::nullopt;
}

}  // namespace isostrata
