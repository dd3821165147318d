#include "extraction/bricks/active_bricks.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "base/parallel.h"
#include "extraction/bricks/brick_simd.h"
#include "extraction/bricks/present_cells.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/cells/value_threshold.h"
#include "extraction/mesh/memory_budget.h"

namespace isostrata {
namespace {

constexpr std::int64_t kBricksPerBlock = 16;

/// The ends of a request in the array's own type.
template <class T>
struct Thresholds {
  explicit Thresholds(const IsoRules& rules) {
    std::vector<double> begins;
    for (const IsoRule& rule : rules.rules()) begins.push_back(rule.lower);
    std::sort(begins.begin(), begins.end());
    for (const double isovalue : rules.isovalues()) {  // where an interval begins, those that end there do at the same value
      const bool one_begins = std::binary_search(begins.begin(), begins.end(), isovalue);
      of.push_back(value_threshold<T>(one_begins ? isovalue : std::nextafter(isovalue, std::numeric_limits<double>::infinity())));
    }
    lowest = value_threshold<T>(rules.lowest());
    highest = value_threshold<T>(rules.highest());
  }
  std::vector<ValueThreshold<T>> of;  // [isovalues] increasing
  ValueThreshold<T> lowest, highest;  // of all lower and all above
};

/// Reads which values of a brick reach each of its isovalues.
template <class T>
class BrickReader {
 public:
  BrickReader(const BrickLayout& layout, std::span<const T> values) : layout_(layout), values_(values), simd_(brick_simd<T>()) {}

  void turn_to(const BrickLayout::Place& place) {
    place_ = place;
    const std::int64_t first = layout_.point(place.first);
    row_stride_ = layout_.dims[0];
    layer_stride_ = layout_.dims[0] * layout_.dims[1];
    at_ = values_.data() + first;
    const std::int64_t last_row = first + (place.reach[1] - 1) * row_stride_ + (place.reach[2] - 1) * layer_stride_;
    constexpr auto kReadAhead = static_cast<std::int64_t>(BrickSimd<T>::kReadAhead);
    if (last_row + kReadAhead <= static_cast<std::int64_t>(values_.size())) return;
    copy_.assign(kBrickRows * kReadAhead, T{});  // vectors would read past the end of the array
    for (int k = 0; k < place.reach[2]; ++k)
      for (int j = 0; j < place.reach[1]; ++j)
        std::copy_n(at_ + j * row_stride_ + k * layer_stride_, place.reach[0], copy_.begin() + (9 * k + j) * kReadAhead);
    at_ = copy_.data();
    row_stride_ = kReadAhead;
    layer_stride_ = 9 * kReadAhead;
  }
  void test(const ValueThreshold<T>& threshold, RowBits& bits) const {
    simd_.test_rows(at_, row_stride_, layer_stride_, place_.reach[1], place_.reach[2], threshold.least, bits.data());
  }

 private:
  const BrickLayout& layout_;
  const std::span<const T> values_;
  const BrickSimd<T> simd_;
  BrickLayout::Place place_;
  const T* at_ = nullptr;
  std::int64_t row_stride_ = 0, layer_stride_ = 0;
  std::vector<T> copy_;
};

/// Tells how the cells of the records are turned. Returns the sum over the cells of their signs.
std::int64_t find_handedness(const Grid& grid, const BrickLayout& layout, const BrickLayout::Place& place,
                             std::span<CellRecord> records) {
  std::int64_t balance = 0;
  const auto& shape = std::get<CurvilinearGrid>(grid.shape);
  const CellTopology& cell = topology(CellType::hexahedron);
  int last = -1, sign = 0;
  std::visit(
      [&](auto points) {
        for (CellRecord& record : records) {
          if (record.cell() != last) {
            last = record.cell();
            std::array<Vec3d, 8> p;
            for (int v = 0; v < 8; ++v) {
              const auto& corner = kHexahedronCorners[v];
              const auto& at =
                  points[layout.point({place.first[0] + (last & 7) + corner[0], place.first[1] + (last >> 3 & 7) + corner[1],
                                       place.first[2] + (last >> 6) + corner[2]})];
              p[v] = {static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z)};
            }
            sign = cell_handedness(cell, p).sign;
            balance += sign;
          }
          record.set_handedness(sign);
        }
      },
      shape.points);
  return balance;
}

/// What find_handedness returned for the records.
std::int64_t sum_of_hands(std::span<const CellRecord> records) {
  std::int64_t balance = 0;
  int last = -1;
  for (const CellRecord& record : records) {
    if (record.cell() != last) balance += record.handedness() == 0 ? 1 : record.handedness() == 1 ? -1 : 0;
    last = record.cell();
  }
  return balance;
}

/// The intervals that values between lowest and highest of a brick meet.
void find_intervals(const IsoRules& rules, const ActiveBrick& brick, double lowest, double highest,
                    std::vector<BrickInterval>& intervals) {
  intervals.clear();
  const auto end_of = [&](double end, std::uint32_t isovalue) {
    if (lowest >= end) return BrickInterval::kEndBelow;
    return highest >= end ? static_cast<int>(isovalue - brick.first_isovalue) : BrickInterval::kEndAbove;
  };
  rules.visit_active(lowest, highest, [&](std::uint16_t interval, const IsoRule& rule) {
    intervals.push_back({interval, end_of(rule.lower, rule.lower_index), end_of(rule.above, rule.upper_index)});
  });
}

/// Whether the axes of a grid of boxes make a left-handed frame.
bool is_mirrored(const Grid& grid) {
  const auto dims = grid.dims();
  const Vec3d first = grid.point(0), last = grid.point(dims[0] * dims[1] * dims[2] - 1);
  return ((last.x < first.x) != (last.y < first.y)) != (last.z < first.z);
}

}  // namespace

ActiveBricks::ActiveBricks(const Grid& grid, const PointArray& array, const MinMaxBricks& index, const IsoRules& rules,
                           std::uint64_t max_bytes, const Task& task, const ActiveBricks* previous)
    : layout_(index.layout()), rules_(rules) {
  std::visit([&](auto values) { classify(grid, values, index, rules, max_bytes, task, previous); }, array.values);
}

template <class T>
void ActiveBricks::classify(const Grid& grid, std::span<const T> values, const MinMaxBricks& index, const IsoRules& rules,
                            std::uint64_t max_bytes, const Task& task, const ActiveBricks* previous) {
  const Thresholds<T> thresholds(rules);
  const std::optional<Thresholds<T>> had = previous ? std::optional<Thresholds<T>>(previous->rules_) : std::nullopt;
  const MinMaxBricks::Ranges<T>& ranges = index.ranges<T>();
  const auto isovalues = static_cast<std::uint32_t>(thresholds.of.size());

  // Which bricks, and which isovalues in each.
  const auto all = static_cast<std::size_t>(layout_.count());
  if (all > kNotActive)
    throw Error(ErrorCode::too_large, "extraction: the grid has " + std::to_string(all) + " bricks; expected fewer than 2^32");
  active_.resize(all);
  std::uint64_t words = 0;
  for (std::size_t b = 0; b < all; ++b) {
    if (b % 65536 == 0) task.check();
    active_[b] = kNotActive;
    const T lowest = ranges.lowest[b], highest = ranges.highest[b];
    if (!thresholds.lowest.reached_by(highest) || thresholds.highest.reached_by(lowest)) continue;
    std::uint32_t first = 0;
    while (first < isovalues && thresholds.of[first].reached_by(lowest)) ++first;
    std::uint32_t last = first;
    while (last < isovalues && thresholds.of[last].reached_by(highest)) ++last;
    bool meets = last > first;
    if (!meets)  // wholly inside an interval, or in a gap between two
      rules.visit_active(static_cast<double>(lowest), static_cast<double>(highest),
                         [&](std::uint16_t, const IsoRule&) { meets = true; });
    if (!meets) continue;
    active_[b] = static_cast<std::uint32_t>(bricks_.size());
    ActiveBrick brick;
    brick.number = static_cast<std::uint32_t>(b);
    brick.first_isovalue = first;
    brick.isovalues = last - first;
    brick.first_word = words;
    words += 8 * (1 + 3 * std::uint64_t{brick.isovalues});
    bricks_.push_back(brick);
  }
  constexpr std::uint64_t kWordBytes = sizeof(std::uint64_t) + sizeof(std::uint32_t);
  const std::uint64_t bits_bytes = bricks_.size() * (sizeof(ActiveBrick) + 1) + words * kWordBytes;
  check_budget("the points of " + std::to_string(bricks_.size()) + " bricks", bits_bytes, max_bytes);
  words_.resize(words);
  bases_.resize(words);
  near_absent_.resize(bricks_.size());
  const bool curvilinear = !grid.rectilinear();

  const auto count = static_cast<std::int64_t>(bricks_.size());
  const std::int64_t blocks = (count + kBricksPerBlock - 1) / kBricksPerBlock;
  std::vector<std::vector<CellRecord>> found(blocks);
  std::atomic<std::int64_t> balance{0};
  std::atomic<std::uint64_t> listed{0};

  // The brick of the previous request that has the same intervals, with ends at the same places.
  const auto find_same = [&](const ActiveBrick& brick, double lowest, double highest,
                             const std::vector<BrickInterval>& intervals) -> const ActiveBrick* {
    if (!previous) return nullptr;
    const std::uint32_t at = previous->find(brick.number);
    if (at == kNotActive) return nullptr;
    const ActiveBrick& other = previous->bricks_[at];
    if (other.isovalues != brick.isovalues) return nullptr;
    for (std::uint32_t v = 0; v < brick.isovalues; ++v) {
      const std::uint32_t now = brick.first_isovalue + v, then = other.first_isovalue + v;
      if (rules.isovalues()[now] != previous->rules_.isovalues()[then] || !(thresholds.of[now] == had->of[then])) return nullptr;
    }
    thread_local std::vector<BrickInterval> then;
    find_intervals(previous->rules_, other, lowest, highest, then);
    return then == intervals ? &other : nullptr;
  };
  std::atomic<std::size_t> taken_over{0};
  const auto take_over = [&](const ActiveBrick& from, ActiveBrick& brick, std::vector<CellRecord>& records) {
    const auto at = static_cast<std::size_t>(&from - previous->bricks_.data());
    const std::size_t count = 8 * (1 + 3 * std::size_t{brick.isovalues});
    std::copy_n(previous->words(from), count, words_.data() + brick.first_word);
    std::copy_n(previous->bases(from), count, bases_.data() + brick.first_word);
    brick.first_record = records.size();
    brick.points = from.points;
    brick.cells = from.cells;
    brick.tetrahedra = from.tetrahedra;
    const std::span<const CellRecord> same = previous->records(at);
    records.insert(records.end(), same.begin(), same.end());
    near_absent_[static_cast<std::size_t>(&brick - bricks_.data())] = previous->near_absent_[at];
    if (curvilinear) balance.fetch_add(sum_of_hands(same), std::memory_order_relaxed);
    taken_over.fetch_add(1, std::memory_order_relaxed);
  };
  StageProgress progress(task, "searching", 0.1, 0.4, blocks);
  parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
    BrickReader<T> reader(layout_, values);
    std::vector<RowBits> bits;
    std::vector<BrickInterval> intervals;
    std::vector<CellRecord> records;  // keeps its room from block to block
    PresentCells present;
    for (std::int64_t block = begin; block < end; ++block) {
      records.clear();
      for (std::int64_t b = block * kBricksPerBlock; b < std::min(count, (block + 1) * kBricksPerBlock); ++b) {
        ActiveBrick& brick = bricks_[b];
        const BrickLayout::Place place = layout_.place(brick.number);
        const auto lowest = static_cast<double>(ranges.lowest[brick.number]);
        const auto highest = static_cast<double>(ranges.highest[brick.number]);
        find_intervals(rules, brick, lowest, highest, intervals);
        if (const ActiveBrick* const same = find_same(brick, lowest, highest, intervals)) {
          take_over(*same, brick, records);
          continue;
        }
        reader.turn_to(place);
        bits.resize(brick.isovalues);
        for (std::uint32_t v = 0; v < brick.isovalues; ++v) reader.test(thresholds.of[brick.first_isovalue + v], bits[v]);

        bool absent = !grid.hidden_cells.empty() || !positions_are_finite(grid, layout_, place);
        if (!absent) {  // a value that is not finite in the brick, or before it
          const auto at = layout_.indices(brick.number);
          for (int o = 0; o < 8 && !absent; ++o) {
            const std::array<std::int64_t, 3> other{at[0] - (o & 1), at[1] - (o >> 1 & 1), at[2] - (o >> 2)};
            if (other[0] < 0 || other[1] < 0 || other[2] < 0) continue;
            absent = index.not_finite(other[0] + layout_.bricks[0] * (other[1] + layout_.bricks[1] * other[2]));
          }
        }
        if (absent) absent = !find_present_cells(grid, values, layout_, place, present);
        near_absent_[b] = absent;

        BrickCase out;
        const std::size_t slots = 1 + 3 * std::size_t{brick.isovalues};
        out.words = std::span(words_).subspan(brick.first_word, 8 * slots);
        out.bases = std::span(bases_).subspan(brick.first_word, 8 * slots);
        brick.first_record = records.size();  // of the block, for now
        classify_brick(place, bits, intervals, absent ? &present : nullptr, out, records);
        brick.points = out.points;
        brick.cells = out.cells;
        brick.tetrahedra = out.tetrahedra;
        if (curvilinear)
          balance.fetch_add(find_handedness(grid, layout_, place, std::span(records).subspan(brick.first_record)),
                            std::memory_order_relaxed);
        if (b % 4 == 0) task.check();
      }
      const std::uint64_t so_far = listed.fetch_add(records.size(), std::memory_order_relaxed) + records.size();
      // The list is held twice while it is joined.
      check_budget("the list of active cells", bits_bytes + 2 * so_far * sizeof(CellRecord), max_bytes);
      found[block] = records;
      progress.done(1);
    }
  });

  std::vector<std::uint64_t> before(blocks + 1);
  for (std::int64_t block = 0; block < blocks; ++block) before[block + 1] = before[block] + found[block].size();
  records_.resize(before[blocks]);
  parallel_for(blocks, 16, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t block = begin; block < end; ++block) {
      if (!found[block].empty())
        std::memcpy(static_cast<void*>(records_.data() + before[block]), found[block].data(),
                    found[block].size() * sizeof(CellRecord));
      for (std::int64_t b = block * kBricksPerBlock; b < std::min(count, (block + 1) * kBricksPerBlock); ++b)
        bricks_[b].first_record += before[block];
      found[block] = {};
    }
  });
  taken_over_ = taken_over.load();
  for (const ActiveBrick& brick : bricks_) {
    points_ += brick.points;
    cells_ += brick.cells;
    tetrahedra_ += brick.tetrahedra;
  }
  if (curvilinear) {
    const bool mostly_left = balance.load() < 0;
    turned_ = {0, 1, mostly_left, mostly_left};
  } else if (is_mirrored(grid)) {
    turned_ = {1, 1, 1, 1};
  }
}

std::uint64_t ActiveBricks::bytes() const {
  return bricks_.size() * (sizeof(ActiveBrick) + 1) + active_.size() * sizeof(std::uint32_t) +
         words_.size() * (sizeof(std::uint64_t) + sizeof(std::uint32_t)) + records_.size() * sizeof(CellRecord);
}

}  // namespace isostrata
