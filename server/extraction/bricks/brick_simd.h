// The loops over values in their own type, in vectors of the machine that runs them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isostrata {

/// For one scalar type T. Every function may be called from any thread.
template <class T>
struct BrickSimd {
  static constexpr std::size_t kReadAhead = 16;  // values read from the start of every row of test_rows

  /// lowest[i] = min(lowest[i], row[i]), highest likewise, for i < count; NaN changes neither. Where T is a floating type and
  /// row[i] is not finite, residue[i] becomes NaN; it is 0 before. Else residue is not touched.
  void (*include_row)(const T* row, std::size_t count, T* lowest, T* highest, T* residue);

  /// Bit i < 9 of bits[9 k + j] is values[i + j row_stride + k layer_stride] >= threshold, false for NaN; bits from 9 on mean
  /// nothing. For j < rows, k < layers, at most 9.
  void (*test_rows)(const T* values, std::int64_t row_stride, std::int64_t layer_stride, int rows, int layers, T threshold,
                    std::uint16_t* bits);
};

template <class T>
BrickSimd<T> brick_simd();

}  // namespace isostrata
