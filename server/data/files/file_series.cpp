#include "data/files/file_series.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "base/error.h"
#include "data/files/beneath.h"
#include "data/files/decimal_names.h"
#include "data/files/plotfile_folder.h"
#include "data/files/recognise.h"
#include "data/files/zarr_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMostFiles = 100'000;
constexpr std::size_t kMostDigits = 18;  // a 64-bit number

bool digit(char c) { return c >= '0' && c <= '9'; }

/// Where an extension that begins with a letter begins: its digits ("h5", "ex2") count nothing. The digits of a restart ("e-s003") do.
std::size_t counted(const std::string& name) {
  const auto dot = name.rfind('.');
  if (dot == std::string::npos || dot + 1 >= name.size() || digit(name[dot + 1])) return name.size();
  const auto restart = name.find("-s", dot);
  return restart != std::string::npos && name.find_first_not_of("0123456789", restart + 2) == std::string::npos ? name.size() : dot;
}

struct Name {
  std::string text;
  std::vector<std::pair<std::size_t, std::size_t>> runs;  // begin, length of each number
  std::vector<std::uint64_t> numbers;
  std::size_t decimal = std::string::npos;  // which of the numbers is one with a dot, a sign or an exponent, or may be
  std::size_t end_of_decimal = 0;           // behind it
  std::string decimal_stars = "*";

  explicit Name(std::string of) : text(std::move(of)) {
    const std::size_t end = counted(text);
    for (std::size_t at = 0; at < end;) {
      if (!digit(text[at])) {
        ++at;
        continue;
      }
      std::size_t length = 1;
      while (at + length < end && digit(text[at + length])) ++length;
      if (length <= kMostDigits) {
        runs.emplace_back(at, length);
        numbers.push_back(std::stoull(text.substr(at, length)));
      }
      at += length;
    }
    find_decimal();
  }

  /// Whether number r stands one letter behind the one before.
  bool behind(std::size_t r) const { return r > 0 && runs[r].first == runs[r - 1].first + runs[r - 1].second + 1; }
  /// The first number of the date and time of day that number r is in: "2020-01-31_06:00:00", "20200131T0600". r itself where it is in none.
  std::size_t date_of(std::size_t r) const {
    const auto is_date = [](std::uint64_t month, std::uint64_t day) { return month >= 1 && month <= 12 && day >= 1 && day <= 31; };
    if (behind(r) && runs[r - 1].second == 8 && (runs[r].second == 4 || runs[r].second == 6)) return is_date(numbers[r - 1] / 100 % 100, numbers[r - 1] % 100) ? r - 1 : r;
    std::size_t first = r;
    while (behind(first) && runs[first].second == 2) --first;
    const bool date = r - first < 6 && runs[first].second == 4 && first + 2 < runs.size() && behind(first + 1) && behind(first + 2) && runs[first + 1].second == 2 && runs[first + 2].second == 2 &&
                      is_date(numbers[first + 1], numbers[first + 2]);
    return date ? first : r;
  }

  bool dot_behind(std::size_t r) const {
    const std::size_t dot = runs[r].first + runs[r].second;
    return r + 1 < runs.size() && runs[r + 1].first == dot + 1 && text[dot] == '.';
  }
  std::size_t end_of(std::size_t r) const { return runs[r].first + runs[r].second; }
  /// Whether a minus before it is not a hyphen: "phi_-0.5", not "run-5".
  bool negative(std::size_t r) const {
    const std::size_t at = runs[r].first;
    return at > 0 && text[at - 1] == '-' && (at == 1 || text[at - 2] == '_' || text[at - 2] == '=' || text[at - 2] == ' ');
  }
  /// Whether the number behind r is its exponent, "1e-3": with a sign, and at the end of a word.
  bool exponent_behind(std::size_t r) const {
    const std::size_t e = end_of(r);
    return r + 1 < runs.size() && runs[r + 1].first == e + 2 && (text[e] == 'e' || text[e] == 'E') && (text[e + 1] == '-' || text[e + 1] == '+') &&
           (end_of(r + 1) == text.size() || !std::isalnum(static_cast<unsigned char>(text[end_of(r + 1)])));
  }
  /// The last number with a minus or an exponent, else the last two with a dot between them, and none before or behind.
  void find_decimal() {
    bool found_special = false;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      const bool fraction = dot_behind(r) && !dot_behind(r + 1) && (runs[r].first == 0 || text[runs[r].first - 1] != '.');
      const std::size_t last = fraction ? r + 1 : r;
      const bool exponent = exponent_behind(last), special = exponent || negative(r);
      if ((!fraction && !special) || (found_special && !special)) continue;
      decimal = r;
      end_of_decimal = end_of(exponent ? last + 1 : last);
      found_special = special;
      if (exponent) r = last + 1;
    }
  }
  std::size_t begin_of(std::size_t r) const { return runs[r].first - (negative(r) ? 1 : 0); }
  WrittenNumber written(std::size_t r) const {
    const std::size_t begin = decimal == r ? begin_of(r) : runs[r].first;
    const bool behind_letter = begin > 0 && std::isalpha(static_cast<unsigned char>(text[begin - 1])) != 0;
    return written_number(text.substr(begin, (decimal == r ? end_of_decimal : end_of(r)) - begin), behind_letter);
  }
  /// The two are one from now on. In place of its value, which is not whole, stands its place among all.
  void join(std::size_t r, std::uint64_t place, const std::string& stars) {
    if (decimal == r) {
      while (r + 1 < runs.size() && runs[r + 1].first < end_of_decimal) {
        runs.erase(runs.begin() + static_cast<std::ptrdiff_t>(r) + 1);
        numbers.erase(numbers.begin() + static_cast<std::ptrdiff_t>(r) + 1);
      }
      const std::size_t begin = begin_of(r);
      runs[r] = {begin, end_of_decimal - begin};
    }
    decimal = r;
    decimal_stars = stars;
    numbers[r] = place;
  }
  /// With a star for each number, of which that with a dot is one.
  std::string joined_pattern() const {
    if (decimal == std::string::npos) return pattern([](std::size_t) { return true; });
    Name one = *this;
    one.join(decimal, 0, "*");
    return one.pattern([](std::size_t) { return true; });
  }

  /// The name with a star for each number that `starred` says.
  template <class Starred>
  std::string pattern(const Starred& starred) const {
    std::string out = text;
    for (std::size_t r = runs.size(); r-- > 0;)
      if (starred(r)) out.replace(runs[r].first, runs[r].second, r == decimal ? decimal_stars : "*");
    return out;
  }
};

void add_group(std::vector<Name> names, std::vector<NameGroup>& groups) {
  std::vector<std::size_t> varying;
  for (std::size_t r = 0; r < names.front().runs.size(); ++r)
    if (std::any_of(names.begin(), names.end(), [&](const Name& name) { return name.numbers[r] != names.front().numbers[r]; })) varying.push_back(r);
  if (names.size() == 1 || varying.empty()) {
    for (const Name& name : names) groups.push_back({name.text, {name.text}});
    return;
  }
  const std::size_t counts = names.front().date_of(varying.back());  // from here on
  if (varying.front() < counts) {
    std::map<std::vector<std::uint64_t>, std::vector<Name>> apart;
    for (const Name& name : names) {
      std::vector<std::uint64_t> key;
      for (const std::size_t r : varying)
        if (r < counts) key.push_back(name.numbers[r]);
      apart[key].push_back(name);
    }
    if (apart.size() < names.size()) {
      for (auto& [key, some] : apart) add_group(std::move(some), groups);
      return;
    }
  }
  std::sort(names.begin(), names.end(), [](const Name& a, const Name& b) { return std::tie(a.numbers, a.text) < std::tie(b.numbers, b.text); });
  const auto starred = [&](std::size_t r) { return std::find(varying.begin(), varying.end(), r) != varying.end(); };
  NameGroup group{names.front().pattern(starred), {}};
  for (const Name& name : names) {
    if (name.pattern(starred) == group.name)
      group.members.push_back(name.text);
    else  // a constant number written with other digits
      groups.push_back({name.text, {name.text}});
  }
  if (group.members.size() == 1) group.name = group.members.front();
  groups.push_back(std::move(group));
}

/// Joins the numbers with a dot in names that are alike but for those dots, if they are decimals.
bool join_decimals(std::vector<Name>& names) {
  std::size_t at = std::string::npos;
  for (const Name& name : names)
    if (name.decimal != std::string::npos) {
      if (at != std::string::npos && name.decimal != at) return false;
      at = name.decimal;
    }
  if (at == std::string::npos) return false;
  std::vector<WrittenNumber> written;
  std::vector<double> values;
  for (const Name& name : names) values.push_back(written.emplace_back(name.written(at)).value());
  std::sort(values.begin(), values.end());
  if (!are_decimals(written)) return false;
  const bool all = std::all_of(written.begin(), written.end(), [](const WrittenNumber& number) { return !number.fraction.empty() && !has_sign_or_exponent(number); });
  for (std::size_t n = 0; n < names.size(); ++n)
    names[n].join(at, static_cast<std::uint64_t>(std::lower_bound(values.begin(), values.end(), written[n].value()) - values.begin()), all ? "*.*" : "*");
  return true;
}

void add_groups(std::vector<Name> names, std::vector<NameGroup>& groups) {
  if (join_decimals(names)) return add_group(std::move(names), groups);
  std::map<std::string, std::vector<Name>> alike;
  for (Name& name : names) {
    name.decimal = std::string::npos;
    alike[name.pattern([](std::size_t) { return true; })].push_back(std::move(name));
  }
  for (auto& [pattern, some] : alike) add_group(std::move(some), groups);
}

/// The numbers at the stars; false if the name is not of the pattern.
bool matches(std::string_view name, std::string_view pattern, std::vector<std::uint64_t>& numbers) {
  while (!pattern.empty()) {
    if (pattern.front() != '*') {
      if (name.empty() || name.front() != pattern.front()) return false;
      name.remove_prefix(1);
      pattern.remove_prefix(1);
      continue;
    }
    std::size_t length = 0;
    std::uint64_t number = 0;
    for (; length < name.size() && digit(name[length]); ++length) number = number * 10 + static_cast<std::uint64_t>(name[length] - '0');
    if (length == 0 || length > kMostDigits) return false;
    numbers.push_back(number);
    name.remove_prefix(length);
    pattern.remove_prefix(1);
  }
  return name.empty();
}

std::vector<SeriesFile> joined(std::vector<SeriesFile> files, const std::vector<SeriesFile>& more) {
  files.insert(files.end(), more.begin(), more.end());
  return files;
}

/// A path with a mark (beneath.h) may not lead out of its root.
void check_link(const fs::path& link) {
  const int opened = open_beneath(link, O_PATH);
  const int why = errno;
  if (opened >= 0) close(opened);
  if (opened < 0 && why == EXDEV)
    throw Error(ErrorCode::not_found, without_mark(link).string() + ": is now a link out of the directory that is served, and is not followed");
}

void add_stamp(const fs::path& file, SourceStamp& stamp) {
  std::error_code no_size, no_time;
  const std::uint64_t size = fs::is_regular_file(file, no_size) ? fs::file_size(file, no_size) : 0;
  const auto time = fs::last_write_time(file, no_time).time_since_epoch().count();
  if (no_time) return;
  if (!no_size) stamp.bytes += size;
  stamp.changed = stamp.changed == 0 ? static_cast<std::int64_t>(time) : std::max(stamp.changed, static_cast<std::int64_t>(time));
}

}  // namespace

bool is_series_pattern(const fs::path& path) {
  std::error_code error;
  return path.filename().string().find('*') != std::string::npos && !fs::exists(fs::symlink_status(path, error));
}

bool names_pictures(const fs::path& path) { return ends_with_one_of(small_letters(path.filename().string()), ".png .tif .tiff .bmp .pnm .pgm .exr"); }

std::vector<SeriesFile> series_files(const fs::path& pattern) {
  const std::string text = pattern.filename().string(), dotted = with_dot(text);
  std::vector<SeriesFile> files, decimals;
  std::error_code error, ignored;
  for (fs::directory_iterator it(pattern.parent_path().empty() ? fs::path(".") : pattern.parent_path(), error), end; !error && it != end; it.increment(error)) {
    std::vector<std::uint64_t> numbers;
    const std::string name = it->path().filename().string();
    const bool whole = matches(name, text, numbers);
    if (!whole) numbers.clear();
    const bool special = !whole && is_signed_at_star(name, text);
    if (special) numbers.push_back(0);
    if ((!whole && !special && (dotted.empty() || !matches(name, dotted, numbers))) || !(it->is_regular_file(ignored) || is_plotfile(it->path()))) continue;
    if (it->is_symlink(ignored)) check_link(it->path());
    if (files.size() + decimals.size() == kMostFiles) throw Error(ErrorCode::too_large, text + ": more than " + std::to_string(kMostFiles) + " files");
    (whole ? files : decimals).push_back({it->path(), std::move(numbers)});
  }
  if (files.empty() || are_decimals(numbers_at_star(text, joined(files, decimals)))) files = joined(std::move(files), decimals);
  if (text.ends_with("-s*"))
    if (const fs::path first = pattern.parent_path() / text.substr(0, text.size() - 3); fs::is_regular_file(first, ignored)) files.push_back({first, {0}});
  if (files.empty()) throw Error(ErrorCode::not_found, pattern.string() + ": no file is named like that, with a number for each *");
  std::sort(files.begin(), files.end(), [](const SeriesFile& a, const SeriesFile& b) { return std::tie(a.numbers, a.path) < std::tie(b.numbers, b.path); });
  sort_decimals(text, files);
  return files;
}

int EqualSteps::place_of(std::uint64_t number, int files) const {
  if (stride == 0 || number < first || (number - first) % stride != 0) return -1;
  const std::uint64_t place = (number - first) / stride;
  return place < static_cast<std::uint64_t>(files) ? static_cast<int>(place) : -1;
}

EqualSteps equal_steps(const std::string& pattern, const std::vector<std::string>& names) {
  if (names.size() < 2) return {};
  std::vector<std::uint64_t> numbers;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (!matches(names[i], pattern, numbers) || numbers.size() != i + 1) return {};
  const std::uint64_t stride = numbers[1] - numbers[0];
  for (std::size_t i = 1; i < numbers.size(); ++i)
    if (numbers[i] <= numbers[i - 1] || numbers[i] - numbers[i - 1] != stride) return {};
  return {numbers[0], stride, static_cast<int>(names[0].size() + 1 - pattern.size())};
}

std::vector<NameGroup> group_by_number(std::vector<std::string> names) {
  std::vector<NameGroup> groups;
  std::map<std::string, std::vector<Name>> alike;
  const std::set<std::string> all(names.begin(), names.end());
  for (std::string& text : names) {
    Name name(std::move(text));
    if (name.runs.empty() || name.text.find('*') != std::string::npos)
      groups.push_back({name.text, {name.text}});
    else
      alike[name.joined_pattern()].push_back(std::move(name));
  }
  for (auto& [pattern, some] : alike) add_groups(std::move(some), groups);
  // "x.e" is the first of its restarts, one or several.
  std::set<std::string> firsts;
  for (NameGroup& group : groups) {
    const std::string& member = group.members.front();
    const auto restart = member.rfind("-s"), dot = member.rfind('.');
    if (restart == std::string::npos || dot == std::string::npos || restart < dot || counted(member) != member.size()) continue;
    const std::string first = member.substr(0, restart);
    if (!all.contains(first)) continue;
    firsts.insert(first);
    group.name = first + "-s*";
    group.members.insert(group.members.begin(), first);
  }
  std::erase_if(groups, [&](const NameGroup& group) { return group.members.size() == 1 && firsts.contains(group.name); });
  std::sort(groups.begin(), groups.end(), [](const NameGroup& a, const NameGroup& b) { return a.name < b.name; });
  return groups;
}

std::int64_t SourceStamp::changed_unix_ms() const {
  if (changed == 0) return 0;
  const auto time = std::chrono::file_clock::to_sys(fs::file_time_type(fs::file_time_type::duration(changed)));
  return std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count();
}

SourceStamp stamp_of(const fs::path& source) {
  SourceStamp stamp;
  std::error_code error;
  if (is_series_pattern(source)) {
    try {
      for (const SeriesFile& file : series_files(source)) add_stamp(file.path, stamp);
    } catch (const Error&) {
    }
    return stamp;
  }
  add_stamp(source, stamp);
  if (!fs::is_directory(source, error)) return stamp;
  int most = 10'000;
  const int deepest = deepest_file(source);
  for (fs::recursive_directory_iterator it(source, fs::directory_options::skip_permission_denied, error), end; !error && it != end && --most > 0; it.increment(error)) {
    if (it.depth() >= deepest) it.disable_recursion_pending();
    add_stamp(it->path(), stamp);
  }
  return stamp;
}

}  // namespace isostrata
