#include "import/adaptive/amrex_header.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string_view>

#include "import/bytes/parsed_number.h"
#include "import/imported/list_file.h"

namespace isostrata {
namespace {

constexpr std::int64_t kMostComponents = 10'000, kMostPlotfileLevels = 64, kMostBoxes = 10'000'000;
constexpr std::int64_t kMostIndex = std::int64_t{1} << 40;

std::string text_of(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) throw Error(ErrorCode::not_found, file.filename().string() + ": is not there, or is not a file");
  check_text_size(file, 1024);
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Words and numbers one after the other; brackets and commas are blanks.
class Words {
 public:
  Words(std::string text, std::string name) : text_(std::move(text)), name_(std::move(name)) {}

  std::string_view line(const char* what) {
    if (at_ >= text_.size()) broken(std::string("ends before ") + what);
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    const std::string_view line = std::string_view(text_).substr(at_, end - at_);
    at_ = end + 1;
    return line.substr(0, line.find_last_not_of(" \t\r") + 1);
  }
  std::string_view word(const char* what) {
    constexpr std::string_view kBlanks = " \t\r\n(),";
    at_ = std::min(text_.find_first_not_of(kBlanks, at_), text_.size());
    const std::size_t end = std::min(text_.find_first_of(kBlanks, at_), text_.size());
    if (end == at_) broken(std::string("ends before ") + what);
    const std::string_view word = std::string_view(text_).substr(at_, end - at_);
    at_ = end;
    return word;
  }
  std::int64_t whole(const char* what, std::int64_t least, std::int64_t most) { return checked(word(what), what, least, most); }
  std::int64_t whole_line(const char* what, std::int64_t least, std::int64_t most) { return checked(line(what), what, least, most); }
  double real(const char* what) {
    const std::string_view text = word(what);
    const auto value = parsed_number<double>(text);
    if (!value || !std::isfinite(*value)) broken(std::string(what) + " is '" + std::string(text.substr(0, 40)) + "'; expected a finite number");
    return *value;
  }
  /// ((lowest cell) (highest cell) (0 0 0)); along axes that are not there the cell 0.
  CellRange box(const char* what, int dimensions) {
    CellRange range{{0, 0, 0}, {1, 1, 1}};
    for (auto* corner : {&range.lower, &range.upper})
      for (int axis = 0; axis < dimensions; ++axis) (*corner)[static_cast<std::size_t>(axis)] = whole(what, -kMostIndex, kMostIndex);
    for (std::size_t axis = 0; axis < static_cast<std::size_t>(dimensions); ++axis)
      if (++range.upper[axis] <= range.lower[axis]) broken(std::string(what) + " ends before it begins");
    for (int axis = 0; axis < dimensions; ++axis)
      if (whole(what, 0, 1) != 0) throw Error(ErrorCode::unsupported, name_ + ": " + what + " has its values on points; expected cells");
    return range;
  }
  std::size_t position() const { return at_; }
  const std::string& name() const { return name_; }
  [[noreturn]] void broken(const std::string& what) const { throw Error(ErrorCode::bad_data, name_ + ": " + what); }

 private:
  std::int64_t checked(std::string_view text, const char* what, std::int64_t least, std::int64_t most) const {
    const auto value = parsed_number<std::int64_t>(text);
    if (!value || *value < least || *value > most)
      broken(std::string(what) + " is '" + std::string(text.substr(0, 40)) + "'; expected a whole number from " + std::to_string(least) + " to " + std::to_string(most));
    return *value;
  }

  const std::string text_, name_;
  std::size_t at_ = 0;
};

std::string called(const std::filesystem::path& file) { return file.parent_path().filename().string() + "/" + file.filename().string(); }

}  // namespace

AmrexHeader read_amrex_header(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "Header";
  Words words(text_of(file), called(file));
  AmrexHeader header;
  words.line("its version");
  const std::int64_t components = words.whole_line("the number of components", 1, kMostComponents);
  for (std::int64_t c = 0; c < components; ++c) header.components.emplace_back(words.line("the names of components"));
  header.dimensions = static_cast<int>(words.whole("the number of dimensions", 1, 3));
  if (header.dimensions == 1) throw Error(ErrorCode::unsupported, words.name() + ": it has one dimension; expected cells with a volume or an area");
  header.time = words.real("the time");
  const std::int64_t finest = words.whole("the finest level", 0, kMostPlotfileLevels - 1);
  for (int axis = 0; axis < header.dimensions; ++axis) header.origin[axis] = words.real("the lowest corner");
  for (int axis = 0; axis < header.dimensions; ++axis) words.real("the highest corner");
  for (std::int64_t level = 0; level < finest; ++level) words.whole("a ratio of refinement", 1, 1024);
  header.levels.resize(static_cast<std::size_t>(finest) + 1);
  for (AmrexLevel& level : header.levels) level.first = words.box("the domain", header.dimensions).lower;
  for (std::int64_t level = 0; level <= finest; ++level) words.word("the steps of levels");
  for (AmrexLevel& level : header.levels)
    for (int axis = 0; axis < header.dimensions; ++axis) level.spacing[axis] = words.real("the size of cells");
  header.coordinates = static_cast<int>(words.whole("the kind of coordinates", 0, 2));
  words.word("the width of the border");
  for (std::int64_t number = 0; number <= finest; ++number) {
    words.whole("the number of a level", number, number);
    const std::int64_t boxes = words.whole("the number of boxes", 0, kMostBoxes);
    words.word("the time of a level");
    words.word("the step of a level");
    for (std::int64_t corner = 0; corner < boxes * header.dimensions * 2; ++corner) words.word("the corners of boxes");
    header.levels[static_cast<std::size_t>(number)].boxes_file = referred_file(file, std::string(words.word("the name of a level")) + "_H");
  }
  return header;
}

std::vector<AmrexBox> read_amrex_boxes(const AmrexLevel& level, const AmrexHeader& header) {
  Words words(text_of(level.boxes_file), called(level.boxes_file));
  const std::int64_t version = words.whole_line("its version", 0, 1000);
  if (version != 1) throw Error(ErrorCode::unsupported, words.name() + ": is of version " + std::to_string(version) + "; expected 1, with a header before each box (amrex: vismf.headerversion=1)");
  words.line("how its files are written");
  const auto components = static_cast<std::int64_t>(header.components.size());
  words.whole_line("the number of components", components, components);
  words.line("the number of ghost cells");
  const std::int64_t count = words.whole("the number of boxes", 0, kMostBoxes);
  words.word("a hash");
  std::vector<AmrexBox> boxes;
  for (std::int64_t box = 0; box < count; ++box) boxes.push_back({words.box("a box", header.dimensions), {}, 0});
  words.whole("the number of boxes on disk", count, count);
  std::string last;
  std::filesystem::path file;
  for (AmrexBox& box : boxes) {
    if (words.word("where the boxes are") != "FabOnDisk:") words.broken("expected 'FabOnDisk:' for each box");
    if (const std::string_view name = words.word("the file of a box"); name != last) file = referred_file(level.boxes_file, last = std::string(name));
    box.file = file;
    box.offset = static_cast<std::uint64_t>(words.whole("the place of a box", 0, std::int64_t{1} << 60));
  }
  return boxes;
}

AmrexFab read_amrex_fab(std::string_view text, int dimensions, const std::string& where) {
  constexpr std::size_t kLongest = 4096;
  if (!text.starts_with("FAB")) throw Error(ErrorCode::bad_data, where + ": expected 'FAB' there");
  const std::size_t end = text.substr(0, kLongest).find('\n');
  if (end == std::string_view::npos) throw Error(ErrorCode::bad_data, where + ": the header of a box does not end");
  Words words(std::string(text.substr(3, end - 3)), where);
  AmrexFab fab;
  for (std::int64_t count = words.whole("the length of a number's form", 8, 8); count > 0; --count) words.word("the form of numbers");
  const std::int64_t bytes = words.whole("the bytes of a number", 1, 16);
  if (bytes != 4 && bytes != 8) throw Error(ErrorCode::unsupported, where + ": numbers of " + std::to_string(bytes) + " bytes; expected 4 or 8");
  fab.type = bytes == 4 ? ScalarType::float32 : ScalarType::float64;
  const bool big = words.whole("the order of bytes", 1, bytes) == 1;
  for (std::int64_t byte = 1; byte < bytes; ++byte)
    if (words.whole("the order of bytes", 1, bytes) != (big ? byte + 1 : bytes - byte)) throw Error(ErrorCode::unsupported, where + ": the order of bytes is neither rising nor falling");
  fab.swapped = big != (std::endian::native == std::endian::big);
  fab.cells = words.box("a box", dimensions);
  fab.components = words.whole("the number of components", 1, kMostComponents);
  fab.length = end + 1;
  return fab;
}

}  // namespace isostrata
