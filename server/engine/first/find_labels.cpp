#include "engine/first/find_labels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <type_traits>
#include <unordered_set>
#include <utility>
#include <variant>

namespace isostrata {
namespace {

constexpr std::size_t kLooks = 8'000'000, kFirstLooks = 65'536, kFewestPerLabel = 50;
constexpr double kAlike = 0.6;    // least share of points that are as the one before
constexpr std::size_t kFew = 32;  // so many values number things if they hold together; more only if they are not a quantity's
constexpr std::size_t kMostSteps = 4096;

template <class T>
T commonest(std::span<const T> values) {
  constexpr std::size_t kSome = 4096;
  std::vector<T> some;
  for (std::size_t i = 0; i < values.size(); i += std::max<std::size_t>(1, values.size() / kSome)) some.push_back(values[i]);
  std::sort(some.begin(), some.end());
  T most{};
  std::size_t longest = 0;
  for (auto begin = some.begin(); begin != some.end();) {
    const auto end = std::upper_bound(begin, some.end(), *begin);
    if (const auto length = static_cast<std::size_t>(end - begin); length > longest) longest = length, most = *begin;
    begin = end;
  }
  return most;
}

/// What points and those before them in memory have.
template <class T>
struct Neighbours {
  std::vector<T> values;               // each once, rising
  std::size_t looks = 0, alike = 0;    // pairs, and those of one value
  std::size_t inside = 0, alike_inside = 0;  // the same of pairs that are not both of the commonest value
  std::size_t unlike_inside = 0;       // pairs of two values, neither of them the commonest
  std::vector<std::pair<T, T>> steps;  // some of those
};

/// Nothing if there are too many values, or hardly two neighbours have the same one.
template <class T>
std::optional<Neighbours<T>> look_at(std::span<const T> values) {
  const std::size_t stride = std::max<std::size_t>(1, values.size() / kLooks);
  const T background = commonest(values);
  Neighbours<T> all;
  std::unordered_set<T> found;
  T last{};
  for (std::size_t i = 1; i < values.size(); i += stride) {
    const T before = values[i - 1], here = values[i];
    if constexpr (std::is_floating_point_v<T>)
      if (here != std::floor(here) || std::abs(here) > 1e15) return std::nullopt;
    ++all.looks;
    const bool alike = here == before, both_outside = alike && here == background;
    all.alike += alike;
    all.inside += !both_outside;
    all.alike_inside += alike && !both_outside;
    if (!alike && here != background && before != background && all.unlike_inside++ % 16 == 0 && all.steps.size() < kMostSteps) all.steps.emplace_back(before, here);
    if (all.looks == 1 || here != last) {
      found.insert({before, here});
      last = here;
      if (found.size() > static_cast<std::size_t>(kMostLabels)) return std::nullopt;
    }
    if (all.looks == kFirstLooks && all.alike < all.looks / 4) return std::nullopt;
  }
  all.values.assign(found.begin(), found.end());
  std::sort(all.values.begin(), all.values.end());
  return all;
}

/// Whether the values go up and down by small steps, as a quantity does that was rounded: numbers of things beside each other have little to do with
/// each other.
template <class T>
bool is_rounded(const Neighbours<T>& all) {
  if (all.steps.empty() || all.unlike_inside * 20 < all.inside - all.alike_inside) return false;  // things that hardly touch each other
  const auto rank = [&](T value) { return std::lower_bound(all.values.begin(), all.values.end(), value) - all.values.begin(); };
  std::vector<std::ptrdiff_t> steps;
  for (const auto& [a, b] : all.steps) steps.push_back(std::abs(rank(a) - rank(b)));
  const auto percentile = [&](std::size_t percent) {
    const auto at = steps.begin() + static_cast<std::ptrdiff_t>(percent * (steps.size() - 1) / 100);
    std::nth_element(steps.begin(), at, steps.end());
    return *at;
  };
  const auto part = [&](std::ptrdiff_t of) { return std::max<std::ptrdiff_t>(2, std::ssize(all.values) / of); };
  // In an atlas, too, half of the steps may be small, for the parts of a thing have numbers one behind the other; but others go far.
  return percentile(50) < part(32) && percentile(90) < part(5);
}

bool most(std::size_t alike, std::size_t of) { return static_cast<double>(alike) >= kAlike * static_cast<double>(of); }

template <class T>
std::vector<double> labels_of(std::span<const T> values) {
  const auto all = look_at(values);
  if (!all || all->values.size() < 3 || values.size() < kFewestPerLabel * all->values.size() || !most(all->alike, all->looks)) return {};
  if (all->values.size() > kFew && (!most(all->alike_inside, all->inside) || is_rounded(*all))) return {};
  return {all->values.begin(), all->values.end()};
}

}  // namespace

std::vector<double> find_labels(const PointArray& array) {
  return std::visit([](auto values) { return labels_of<std::remove_cv_t<typename decltype(values)::element_type>>(values); }, array.values);
}

}  // namespace isostrata
