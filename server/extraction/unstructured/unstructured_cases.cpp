#include "extraction/unstructured/unstructured_cases.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <type_traits>

#include "base/finite.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/mesh/memory_budget.h"

namespace isostrata {
namespace {

constexpr std::uint64_t kMaxUses = 1u << 30;
constexpr unsigned kReaches = 1, kBegins = 2;  // of a point: its value is not below the intervals; it is before their end

constexpr std::array<int, kMaxCellVertices> kCaseDigits{1, 3, 9, 27, 81, 243, 729, 2187};

/// The four ids in order, and which vertex has which place. Equal ids keep the order of their vertices.
struct SortedIds {
  std::array<std::uint32_t, 4> ids;
  std::array<int, 4> vertex;
  std::uint8_t places;
  bool odd, distinct;
};

SortedIds sort_ids(const std::int64_t* ids) {
  std::array<std::uint64_t, 4> key;
  for (int v = 0; v < 4; ++v) key[v] = static_cast<std::uint64_t>(ids[v]) << 2 | static_cast<unsigned>(v);
  bool odd = false;
  const auto order = [&](int i, int j) {
    odd ^= key[j] < key[i];
    const std::uint64_t lower = std::min(key[i], key[j]), upper = std::max(key[i], key[j]);
    key[i] = lower;
    key[j] = upper;
  };
  order(0, 1);
  order(2, 3);
  order(0, 2);
  order(1, 3);
  order(1, 2);
  SortedIds out;
  out.places = 0;
  for (int i = 0; i < 4; ++i) {
    out.ids[i] = static_cast<std::uint32_t>(key[i] >> 2);
    out.vertex[i] = static_cast<int>(key[i] & 3);
    out.places = static_cast<std::uint8_t>(out.places | out.vertex[i] << 2 * i);
  }
  out.odd = odd;
  out.distinct = out.ids[0] != out.ids[1] && out.ids[1] != out.ids[2] && out.ids[2] != out.ids[3];
  return out;
}

/// Of the cell's volume, as handedness_of() has it; without its square root if there is no doubt.
int sign_of(double volume, std::span<const Vec3d> points) {
  Box3d box;
  for (const Vec3d& p : points) box.include(p);
  const Vec3d d = box.upper - box.lower;
  const double at_least_size = d.x + d.y + d.z;
  double largest = at_least_size;
  for (int axis = 0; axis < 3; ++axis) largest = std::max({largest, -box.lower[axis], box.upper[axis]});
  const double doubt = 5 * std::numeric_limits<double>::epsilon() * largest * at_least_size * at_least_size;
  if (std::abs(volume) > doubt) return volume > 0 ? 1 : -1;
  return handedness_of(volume, box).sign;
}

}  // namespace

UnstructuredCases::UnstructuredCases(const Grid& grid, const PointArray& array, const IsoRules& rules, std::uint64_t max_bytes,
                                     const Task& task)
    : grid_(grid),
      rules_(rules),
      max_bytes_(max_bytes),
      task_(task),
      cells_(std::get<UnstructuredGrid>(grid.shape)),
      blocks_((grid.cell_count() + kCellsPerBlock - 1) / kCellsPerBlock),
      uses_before_(blocks_.size() + 1),
      runs_before_(blocks_.size() + 1) {
  std::visit([&](auto values) { find(values); }, array.values);
  for (std::size_t b = 1; b < uses_before_.size(); ++b) {
    uses_before_[b] += uses_before_[b - 1];
    runs_before_[b] += runs_before_[b - 1];
  }
  bytes_ = listed_.load() * sizeof(CaseRecord);
  if (uses() > kMaxUses)
    throw Error(ErrorCode::too_large, "extraction: the active cells use points " + std::to_string(uses()) +
                                          " times; expected at most 2^30: narrow the intervals");
}

template <class T>
void UnstructuredCases::find(std::span<const T> values) {
  compare_points(values);
  std::atomic<std::int64_t> balance{0};
  for_each_block<std::vector<CaseRecord>>(task_, "searching", 0.0, 0.3, blocks(),
                                          [&](std::int64_t b, std::vector<CaseRecord>& records) {
                                            find_in_block(b, values, records);
                                            balance.fetch_add(count_block(b), std::memory_order_relaxed);
                                          });
  sides_ = {};
  usual_sign_ = balance.load() < 0 ? -1 : 1;
}

template <class T>
void UnstructuredCases::find_in_block(std::int64_t b, std::span<const T> values, std::vector<CaseRecord>& records) {
  const std::int64_t begin = b * kCellsPerBlock, end = std::min(grid_.cell_count(), begin + kCellsPerBlock);
  records.clear();
  Candidates candidates;
  for (std::int64_t cell = begin; cell < end;) {
    const std::int64_t run_end = end_of_run(cell, end);
    const auto find = [&]<CellType kType, int kVertices>(std::integral_constant<CellType, kType>,
                                                         std::integral_constant<int, kVertices>) {
      const std::size_t count = select<kVertices>(cell, run_end, candidates);
      add_candidates<kType, kVertices>(cell, std::span(candidates).first(count), values, records);
    };
    switch (static_cast<CellType>(cells_.shape().types[cell])) {
      case CellType::tetrahedron:
        find(std::integral_constant<CellType, CellType::tetrahedron>(), std::integral_constant<int, 4>());
        break;
      case CellType::pyramid:
        find(std::integral_constant<CellType, CellType::pyramid>(), std::integral_constant<int, 5>());
        break;
      case CellType::wedge:
        find(std::integral_constant<CellType, CellType::wedge>(), std::integral_constant<int, 6>());
        break;
      case CellType::hexahedron:
        find(std::integral_constant<CellType, CellType::hexahedron>(), std::integral_constant<int, 8>());
        break;
      case CellType::triangle:
      case CellType::quadrilateral:
        break;  // a flat grid does not come here
    }
    cell = run_end;
  }
  listed_.fetch_add(records.size(), std::memory_order_relaxed);
  blocks_[b] = pool_.keep(records);
}

/// Writes those cells of a run that compare_points() does not rule out, and returns how many.
template <int kVertices>
std::size_t UnstructuredCases::select(std::int64_t begin, std::int64_t end, Candidates& candidates) const {
  std::size_t count = 0;
  const std::int64_t* ids = cells_.ids(begin);
  for (std::int64_t cell = begin; cell < end; ++cell, ids += kVertices) {
    candidates[count] = static_cast<std::uint16_t>(cell - begin);
    unsigned sides = 0;
    for (int v = 0; v < kVertices; ++v) sides |= sides_[ids[v]];
    count += sides == (kReaches | kBegins);  // with a NaN the cell may pass; add_cases looks again
  }
  return count;
}

template <CellType kType, int kVertices, class T>
void UnstructuredCases::add_candidates(std::int64_t begin, std::span<const std::uint16_t> candidates, std::span<const T> values,
                                       std::vector<CaseRecord>& records) const {
  const std::int64_t* const first = cells_.ids(begin);
  constexpr std::size_t kAhead = 8;  // candidates whose points are brought near
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (i + kAhead < candidates.size()) {
      const std::int64_t* const later = first + candidates[i + kAhead] * kVertices;
      for (int v = 0; v < kVertices; ++v) cells_.prefetch(later[v]);
    }
    add_cases<kType, kVertices>(begin + candidates[i], first + candidates[i] * kVertices, values, records);
    if (i % 64 == 63 || i + 1 == candidates.size()) {
      task_.check();  // with many intervals a block is much
      check_budget("the list of active cells", (listed_.load(std::memory_order_relaxed) + records.size()) * sizeof(CaseRecord),
                   max_bytes_);
    }
  }
}

/// The first cell after `cell` of another type, at most `end`.
std::int64_t UnstructuredCases::end_of_run(std::int64_t cell, std::int64_t end) const {
  const std::uint8_t* const types = cells_.shape().types.data();
  if (std::memcmp(types + cell, types + cell + 1, static_cast<std::size_t>(end - cell - 1)) == 0) return end;
  std::int64_t last = cell + 1;
  while (types[last] == types[cell]) ++last;
  return last;
}

/// Notes for each point whether it reaches the intervals and whether it lies before their end. One byte a point instead of a
/// value makes the search through the cells twice as fast: what it gathers from fits the core's cache.
template <class T>
void UnstructuredCases::compare_points(std::span<const T> values) {
  check_budget("the sides of the points", values.size(), max_bytes_);
  sides_.resize(values.size());
  const double lowest = rules_.lowest(), highest = rules_.highest();
  parallel_for(static_cast<std::int64_t>(values.size()), 1 << 16, [&](std::int64_t begin, std::int64_t end) {
    task_.check();
    for (std::int64_t i = begin; i < end; ++i) {
      const auto f = static_cast<double>(values[i]);
      sides_[i] = static_cast<std::uint8_t>((f >= lowest ? kReaches : 0) | (f < highest ? kBegins : 0));
    }
  });
}

/// Adds the cell's cases if it is active and not absent (active_cells.h).
template <CellType kType, int kVertices, class T>
void UnstructuredCases::add_cases(std::int64_t cell, const std::int64_t* ids, std::span<const T> values,
                                  std::vector<CaseRecord>& records) const {
  if (grid_.hidden(cell)) return;
  std::array<double, kVertices> f;
  for (int v = 0; v < kVertices; ++v) f[v] = static_cast<double>(values[ids[v]]);
  double minimum = f[0], maximum = f[0];
  bool finite = true;
  for (int v = 0; v < kVertices; ++v) {
    finite = finite && std::isfinite(f[v]);
    minimum = f[v] < minimum ? f[v] : minimum;
    maximum = f[v] > maximum ? f[v] : maximum;
  }
  if (!finite) return;
  CaseRecord record;
  SortedIds sorted;
  bool looked = false;
  rules_.visit_active(minimum, maximum, [&](std::uint16_t interval, const IsoRule& rule) {
    if (!looked) {
      looked = true;
      std::array<Vec3d, kVertices> p;
      for (int v = 0; v < kVertices; ++v) {
        p[v] = cells_.point(ids[v]);
        finite = finite && is_finite(p[v]);
      }
      record.cell = static_cast<std::uint32_t>(cell);
      if constexpr (kType == CellType::tetrahedron) {
        record.sign = static_cast<std::int8_t>(sign_of(orient3d(p[0], p[1], p[2], p[3]) / 6, p));
        sorted = sort_ids(ids);
        record.has_row = sorted.distinct;
        record.ids = sorted.ids;
        record.places = sorted.places;
        record.odd = sorted.odd;
      } else {
        record.sign = static_cast<std::int8_t>(sign_of(signed_cell_volume(topology(kType), p.data()), p));
      }
    }
    if (!finite) return;
    int case_index = 0;
    if (record.has_row)
      for (int i = 0; i < 4; ++i) case_index += rule.class_of(f[sorted.vertex[i]]) * kCaseDigits[i];
    else
      for (int v = 0; v < kVertices; ++v) case_index += rule.class_of(f[v]) * kCaseDigits[v];
    record.interval = interval;
    record.case_index = static_cast<std::uint16_t>(case_index);
    records.push_back(record);
  });
}

/// Counts the block's uses and cells; returns how many more cells are right-handed than left-handed.
std::int64_t UnstructuredCases::count_block(std::int64_t b) {
  std::uint64_t uses = 0, runs = 0;
  std::int64_t balance = 0;
  const CaseRecord* before = nullptr;
  for (const CaseRecord& record : blocks_[b]) {
    uses += use_count(record);
    if (!before || before->cell != record.cell) {
      ++runs;
      balance += record.sign;
    }
    before = &record;
  }
  uses_before_[b + 1] = uses;
  runs_before_[b + 1] = runs;
  return balance;
}

}  // namespace isostrata
