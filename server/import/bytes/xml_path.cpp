#include "import/bytes/xml_path.h"

#include <algorithm>
#include <cstddef>
#include <string>

#include "import/bytes/parsed_number.h"

namespace isostrata {
namespace {

std::string_view without_blanks(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

/// "/" or "//", the name, and what stands in brackets behind it.
struct PathStep {
  bool anywhere = false;
  std::string_view name;
  std::vector<std::string_view> conditions;
};

/// Where the text goes on behind a place that is not in quotes.
std::size_t find_outside_quotes(std::string_view text, std::string_view which, std::size_t from) {
  char quote = 0;
  for (std::size_t at = from; at < text.size(); ++at) {
    if (quote ? text[at] == quote : text[at] == '"' || text[at] == '\'')
      quote = quote ? 0 : text[at];
    else if (!quote && which.find(text[at]) != std::string_view::npos)
      return at;
  }
  return std::string_view::npos;
}

std::optional<std::vector<PathStep>> path_steps(std::string_view path) {
  std::vector<PathStep> steps;
  while (!path.empty()) {
    PathStep& step = steps.emplace_back();
    if (path.front() != '/') return std::nullopt;
    path.remove_prefix(1);
    step.anywhere = path.starts_with('/');
    if (step.anywhere) path.remove_prefix(1);
    const std::size_t end = std::min(path.find_first_of("/["), path.size());
    step.name = without_blanks(path.substr(0, end));
    path.remove_prefix(end);
    while (path.starts_with('[')) {
      const std::size_t close = find_outside_quotes(path, "]", 1);
      if (close == std::string_view::npos) return std::nullopt;
      step.conditions.push_back(without_blanks(path.substr(1, close - 1)));
      path = without_blanks(path.substr(close + 1));
    }
    if (step.name.empty() || step.name.find_first_of(" ()@:.") != std::string_view::npos) return std::nullopt;
  }
  return steps;
}

using XmlElements = std::vector<vtkXMLDataElement*>;

/// Whether it holds for the element that is number `place` of `count`; nothing if it is not understood.
std::optional<bool> condition_holds(std::string_view condition, vtkXMLDataElement* element, std::size_t place, std::size_t count) {
  if (const auto number = parsed_number<std::size_t>(condition)) return place + 1 == *number;
  if (condition == "last()") return place + 1 == count;
  if (condition.starts_with('@')) {
    const auto equals = condition.find('=');
    if (equals == std::string_view::npos) return std::nullopt;
    const std::string name(without_blanks(condition.substr(1, equals - 1)));
    const std::string_view value = without_blanks(condition.substr(equals + 1));
    if (value.size() < 2 || (value.front() != '"' && value.front() != '\'') || value.find(value.front(), 1) != value.size() - 1) return std::nullopt;
    const char* own = element->GetAttribute(name.c_str());
    return own && value.substr(1, value.size() - 2) == own;
  }
  for (std::string_view rest = condition; rest.starts_with("self::");) {
    const auto end = rest.find(" or ");
    if (without_blanks(rest.substr(6, end == std::string_view::npos ? end : end - 6)) == element->GetName()) return true;
    if (end == std::string_view::npos) return false;
    rest = without_blanks(rest.substr(end + 4));
  }
  return std::nullopt;
}

/// Those of some brothers that a step takes. False if it is not understood.
bool take_brothers(XmlElements brothers, const PathStep& step, XmlElements& to) {
  if (step.name != "*") std::erase_if(brothers, [&](vtkXMLDataElement* one) { return step.name != one->GetName(); });
  for (const std::string_view condition : step.conditions) {
    XmlElements kept;
    for (std::size_t i = 0; i < brothers.size(); ++i) {
      const auto is = condition_holds(condition, brothers[i], i, brothers.size());
      if (!is) return false;
      if (*is) kept.push_back(brothers[i]);
    }
    brothers = std::move(kept);
  }
  to.insert(to.end(), brothers.begin(), brothers.end());
  return true;
}

XmlElements nested_in(vtkXMLDataElement* element) {
  XmlElements out;
  for (int i = 0; i < element->GetNumberOfNestedElements(); ++i) out.push_back(element->GetNestedElement(i));
  return out;
}

bool take_anywhere(const XmlElements& brothers, const PathStep& step, XmlElements& to) {
  if (!take_brothers(brothers, step, to)) return false;
  return std::all_of(brothers.begin(), brothers.end(), [&](vtkXMLDataElement* one) { return take_anywhere(nested_in(one), step, to); });
}

/// "/1/2/3": the third element of the second of the root.
std::optional<XmlElements> by_numbers(vtkXMLDataElement* root, std::string_view path) {
  XmlElements brothers{root};
  vtkXMLDataElement* found = nullptr;
  while (path.starts_with('/')) {
    path.remove_prefix(1);
    const std::size_t end = std::min(path.find('/'), path.size());
    const auto number = parsed_number<std::size_t>(path.substr(0, end));
    if (!number) return std::nullopt;
    if (*number < 1 || *number > brothers.size()) return XmlElements{};
    found = brothers[*number - 1];
    brothers = nested_in(found);
    path.remove_prefix(end);
  }
  return path.empty() && found ? std::optional(XmlElements{found}) : std::nullopt;
}

}  // namespace

std::optional<XmlElements> elements_at(vtkXMLDataElement* root, std::string_view path) {
  path = without_blanks(path);
  if (path.starts_with("element(") && path.ends_with(')')) return by_numbers(root, path.substr(8, path.size() - 9));
  if (path.starts_with("xpointer(") && path.ends_with(')')) path = without_blanks(path.substr(9, path.size() - 10));
  const auto steps = path_steps(path);
  if (!steps || steps->empty()) return std::nullopt;
  XmlElements now{root};
  for (std::size_t s = 0; s < steps->size(); ++s) {
    const PathStep& step = (*steps)[s];
    XmlElements next;
    if (s == 0) {
      if (!(step.anywhere ? take_anywhere(now, step, next) : take_brothers(now, step, next))) return std::nullopt;
    } else {
      for (vtkXMLDataElement* one : now)
        if (!(step.anywhere ? take_anywhere(nested_in(one), step, next) : take_brothers(nested_in(one), step, next))) return std::nullopt;
    }
    now = std::move(next);
  }
  return now;
}

}  // namespace isostrata
