#include "extraction/cells/active_cells.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "base/finite.h"
#include "base/parallel.h"
#include "extraction/mesh/memory_budget.h"

namespace isostrata {
namespace {

constexpr std::array<int, kMaxCellVertices> kPowersOf3{1, 3, 9, 27, 81, 243, 729, 2187};

/// Positions of uniform and rectilinear grids are finite by contract.
bool positions_are_finite(const Grid& grid, std::span<const std::int64_t> ids) {
  if (grid.rectilinear()) return true;
  return std::all_of(ids.begin(), ids.end(), [&](std::int64_t id) { return is_finite(grid.point(id)); });
}

/// Adds the cell's cases if it is active and not absent.
void classify(const Grid& grid, const IsoRules& rules, std::int64_t cell, std::span<const std::int64_t> ids, const double* values,
              std::vector<CellCase>& out) {
  const int n = static_cast<int>(ids.size());
  double minimum = values[0], maximum = values[0];
  bool finite = true;
  for (int v = 0; v < n; ++v) {
    minimum = std::min(minimum, values[v]);
    maximum = std::max(maximum, values[v]);
    finite = finite && std::isfinite(values[v]);
  }
  if (!finite || grid.hidden(cell)) return;
  bool checked = false;
  rules.visit_active(minimum, maximum, [&](std::uint16_t interval, const IsoRule& rule) {
    if (!checked && !positions_are_finite(grid, ids)) finite = false;
    checked = true;
    if (!finite) return;
    int case_index = 0;
    for (int v = 0; v < n; ++v) case_index += rule.class_of(values[v]) * kPowersOf3[v];
    out.push_back({cell, interval, static_cast<std::uint16_t>(case_index)});
  });
}

/// What every find shares.
struct Search {
  const Grid& grid;
  const IsoRules& rules;
  std::uint64_t max_bytes;
  const Task& task;
};

/// Runs find(begin, end, check, out) over blocks of [0, count) and joins their lists in order. find calls check(out) often.
template <class Find>
std::vector<CellCase> join_blocks(const Search& search, std::int64_t count, std::int64_t block, const Find& find) {
  const Task& task = search.task;
  const std::int64_t blocks = (count + block - 1) / block;
  std::vector<std::vector<CellCase>> found(blocks);
  std::atomic<std::uint64_t> listed{0};
  const auto check = [&](const std::vector<CellCase>& out) {
    task.check();
    // The list is held twice while it is joined.
    check_budget("the list of active cells", 2 * (listed.load(std::memory_order_relaxed) + out.size()) * sizeof(CellCase),
                 search.max_bytes);
  };
  StageProgress progress(task, "searching", 0.0, 0.3, count);
  parallel_for(blocks, 1, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t b = first; b < last; ++b) {
      const std::int64_t begin = b * block, end = std::min(count, begin + block);
      find(begin, end, check, found[b]);
      check(found[b]);
      listed.fetch_add(found[b].size(), std::memory_order_relaxed);
      progress.done(end - begin);
    }
  });
  std::vector<std::size_t> offsets(blocks + 1);
  for (std::int64_t b = 0; b < blocks; ++b) offsets[b + 1] = offsets[b] + found[b].size();
  std::vector<CellCase> all(offsets[blocks]);
  parallel_for(blocks, 16, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t b = first; b < last; ++b) {
      std::copy(found[b].begin(), found[b].end(), all.begin() + static_cast<std::ptrdiff_t>(offsets[b]));
      found[b] = {};
    }
  });
  return all;
}

/// The extremes of the four rows of points around a row of cells, column by column. A NaN may or may not come through; classify
/// looks again.
template <class T>
struct RowExtremes {
  std::vector<T> lowest, highest;  // [ni] over the four rows

  void compute(const T* a, const T* b, const T* c, const T* d, std::int64_t ni) {
    lowest.resize(ni);
    highest.resize(ni);
    T* const lo = lowest.data();
    T* const hi = highest.data();
    for (std::int64_t i = 0; i < ni; ++i) {
      const T ab_lo = a[i] < b[i] ? a[i] : b[i], ab_hi = a[i] > b[i] ? a[i] : b[i];
      const T cd_lo = c[i] < d[i] ? c[i] : d[i], cd_hi = c[i] > d[i] ? c[i] : d[i];
      lo[i] = ab_lo < cd_lo ? ab_lo : cd_lo;
      hi[i] = ab_hi > cd_hi ? ab_hi : cd_hi;
    }
  }
};

/// The smallest T that is not below the bound once promoted to double; for integers in a type that also holds one past T's
/// largest.
template <class T>
auto threshold(double bound) {
  if constexpr (std::is_same_v<T, float>) {
    float t = static_cast<float>(bound);  // overflows to infinity, which is right
    if (static_cast<double>(t) < bound) t = std::nextafter(t, std::numeric_limits<float>::infinity());
    return t;
  } else if constexpr (std::is_integral_v<T> && sizeof(T) <= 4) {
    using Wide = std::conditional_t<sizeof(T) <= 2, std::int32_t, std::int64_t>;
    const double lowest = static_cast<double>(std::numeric_limits<T>::lowest());
    const double past = static_cast<double>(std::numeric_limits<T>::max()) + 1;
    return static_cast<Wide>(std::clamp(std::ceil(bound), lowest, past));
  } else {
    return bound;  // double, and 64-bit integers, which are promoted
  }
}

template <class T>
std::vector<CellCase> find_structured(const Search& search, std::span<const T> values) {
  const Grid& grid = search.grid;
  const IsoRules& rules = search.rules;
  const auto dims = grid.dims();
  const std::int64_t ni = dims[0], nj = dims[1];
  const std::int64_t ci = ni - 1, cj = nj - 1, ck = dims[2] - 1;
  const auto lowest = threshold<T>(rules.lowest());
  const auto highest = threshold<T>(rules.highest());
  using Bound = std::remove_const_t<decltype(lowest)>;

  const std::int64_t rows = cj * ck;
  const std::int64_t block = std::max<std::int64_t>(1, 32768 / std::max<std::int64_t>(ci, 1));
  return join_blocks(
      search, rows, block, [&](std::int64_t begin, std::int64_t end, const auto& check, std::vector<CellCase>& out) {
        RowExtremes<T> row;
        std::vector<std::uint8_t> candidate((ci + 7) / 8 * 8);
        for (std::int64_t r = begin; r < end; ++r) {
          const std::int64_t k = r / cj, j = r - k * cj;
          const std::int64_t first = ni * (j + nj * k);
          const T* const p = values.data() + first;
          row.compute(p, p + ni, p + ni * nj, p + ni * nj + ni, ni);
          const T* const lo = row.lowest.data();
          const T* const hi = row.highest.data();
          for (std::int64_t i = 0; i < ci; ++i) {
            const bool reaches = (static_cast<Bound>(hi[i]) >= lowest) | (static_cast<Bound>(hi[i + 1]) >= lowest);
            const bool begins = (static_cast<Bound>(lo[i]) < highest) | (static_cast<Bound>(lo[i + 1]) < highest);
            candidate[i] = reaches & begins;
          }
          for (std::int64_t i8 = 0; i8 < ci; i8 += 8) {
            std::uint64_t eight;
            std::memcpy(&eight, candidate.data() + i8, 8);
            if (eight == 0) continue;
            check(out);
            for (std::int64_t i = i8; i < std::min(ci, i8 + 8); ++i) {
              if (!candidate[i]) continue;
              const std::int64_t q = first + i;
              const std::array<std::int64_t, 8> ids{q,           q + 1,           q + ni + 1,           q + ni,
                                                    q + ni * nj, q + ni * nj + 1, q + ni * nj + ni + 1, q + ni * nj + ni};
              std::array<double, 8> f;
              for (int v = 0; v < 8; ++v) f[v] = static_cast<double>(values[ids[v]]);
              classify(grid, rules, r * ci + i, ids, f.data(), out);
            }
          }
        }
      });
}

/// Cell by cell: ids_of(cell, room) are the cell's points.
template <class T, class IdsOf>
std::vector<CellCase> find_in_cells(const Search& search, std::span<const T> values, const IdsOf& ids_of) {
  constexpr std::int64_t kCellsPerBlock = 8192;
  return join_blocks(search, search.grid.cell_count(), kCellsPerBlock,
                     [&](std::int64_t begin, std::int64_t end, const auto& check, std::vector<CellCase>& out) {
                       std::array<std::int64_t, kMaxCellVertices> room;
                       std::array<double, kMaxCellVertices> f;
                       for (std::int64_t cell = begin; cell < end; ++cell) {
                         const std::span<const std::int64_t> ids = ids_of(cell, room);
                         for (std::size_t v = 0; v < ids.size(); ++v) f[v] = static_cast<double>(values[ids[v]]);
                         classify(search.grid, search.rules, cell, ids, f.data(), out);
                         if (cell % 16 == 0) check(out);
                       }
                     });
}

template <class T>
std::vector<CellCase> find_unstructured(const Search& search, std::span<const T> values) {
  return find_in_cells(search, values, [&shape = std::get<UnstructuredGrid>(search.grid.shape)](std::int64_t cell, auto&) {
    return shape.connectivity.subspan(static_cast<std::size_t>(shape.offsets[cell]),
                                      static_cast<std::size_t>(shape.offsets[cell + 1] - shape.offsets[cell]));
  });
}

template <class T>
std::vector<CellCase> find_flat(const Search& search, std::span<const T> values) {
  return find_in_cells(search, values, [&grid = search.grid](std::int64_t cell, auto& room) {
    return std::span<const std::int64_t>(room).first(static_cast<std::size_t>(grid.cell_points(cell, room)));
  });
}

}  // namespace

std::vector<CellCase> find_active_cells(const Grid& grid, const PointArray& array, const IsoRules& rules, std::uint64_t max_bytes,
                                        const Task& task) {
  if (grid.cell_count() == 0) return {};
  const Search search{grid, rules, max_bytes, task};
  return std::visit(
      [&](auto values) {
        if (grid.flat()) return find_flat(search, values);
        return grid.structured() ? find_structured(search, values) : find_unstructured(search, values);
      },
      array.values);
}

bool cell_is_absent(const Grid& grid, const PointArray& array, std::int64_t cell) {
  if (grid.hidden(cell)) return true;
  std::array<std::int64_t, kMaxCellVertices> ids;
  const auto n = static_cast<std::size_t>(grid.cell_points(cell, ids));
  for (std::size_t v = 0; v < n; ++v)
    if (!std::isfinite(array.at(ids[v]))) return true;
  return !positions_are_finite(grid, std::span(ids).first(n));
}

}  // namespace isostrata
