// Headers of FITS for the tests that write its files byte by byte.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace isostrata::test {

using Cards = std::vector<std::pair<std::string, std::string>>;

inline std::string padded(std::string text, char by) {
  text.resize((text.size() + 2879) / 2880 * 2880, by);
  return text;
}

inline std::string header(const Cards& cards) {
  std::string out;
  for (const auto& [key, value] : cards) {
    std::string card = key;
    card.resize(8, ' ');
    card += "= " + value;
    card.resize(80, ' ');
    out += card;
  }
  return padded(out + "END" + std::string(77, ' '), ' ');
}

inline Cards image(int bits, const std::vector<int>& axes, const Cards& more = {}) {
  Cards cards{{"SIMPLE", "T"}, {"BITPIX", std::to_string(bits) + " / bits of a number"}, {"NAXIS", std::to_string(axes.size())}};
  for (std::size_t a = 0; a < axes.size(); ++a) cards.emplace_back("NAXIS" + std::to_string(a + 1), std::to_string(axes[a]));
  cards.insert(cards.end(), more.begin(), more.end());
  return cards;
}

}  // namespace isostrata::test
