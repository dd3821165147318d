// What is done to one brick of a structured grid, compiled for several kinds of machine.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "extraction/bricks/brick_layout.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

inline constexpr int kBrickRows = 9 * 9;  // of points, [9 k + j]
using RowBits = std::array<std::uint16_t, kBrickRows>;

/// One interval in one active cell of a brick, in 32 bits.
class CellRecord {
 public:
  CellRecord() = default;
  CellRecord(int cell, int case_index, int interval)
      : bits_(static_cast<std::uint32_t>(cell) | static_cast<std::uint32_t>(case_index) << 9 |
              static_cast<std::uint32_t>(interval) << 24) {}

  int cell() const { return static_cast<int>(bits_ & 511); }  // i + 8 j + 64 k in the brick
  int case_index() const { return static_cast<int>(bits_ >> 9 & 8191); }
  int interval() const { return static_cast<int>(bits_ >> 24); }
  /// 0 right-handed, or as the whole grid; 1 left-handed; 2 flat, which has no hand of its own.
  int handedness() const { return static_cast<int>(bits_ >> 22 & 3); }
  void set_handedness(int sign) { bits_ = (bits_ & ~(3u << 22)) | (sign < 0 ? 1u << 22 : 0) | (sign == 0 ? 2u << 22 : 0); }

  bool operator==(const CellRecord&) const = default;

 private:
  std::uint32_t bits_ = 0;
};

inline constexpr std::size_t kMaxRecordIntervals = 256;

/// An interval in a brick, by the brick's own numbers of its ends: an end below all values of the brick is kEndBelow, one above
/// all kEndAbove.
struct BrickInterval {
  static constexpr int kEndBelow = -1, kEndAbove = -2;
  int interval = 0;
  int lower = 0, upper = 0;

  bool operator==(const BrickInterval&) const = default;
};

/// Which cells of a brick and around it hold parts of intervals: bit i + 1 of row 9 (k + 1) + (j + 1) for the cell at i, j, k
/// relative to the brick, from -1 to 7. Cells outside the grid are not there.
using PresentCells = RowBits;

/// What classify_brick finds. The mesh points that the brick owns are numbered by k, then slot (0 the grid points, 1 + 3 v + axis
/// the crossings of its isovalue v on edges along the axis), then j, then i.
struct BrickCase {
  std::span<std::uint64_t> words;  // [8][1 + 3 isovalues] bit i + 8 j
  std::span<std::uint32_t> bases;  // [8][1 + 3 isovalues] points of the brick before the word's
  std::uint32_t points = 0, cells = 0, tetrahedra = 0;
};

/// isovalues: for each isovalue that values of the brick lie on both sides of, which points reach it (bits up to
/// place.reach[0] and rows up to place.reach are read). Appends the records, by cell, then in the order of `intervals`. present:
/// null if all cells of the grid around the brick are.
void classify_brick(const BrickLayout::Place& place, std::span<RowBits> isovalues, std::span<const BrickInterval> intervals,
                    const PresentCells* present, BrickCase& out, std::vector<CellRecord>& records);

/// The numbers of mesh points in a brick's table (HexahedronGather) from one of the up to eight bricks that own them.
struct BrickPoints {
  const std::uint64_t* words = nullptr;  // null if the brick owns none
  const std::uint32_t* bases = nullptr;
  std::uint32_t first_point = 0;
  int isovalues = 0;         // of that brick
  int lower = 0, upper = 0;  // the interval's ends among them, or outside [0, isovalues)
};

/// owners[di + 2 dj + 4 dk]. numbers: [7][9][9][9]; only what owners have is written.
void fill_numbers(const std::array<BrickPoints, 8>& owners, std::uint32_t* numbers);

/// Writes the tetrahedra of a brick's records. numbers_of[interval]: its table. turned[handedness]: whether tetrahedra are
/// turned. out: [tetrahedra]. Returns how many were written.
std::size_t write_records(std::span<const CellRecord> records, const std::uint32_t* const* numbers_of,
                          const std::array<std::uint8_t, 4>& turned, std::array<std::uint32_t, 4>* out);

}  // namespace isostrata
