#include "data/files/referred_names.h"

#include <algorithm>
#include <functional>
#include <set>
#include <sstream>
#include <string_view>

#include "data/files/file_beginning.h"
#include "data/files/nifti_mark.h"

namespace isostrata {
namespace {

constexpr std::size_t kMostNames = 200'000;

/// What stands in quotes after each `key` and a colon or an equals sign.
std::vector<std::string> quoted_after(std::string_view text, std::string_view key) {
  std::vector<std::string> names;
  for (auto at = text.find(key); at != std::string_view::npos && names.size() < kMostNames; at = text.find(key, at + 1)) {
    const auto quote = text.find_first_not_of(" \t\r\n:=", at + key.size());
    if (quote == std::string_view::npos || (text[quote] != '"' && text[quote] != '\'') || quote == at + key.size()) continue;
    const auto close = text.find(text[quote], quote + 1);
    if (close == std::string_view::npos) break;
    names.emplace_back(text.substr(quote + 1, close - quote - 1));
  }
  return names;
}

std::string trimmed(std::string text) {
  text.erase(0, text.find_first_not_of(" \t"));
  text.erase(text.find_last_not_of(" \t\r") + 1);
  return text;
}

/// The file of a line "key: file", or those of the lines that follow "key: LIST".
std::vector<std::string> of_header(const std::string& text, std::string_view key, char separator) {
  std::vector<std::string> names;
  std::istringstream lines(text.substr(0, 64 << 10));
  bool listed = false;
  for (std::string line; std::getline(lines, line);) {
    const auto at = line.find(separator);
    if (listed && !trimmed(line).empty()) names.push_back(trimmed(line));
    if (at == std::string::npos || small_letters(trimmed(line.substr(0, at))) != key) continue;
    const std::string value = trimmed(line.substr(at + 1));
    listed = value.starts_with("LIST");
    const auto percent = value.find('%');
    if (percent != std::string::npos) {  // slice_%03d.raw 1 64 1
      const auto d = value.find('d', percent), space = value.find(' ');
      if (d != std::string::npos) names.push_back(value.substr(0, percent) + "*" + value.substr(d + 1, space == std::string::npos ? space : space - d - 1));
    } else if (!listed && small_letters(value) != "local") {
      names.push_back(value);
    }
  }
  return names;
}

std::vector<std::string> of_ensight(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const auto colon = line.find(':');
    if (colon == std::string::npos || line.starts_with("time") || line.starts_with("#")) continue;
    std::istringstream words(line.substr(colon + 1));
    std::string last;
    for (std::string word; words >> word;)
      if (word.find_first_not_of("0123456789.") != std::string::npos && !word.starts_with("change_coords") && !word.starts_with("[")) last = word;
    if (const auto star = last.find('*'); star != std::string::npos) last.replace(star, last.find_last_of('*') - star + 1, "*");
    if (!last.empty()) names.push_back(last);
  }
  return names;
}

/// The files in "FILE:/ARRAY" and in the texts of DataItems of binary files, each once.
std::vector<std::string> of_xdmf(std::string_view text) {
  std::set<std::string, std::less<>> names;
  for (const std::string& name : quoted_after(text, "href")) names.insert(name);
  for (auto at = text.find("<DataItem"); at != std::string_view::npos && names.size() < kMostNames; at = text.find("<DataItem", at + 1)) {
    const auto open = text.find('>', at), close = text.find('<', open);
    if (close == std::string_view::npos) break;
    const std::string_view element = text.substr(at, open - at);
    const bool binary = element.find("\"Binary\"") != std::string_view::npos;
    if (!binary && element.find("\"HDF") == std::string_view::npos) continue;
    const std::string_view inside = text.substr(open + 1, close - open - 1);
    const auto begin = std::min(inside.find_first_not_of(" \t\r\n"), inside.size()), end = binary ? inside.find_last_not_of(" \t\r\n") + 1 : inside.find(':');
    if (end != std::string_view::npos && begin < end && !names.contains(inside.substr(begin, end - begin))) names.emplace(inside.substr(begin, end - begin));
  }
  return {names.begin(), names.end()};
}

std::vector<std::string> of_volume_text(const std::string& text) {
  std::vector<std::string> names = of_header(text, "rawfile", ':');
  return names.empty() ? of_header(text, "objectfilename", ':') : names;
}

/// "file: . 512" is the file itself.
std::vector<std::string> of_mrtrix(const std::string& text) {
  std::vector<std::string> names = of_header(text.substr(0, text.find("\nEND")), "file", ':');
  for (std::string& name : names) name = name.substr(0, name.find(' '));
  std::erase(names, ".");
  return names;
}

/// What holds the values of a pair is the header's.
std::vector<std::string> of_nifti_header(const std::filesystem::path& file) {
  if (small_letters(file.extension().string()) != ".hdr") return {};
  return {other_of_nifti_pair(file).filename().string()};
}

}  // namespace

std::vector<std::string> referred_names(const std::filesystem::path& file, const Recognised& of) {
  switch (of.kind) {
    case FileKind::vtk_xml:
      return of.vtk_type.starts_with("P") && of.vtk_type != "PolyData" ? quoted_after(file_beginning(file), "Source") : std::vector<std::string>{};
    case FileKind::pvd:
    case FileKind::multi_block:
    case FileKind::vtk_levels:
      return quoted_after(file_beginning(file), "file");
    case FileKind::series:
      return quoted_after(file_beginning(file), "\"name\"");
    case FileKind::xdmf:
      return of_xdmf(file_beginning(file));
    case FileKind::nrrd:
      return of_header(file_beginning(file), "data file", ':');
    case FileKind::meta_image:
      return of_header(file_beginning(file), "elementdatafile", '=');
    case FileKind::bov:
      return of_header(file_beginning(file), "data_file", ':');
    case FileKind::volume_text:
      return of_volume_text(file_beginning(file));
    case FileKind::mrtrix:
      return of_mrtrix(file_beginning(file));
    case FileKind::ensight:
      return of_ensight(file_beginning(file));
    case FileKind::nifti:
      return of_nifti_header(file);
    default:
      return {};
  }
}

}  // namespace isostrata
