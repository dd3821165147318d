#include "session/commands/command_checks.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "session/wire/wire.h"

namespace isostrata {

[[noreturn]] void refuse(const char* code, std::string message, std::string field) {
  throw Refused{wire_error(code, std::move(message), std::move(field))};
}

std::string number_text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", value);
  return text.data();
}

double finite(double value, const std::string& field, double limit) {
  if (!std::isfinite(value) || std::abs(value) > limit)
    refuse("invalid_argument",
           field + " is " + number_text(value) + "; expected a finite number of at most " + number_text(limit), field);
  return value;
}

double unit(double value, const std::string& field) {
  if (!(value >= 0 && value <= 1))
    refuse("invalid_argument", field + " is " + number_text(value) + "; expected a number in [0, 1]", field);
  return value;
}

const std::string& name(const std::string& text, const std::string& field) {
  if (text.size() > kMaxNameBytes)
    refuse("invalid_argument",
           field + " has " + std::to_string(text.size()) + " bytes; expected at most " + std::to_string(kMaxNameBytes), field);
  return text;
}

Rgb rgb_of(const v1::Rgb& rgb, const std::string& field) {
  return {static_cast<float>(unit(rgb.r(), field + ".r")), static_cast<float>(unit(rgb.g(), field + ".g")),
          static_cast<float>(unit(rgb.b(), field + ".b"))};
}

std::string color_map_of(const std::string& map, const std::string& field) {
  if (map.empty()) return {};
  name(map, field);
  if (!is_color_map(map)) {
    const auto names = color_map_names();
    std::string known;
    for (const auto n : names) known += (known.empty() ? "" : ", ") + std::string(n);
    refuse("not_found", "colour map '" + map + "' is not built in; expected one of " + known + ", or a ramp as #0000ff-#ffffff",
           field);
  }
  return map;
}

void check_ends(double lower, double upper, const std::string& field) {
  if (lower != -INFINITY) finite(lower, field + "lower");
  if (upper != INFINITY) finite(upper, field + "upper");
  if (!(lower < upper))
    refuse("invalid_argument", "lower " + number_text(lower) + " is not less than upper " + number_text(upper), field + "lower");
}

const DatasetFacts& opened(const CommandContext& context) {
  if (!context.dataset) refuse("not_found", "no dataset is open; open one first", "");
  return *context.dataset;
}

const ArrayFacts& array_of(const std::string& array, const CommandContext& context, const char* field) {
  const DatasetFacts& dataset = opened(context);
  const ArrayFacts* facts = dataset.find_array(name(array, field));
  if (!facts) {
    std::string known;
    for (const ArrayFacts& a : dataset.arrays) known += (known.empty() ? "" : ", ") + a.name;
    refuse("not_found", "array '" + array + "' is not in " + dataset.name + "; it has " + (known.empty() ? "no arrays" : known),
           field);
  }
  return *facts;
}

double within(double value, double lower, double upper, const std::string& field) {
  if (!(value >= lower && value <= upper))
    refuse("invalid_argument",
           field + " is " + number_text(value) + "; expected " + number_text(lower) + " to " + number_text(upper), field);
  return value;
}

}  // namespace isostrata
