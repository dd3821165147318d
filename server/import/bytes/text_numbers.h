// Numbers in a text, one after the other, as C and Fortran write them.
#pragma once

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "base/error.h"
#include "import/bytes/parsed_number.h"

namespace isostrata {

/// Numbers, one after the other, wherever lines end.
class TextNumbers {
 public:
  TextNumbers(std::string_view text, const std::string& name) : text_(text), name_(name) {}
  void skip_line() {
    const auto end = text_.find('\n');
    if (end == std::string_view::npos) throw Error(ErrorCode::bad_data, name_ + ": ends within its header");
    text_.remove_prefix(end + 1);
  }
  double number(const char* what) {
    const auto first = text_.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) throw Error(ErrorCode::bad_data, name_ + ": ends before " + what);
    text_.remove_prefix(first + (text_[first] == '+'));
    double value = 0;
    const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
    if (end != text_.data() + text_.size() && !std::isspace(static_cast<unsigned char>(*end))) return fortran_number(static_cast<std::size_t>(end - text_.data()), what);
    if (error == std::errc::invalid_argument) refuse(what);
    text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
    return value;
  }
  std::string_view rest_of_line() {
    const auto line = text_.substr(0, text_.find('\n'));
    skip_line();
    return line;
  }
  /// The line with the next word, which is not empty; an empty one where nothing follows.
  std::string_view next_line() {
    text_.remove_prefix(std::min(text_.find_first_not_of(" \t\r\n"), text_.size()));
    const auto line = text_.substr(0, text_.find('\n'));
    text_.remove_prefix(std::min(line.size() + 1, text_.size()));
    return line.substr(0, line.find_last_not_of(" \t\r") + 1);
  }
  /// The next letters up to a blank.
  std::string_view word(const char* what) {
    text_.remove_prefix(std::min(text_.find_first_not_of(" \t\r\n"), text_.size()));
    const auto one = text_.substr(0, text_.find_first_of(" \t\r\n"));
    if (one.empty()) throw Error(ErrorCode::bad_data, name_ + ": ends before " + what);
    text_.remove_prefix(one.size());
    return one;
  }
  /// The next bytes, whatever they are: binary numbers within a text.
  std::string_view take(std::size_t bytes, const char* what) {
    if (bytes > text_.size()) throw Error(ErrorCode::bad_data, name_ + ": ends before " + what);
    const auto taken = text_.substr(0, bytes);
    text_.remove_prefix(bytes);
    return taken;
  }
  bool number_follows() const {
    const auto at = text_.find_first_not_of(" \t\r\n");
    return at != std::string_view::npos && (std::isdigit(static_cast<unsigned char>(text_[at])) || text_[at] == '-' || text_[at] == '+' || text_[at] == '.');
  }
  const std::string& name() const { return name_; }
  std::size_t left() const { return text_.size(); }
  std::int64_t integer(const char* what, std::int64_t most) {
    const double value = number(what);
    if (value != std::floor(value) || std::abs(value) > static_cast<double>(most))
      throw Error(ErrorCode::bad_data, name_ + ": " + what + " is " + std::to_string(value) + "; expected a whole number up to " + std::to_string(most));
    return static_cast<std::int64_t>(value);
  }

 private:
  /// "0.5D-02", and "3.45-102" where the letter found no place. from_chars ends at `mantissa`.
  double fortran_number(std::size_t mantissa, const char* what) {
    const std::string_view word = text_.substr(0, text_.find_first_of(" \t\r\n"));
    const char at = word[mantissa];
    std::string text(word);
    if (at == 'D' || at == 'd')
      text[mantissa] = 'E';
    else if (at == '+' || at == '-')
      text.insert(mantissa, "E");
    const auto value = mantissa > 0 && text != word ? parsed_number<double>(text) : std::nullopt;
    if (!value) refuse(what);
    text_.remove_prefix(word.size());
    return *value;
  }
  [[noreturn]] void refuse(const char* what) const {
    throw Error(ErrorCode::bad_data, name_ + ": expected a number for " + what + ", not '" + printable(text_.substr(0, 16)) + "'");
  }
  static std::string printable(std::string_view text) {
    std::string out(text);
    for (char& c : out)
      if (c < 32 || c == 127) c = ' ';
    return out;
  }
  std::string_view text_;
  const std::string& name_;
};

}  // namespace isostrata
