// Words, texts between quotes, and numbers of a text file of Tecplot, wherever lines end; what follows '#' in a line is a remark.
#pragma once

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/error.h"
#include "import/bytes/parsed_number.h"

namespace isostrata {

class TecplotWords {
 public:
  TecplotWords(std::string_view text, std::size_t at, const std::string& name) : text_(text), name_(name), at_(at) {}

  /// The next letter behind blanks and remarks; 0 at the end.
  char peek() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#') {
        skip_line();
      } else if (is_blank(c)) {
        ++at_;
      } else {
        return c;
      }
    }
    return 0;
  }
  std::size_t at() {
    peek();
    return at_;
  }
  void go_back(std::size_t to) { at_ = to; }
  void skip_line() { at_ = std::min(text_.find('\n', at_), text_.size()); }
  bool take(char c) {
    if (peek() != c) return false;
    ++at_;
    return true;
  }
  /// A word; without its quotes, or with the brackets that it stands in. Empty at the end.
  std::string word() {
    const char first = peek();
    if (first == '"' || first == '\'') return between(first);
    const std::size_t from = at_;
    if (first == '(') {
      past(')');
      return std::string(text_.substr(from, at_ - from));
    }
    while (at_ < text_.size() && !is_blank(text_[at_]) && text_[at_] != '=' && text_[at_] != '(' && text_[at_] != '"') ++at_;
    if (at_ == from && at_ < text_.size()) ++at_;
    return std::string(text_.substr(from, at_ - from));
  }
  bool number_follows() {
    const char c = peek();
    return std::isdigit(static_cast<unsigned char>(c)) || c == '-' || c == '+' || c == '.';
  }
  /// Calls use(value) for so many numbers; "3*1.5" is three.
  template <class Use>
  void numbers(std::int64_t count, const Use& use) {
    while (count > 0) {
      const std::string_view word = next();
      const std::size_t star = word.find('*');
      std::int64_t times = 1;
      if (star != std::string_view::npos) times = parsed_number<std::int64_t>(word.substr(0, star)).value_or(0);
      const double value = real(star == std::string_view::npos ? word : word.substr(star + 1));
      if (times < 1 || times > count) refuse("'" + std::string(word.substr(0, 40)) + "' stands for " + std::to_string(times) + " numbers; " + std::to_string(count) + " are expected");
      for (count -= times; times > 0; --times) use(value);
    }
  }
  void skip_numbers(std::int64_t count) {
    while (count > 0) {
      const std::string_view word = next();
      const std::size_t star = word.find('*');
      count -= star == std::string_view::npos ? 1 : parsed_number<std::int64_t>(word.substr(0, star)).value_or(1);
    }
    if (count < 0) refuse("a number is repeated beyond its zone");
  }
  [[noreturn]] void refuse(const std::string& why) const { throw Error(ErrorCode::bad_data, name_ + ": " + why + " (line " + std::to_string(1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n')) + ")"); }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ',' || c == '\v' || c == '\f'; }
  std::string_view next() {
    if (peek() == 0) refuse("ends within the numbers of a zone");
    const std::size_t from = at_;
    while (at_ < text_.size() && !is_blank(text_[at_])) ++at_;
    return text_.substr(from, at_ - from);
  }
  double real(std::string_view word) const {
    const std::string_view all = word;
    if (word.starts_with('+')) word.remove_prefix(1);
    if (const auto value = parsed_number<double>(word)) return *value;
    std::string text(word);  // Fortran: 1.5D-3, and 1.5-103
    if (const auto letter = text.find_first_of("dD"); letter != std::string::npos)
      text[letter] = 'e';
    else if (const auto sign = text.find_first_of("+-", 1); sign != std::string::npos && text.find_first_of("eE") == std::string::npos)
      text.insert(sign, "e");
    if (const auto value = parsed_number<double>(text)) return *value;
    refuse("expected a number, not '" + std::string(all.substr(0, 40)) + "'");
  }
  void past(char end) {
    const std::size_t found = text_.find(end, at_ + 1);
    if (found == std::string_view::npos) refuse(std::string("expected ") + end);
    at_ = found + 1;
  }
  std::string between(char quote) {
    const std::size_t from = at_ + 1;
    past(quote);
    return std::string(text_.substr(from, at_ - 1 - from));
  }

  std::string_view text_;
  const std::string& name_;
  std::size_t at_ = 0;
};

}  // namespace isostrata
