#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>

#include "data/files/raw_name.h"
#include "data/files/recognise.h"
#include "import/bytes/mapped_file.h"
#include "import/bytes/swap_bytes.h"
#include "import/bytes/text_numbers.h"
#include "import/bytes/trimmed.h"
#include "import/bytes/unpack_bytes.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

/// "Lattice { float[3] Velocity } @2(HxZip,1234)".
struct Field {
  std::string name, mark, coding;  // mark: "@2"; coding: "", "HxZip", "HxByteRLE"
  ScalarType type = ScalarType::uint8;
  int components = 1;
  std::size_t bytes = 0;  // as they are packed
};

/// Bytes that are repeated so many times, and bytes that are not: a number below 128 and a byte, or 128 and more and so many bytes. How many were made; more than there is room for if it fails.
std::size_t unpack_runs(std::span<const std::byte> from, std::span<std::byte> to) {
  std::size_t at = 0;
  while (!from.empty()) {
    const auto head = static_cast<unsigned>(from[0]);
    const std::size_t count = head & 127u, taken = head & 128u ? 1 + count : 2;
    if (taken > from.size() || count > to.size() - at) return to.size() + 1;
    if (head & 128u)
      std::memcpy(to.data() + at, from.data() + 1, count);
    else
      std::memset(to.data() + at, static_cast<int>(from[1]), count);
    at += count;
    from = from.subspan(taken);
  }
  return at;
}

class AmiraMesh {
 public:
  explicit AmiraMesh(const ReadRequest& request) : request_(request), name_(request.file.filename().string()), file_(std::make_shared<const MappedFile>(request.file)) {}

  Imported read() {
    const std::string_view all(reinterpret_cast<const char*>(file_->bytes().data()), file_->bytes().size());
    const std::string_view first = all.substr(0, all.find('\n'));
    text_ = first.find("ASCII") != std::string_view::npos;
    little_ = first.find("LITTLE") != std::string_view::npos;
    const auto begin = all.find("\n@");
    if (begin == std::string_view::npos || begin > kMostHeader) throw Error(ErrorCode::bad_data, name_ + ": has no data section (@1) behind its header");
    header_ = all.substr(0, begin + 1);
    data_ = all.substr(begin);
    const auto lattice = line_of("define Lattice");
    if (!lattice) throw Error(ErrorCode::unsupported, name_ + ": an AmiraMesh without a Lattice, which is a surface, a mesh or lines; expected a field on a regular grid");
    read_sizes(*lattice);
    if (const auto kind = line_of("CoordType"); kind && kind->find("uniform") == std::string_view::npos)
      throw Error(ErrorCode::unsupported, name_ + ": its grid is of type " + std::string(trimmed(*kind)).substr(0, 32) + "; expected \"uniform\"");
    Imported imported;
    Block block;
    place(block);
    for (const Field& field : fields()) block.arrays.push_back(values(field));
    if (block.arrays.empty()) throw Error(ErrorCode::bad_data, name_ + ": its Lattice has no data");
    imported.blocks.push_back(std::move(block));
    if (const auto unit = line_of("Coordinates \"")) imported.axes[0].unit = imported.axes[1].unit = imported.axes[2].unit = std::string(unit->substr(0, unit->find('"')));
    return imported;
  }

 private:
  static constexpr std::size_t kMostHeader = 16 << 20;

  /// What follows these words in the header, to the end of the line.
  std::optional<std::string_view> line_of(std::string_view words) const {
    const auto at = header_.find(words);
    if (at == std::string_view::npos) return std::nullopt;
    const std::string_view rest = header_.substr(at + words.size());
    return rest.substr(0, rest.find_first_of("\n\r"));
  }
  void read_sizes(std::string_view line) {
    const std::string numbers(line);
    TextNumbers text(numbers, name_);
    for (std::int64_t& size : dims_) size = text.number_follows() ? text.integer("a size of the Lattice", std::int64_t{1} << 40) : 0;
    if (dims_[2] == 0 && dims_[0] > 0 && dims_[1] > 0) dims_[2] = 1;
    if (dims_[0] < 1 || dims_[1] < 1 || dims_[2] < 1) throw Error(ErrorCode::bad_data, name_ + ": its Lattice has no three sizes of at least 1");
    points_ = checked_product({dims_[0], dims_[1], dims_[2]}, name_);
  }
  /// The box reaches from the first point to the last one.
  void place(Block& block) const {
    std::array<double, 3> origin{};
    std::array<std::array<double, 3>, 3> step{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    if (const auto box = line_of("BoundingBox")) {
      std::string numbers(*box);
      std::replace(numbers.begin(), numbers.end(), ',', ' ');
      TextNumbers text(numbers, name_);
      for (std::size_t a = 0; a < 3; ++a) {
        origin[a] = text.number("the BoundingBox");
        const double end = text.number("the BoundingBox");
        if (dims_[a] > 1) step[a][a] = (end - origin[a]) / static_cast<double>(dims_[a] - 1);
      }
    }
    place_image(block, dims_, origin, step, name_);
  }

  std::vector<Field> fields() const {
    std::vector<Field> all;
    for (auto at = header_.find("\nLattice"); at != std::string_view::npos && all.size() < 256; at = header_.find("\nLattice", at + 1)) {
      std::string_view line = header_.substr(at + 8, header_.find('\n', at + 1) - at - 8);
      const auto open = line.find('{'), close = line.find('}'), mark = line.find('@');
      if (open == std::string_view::npos || close == std::string_view::npos || mark == std::string_view::npos || close < open || mark < close) continue;
      all.push_back(field(trimmed(line.substr(open + 1, close - open - 1)), trimmed(line.substr(mark))));
    }
    return all;
  }
  Field field(std::string_view what, std::string_view where) const {
    Field field;
    const auto blank = what.find_first_of(" \t");
    std::string_view type = what.substr(0, blank);
    field.name = blank == std::string_view::npos ? "" : std::string(trimmed(what.substr(blank)));
    if (const auto bracket = type.find('['); bracket != std::string_view::npos) {
      const auto count = parsed_number<int>(type.substr(bracket + 1, type.find(']') - bracket - 1));
      if (!count || *count < 1 || *count > 256) throw Error(ErrorCode::unsupported, name_ + ": '" + std::string(type.substr(0, 32)) + "' has no number of components from 1 to 256");
      field.components = *count;
      type = type.substr(0, bracket);
    }
    const auto scalar = scalar_type_named(small_letters(std::string(type)));
    if (!scalar) throw Error(ErrorCode::unsupported, name_ + ": values of type '" + std::string(type.substr(0, 32)) + "'; expected byte, short, ushort, int, float or double");
    field.type = *scalar;
    const auto open = where.find('(');
    field.mark = std::string(trimmed(where.substr(0, open)));
    if (open == std::string_view::npos) return field;
    const std::string_view inside = where.substr(open + 1, where.find(')') - open - 1);
    const auto comma = inside.find(',');
    field.coding = std::string(trimmed(inside.substr(0, comma)));
    const auto bytes = comma == std::string_view::npos ? std::nullopt : parsed_number<std::size_t>(trimmed(inside.substr(comma + 1)));
    if ((field.coding != "HxZip" && field.coding != "HxByteRLE") || !bytes)
      throw Error(ErrorCode::unsupported, name_ + ": values that are packed by '" + std::string(inside.substr(0, 32)) + "'; expected HxZip or HxByteRLE and a number of bytes");
    field.bytes = *bytes;
    return field;
  }
  /// What is behind the mark's line.
  std::string_view section(const Field& field) const {
    const auto at = data_.find("\n" + field.mark + "\n");
    if (at == std::string_view::npos) throw Error(ErrorCode::bad_data, name_ + ": has no section " + field.mark.substr(0, 16) + ", the values of " + field.name);
    return data_.substr(at + field.mark.size() + 2);
  }
  FileArray values(const Field& field) const {
    FileArray array;
    array.name = field.name;
    array.type = field.type;
    array.components = field.components;
    const std::size_t width = size_of(field.type);
    const auto bytes = static_cast<std::size_t>(checked_product({points_, field.components, static_cast<std::int64_t>(width)}, name_));
    const std::string_view there = section(field);
    const auto refuse_short = [&](std::size_t present) {
      throw Error(ErrorCode::bad_data, name_ + ": " + field.name + " takes " + std::to_string(bytes) + " bytes; " + std::to_string(present) + " present");
    };
    const std::size_t present = field.coding.empty() ? there.size() : std::min(field.bytes, there.size());
    const auto from = std::as_bytes(std::span(there.data(), present));
    if (field.coding.empty() && !text_ && present < bytes) refuse_short(present);
    if (field.coding.empty() && !text_ && (little_ || width == 1) && reinterpret_cast<std::uintptr_t>(from.data()) % width == 0) {
      array.values = from.first(bytes);
      array.storage = file_;
      return array;
    }
    // Text takes two bytes a number at least, zlib at most 1032 times fewer bytes, runs 63 times.
    if ((text_ && bytes / width > there.size()) || (!text_ && !field.coding.empty() && bytes / 1100 > present)) refuse_short(present);
    check_bytes(request_, bytes, name_);
    auto [storage, to] = allocate<std::byte>(bytes);
    if (text_) {
      read_text(field, there, to);
    } else if (field.coding.empty()) {
      std::memcpy(to.data(), from.data(), bytes);
    } else if (const std::size_t made = field.coding == "HxZip" ? inflate_all(from, to) : unpack_runs(from, to); made != bytes) {
      throw Error(ErrorCode::bad_data, name_ + ": the packed values of " + field.name + " are damaged");
    }
    if (!text_ && !little_ && width > 1) swap_bytes(to, width);
    array.values = to;
    array.storage = storage;
    return array;
  }
  void read_text(const Field& field, std::string_view there, std::span<std::byte> to) const {
    TextNumbers text(there, name_);
    for (std::size_t at = 0; at < to.size(); at += size_of(field.type)) {
      const double value = text.number("a value");
      std::visit(
          [&]<class T>(std::span<const T>) {
            // Of 64 bits the upper end is not a double; nobody writes it.
            if (std::is_integral_v<T> && !(value >= static_cast<double>(std::numeric_limits<T>::lowest()) && value < static_cast<double>(std::numeric_limits<T>::max()) + 1 && value == std::floor(value)))
              throw Error(ErrorCode::bad_data, name_ + ": " + std::to_string(value) + " among the numbers of " + field.name + ", which are of type " + to_string(field.type));
            const T one = static_cast<T>(value);
            std::memcpy(to.data() + at, &one, sizeof one);
          },
          scalar_span(field.type, {}));
    }
  }

  const ReadRequest& request_;
  const std::string name_;
  const std::shared_ptr<const MappedFile> file_;
  bool text_ = false, little_ = false;
  std::string_view header_, data_;
  std::array<std::int64_t, 3> dims_{};
  std::int64_t points_ = 0;
};

}  // namespace

// AmiraMesh, of Amira and Avizo: fields on a uniform Lattice. After T. Weinkauf, "Reading AmiraMesh Files for Scalar and Vector Fields", and the files themselves.
Imported read_amira(const ReadRequest& request) {
  check_step(request, 1);
  return AmiraMesh(request).read();
}

}  // namespace isostrata
