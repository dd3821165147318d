#include "import/meshes/check_ensight_gold.h"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "base/error.h"

namespace isostrata {
namespace {

constexpr std::int32_t kMostParts = 65536;  // a larger number means the other byte order, as VTK has it

struct Kind {
  std::string_view name;
  std::uint64_t points;
};
constexpr Kind kKinds[] = {{"point", 1},  {"bar2", 2},     {"bar3", 3},   {"tria3", 3},   {"tria6", 6},     {"quad4", 4},   {"quad8", 8},   {"tetra4", 4},
                           {"tetra10", 10}, {"pyramid5", 5}, {"pyramid13", 13}, {"penta6", 6}, {"penta15", 15}, {"hexa8", 8}, {"hexa20", 20}};

/// Of a cell of this name, or of a ghost cell; 0: this knows no such cells.
std::uint64_t points_of(std::string_view kind) {
  if (kind.starts_with("g_")) kind.remove_prefix(2);
  for (const Kind& known : kKinds)
    if (kind == known.name) return known.points;
  return 0;
}

/// Lines of 80 bytes, and numbers of four.
class GoldFile {
 public:
  GoldFile(std::span<const std::byte> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  bool ended() const { return at_ == bytes_.size(); }
  std::string line() {
    const auto here = take(80);
    const std::string_view text(reinterpret_cast<const char*>(here.data()), here.size());
    const auto end = std::min(text.find_first_of(std::string_view("\0\r\n", 3)), text.size());
    const auto last = text.substr(0, end).find_last_not_of(' ');
    return std::string(text.substr(0, last == std::string_view::npos ? 0 : last + 1));
  }
  std::int32_t number() {
    std::uint32_t value = 0;
    std::memcpy(&value, take(4).data(), 4);
    return static_cast<std::int32_t>(swapped_ ? __builtin_bswap32(value) : value);
  }
  /// The first one says in which order bytes are.
  std::int32_t part() {
    const std::int32_t value = number();
    if (known_ || (value >= 0 && value < kMostParts)) return known_ = true, value;
    known_ = swapped_ = true;
    return static_cast<std::int32_t>(__builtin_bswap32(static_cast<std::uint32_t>(value)));
  }
  std::uint64_t count(const char* of) {
    const std::int32_t value = number();
    if (value < 0) fail("declares " + std::to_string(value) + " " + of);
    return static_cast<std::uint64_t>(value);
  }
  /// Numbers whose values VTK may have as they are.
  void step_over(std::uint64_t numbers, std::uint64_t times = 1) {
    for (std::uint64_t i = 0; i < times; ++i) take(numbers, 4);
  }
  /// The sum of these, none of them below 0.
  std::uint64_t sum(std::uint64_t numbers) {
    std::uint64_t all = 0;
    check(numbers, 4);
    for (std::uint64_t i = 0; i < numbers; ++i) all += count("points of a cell");
    return all;
  }
  void ids(std::uint64_t numbers, std::uint64_t points) {
    check(numbers, 4);
    for (std::uint64_t i = 0; i < numbers; ++i)
      if (const std::int32_t id = number(); id < 1 || static_cast<std::uint64_t>(id) > points)
        fail("has a cell with point " + std::to_string(id) + " in a part of " + std::to_string(points));
  }
  [[noreturn]] void fail(const std::string& why) const { throw Error(ErrorCode::bad_data, name_ + ": " + why); }

 private:
  void check(std::uint64_t count, std::uint64_t size) const {
    if (count > (bytes_.size() - at_) / size) fail("ends early: at byte " + std::to_string(at_) + " " + std::to_string(count) + " numbers or more are expected");
  }
  std::span<const std::byte> take(std::uint64_t count, std::uint64_t size = 1) {
    check(count, size);
    const auto here = bytes_.subspan(at_, static_cast<std::size_t>(count * size));
    at_ += here.size();
    return here;
  }

  const std::span<const std::byte> bytes_;
  const std::string& name_;
  std::size_t at_ = 0;
  bool known_ = false, swapped_ = false;
};

/// The points of a structured part, and the cells' numbers behind them.
void read_block(GoldFile& file, const std::string& line, GoldPart& part) {
  part.block = true;
  std::uint64_t points = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t along = file.count("points along an axis");
    if (along == 0 || __builtin_mul_overflow(points, along, &points)) file.fail("has a block without points, or of too many");
  }
  part.points = points;
  file.step_over(points, 3);
  if (line.find("iblanked") != std::string::npos) file.step_over(points);
}

/// Cells of one kind; false if this knows no such.
bool read_cells(GoldFile& file, const std::string& kind, bool ids, GoldPart& part) {
  const bool sided = kind == "nsided" || kind == "g_nsided", faced = kind == "nfaced" || kind == "g_nfaced";
  const std::uint64_t points = points_of(kind);
  if (points == 0 && !sided && !faced) return false;
  const std::uint64_t cells = file.count("cells");
  if (ids) file.step_over(cells);
  part.cells[kind] += cells;
  std::uint64_t numbers = 0;
  if (sided)
    numbers = file.sum(cells);
  else if (faced)
    numbers = file.sum(file.sum(cells));
  else if (__builtin_mul_overflow(cells, points, &numbers))
    file.fail("has too many cells");
  file.ids(numbers, part.points);
  return true;
}

}  // namespace

std::optional<GoldParts> check_gold_geometry(std::span<const std::byte> bytes, const std::string& name) {
  GoldFile file(bytes, name);
  file.line();  // C Binary
  std::string line = file.line();
  if (line.starts_with("BEGIN TIME STEP")) return std::nullopt;
  file.line();
  const std::string nodes = file.line(), elements = file.line();
  const auto has_ids = [](const std::string& text) { return text.ends_with("given") || text.ends_with("ignore"); };
  const bool node_ids = has_ids(nodes), element_ids = has_ids(elements);
  if (!nodes.starts_with("node id") || !elements.starts_with("element id")) file.fail("expected lines 'node id' and 'element id' behind two of description");
  GoldParts parts;
  if (file.ended()) return parts;
  line = file.line();
  if (line.starts_with("extents")) {
    file.step_over(6);
    if (file.ended()) return parts;
    line = file.line();
  }
  while (line.starts_with("part")) {
    GoldPart& part = parts[file.part()];
    part = {};
    file.line();  // what it is called
    line = file.line();
    if (line.starts_with("block")) {
      if (line.find("range") != std::string::npos || line.find("ghost") != std::string::npos || line.find("uniform") != std::string::npos ||
          line.find("rectilinear") != std::string::npos)
        return std::nullopt;
      read_block(file, line, part);
    } else if (line == "coordinates") {
      part.points = file.count("points");
      if (node_ids) file.step_over(part.points);
      file.step_over(part.points, 3);
    } else {
      file.fail("expected 'coordinates' or 'block' in a part, not '" + line + "'");
    }
    for (;;) {  // its cells
      if (file.ended()) return parts;
      line = file.line();
      if (line.starts_with("part")) break;
      if (part.block || !read_cells(file, line, element_ids, part)) file.fail("expected a part or a kind of cells, not '" + line + "'");
    }
  }
  file.fail("expected a part, not '" + line + "'");
}

void check_gold_values(std::span<const std::byte> bytes, const GoldParts& parts, bool on_cells, std::uint64_t components, const std::string& name) {
  GoldFile file(bytes, name);
  if (file.line().starts_with("BEGIN TIME STEP") || file.ended()) return;
  std::string line = file.line();
  while (line.starts_with("part")) {
    const std::int32_t number = file.part();
    const auto part = parts.find(number);
    if (part == parts.end()) file.fail("has values of part " + std::to_string(number) + ", which its geometry lacks");
    for (;;) {
      if (file.ended()) return;
      line = file.line();
      if (line.starts_with("part")) break;
      std::uint64_t values = part->second.points;
      if (on_cells) {
        const auto kind = part->second.cells.find(line);
        if (kind == part->second.cells.end()) return;  // of a block, or only some of them
        values = kind->second;
      } else if (line != "coordinates" && line != "block") {
        return;
      }
      file.step_over(values, components);
    }
  }
}

}  // namespace isostrata
