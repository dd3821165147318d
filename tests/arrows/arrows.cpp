#include "arrows/arrows.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr int kNoRoom = -1;

int rank_of(const std::string& room) {
  const auto at = std::find(rooms().begin(), rooms().end(), room);
  return at == rooms().end() ? kNoRoom : static_cast<int>(at - rooms().begin());
}

// The rightmost room that a file may include. The import child reads files into data's vocabulary and goes no further; it may use
// its own headers, as every room may.
int reach_of(const std::string& room) { return rank_of(room == "import" ? "data" : room); }

bool is_source(const fs::path& path) {
  static const std::set<std::string> extensions{".h", ".hpp", ".cpp", ".cc", ".glsl", ".vert", ".frag", ".comp"};
  return extensions.contains(path.extension().string());
}

struct Include {
  int line;
  std::string path;
  bool in_angle_brackets;
};

std::vector<Include> includes_of(const fs::path& file) {
  static const std::regex pattern(R"re(^\s*#\s*include\s*([<"])([^>"]+)[>"])re");
  std::ifstream in(file);
  std::vector<Include> found;
  std::string text;
  for (int line = 1; std::getline(in, text); ++line) {
    std::smatch match;
    if (std::regex_search(text, match, pattern)) found.push_back({line, match[2], match[1] == "<"});
  }
  return found;
}

std::string first_folder(const std::string& path) { return path.substr(0, path.find('/')); }

// The folders of a room in their order, as its CMakeLists.txt gives them: isostrata_room(... FOLDERS a b c PUBLIC ...), and import, which is no
// library, set(FOLDERS a b c).
std::vector<std::string> folders_of(const fs::path& room) {
  std::ifstream in(room / "CMakeLists.txt");
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  static const std::regex call(R"re((?:isostrata_room\(\w+\s+|set\()FOLDERS\s+([a-z_0-9\s]+))re");
  std::smatch match;
  if (!std::regex_search(text, match, call)) return {};
  std::istringstream names(match[1]);
  return {std::istream_iterator<std::string>(names), {}};
}

class Checker {
 public:
  explicit Checker(fs::path root) : root_(std::move(root)) {}

  std::vector<std::string> run() {
    if (!fs::is_directory(root_ / "server")) throw std::runtime_error(root_.string() + ": expected a folder 'server' in it");
    for (const auto& entry : fs::directory_iterator(root_ / "server"))
      if (const auto name = entry.path().filename().string();
          entry.is_directory() && name != "import" && rank_of(name) == kNoRoom)
        complain(entry.path(), 0, "is not a room");
    std::vector<std::string> with_folders = rooms();
    with_folders.push_back("import");
    for (const std::string& room : with_folders)
      if (auto folders = folders_of(root_ / "server" / room); !folders.empty()) {
        check_folders(root_ / "server" / room, folders);
        folders_[room] = std::move(folders);
      }
    for (const char* top : {"server", "client", "protocol"})
      if (fs::is_directory(root_ / top))
        for (const auto& entry : fs::recursive_directory_iterator(root_ / top))
          if (entry.is_regular_file()) check_file(entry.path(), top);
    for (const auto& [name, places] : types_)
      for (auto it = std::next(places.begin()); it != places.end(); ++it)
        complain(it->first, it->second,
                 name + " has this name in " + places.begin()->first.lexically_relative(root_).generic_string() + ", too");
    std::sort(broken_.begin(), broken_.end());
    return broken_;
  }

 private:
  void complain(const fs::path& file, int line, const std::string& what) {
    std::string where = file.lexically_relative(root_).generic_string();
    if (line) where.append(":").append(std::to_string(line));
    broken_.push_back(where.append(": ").append(what));
  }

  void check_file(const fs::path& file, const std::string& top) {
    static const std::regex empty_name(R"re((^|_)(utils?|common|helpers?|managers?|misc)(_|$))re");
    if (std::regex_search(file.stem().string(), empty_name)) complain(file, 0, "is named for nothing");
    if (file.extension() == ".proto") check_proto(file);
    if (!is_source(file)) return;
    const std::string room = top == "server" ? first_folder(file.lexically_relative(root_ / "server").generic_string()) : top;
    for (const Include& include : includes_of(file)) check_include(file, room, include);
    if (file.extension() == ".h") note_types(file);
  }

  void check_folders(const fs::path& room, const std::vector<std::string>& folders) {
    std::set<std::string> with_sources;
    for (const auto& entry : fs::recursive_directory_iterator(room)) {
      if (!entry.is_regular_file() || !is_source(entry.path())) continue;
      const std::string path = entry.path().lexically_relative(room).generic_string();
      if (path.find('/') == std::string::npos) {
        complain(entry.path(), 0, "is in none of the room's folders");
      } else if (const std::string folder = first_folder(path); with_sources.insert(folder).second &&
                                                               std::find(folders.begin(), folders.end(), folder) == folders.end()) {
        complain(room / folder, 0, "is not among the FOLDERS of the room's CMakeLists.txt");
      }
    }
    for (const std::string& folder : folders)
      if (!with_sources.contains(folder)) complain(room / "CMakeLists.txt", 0, "FOLDERS names " + folder + ", which has no source");
  }

  void check_folder_order(const fs::path& file, const std::string& room, const Include& include) {
    const auto it = folders_.find(room);
    if (it == folders_.end()) return;
    const auto rank = [&](const std::string& folder) { return std::find(it->second.begin(), it->second.end(), folder); };
    const auto from = rank(first_folder(file.lexically_relative(root_ / "server" / room).generic_string()));
    const auto to = rank(first_folder(include.path.substr(room.size() + 1)));
    if (to != it->second.end() && from < to)
      complain(file, include.line, room + "/" + *from + " may not include " + room + "/" + *to + ": " + include.path);
  }

  // Two types of one name that differ are not an error to a linker, which keeps the code of one for both.
  void note_types(const fs::path& file) {
    static const std::regex scope(R"re(^namespace ([\w:]+) \{)re"),
        type(R"re(^(?:struct|class) (\w+)(?: final)?(?: : [^;]+)? \{)re");
    std::ifstream in(file);
    std::string text, within;
    for (int line = 1; std::getline(in, text); ++line) {
      std::smatch match;
      if (std::regex_search(text, match, scope)) within = match[1].str() + "::";
      if (std::regex_search(text, match, type)) types_[within + match[1].str()].emplace(file, line);
    }
  }

  void check_include(const fs::path& file, const std::string& room, const Include& include) {
    // Angle brackets are for the system and for libraries (<net/if.h>), unless they happen to reach one of ours.
    const bool ours = fs::exists(root_ / "server" / include.path) || first_folder(include.path) == "isostrata";
    if (include.in_angle_brackets && !ours) return;
    // A name without a folder, or one that is found beside the file, is the room's own.
    if (include.path.find('/') == std::string::npos || fs::exists(file.parent_path() / include.path)) return;
    const std::string wanted = first_folder(include.path);
    if (wanted == room) return check_folder_order(file, room, include);
    if (include.path.starts_with("isostrata/v1/")) {  // generated: the one place where Protobuf meets our types is session
      if (rank_of(room) != kNoRoom && rank_of(room) < rank_of("session"))
        complain(file, include.line, "Protobuf left of session: " + include.path);
    } else if (wanted == "isostrata" || wanted == "client") {  // isostrata/x.h is the client library's
      if (room != "client") complain(file, include.line, room + " may not include the client: " + include.path);
    } else if (rank_of(wanted) == kNoRoom) {
      complain(file, include.line, "no such room: " + include.path);
    } else if (reach_of(room) < rank_of(wanted)) {
      complain(file, include.line, room + " may not include " + wanted + ": " + include.path);
    }
  }

  void check_proto(const fs::path& file) {
    static const std::regex proto3(R"re(^\s*syntax\s*=\s*"proto3"\s*;)re");
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);)
      if (std::regex_search(line, proto3)) return;
    complain(file, 0, "is not proto3");
  }

  fs::path root_;
  std::vector<std::string> broken_;
  std::map<std::string, std::vector<std::string>> folders_;  // of the rooms that have some
  std::map<std::string, std::map<fs::path, int>> types_;  // where each is defined
};

}  // namespace

const std::vector<std::string>& rooms() {
  static const std::vector<std::string> order{"base",     "tables", "data",   "scene",   "extraction", "rendering",
                                              "encoding", "engine", "worker", "session", "net",        "main",
                                              "bench", "rank"};
  return order;
}

std::vector<std::string> broken_arrows(const fs::path& root) { return Checker(root).run(); }

}  // namespace isostrata
