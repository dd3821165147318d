#include "import/meshes/check_ensight.h"

#include <fnmatch.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "import/bytes/mapped_file.h"
#include "import/imported/imported.h"
#include "import/meshes/check_ensight_gold.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr int kMostLines = 1'000'000;

/// The files that a case names, with * where the number of a step stands: none may lie elsewhere.
struct CaseFiles {
  struct Values {
    std::string file;
    bool on_cells = false;
    std::uint64_t components = 1;
  };
  bool gold = false;
  std::string geometry;
  std::vector<Values> values;
};

/// VTK's reader takes a case's lines in one order, and each by its words.
class Order {
 public:
  explicit Order(const std::string& name) : name_(name) {}

  void check(const std::string& line) {
    static const std::set<std::string> kRead{"FORMAT", "GEOMETRY", "VARIABLE", "TIME", "FILE"}, kNotRead{"MATERIAL", "SCRIPTS", "BLOCK_CONTINUATION"};
    const std::string word = line.substr(0, line.find_first_of(" \t\r"));
    if (kNotRead.contains(word)) {
      if (section_ == "VARIABLE") ends_by_ = word;
      section_ = word;
    } else if (kRead.contains(word)) {
      if (!ends_by_.empty() && (word == "TIME" || word == "FILE"))
        throw Error(ErrorCode::bad_data, name_ + ": its section " + ends_by_ + " stands in front of " + word + "; expected it behind, as EnSight's manual has it");
      section_ = word;
    } else if (!kNotRead.contains(section_)) {
      check_blank(line);
    }
  }

 private:
  void check_blank(const std::string& line) const {
    const auto colon = line.find(':');
    if (colon == std::string::npos || colon + 1 == line.size() || std::isspace(static_cast<unsigned char>(line[colon + 1]))) return;
    if (line.starts_with("model") && line.find_last_not_of(" \t\r") > line.find_first_of(" \t", colon)) return;  // a time set and a file
    throw Error(ErrorCode::bad_data, name_ + ": expected a blank behind '" + line.substr(0, colon + 1) + "'");
  }

  const std::string& name_;
  std::string section_, ends_by_;
};

CaseFiles files_of(const fs::path& file) {
  const std::string name = file.filename().string();
  std::ifstream in(file);
  std::string line;
  bool format = false;
  std::set<std::string> named, there;  // sets of times, by their numbers
  CaseFiles files;
  Order order(name);
  for (int lines = 0; std::getline(in, line); ++lines) {
    if (lines > kMostLines) throw Error(ErrorCode::too_large, name + ": more than a million lines; a case is not that long");
    line.erase(0, std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.starts_with("#")) continue;
    order.check(line);
    if (line.starts_with("FORMAT")) format = true;
    if (line.starts_with("type:")) files.gold = line.find("gold") != std::string::npos;
    if (line.starts_with("number of steps:") && std::strtod(line.c_str() + 16, nullptr) > kMostLines)
      throw Error(ErrorCode::too_large, name + ": " + line + "; expected at most a million");
    const auto colon = line.find(':');
    if (colon == std::string::npos) continue;
    std::istringstream words(line.substr(colon + 1));
    if (line.starts_with("time")) {
      if (std::string number; line.starts_with("time set") && words >> number) there.insert(number);
      continue;
    }
    std::string word, first;  // first: behind the numbers of sets
    int names = 0;
    while (words >> std::quoted(word)) {
      ++names;
      check_name_below(file, word);
      if (first.empty() && word.find_first_not_of("0123456789") != std::string::npos) first = word;
      if (names == 1 && first.empty() && (line.starts_with("model") || line.find(" per ") < colon)) named.insert(word);
    }
    static const std::set<std::string> kPer{"node", "element", "measured node", "measured element", "case", "case file"};
    if (const auto per = line.find(" per "); per < colon && !kPer.contains(line.substr(per + 5, colon - per - 5)))
      throw Error(ErrorCode::bad_data, name + ": expected values per node, element, measured node, measured element or case in '" + line.substr(0, colon + 1) + "'");
    if (line.find(" per ") < colon && names < 2)
      throw Error(ErrorCode::bad_data, name + ": expected a name and a file behind '" + line.substr(0, colon + 1) + "'");
    if (line.starts_with("model")) files.geometry = first;
    const std::string kind = line.substr(0, colon);
    if (kind.ends_with("per node") || kind.ends_with("per element"))
      files.values.push_back({word, kind.ends_with("per element"),
                              kind.starts_with("vector") ? 3u : kind.starts_with("tensor symm") ? 6u : kind.starts_with("tensor asym") ? 9u : 1u});
  }
  if (!format) throw Error(ErrorCode::bad_data, name + ": expected a line FORMAT, as EnSight's cases have");
  for (const std::string& number : named)
    if (!there.contains(number)) throw Error(ErrorCode::bad_data, name + ": names files of the time set " + number + ", but has no line 'time set: " + number + "'");
  return files;
}

std::string_view text_of(const MappedFile& file) { return {reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()}; }

/// The numbers behind the lines of a text that begin with "part", on the same line (EnSight 6) or the next (Gold).
std::set<std::uint32_t> parts_of(std::string_view bytes) {
  std::set<std::uint32_t> parts;
  for (auto at = bytes.find("part"); at != std::string_view::npos; at = bytes.find("part", at + 4)) {
    if (at > 0 && bytes[at - 1] != '\n') continue;
    std::string_view behind = bytes.substr(at + 4, 100);
    behind.remove_prefix(std::min(behind.find_first_not_of(" \t\r\n"), behind.size()));
    std::uint32_t number = 0;
    if (std::from_chars(behind.data(), behind.data() + behind.size(), number).ec == std::errc()) parts.insert(number);
  }
  return parts;
}

enum class Beginning { text, binary, neither };

/// By its first 80 bytes VTK chooses one of three readers.
Beginning beginning_of(std::string_view bytes) {
  bytes = bytes.substr(0, 84);
  if (bytes.find("Binary") != std::string_view::npos) return Beginning::binary;
  return bytes.find('\0') == std::string_view::npos ? Beginning::text : Beginning::neither;
}

}  // namespace

void check_ensight_case(const fs::path& file) {
  const CaseFiles files = files_of(file);
  std::uintmax_t left = std::uintmax_t{256} << 20;
  const auto files_like = [&](const std::string& pattern) {
    const fs::path path = file.parent_path() / pattern;
    std::vector<fs::path> found;
    std::error_code error;
    for (fs::directory_iterator it(path.parent_path(), error), end; !error && it != end; it.increment(error)) {
      if (fnmatch(path.filename().c_str(), it->path().filename().c_str(), 0) != 0) continue;
      const std::uintmax_t size = it->file_size(error);
      left -= error ? left : std::min(left, size);
      if (left > 0) found.push_back(it->path());
    }
    return found;
  };
  const std::string name = file.filename().string();
  std::set<std::uint32_t> parts;
  std::optional<GoldParts> gold;  // of binary geometries the last one
  bool binary = false;
  const std::vector<fs::path> geometries = files_like(files.geometry);
  for (const fs::path& path : geometries) {
    const MappedFile geometry(path);
    const Beginning beginning = beginning_of(text_of(geometry));
    if (beginning == Beginning::binary) {
      binary = true;
      if (!files.gold || !text_of(geometry).starts_with("C Binary")) return;
      gold = check_gold_geometry(geometry.bytes(), path.filename().string());
      continue;
    }
    if (beginning == Beginning::neither)
      throw Error(ErrorCode::bad_data, name + ": expected its geometry '" + path.filename().string() + "' to begin with C Binary, Fortran Binary or a text");
    parts.merge(parts_of(text_of(geometry)));
  }
  if (binary) {
    if (!gold || geometries.size() != 1) return;
    for (const CaseFiles::Values& values : files.values)
      for (const fs::path& path : files_like(values.file))
        check_gold_values(MappedFile(path).bytes(), *gold, values.on_cells, values.components, path.filename().string());
    return;
  }
  if (left == 0) return;
  if (parts.empty()) throw Error(ErrorCode::bad_data, name + ": expected a part in its geometry '" + files.geometry + "', which has none or is not there");
  for (const CaseFiles::Values& values : files.values)
    for (const fs::path& path : files_like(values.file))
      for (const std::uint32_t part : parts_of(text_of(MappedFile(path))))
        if (!parts.contains(part))
          throw Error(ErrorCode::bad_data,
                      name + ": " + path.filename().string() + " has values of part " + std::to_string(part) + ", which its geometry '" + files.geometry + "' lacks");
}

}  // namespace isostrata
