// The two ends of a cut of a grid of tetrahedra, in vectors of the machine that runs it: the look at every value, and the
// tetrahedra that are written.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace isostrata {

/// bins[i] is how many of the thresholds values[i] reaches (values[i] >= threshold), for i < count. At most 255 thresholds.
template <class T>
using CountReached = void (*)(const T* values, std::size_t count, std::span<const T> thresholds, std::uint8_t* bins);

/// For each of the ten scalar types. Any thread.
template <class T>
CountReached<T> count_reached();

/// What one interval does to 64 tetrahedra.
struct BlockCases {
  std::array<std::uint8_t, 64> of;  // sum of bin * 3^i over the vertices i: 0 all below, 80 all above
  std::uint64_t active;             // bit t: neither of these
};
/// bins: of the block's points, at most 64, each 0, 1 or 2; corners: the vertices, as places in bins. Any thread.
void find_cases(const std::array<std::uint8_t, 64>& bins, const std::array<std::array<std::uint8_t, 64>, 4>& corners,
                BlockCases& out);

/// A case of a tetrahedron in the form in which it is written: each vertex is one of the sixteen numbers that a cell may use.
struct CutRow {
  static constexpr int kNumbers = 16;
  std::array<std::array<std::uint8_t, 4>, 8> slots{};  // of count, at most 6; what is behind them is read, too
  std::uint8_t count = 0;
};

/// Writes rows[i]'s tetrahedra out of numbers[i], for i < count, one after another to `out`, if there is room for just these.
/// Any thread.
void write_rows(const std::array<std::uint32_t, CutRow::kNumbers>* numbers, const CutRow* const* rows, std::size_t count,
                std::span<std::array<std::uint32_t, 4>> out);

}  // namespace isostrata
