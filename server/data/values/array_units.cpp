#include "data/values/array_units.h"

namespace isostrata {
namespace {

std::string begins(std::string_view array) { return "unit of '" + std::string(array) + "': "; }

}  // namespace

void note_unit(std::vector<std::string>& notes, std::string_view array, std::string_view unit) {
  if (!unit.empty()) notes.push_back(begins(array) + std::string(unit));
}

std::string unit_of(const std::vector<std::string>& notes, std::string_view array) {
  const std::string start = begins(array);
  for (const std::string& note : notes)
    if (note.starts_with(start)) return note.substr(start.size());
  return {};
}

std::string name_with_unit(const std::vector<std::string>& notes, std::string_view array) {
  const std::string unit = unit_of(notes, array);
  return std::string(array) + (unit.empty() ? "" : " (" + unit + ")");
}

}  // namespace isostrata
