#include "rendering/annotations/other_fonts.h"

#include <ft2build.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>
#include <utility>
#include <vector>
#include FT_FREETYPE_H

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolders[] = {"/usr/share/fonts", "/usr/local/share/fonts"};
constexpr int kMostEntries = 10000, kMostSearches = 64;

/// Those that read best beside the program's own first.
int rank_of(const std::string& name) {
  const auto has = [&](const char* part) { return name.find(part) != std::string::npos; };
  if (has("Bold") || has("Italic") || has("Oblique") || has("Light") || has("Black") || has("Thin") || has("Condensed")) return 2;
  return has("Sans") || has("Gothic") || has("Hei") ? 0 : 1;
}

class OtherFonts {
 public:
  std::string with(char32_t character) {
    const std::lock_guard lock(mutex_);
    if (const auto known = known_.find(character); known != known_.end()) return known->second;
    std::string file = first_of(found_, character);
    if (file.empty() && searches_ < kMostSearches) {
      ++searches_;
      if (searches_ == 1) list();
      file = first_of(all_, character);
      if (!file.empty()) found_.push_back(file);
    }
    if (known_.size() < 100000) known_.emplace(character, file);
    return file;
  }

 private:
  void list() {
    int entries = 0;
    for (const char* folder : kFolders) {
      std::error_code error;
      fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, error);
      for (; !error && at != fs::recursive_directory_iterator() && ++entries < kMostEntries; at.increment(error)) {
        const std::string end = at->path().extension().string();
        if (end == ".ttf" || end == ".otf" || end == ".ttc" || end == ".otc") all_.push_back(at->path().string());
      }
    }
    std::sort(all_.begin(), all_.end(), [](const std::string& a, const std::string& b) {
      return std::pair(rank_of(fs::path(a).filename().string()), a) < std::pair(rank_of(fs::path(b).filename().string()), b);
    });
  }

  static std::string first_of(const std::vector<std::string>& files, char32_t character) {
    FT_Library library = nullptr;
    if (files.empty() || FT_Init_FreeType(&library) != 0) return {};
    std::string file;
    for (const std::string& of : files) {
      FT_Face face = nullptr;
      if (FT_New_Face(library, of.c_str(), 0, &face) != 0) continue;
      const bool has = FT_IS_SCALABLE(face) && FT_Get_Char_Index(face, character) != 0;
      FT_Done_Face(face);
      if (!has) continue;
      file = of;
      break;
    }
    FT_Done_FreeType(library);
    return file;
  }

  std::mutex mutex_;  // guards the rest
  std::vector<std::string> all_, found_;
  std::map<char32_t, std::string> known_;
  int searches_ = 0;
};

}  // namespace

std::string font_with(char32_t character) {
  static OtherFonts fonts;
  return fonts.with(character);
}

}  // namespace isostrata
