// Headers of lines "KEY: value".
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "data/files/recognise.h"
#include "import/bytes/parsed_number.h"
#include "import/bytes/trimmed.h"

namespace isostrata {

/// Keys in small letters, each with the value of its last line; what follows '#' is a remark.
class HeaderLines {
 public:
  HeaderLines(std::string_view text, std::string name) : name_(std::move(name)) {
    while (!text.empty()) {
      const auto end = std::min(text.find('\n'), text.size());
      std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      line = line.substr(0, line.find('#'));
      const auto colon = line.find(':');
      if (colon == std::string_view::npos) continue;
      values_[small_letters(std::string(trimmed(line.substr(0, colon))))] = std::string(trimmed(line.substr(colon + 1)));
    }
  }
  const std::string& name() const { return name_; }
  /// Null if there is no such key.
  const std::string* find(const std::string& key) const {
    const auto it = values_.find(key);
    return it == values_.end() ? nullptr : &it->second;
  }
  std::string word(const std::string& key, const std::string& otherwise = {}) const {
    const std::string* value = find(key);
    return value ? small_letters(*value) : otherwise;
  }
  const std::string& needed(const std::string& key) const {
    const std::string* value = find(key);
    if (!value || value->empty()) throw Error(ErrorCode::bad_data, name_ + ": has no " + key);
    return *value;
  }
  /// As many numbers as the line has, of at least `least`. T: whole or real.
  template <class T>
  std::vector<T> numbers(const std::string& key, std::size_t least) const {
    std::vector<T> all;
    std::string_view rest = needed(key);
    for (;;) {
      rest.remove_prefix(std::min(rest.find_first_not_of(" \t,;()[]"), rest.size()));
      if (rest.empty()) break;
      const std::string_view one = rest.substr(0, rest.find_first_of(" \t,;()[]"));
      const auto number = parsed_number<T>(one.starts_with('+') ? one.substr(1) : one);
      if (!number) throw Error(ErrorCode::bad_data, name_ + ": '" + std::string(one.substr(0, 32)) + "' in " + key + " is not a number");
      all.push_back(*number);
      rest.remove_prefix(one.size());
    }
    if (all.size() < least) throw Error(ErrorCode::bad_data, name_ + ": " + key + " has " + std::to_string(all.size()) + " numbers; expected " + std::to_string(least));
    return all;
  }

 private:
  const std::string name_;
  std::map<std::string, std::string> values_;
};

}  // namespace isostrata
