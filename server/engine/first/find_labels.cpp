#include "engine/first/find_labels.h"

#include <algorithm>
#include <set>
#include <type_traits>
#include <variant>

namespace isostrata {
namespace {

constexpr std::size_t kLooks = 8'000'000, kFewestPerLabel = 50;
constexpr double kAlike = 0.6;  // least share of points that are as the one before

template <class T>
std::vector<double> labels_of(std::span<const T> values) {
  const std::size_t stride = std::max<std::size_t>(1, values.size() / kLooks);
  std::set<T> found;
  std::size_t looks = 0, alike = 0;
  for (std::size_t i = 1; i < values.size(); i += stride) {
    ++looks;
    if (values[i] == values[i - 1]) {
      ++alike;
      if (stride == 1) continue;  // it was inserted as that before
    }
    found.insert({values[i - 1], values[i]});
    if (found.size() > static_cast<std::size_t>(kMostLabels)) return {};
  }
  if (found.size() < 3 || values.size() < kFewestPerLabel * found.size()) return {};
  if (static_cast<double>(alike) < kAlike * static_cast<double>(looks)) return {};
  return {found.begin(), found.end()};
}

}  // namespace

std::vector<double> find_labels(const PointArray& array) {
  return std::visit(
      [](auto values) -> std::vector<double> {
        using T = std::remove_cv_t<typename decltype(values)::element_type>;
        if constexpr (std::is_integral_v<T>)
          return labels_of<T>(values);
        else
          return {};
      },
      array.values);
}

}  // namespace isostrata
