#include "import/ensight_quotes.h"

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestLine = 250;  // the reader's own are of 256 bytes

struct Line {
  std::string key;                 // with its colon
  std::vector<std::string> words;  // behind it, without quotes
  std::size_t file = 0;            // which of them is a file's name; their number if none is
};

/// "model: [sets] FILE [more]", "scalar per node: [sets] NAME FILE"; nothing else names files that the reader opens.
Line line_of(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t"), colon = text.find(':');
  if (begin == std::string::npos || colon == std::string::npos || text[begin] == '#') return {};
  Line out{text.substr(begin, colon + 1 - begin), {}, 0};
  std::istringstream words(text.substr(colon + 1));
  for (std::string word; words >> std::quoted(word);) out.words.push_back(word);
  const auto number = [](const std::string& word) { return word.find_first_not_of("0123456789") == std::string::npos; };
  out.file = out.words.size();
  if (out.key == "model:")
    out.file = static_cast<std::size_t>(std::find_if_not(out.words.begin(), out.words.end(), number) - out.words.begin());
  else if (out.key.find(" per ") != std::string::npos && !out.key.ends_with("per case:") && !out.words.empty())
    out.file = out.words.size() - 1;
  return out;
}

std::string written(const Line& line, const std::string& folder) {
  std::string out = line.key;
  for (std::size_t i = 0; i < line.words.size(); ++i) {
    std::string word = line.words[i];
    if (i == line.file) word = folder + "/" + word;
    else std::replace(word.begin(), word.end(), ' ', '_');
    out += " " + word;
  }
  return out;
}

bool has_blank(const std::string& text) { return text.find_first_of(" \t") != std::string::npos; }

}  // namespace

fs::path case_without_quotes(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  std::ifstream in(request.file);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (text.find('"') == std::string::npos) return request.file;
  const std::string folder = fs::relative(request.file.parent_path(), request.scratch).string();
  std::istringstream lines(text);
  std::string copy;
  for (std::string one; std::getline(lines, one);) {
    if (one.ends_with('\r')) one.pop_back();
    const Line line = line_of(one);
    if (line.file == line.words.size()) {
      copy += one + "\n";
      continue;
    }
    if (has_blank(line.words[line.file]))
      throw Error(ErrorCode::unsupported, name + ": names its file '" + line.words[line.file] + "', and VTK's reader takes no blanks in names; rename the file, and its name here");
    const std::string made = written(line, folder);
    if (has_blank(folder) || made.size() > kLongestLine)
      throw Error(ErrorCode::unsupported, name + ": names its files in quotes, which VTK's reader takes for a part of the names; remove the quotes around '" + line.words[line.file] + "'");
    copy += made + "\n";
  }
  const fs::path out = request.scratch / name;
  std::ofstream(out) << copy;
  return out;
}

}  // namespace isostrata
