#include "extraction/unstructured/ordered_rows.h"

#include <cstdint>

#include "extraction/unstructured/sorted_tetrahedron.h"

namespace isostrata {
namespace {

constexpr std::array<int, 4> kPowersOf3{1, 3, 9, 27};

OrderedRows build_rows(bool alone) {
  OrderedRows rows;
  for (int i = 0; i < 81; ++i) {
    const SortedTetrahedronRow& row = sorted_tetrahedron_rows()[i];
    std::array<std::uint8_t, SortedTetrahedronRow::kMaxUses> slot{};
    for (int u = 0; u < row.use_count; ++u) {
      const auto& [a, b, end] = row.uses[u];
      int edge = 0;
      while (end != SortedTetrahedronRow::kKept && (kSortedEdges[edge][0] != a || kSortedEdges[edge][1] != b)) ++edge;
      const int class_a = i / kPowersOf3[a] % 3, class_b = i / kPowersOf3[b] % 3;
      const bool upper = end == SortedTetrahedronRow::kUpper && (!alone || class_a == 0 || class_b == 0);
      slot[u] = static_cast<std::uint8_t>(end == SortedTetrahedronRow::kKept ? a : edge + (upper ? kUpperSlot : kLowerSlot));
    }
    for (int swapped = 0; swapped < 2; ++swapped) {
      CutRow& out = rows[swapped][i];
      out.count = row.count;
      for (int t = 0; t < row.count; ++t) {
        const auto& of = row.tetrahedra[t];
        out.slots[t] = {slot[of[swapped]], slot[of[!swapped]], slot[of[2]], slot[of[3]]};
      }
    }
  }
  return rows;
}

}  // namespace

const OrderedRows& ordered_rows(bool alone) {
  static const std::array<OrderedRows, 2> rows{build_rows(false), build_rows(true)};
  return rows[alone];
}

}  // namespace isostrata
