#include "extraction/extract_unstructured.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>

#include "base/buffer.h"
#include "base/parallel.h"
#include "extraction/active_cells.h"
#include "extraction/boundary_facets.h"
#include "extraction/cell_geometry.h"
#include "extraction/cell_triangulation.h"
#include "extraction/iso_rules.h"
#include "extraction/list_pool.h"
#include "extraction/memory_budget.h"
#include "extraction/mesh_points.h"
#include "extraction/point_table.h"
#include "extraction/sorted_tetrahedron.h"

namespace isostrata {
namespace {

/// Cells are taken in blocks of the grid's own order; what is summed is summed block by block, so that it does not depend on
/// threads.
constexpr std::int64_t kCellsPerBlock = 4096;
constexpr std::uint32_t kMaxUses = 1u << 30;  // of points by cells, all together

constexpr std::array<int, kMaxCellVertices> kPowersOf3{1, 3, 9, 27, 81, 243, 729, 2187};
constexpr std::array<std::uint8_t, 4> kFaceOpposite{1, 2, 0, 3};  // of a tetrahedron's vertex, as topology() numbers faces

using LocalTetrahedron = std::array<std::uint8_t, 4>;  // into the uses of its case

/// One interval in one active cell.
struct CaseRecord {
  std::array<std::uint32_t, 4> ids{};  // of a tetrahedron's points, increasing
  std::uint32_t cell = 0;
  std::uint16_t interval = 0;
  std::uint16_t case_index = 0;   // of the row for the sorted tetrahedron, else of the cell's complex
  std::uint16_t shape_count = 0;  // tetrahedra of a cell that has no row
  std::uint8_t places = 0;        // bits 2 i, 2 i + 1: the vertex that is the i-th by id
  bool has_row = false;           // a tetrahedron with four different points
  bool odd = false;               // places is an odd permutation
  std::int8_t sign = 0;           // of the cell's volume
};

/// What one interval gets from one block.
struct Sums {
  std::int64_t active_cells = 0, tetrahedra = 0, inverted = 0;
  double volume = 0, signed_volume = 0;
};

struct Block {
  std::span<CaseRecord> records;
  std::span<LocalTetrahedron> shapes;  // of the records without a row, in their order
  std::map<std::uint16_t, Sums> sums;
};

/// Positions and connectivity without a look at the grid's kind each time.
class Mesh {
 public:
  explicit Mesh(const UnstructuredGrid& shape) : shape_(shape) {
    if (const auto* single = std::get_if<std::span<const Vec3f>>(&shape.points))
      single_ = single->data();
    else
      double_ = std::get<std::span<const Vec3d>>(shape.points).data();
  }
  Vec3d point(std::int64_t id) const {
    if (!single_) return double_[id];
    const Vec3f& p = single_[id];
    return {p.x, p.y, p.z};
  }
  void prefetch(std::int64_t id) const {
    if (single_)
      __builtin_prefetch(single_ + id);
    else
      __builtin_prefetch(double_ + id);
  }
  const UnstructuredGrid& shape() const { return shape_; }
  const std::int64_t* ids(std::int64_t cell) const { return shape_.connectivity.data() + shape_.offsets[cell]; }
  int vertex_count(std::int64_t cell) const { return static_cast<int>(shape_.offsets[cell + 1] - shape_.offsets[cell]); }
  bool is_tetrahedron(std::int64_t cell) const { return shape_.types[cell] == static_cast<std::uint8_t>(CellType::tetrahedron); }

 private:
  const UnstructuredGrid& shape_;
  const Vec3f* single_ = nullptr;
  const Vec3d* double_ = nullptr;
};

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

/// Two vertices are one point: the tetrahedron has no extent, and both facets that they separate are the same triangle.
template <class T>
bool repeats_a_point(const std::array<T, 4>& t) {
  return t[0] == t[1] || t[0] == t[2] || t[0] == t[3] || t[1] == t[2] || t[1] == t[3] || t[2] == t[3];
}

/// Packs a < 2^32, b < 2^32 and an isovalue's index into 64 bits, which are never all set.
struct KeyFormat {
  int b_shift = 0, a_shift = 0, bits = 0;

  KeyFormat(std::int64_t points, std::size_t isovalues) {
    b_shift = std::max(1, static_cast<int>(std::bit_width(isovalues)));
    const int point_bits = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(std::max<std::int64_t>(points, 1))));
    a_shift = b_shift + point_bits;
    bits = a_shift + point_bits;
  }
  std::uint64_t pack(std::uint64_t a, std::uint64_t b, std::uint64_t isovalue) const {
    return a << a_shift | b << b_shift | isovalue;
  }
  std::int64_t a(std::uint64_t key) const { return static_cast<std::int64_t>(key >> a_shift); }
  std::int64_t b(std::uint64_t key) const {
    return static_cast<std::int64_t>(key >> b_shift & ((std::uint64_t{1} << (a_shift - b_shift)) - 1));
  }
  std::uint64_t isovalue(std::uint64_t key) const { return key & ((std::uint64_t{1} << b_shift) - 1); }
};

class UnstructuredExtraction {
 public:
  UnstructuredExtraction(const Grid& grid, const PointArray& array, const IsoRules& rules, const ExtractOptions& options,
                         const Task& task)
      : grid_(grid),
        array_(array),
        rules_(rules),
        options_(options),
        task_(task),
        cells_(std::get<UnstructuredGrid>(grid.shape)),
        format_(grid.point_count(), rules.isovalues().size()),
        blocks_((grid.cell_count() + kCellsPerBlock - 1) / kCellsPerBlock) {}

  IntervalMesh run() {
    for (const IsoRule& rule : rules_.rules()) {
      mesh_.summaries.emplace_back();
      mesh_.summaries.back().interval = {rule.lower, rule.upper};
    }
    mesh_.cells = grid_.cell_count();
    find_cases();
    ask_for_points();
    task_.report(0.5, "numbering");
    keys_ = table_->number_keys(uses_before_.back(), task_);
    check_size();
    locate_points();
    write_tetrahedra();
    summarise();
    if (options_.facets) mesh_.facets = boundary_facets(grid_, array_, mesh_, labels_, options_.max_bytes, task_);
    task_.report(1.0, "extracted");
    return std::move(mesh_);
  }

 private:
  std::int64_t block_count() const { return static_cast<std::int64_t>(blocks_.size()); }

  struct Nothing {};

  /// Calls visit(block, own) on the pool, checking for cancel; `own` is the thread's for as long as it goes through blocks.
  template <class Own, class Visit>
  void for_each_block(const char* stage, double begin, double end, const Visit& visit) {
    StageProgress progress(task_, stage, begin, end, block_count());
    parallel_for(block_count(), 1, [&](std::int64_t first, std::int64_t last) {
      Own own;
      for (std::int64_t b = first; b < last; ++b) {
        visit(b, own);
        progress.done(1);
      }
    });
  }

  /// Turns [b + 1] counts into [blocks + 1] starts.
  static void accumulate(std::vector<std::uint64_t>& counts) {
    for (std::size_t b = 1; b < counts.size(); ++b) counts[b] += counts[b - 1];
  }

  // ---- which cells ------------------------------------------------------------------------------------------------

  void find_cases() {
    uses_before_.assign(blocks_.size() + 1, 0);
    runs_before_.assign(blocks_.size() + 1, 0);
    std::atomic<std::int64_t> balance{0};
    std::atomic<std::uint64_t> listed{0};
    std::visit(
        [&](auto values) {
          compare_points(values);
          for_each_block<std::vector<CaseRecord>>("searching", 0.0, 0.3, [&](std::int64_t b, std::vector<CaseRecord>& found) {
            find_in_block(b, values, found, listed);
            balance.fetch_add(count_block(b), std::memory_order_relaxed);
          });
        },
        array_.values);
    sides_ = {};
    usual_sign_ = balance.load() < 0 ? -1 : 1;
    accumulate(uses_before_);
    accumulate(runs_before_);
    record_bytes_ = listed.load() * sizeof(CaseRecord);
    if (uses_before_.back() > kMaxUses)
      throw Error(ErrorCode::too_large, "extraction: the active cells use points " + std::to_string(uses_before_.back()) +
                                            " times; expected at most 2^30: narrow the intervals");
  }

  template <class T>
  void find_in_block(std::int64_t b, std::span<const T> values, std::vector<CaseRecord>& records,
                     std::atomic<std::uint64_t>& listed) {
    const std::int64_t begin = b * kCellsPerBlock, end = std::min(mesh_.cells, begin + kCellsPerBlock);
    records.clear();
    const auto& types = cells_.shape().types;
    for (std::int64_t cell = begin; cell < end;) {
      const std::int64_t run_end = end_of_run(cell, end);
      switch (static_cast<CellType>(types[cell])) {
        case CellType::tetrahedron:
          find_in_run<CellType::tetrahedron, 4>(cell, run_end, values, records, listed);
          break;
        case CellType::pyramid:
          find_in_run<CellType::pyramid, 5>(cell, run_end, values, records, listed);
          break;
        case CellType::wedge:
          find_in_run<CellType::wedge, 6>(cell, run_end, values, records, listed);
          break;
        case CellType::hexahedron:
          find_in_run<CellType::hexahedron, 8>(cell, run_end, values, records, listed);
          break;
      }
      cell = run_end;
    }
    listed.fetch_add(records.size(), std::memory_order_relaxed);
    blocks_[b].records = records_.keep(records);
  }

  /// In cells of one type.
  template <CellType kType, int kVertices, class T>
  void find_in_run(std::int64_t begin, std::int64_t end, std::span<const T> values, std::vector<CaseRecord>& records,
                   const std::atomic<std::uint64_t>& listed) {
    std::array<std::uint16_t, kCellsPerBlock> candidates;  // from begin
    std::size_t count = 0;
    const std::int64_t* const first = cells_.ids(begin);
    const std::int64_t* ids = first;
    for (std::int64_t cell = begin; cell < end; ++cell, ids += kVertices) {
      candidates[count] = static_cast<std::uint16_t>(cell - begin);
      count += may_be_active<kVertices>(ids);
    }
    if (records.capacity() < records.size() + count) records.reserve(std::max(records.size() + count, 2 * records.size()));
    constexpr std::size_t kAhead = 8;  // candidates whose points are brought near
    for (std::size_t i = 0; i < count; ++i) {
      if (i + kAhead < count) {
        const std::int64_t* const later = first + candidates[i + kAhead] * kVertices;
        for (int v = 0; v < kVertices; ++v) cells_.prefetch(later[v]);
      }
      add_cases<kType, kVertices>(begin + candidates[i], first + candidates[i] * kVertices, values, records);
      if (i % 64 == 63 || i + 1 == count)
        check_budget("the list of active cells", (listed.load(std::memory_order_relaxed) + records.size()) * sizeof(CaseRecord),
                     options_.max_bytes);
    }
  }

  /// The first cell after `cell` of another type, at most `end`.
  std::int64_t end_of_run(std::int64_t cell, std::int64_t end) const {
    const std::uint8_t* const types = cells_.shape().types.data();
    if (std::memcmp(types + cell, types + cell + 1, static_cast<std::size_t>(end - cell - 1)) == 0) return end;
    std::int64_t last = cell + 1;
    while (types[last] == types[cell]) ++last;
    return last;
  }

  /// Notes for each point whether it reaches the intervals and whether it lies before their end. One byte a point instead of a
  /// value makes the search through the cells twice as fast: what it gathers from fits the core's cache.
  template <class T>
  void compare_points(std::span<const T> values) {
    check_budget("the sides of the points", values.size(), options_.max_bytes);
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

  /// Whether the cell's values reach into the span of all intervals. With a NaN it may be said to; add_cases looks again.
  template <int kVertices>
  bool may_be_active(const std::int64_t* ids) const {
    unsigned sides = 0;
    for (int v = 0; v < kVertices; ++v) sides |= sides_[ids[v]];
    return sides == (kReaches | kBegins);
  }

  /// Adds the cell's cases where it is active and not absent (active_cells.h).
  template <CellType kType, int kVertices, class T>
  void add_cases(std::int64_t cell, const std::int64_t* ids, std::span<const T> values, std::vector<CaseRecord>& records) const {
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
          finite = finite && std::isfinite(p[v].x) && std::isfinite(p[v].y) && std::isfinite(p[v].z);
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
        for (int i = 0; i < 4; ++i) case_index += rule.class_of(f[sorted.vertex[i]]) * kPowersOf3[i];
      else
        for (int v = 0; v < kVertices; ++v) case_index += rule.class_of(f[v]) * kPowersOf3[v];
      record.interval = interval;
      record.case_index = static_cast<std::uint16_t>(case_index);
      records.push_back(record);
    });
  }

  /// Of the cell's volume, as handedness_of() has it; without its square root where there is no doubt.
  static int sign_of(double volume, std::span<const Vec3d> points) {
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

  /// Counts the block's uses and cells; returns how many more cells are right-handed than left-handed.
  std::int64_t count_block(std::int64_t b) {
    std::uint64_t uses = 0, runs = 0;
    std::int64_t balance = 0;
    const CaseRecord* before = nullptr;
    for (const CaseRecord& record : blocks_[b].records) {
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

  std::uint32_t use_count(const CaseRecord& record) const {
    if (record.has_row) return rows_[record.case_index].use_count;
    return static_cast<std::uint32_t>(
        std::popcount(interval_complex(grid_.cell_type(record.cell)).isovertices[record.case_index]));
  }

  // ---- which points -----------------------------------------------------------------------------------------------

  /// Fills slots_ and the shapes of cells without a row, and counts tetrahedra.
  void ask_for_points() {
    const std::uint64_t uses = uses_before_.back();
    // Most points are used by several cells; where they are not, the table turns out too small and a larger one is made.
    std::uint64_t size = std::bit_ceil(std::max<std::uint64_t>(1024, uses / 2 + 1));
    const std::uint64_t enough = std::bit_ceil(std::max<std::uint64_t>(1024, 2 * uses));
    for (;; size = std::min(enough, size * 4)) {
      check_budget("the points of the active cells", record_bytes_ + uses * sizeof(std::uint32_t) + PointTable::bytes(size),
                   options_.max_bytes);
      table_.emplace(static_cast<std::uint32_t>(size), size < enough, task_);
      slots_.resize(uses);
      tetrahedra_before_.assign(blocks_.size() + 1, 0);
      std::atomic<bool> full{false};
      shapes_.clear();
      for_each_block<std::vector<LocalTetrahedron>>("points", 0.3, 0.5, [&](std::int64_t b, std::vector<LocalTetrahedron>& kept) {
        if (!full.load(std::memory_order_relaxed) && !ask_in_block(b, kept)) full.store(true, std::memory_order_relaxed);
      });
      if (!full.load()) break;
    }
    accumulate(tetrahedra_before_);
  }

  /// False where the table is full.
  bool ask_in_block(std::int64_t b, std::vector<LocalTetrahedron>& kept_shapes) {
    kept_shapes.clear();
    CellTriangulation triangulation(grid_);
    auto use = static_cast<std::uint32_t>(uses_before_[b]);
    PointRequests requests(*table_, slots_.data(), use);
    const auto ask = [&](const PointKey& key) {
      const auto a = static_cast<std::uint64_t>(key.a);
      requests.add(format_.pack(a, static_cast<std::uint64_t>(key.b), key.isovalue), a >> 5);
    };
    std::int64_t turned_to = -1;
    std::uint64_t tetrahedra = 0;
    for (CaseRecord& record : blocks_[b].records) {
      const IsoRule& rule = rules_.rules()[record.interval];
      if (record.has_row) {
        const SortedTetrahedronRow& row = rows_[record.case_index];
        const std::array<std::uint32_t, 3> isovalue{0, rule.lower_index, rule.upper_index};
        for (int i = 0; i < row.use_count; ++i) {
          const auto& [a, b, end] = row.uses[i];
          ask({record.ids[a], record.ids[b], isovalue[end]});
        }
        use += row.use_count;
        tetrahedra += row.count;
        continue;
      }
      if (turned_to != record.cell) triangulation.begin_cell(turned_to = record.cell);
      std::array<std::uint8_t, kMaxIsoVertices> place;
      std::uint8_t uses = 0;
      for (std::uint32_t rest = triangulation.isovertices(record.case_index); rest; rest &= rest - 1) {
        const int v = std::countr_zero(rest);
        place[v] = uses++;
        ask(point_key(triangulation.cell(), triangulation.ids(), rule, v));
      }
      const bool collapsed = triangulation.collapsed();
      if (collapsed) requests.flush();
      if (requests.full()) return false;
      const std::size_t shapes = kept_shapes.size();
      const std::uint32_t* const slots = slots_.data() + use;
      for (const auto& t : triangulation.tetrahedra(record.case_index)) {
        const LocalTetrahedron local{place[t[0]], place[t[1]], place[t[2]], place[t[3]]};
        if (collapsed &&
            repeats_a_point(std::array<std::uint32_t, 4>{slots[local[0]], slots[local[1]], slots[local[2]], slots[local[3]]}))
          continue;
        kept_shapes.push_back(local);
      }
      use += uses;
      record.shape_count = static_cast<std::uint16_t>(kept_shapes.size() - shapes);
      tetrahedra += record.shape_count;
    }
    requests.flush();
    blocks_[b].shapes = shapes_.keep(kept_shapes);
    tetrahedra_before_[b + 1] = tetrahedra;
    return !requests.full();
  }

  void check_size() const {
    const std::uint64_t tetrahedra = tetrahedra_before_.back(), points = keys_.size();
    const std::uint64_t bytes =
        tetrahedra *
            (sizeof(std::array<std::uint32_t, 4>) + sizeof(std::uint16_t) + (options_.facets ? sizeof(FacetLabels) : 0)) +
        points * (sizeof(Vec3d) + sizeof(PointOrigin) + (options_.values ? sizeof(double) : 0) + sizeof(std::uint64_t)) +
        record_bytes_ + uses_before_.back() * 3 * sizeof(std::uint32_t) + runs_before_.back() * sizeof(CellRun);
    check_budget(std::to_string(tetrahedra) + " tetrahedra with " + std::to_string(points) + " points", bytes,
                 options_.max_bytes);
    if (tetrahedra > std::numeric_limits<std::uint32_t>::max())
      throw Error(ErrorCode::too_large,
                  "extraction: " + std::to_string(tetrahedra) + " tetrahedra; expected fewer than 2^32: narrow the intervals");
  }

  void locate_points() {
    mesh_.positions.resize(keys_.size());
    mesh_.origins.resize(keys_.size());
    if (options_.values) mesh_.values.resize(keys_.size());
    std::visit(
        [&](auto values) {
          parallel_for(static_cast<std::int64_t>(keys_.size()), 1 << 13, [&](std::int64_t begin, std::int64_t end) {
            task_.check();
            for (std::int64_t i = begin; i < end; ++i) {
              const std::int64_t a = format_.a(keys_[i]), b = format_.b(keys_[i]);
              const auto fa = static_cast<double>(values[a]);
              if (a == b)
                set_kept_point(mesh_, static_cast<std::uint32_t>(i), a, cells_.point(a), fa);
              else
                set_crossing(mesh_, static_cast<std::uint32_t>(i), a, cells_.point(a), fa, b, cells_.point(b),
                             static_cast<double>(values[b]), rules_.isovalues()[format_.isovalue(keys_[i])]);
            }
          });
        },
        array_.values);
    keys_ = {};
  }

  // ---- which tetrahedra ---------------------------------------------------------------------------------------------

  void write_tetrahedra() {
    mesh_.tetrahedra.resize(tetrahedra_before_.back());
    mesh_.tetrahedron_interval.resize(tetrahedra_before_.back());
    mesh_.cell_runs.resize(runs_before_.back());
    mesh_.active_cells = static_cast<std::int64_t>(runs_before_.back());
    if (options_.facets) labels_.resize(tetrahedra_before_.back());
    for_each_block<Nothing>("extracting", 0.6, options_.facets ? 0.8 : 1.0, [&](std::int64_t b, Nothing&) { write_block(b); });
  }

  void write_block(std::int64_t b) {
    Block& block = blocks_[b];
    std::uint64_t to = tetrahedra_before_[b], run = runs_before_[b];
    // All at once: reads that do not wait for one another.
    for (std::uint64_t use = uses_before_[b]; use < uses_before_[b + 1]; ++use) slots_[use] = table_->number(slots_[use]);
    const std::uint32_t* numbers = slots_.data() + uses_before_[b];
    const LocalTetrahedron* shape = block.shapes.data();
    const CaseRecord* before = nullptr;
    Sums* sums = nullptr;
    double tolerance = 0;
    for (const CaseRecord& record : block.records) {
      if (!before || before->cell != record.cell) {
        mesh_.cell_runs[run++] = {record.cell, static_cast<std::uint32_t>(to)};
        if (options_.measure) tolerance = tolerance_of(record.cell);
      }
      if (!before || before->interval != record.interval) sums = &block.sums[record.interval];
      before = &record;
      ++sums->active_cells;

      const std::uint64_t first = to;
      const bool left_handed = (record.sign != 0 ? record.sign : usual_sign_) < 0;
      const auto write = [&](const LocalTetrahedron* tetrahedra, int count, bool swapped) {
        for (int i = 0; i < count; ++i) {
          const LocalTetrahedron& t = tetrahedra[i];
          mesh_.tetrahedra[to] = {numbers[t[swapped]], numbers[t[!swapped]], numbers[t[2]], numbers[t[3]]};
          mesh_.tetrahedron_interval[to++] = record.interval;
        }
      };
      if (record.has_row) {  // positive where the cell's own orientation is
        const SortedTetrahedronRow& row = rows_[record.case_index];
        write(row.tetrahedra.data(), row.count, left_handed != record.odd);
        if (options_.facets) label_row(record, row, left_handed != record.odd, first);
      } else {
        write(shape, record.shape_count, left_handed);
        if (options_.facets) label_shapes(record, shape, numbers, left_handed, first);
        shape += record.shape_count;
      }
      sums->tetrahedra += static_cast<std::int64_t>(to - first);
      numbers += use_count(record);
      if (options_.measure) measure(first, to, tolerance, *sums);
    }
  }

  void label_row(const CaseRecord& record, const SortedTetrahedronRow& row, bool swapped, std::uint64_t first) {
    std::array<std::uint8_t, kFirstCellFace + 4> name{kInsideCell, kLowerFacet, kUpperFacet};
    for (int i = 0; i < 4; ++i)
      name[kFirstCellFace + i] = static_cast<std::uint8_t>(kFirstCellFace + kFaceOpposite[record.places >> 2 * i & 3]);
    for (int i = 0; i < row.count; ++i) {
      const FacetLabels& labels = row.labels[i];
      labels_[first + i] = {name[labels[swapped]], name[labels[!swapped]], name[labels[2]], name[labels[3]]};
    }
  }

  void label_shapes(const CaseRecord& record, const LocalTetrahedron* shape, const std::uint32_t* numbers, bool swapped,
                    std::uint64_t first) {
    const IntervalComplex& complex = interval_complex(grid_.cell_type(record.cell));
    std::array<FaceMask, kMaxIsoVertices> masks;  // of the uses
    int uses = 0;
    for (std::uint32_t rest = complex.isovertices[record.case_index]; rest; rest &= rest - 1)
      masks[uses++] = complex.masks[std::countr_zero(rest)];
    // In a collapsed cell uses may be one point, and that point lies wherever any of them does.
    for (int v = 1; v < uses; ++v)
      for (int w = 0; w < v; ++w)
        if (numbers[v] == numbers[w]) masks[v] = masks[w] = masks[v] | masks[w];
    for (int i = 0; i < record.shape_count; ++i) {
      const LocalTetrahedron& t = shape[i];
      labels_[first + i] = label_facets(masks[t[swapped]], masks[t[!swapped]], masks[t[2]], masks[t[3]]);
    }
  }

  double tolerance_of(std::int64_t cell) const {
    const int n = cells_.vertex_count(cell);
    Box3d box;
    for (int v = 0; v < n; ++v) box.include(cells_.point(cells_.ids(cell)[v]));
    return handedness_of(0, box).tolerance;
  }

  void measure(std::uint64_t first, std::uint64_t last, double tolerance, Sums& sums) const {
    const auto& x = mesh_.positions;
    for (std::uint64_t i = first; i < last; ++i) {
      const auto& p = mesh_.tetrahedra[i];
      const double volume = orient3d(x[p[0]], x[p[1]], x[p[2]], x[p[3]]) / 6;
      sums.volume += std::abs(volume);
      sums.signed_volume += volume;
      sums.inverted += volume < -tolerance;  // flat ones come out as rounding of either sign
    }
  }

  void summarise() {
    for (const Block& block : blocks_)
      for (const auto& [interval, sums] : block.sums) {
        IntervalSummary& summary = mesh_.summaries[interval];
        summary.active_cells += sums.active_cells;
        summary.tetrahedra += sums.tetrahedra;
        summary.inverted += sums.inverted;
        summary.volume += sums.volume;
        summary.signed_volume += sums.signed_volume;
      }
    blocks_ = {};
    records_.clear();
    shapes_.clear();
    table_.reset();
    slots_ = {};
  }

  const Grid& grid_;
  const PointArray& array_;
  const IsoRules& rules_;
  const ExtractOptions& options_;
  const Task& task_;
  const Mesh cells_;
  const KeyFormat format_;
  const std::array<SortedTetrahedronRow, 81>& rows_ = sorted_tetrahedron_rows();
  IntervalMesh mesh_;
  ListPool<CaseRecord> records_;
  ListPool<LocalTetrahedron> shapes_;
  std::vector<Block> blocks_;
  std::vector<std::uint64_t> uses_before_, runs_before_, tetrahedra_before_;  // [blocks + 1]
  std::uint64_t record_bytes_ = 0;
  int usual_sign_ = 1;  // a cell without volume is taken to be turned as most others are
  static constexpr unsigned kReaches = 1, kBegins = 2;
  Buffer<std::uint8_t> sides_;  // [grid points] while cells are searched
  std::optional<PointTable> table_;
  Buffer<std::uint32_t> slots_;  // [uses] in table_, then numbers of points
  Buffer<std::uint64_t> keys_;   // [np] of the points
  Buffer<FacetLabels> labels_;   // [nt] where facets are wanted
};

}  // namespace

std::optional<IntervalMesh> extract_unstructured(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                                                 const ExtractOptions& options, const Task& task) {
  if (grid.structured()) return std::nullopt;
  const IsoRules rules(intervals, options.complement);
  if (grid.cell_count() > std::numeric_limits<std::uint32_t>::max() ||
      grid.point_count() > std::numeric_limits<std::uint32_t>::max() ||
      KeyFormat(grid.point_count(), rules.isovalues().size()).bits > 64)
    return std::nullopt;
  return UnstructuredExtraction(grid, array, rules, options, task).run();
}

}  // namespace isostrata
