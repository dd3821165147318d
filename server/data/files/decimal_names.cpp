#include "data/files/decimal_names.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace isostrata {
namespace {

bool with_zeros(const std::string& digits) { return digits.size() > 1 && digits.front() == '0'; }

struct Facts {
  bool fixed = true;     // as many places each
  bool shortest = true;  // no 0 at an end
  bool from_1 = false;   // one is 0, 1 or begins with 0, as a counter does
  bool places = false;   // a fraction with a 0 in front is longer than another: 0.05 and 0.1
  std::map<std::string, std::set<std::string>> fractions;  // by whole part
  std::set<std::string> all;
};

Facts facts_of(const std::vector<WrittenNumber>& numbers) {
  Facts facts;
  std::size_t least = std::string::npos;
  for (const WrittenNumber& number : numbers) {
    const std::string& fraction = number.fraction;
    facts.fixed = facts.fixed && fraction.size() == numbers.front().fraction.size();
    facts.shortest = facts.shortest && (fraction.size() < 2 || fraction.back() != '0');
    facts.from_1 = facts.from_1 || fraction == "1" || fraction.starts_with('0');
    if (!fraction.empty()) least = std::min(least, fraction.size());
    facts.fractions[number.whole].insert(fraction.empty() ? "0" : fraction);
    facts.all.insert(fraction.empty() ? "0" : fraction);
  }
  for (const WrittenNumber& number : numbers) facts.places = facts.places || (with_zeros(number.fraction) && number.fraction.size() > least);
  return facts;
}

bool evenly_spaced(const std::vector<WrittenNumber>& numbers) {
  std::set<double> values;
  for (const WrittenNumber& number : numbers) values.insert(number.value());
  if (values.size() < 3) return false;
  double least = *values.rbegin(), most = 0;
  for (auto it = values.begin(), next = std::next(it); next != values.end(); ++it, ++next) {
    least = std::min(least, *next - *it);
    most = std::max(most, *next - *it);
  }
  return most <= 1.5 * least;
}

/// Each whole part has fractions that the fullest one has, and most have several; and they begin as counters do.
bool counted_apart(const Facts& facts) {
  if (facts.shortest && !facts.from_1) return false;
  const auto& fullest = std::max_element(facts.fractions.begin(), facts.fractions.end(), [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); })->second;
  std::size_t several = 0;
  for (const auto& [whole, fractions] : facts.fractions) {
    several += fractions.size() > 1;
    if (!std::includes(fullest.begin(), fullest.end(), fractions.begin(), fractions.end())) return false;
  }
  return 2 * several >= facts.fractions.size();
}

/// Whether each whole part has three or more fractions that count in equal steps, one of which may be missing: 5, 15, 25.
bool counts_evenly(const Facts& facts) {
  for (const auto& [whole, fractions] : facts.fractions) {
    if (fractions.size() < 3) return false;
    std::set<std::uint64_t> counted;
    for (const std::string& fraction : fractions) counted.insert(std::strtoull(fraction.c_str(), nullptr, 10));
    std::uint64_t least = *counted.rbegin(), most = 0;
    for (auto it = counted.begin(), next = std::next(it); next != counted.end(); ++it, ++next) {
      least = std::min(least, *next - *it);
      most = std::max(most, *next - *it);
    }
    if (most > 2 * least) return false;
  }
  return true;
}

}  // namespace

double WrittenNumber::value() const {
  const std::string text = whole + (fraction.empty() ? "" : "." + fraction);
  double out = 0;
  std::from_chars(text.data(), text.data() + text.size(), out);
  return out;
}

WrittenNumber written_number(const std::string& text, bool behind_letter) {
  const auto dot = std::min(text.find('.'), text.size());
  return {text.substr(0, dot), text.substr(std::min(dot + 1, text.size())), behind_letter};
}

bool has_sign_or_exponent(const WrittenNumber& number) { return number.whole.starts_with('-') || (number.whole + number.fraction).find_first_of("eE") != std::string::npos; }

bool are_decimals(const std::vector<WrittenNumber>& numbers) {
  if (numbers.size() > 1 && std::any_of(numbers.begin(), numbers.end(), has_sign_or_exponent)) return true;
  const auto has_dot = [](const WrittenNumber& number) { return !number.fraction.empty(); };
  if (numbers.size() < 2 || std::none_of(numbers.begin(), numbers.end(), has_dot)) return false;
  if (std::any_of(numbers.begin(), numbers.end(), [](const WrittenNumber& number) { return with_zeros(number.whole); })) return false;
  const Facts facts = facts_of(numbers);
  if (facts.all.size() == 1 || (!facts.fixed && !facts.shortest)) return false;
  if (!facts.fixed && facts.places) return true;
  if (!facts.fixed && counts_evenly(facts) && !evenly_spaced(numbers)) return false;
  if (facts.fractions.size() == 1) return numbers.front().whole == "0" && !numbers.front().behind_letter;
  return evenly_spaced(numbers) || !counted_apart(facts);
}

std::size_t decimal_star(std::string_view pattern) {
  const auto last = pattern.rfind('*');
  if (last == std::string_view::npos) return last;
  const auto first = last >= 2 && pattern.substr(last - 2, 3) == "*.*" ? last - 2 : last;
  const auto digit = [&](std::size_t at) { return at < pattern.size() && std::isdigit(static_cast<unsigned char>(pattern[at])); };
  const bool joined = (first > 0 && (pattern[first - 1] == '.' || digit(first - 1))) || (last + 1 < pattern.size() && pattern[last + 1] == '.' && digit(last + 2));
  return joined ? std::string_view::npos : first;
}

std::vector<WrittenNumber> numbers_at_star(std::string_view pattern, const std::vector<SeriesFile>& files) {
  const auto first = decimal_star(pattern), last = pattern.rfind('*');
  std::vector<WrittenNumber> out;
  if (first == std::string_view::npos || pattern.find('*') != first) return out;
  for (const SeriesFile& file : files) {
    const std::string name = file.path.filename().string();
    if (name.size() + 1 < pattern.size() - (last - first)) return {};  // the first of restarts has no number
    const std::string text = name.substr(first, name.size() - first - (pattern.size() - last - 1));
    out.push_back(written_number(text, first > 0 && std::isalpha(static_cast<unsigned char>(pattern[first - 1])) != 0));
  }
  return out;
}

std::vector<double> decimals_in_names(std::string_view pattern, const std::vector<SeriesFile>& files) {
  const std::vector<WrittenNumber> numbers = numbers_at_star(pattern, files);
  const bool one_star = pattern.find('*') == pattern.rfind('*');
  const bool dots = std::any_of(numbers.begin(), numbers.end(), [](const WrittenNumber& number) { return !number.fraction.empty() || has_sign_or_exponent(number); });
  std::vector<double> out;
  if (!dots || (!one_star && !are_decimals(numbers))) return out;
  for (const WrittenNumber& number : numbers) out.push_back(number.value());
  return out;
}

bool is_signed_at_star(std::string_view name, std::string_view pattern) {
  const auto star = decimal_star(pattern);
  if (star == std::string_view::npos || pattern.find('*') != star || star != pattern.rfind('*') || name.size() < pattern.size()) return false;
  const std::string_view before = pattern.substr(0, star), behind = pattern.substr(star + 1);
  if (!name.starts_with(before) || !name.ends_with(behind)) return false;
  std::string_view rest = name.substr(star, name.size() + 1 - pattern.size());
  const auto digits = [&] {
    const auto count = std::min(rest.find_first_not_of("0123456789"), rest.size());
    rest.remove_prefix(count);
    return count > 0;
  };
  const bool minus = rest.starts_with('-') && (star == 0 || before.ends_with('_') || before.ends_with('=') || before.ends_with(' '));
  if (minus) rest.remove_prefix(1);
  if (!digits()) return false;
  if (rest.starts_with('.')) {
    rest.remove_prefix(1);
    if (!digits()) return false;
  }
  if (rest.size() > 2 && (rest[0] == 'e' || rest[0] == 'E') && (rest[1] == '-' || rest[1] == '+')) {
    rest.remove_prefix(2);
    return digits() && rest.empty();
  }
  return minus && rest.empty();
}

std::string with_dot(const std::string& pattern) {
  const auto star = decimal_star(pattern);
  const bool alone = star != std::string::npos && pattern.find('*') == star && star == pattern.rfind('*');
  return alone ? std::string(pattern).replace(star, 1, "*.*") : std::string();
}

void sort_decimals(const std::string& pattern, std::vector<SeriesFile>& files) {
  const std::vector<double> values = decimals_in_names(pattern, files);
  if (values.empty()) return;
  std::vector<std::pair<double, SeriesFile>> order;
  for (std::size_t i = 0; i < files.size(); ++i) order.emplace_back(values[i], std::move(files[i]));
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < files.size(); ++i) files[i] = std::move(order[i].second);
}

}  // namespace isostrata
