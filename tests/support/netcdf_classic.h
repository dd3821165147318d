// Files of netCDF's classic format, written from its specification ("NetCDF Classic Format", CDF-1), for tests that need an Exodus file
// of exactly these contents.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace isostrata::testing {

class NetcdfClassic {
 public:
  /// A dimension's number. Length 0: the one that records run along.
  int dimension(const std::string& name, std::uint32_t length) {
    dimensions_.push_back({name, length});
    return static_cast<int>(dimensions_.size()) - 1;
  }
  void attribute(const std::string& name, float value) { globals_ += attribute_of(name, 5, 1, big(value)); ++global_count_; }
  void attribute(const std::string& name, std::int32_t value) { globals_ += attribute_of(name, 4, 1, big(value)); ++global_count_; }

  /// A variable whose first dimension may be that of the records; then values hold all records.
  void variable(const std::string& name, const std::vector<int>& dimensions, const std::vector<double>& values) {
    add(name, dimensions, 6, bytes_of<double>(values), 8);
  }
  void variable(const std::string& name, const std::vector<int>& dimensions, const std::vector<std::int32_t>& values,
                const std::string& text_attribute = "", const std::string& text = "") {
    add(name, dimensions, 4, bytes_of<std::int32_t>(values), 4);
    if (!text_attribute.empty())
      variables_.back().attributes = attribute_of(text_attribute, 2, static_cast<std::uint32_t>(text.size()), text);
  }
  /// Rows of characters, each filled up with zeros.
  void text(const std::string& name, const std::vector<int>& dimensions, std::size_t width, const std::vector<std::string>& rows) {
    std::string all;
    for (std::string row : rows) {
      row.resize(width);
      all += row;
    }
    add(name, dimensions, 2, all, 1);
  }

  std::string bytes(std::uint32_t records) const {
    std::string file = header(records, 0);
    file = header(records, static_cast<std::uint32_t>(file.size()));
    for (const Variable& of : variables_)
      if (!of.recorded) file += padded(of.data);
    for (std::uint32_t r = 0; r < records; ++r)
      for (const Variable& of : variables_)
        if (of.recorded) file += padded(of.data.substr(r * (of.data.size() / records), of.data.size() / records));
    return file;
  }

 private:
  struct Variable {
    std::string name;
    std::vector<int> dimensions;
    std::uint32_t type = 0;
    std::string data;
    std::string attributes;  // one or none
    bool recorded = false;
    std::uint32_t size = 0;  // of a record, or of all
  };

  template <class T>
  static std::string big(T value) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    return {bytes.rbegin(), bytes.rend()};
  }
  template <class T, class From>
  static std::string bytes_of(const std::vector<From>& values) {
    std::string bytes;
    for (const From value : values) bytes += big(static_cast<T>(value));
    return bytes;
  }
  static std::string padded(std::string bytes) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    return bytes;
  }
  static std::string name_of(const std::string& name) { return big(static_cast<std::uint32_t>(name.size())) + padded(name); }
  static std::string attribute_of(const std::string& name, std::uint32_t type, std::uint32_t count, const std::string& value) {
    return name_of(name) + big(type) + big(count) + padded(value);
  }
  static std::string list(std::uint32_t tag, std::size_t count) {
    return count == 0 ? big(std::uint64_t{0}) : big(tag) + big(static_cast<std::uint32_t>(count));
  }

  void add(const std::string& name, const std::vector<int>& dimensions, std::uint32_t type, std::string data, std::size_t width) {
    Variable& of = variables_.emplace_back();
    of.name = name;
    of.dimensions = dimensions;
    of.type = type;
    of.data = std::move(data);
    of.recorded = !dimensions.empty() && dimensions_[static_cast<std::size_t>(dimensions.front())].second == 0;
    std::size_t size = width;
    for (const int d : dimensions)
      if (const std::uint32_t length = dimensions_[static_cast<std::size_t>(d)].second) size *= length;
    of.size = static_cast<std::uint32_t>((size + 3) / 4 * 4);
  }

  std::string header(std::uint32_t records, std::uint32_t header_bytes) const {
    std::string out = std::string("CDF\1") + big(records) + list(10, dimensions_.size());
    for (const auto& [name, length] : dimensions_) out += name_of(name) + big(length);
    out += list(12, static_cast<std::size_t>(global_count_)) + globals_ + list(11, variables_.size());
    std::uint32_t at = header_bytes;
    std::vector<std::uint32_t> begin(variables_.size());
    for (const bool recorded : {false, true})
      for (std::size_t v = 0; v < variables_.size(); ++v) {
        if (variables_[v].recorded != recorded) continue;
        begin[v] = at;
        at += variables_[v].size;
      }
    for (std::size_t v = 0; v < variables_.size(); ++v) {
      const Variable& of = variables_[v];
      out += name_of(of.name) + big(static_cast<std::uint32_t>(of.dimensions.size()));
      for (const int d : of.dimensions) out += big(static_cast<std::uint32_t>(d));
      out += list(12, of.attributes.empty() ? 0 : 1) + of.attributes + big(of.type) + big(of.size) + big(begin[v]);
    }
    return out;
  }

  std::vector<std::pair<std::string, std::uint32_t>> dimensions_;
  std::string globals_;
  int global_count_ = 0;
  std::vector<Variable> variables_;
};

}  // namespace isostrata::testing
