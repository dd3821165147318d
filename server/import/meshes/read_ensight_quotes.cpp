#include "import/meshes/ensight_quotes.h"

#include <algorithm>
#include <cctype>
#include <climits>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "base/error.h"
#include "data/files/recognise.h"
#include "import/bytes/parsed_number.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestLine = 250;  // the reader's own are of 256 bytes
constexpr int kMostLinks = 100'000, kDeepest = 3;
constexpr std::size_t kMostNumbers = 64u << 20;
constexpr const char* kBeside = "beside";

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

bool has_blank(const std::string& text) { return text.find_first_of(" \t") != std::string::npos; }

/// Of a path below the case's folder, or a pattern of such paths; no two have the same.
std::string link_name(const std::string& path) {
  std::string out = "named-";
  for (const char c : path) out += c == '/' ? "_s" : c == ' ' ? "_b" : c == '\t' ? "_t" : c == '_' ? "__" : std::string(1, c);
  return out;
}

std::string written(const Line& line) {
  std::string out = line.key;
  for (std::size_t i = 0; i < line.words.size(); ++i) {
    std::string word = line.words[i];
    if (i == line.file)
      word = has_blank(word) ? link_name(fs::path(word).lexically_normal().string()) : std::string(kBeside) + "/" + word;
    else
      std::replace(word.begin(), word.end(), ' ', '_');
    out += " " + word;
  }
  return out;
}

/// As all readers take them: that of VTK 9.6 looks for them on one line alone, and none takes a line above kLongestLine.
std::string file_numbers(const std::vector<std::string>& words, const std::string& name) {
  std::vector<std::int64_t> numbers;
  for (const std::string& word : words) {
    const auto number = parsed_number<std::int64_t>(word);
    if (!number || *number < 0 || *number > INT_MAX) throw Error(ErrorCode::bad_data, name + ": expected whole numbers behind 'filename numbers', which has '" + word.substr(0, 40) + "'");
    numbers.push_back(*number);
  }
  const std::int64_t step = numbers.size() > 1 ? numbers[1] - numbers[0] : 0;
  if (step > 0 && std::adjacent_find(numbers.begin(), numbers.end(), [&](auto a, auto b) { return b - a != step; }) == numbers.end())
    return "filename start number: " + std::to_string(numbers[0]) + "\nfilename increment: " + std::to_string(step) + "\n";
  std::string line = "filename numbers:", lines = line + "\n";
  for (const std::int64_t number : numbers) line += " " + std::to_string(number), lines += std::to_string(number) + "\n";
  return line.size() <= kLongestLine ? line + "\n" : lines;
}

/// The text behind the key, if the line has it.
std::optional<std::string> behind(const std::string& line, const std::string& key) {
  const auto begin = line.find_first_not_of(" \t");
  if (begin == std::string::npos || !line.substr(begin).starts_with(key)) return std::nullopt;
  return line.substr(begin + key.size());
}

std::vector<std::string> numbers_of(const std::string& file, const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  std::ifstream in(referred_file(request.file, file));
  std::vector<std::string> out;
  std::size_t bytes = 0;
  for (std::string word; in >> word;) {
    if (!parsed_number<double>(word)) throw Error(ErrorCode::bad_data, name + ": expected numbers in '" + file + "', which has '" + word.substr(0, 40) + "'");
    if ((bytes += word.size()) > kMostNumbers) throw Error(ErrorCode::too_large, name + ": '" + file + "' is above " + std::to_string(kMostNumbers >> 20) + " MiB; numbers of steps are not that many");
    out.push_back(word);
  }
  return out;
}

std::string time_values(const std::vector<std::string>& words) {
  std::string out = "time values:\n";
  for (const std::string& word : words) out += word + "\n";
  return out;
}

/// The numbers at the end of a line and on those that follow, up to where `lines` then is.
std::vector<std::string> numbers_on(const std::string& line, std::istream& lines) {
  std::istringstream words(line);
  std::vector<std::string> out{std::istream_iterator<std::string>(words), {}};
  const auto begins_number = [](int c) { return std::isdigit(c) || c == '-' || c == '+' || c == '.'; };
  while (lines >> std::ws && begins_number(lines.peek())) lines >> out.emplace_back();
  lines.clear();
  return out;
}

/// The numbers of a time set, or those of the file that is named for them, as file_numbers and time_values have them.
std::optional<std::string> with_numbers(const std::string& line, std::istream& lines, const ReadRequest& request) {
  const auto named = [](const std::string& text) {
    std::string file;
    std::istringstream(text) >> std::quoted(file);
    return file;
  };
  const std::string name = request.file.filename().string();
  if (const auto text = behind(line, "time values file:")) return time_values(numbers_of(named(*text), request));
  if (const auto text = behind(line, "time values:")) return time_values(numbers_on(*text, lines));
  if (const auto text = behind(line, "filename numbers file:")) return file_numbers(numbers_of(named(*text), request), name);
  if (const auto text = behind(line, "filename numbers:")) return file_numbers(numbers_on(*text, lines), name);
  return std::nullopt;
}

bool is_case(const fs::path& file) {
  const std::string ending = small_letters(file.extension().string());
  return ending == ".case" || ending == ".encas";
}

}  // namespace

void make_links_without_blanks(const ReadRequest& request) {
  if (!is_case(request.file)) return;
  const fs::path folder = request.file.parent_path();
  std::error_code error;
  fs::create_symlink(folder, request.scratch / kBeside, error);
  int left = kMostLinks;
  for (fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, error), end; !error && it != end && --left > 0; it.increment(error)) {
    if (it.depth() >= kDeepest) it.disable_recursion_pending();
    const std::string path = it->path().lexically_relative(folder).string();
    std::error_code ignored;
    if (has_blank(path) && !it->is_directory(ignored)) fs::create_symlink(it->path(), request.scratch / link_name(path), ignored);
  }
}

void remove_links(const ReadRequest& request) {
  std::error_code error;
  for (fs::directory_iterator it(request.scratch, error), end; !error && it != end; it.increment(error))
    if (std::error_code ignored; it->is_symlink(ignored)) fs::remove(it->path(), ignored);
}

fs::path case_for_reader(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  std::ifstream in(request.file);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (text.find('"') == std::string::npos && text.find("TIME") == std::string::npos) return request.file;
  std::istringstream lines(text);
  std::string copy;
  for (std::string one; std::getline(lines, one);) {
    if (one.ends_with('\r')) one.pop_back();
    const Line line = line_of(one);
    if (line.file == line.words.size()) {
      copy += with_numbers(one, lines, request).value_or(one + "\n");
      continue;
    }
    const std::string made = written(line);
    if (made.size() > kLongestLine)
      throw Error(ErrorCode::unsupported, name + ": names its file '" + line.words[line.file] + "', which is too long for VTK's reader; rename the file, and its name here");
    copy += made + "\n";
  }
  const fs::path out = request.scratch / "reader.case";
  std::ofstream(out) << copy;
  return out;
}

}  // namespace isostrata
