#include "base/nearest_name.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace isostrata {
namespace {

constexpr std::size_t kLongest = 100;  // letters: nobody mistypes more, and the table is as large as their square

char lower(char letter) { return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter; }

/// Edits from one to the other, neighbours that changed places counted as one (optimal string alignment).
std::size_t edits(std::string_view from, std::string_view to) {
  std::array<std::vector<std::size_t>, 3> rows;  // of the letter before the last, the last, this one
  for (auto& row : rows) row.resize(to.size() + 1);
  for (std::size_t j = 0; j <= to.size(); ++j) rows[2][j] = j;
  for (std::size_t i = 1; i <= from.size(); ++i) {
    std::rotate(rows.begin(), rows.begin() + 1, rows.end());
    rows[2][0] = i;
    for (std::size_t j = 1; j <= to.size(); ++j) {
      const bool same = lower(from[i - 1]) == lower(to[j - 1]);
      rows[2][j] = std::min({rows[1][j] + 1, rows[2][j - 1] + 1, rows[1][j - 1] + (same ? 0 : 1)});
      if (i > 1 && j > 1 && lower(from[i - 1]) == lower(to[j - 2]) && lower(from[i - 2]) == lower(to[j - 1]))
        rows[2][j] = std::min(rows[2][j], rows[0][j - 2] + 1);
    }
  }
  return rows[2][to.size()];
}

}  // namespace

std::string did_you_mean(std::string_view typed, std::span<const std::string> names) {
  if (typed.size() > kLongest) return {};
  std::string_view nearest;
  std::size_t least = std::max<std::size_t>(1, typed.size() / 3) + 1;
  for (const std::string& name : names) {
    if (name.size() > kLongest) continue;
    if (const std::size_t needed = edits(typed, name); needed < least) {
      least = needed;
      nearest = name;
    }
  }
  return nearest.empty() ? std::string() : " Did you mean '" + std::string(nearest) + "'?";
}

}  // namespace isostrata
