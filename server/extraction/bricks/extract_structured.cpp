#include "extraction/bricks/extract_structured.h"

#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "base/parallel.h"
#include "extraction/bricks/active_bricks.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/bricks/hexahedron_gather.h"
#include "extraction/bricks/minmax_bricks.h"
#include "extraction/bricks/structured_facets.h"
#include "extraction/bricks/structured_measure.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/mesh_points.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/mesh/open_ends.h"

namespace isostrata {
namespace {

constexpr std::int64_t kBricksPerTask = 8;

/// Positions of the points of one brick and beside it.
class BrickPositions {
 public:
  BrickPositions(const Grid& grid, const BrickLayout& layout)
      : grid_(grid), layout_(layout), curvilinear_(std::get_if<CurvilinearGrid>(&grid.shape)) {}

  void turn_to(const BrickLayout::Place& place) {
    if (curvilinear_) return;
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < place.reach[axis]; ++i) {
        std::array<std::int64_t, 3> at{};
        at[axis] = place.first[axis] + i;
        axes_[axis][i] = grid_.point(layout_.point(at))[axis];
      }
  }
  /// Of the point i, j, k from the brick's first, which has the number `point`.
  Vec3d at(std::int64_t point, int i, int j, int k) const {
    if (!curvilinear_) return {axes_[0][i], axes_[1][j], axes_[2][k]};
    if (const auto* single = std::get_if<std::span<const Vec3f>>(&curvilinear_->points)) {
      const Vec3f& p = (*single)[point];
      return {p.x, p.y, p.z};
    }
    return std::get<std::span<const Vec3d>>(curvilinear_->points)[point];
  }

 private:
  const Grid& grid_;
  const BrickLayout& layout_;
  const CurvilinearGrid* curvilinear_;
  std::array<std::array<double, 9>, 3> axes_{};
};

/// Where each brick's parts of the mesh begin: [bricks + 1].
struct Starts {
  std::vector<std::uint32_t> points, tetrahedra, runs;
};

class Writer {
 public:
  Writer(const Grid& grid, const PointArray& array, const IsoRules& rules, const ActiveBricks& active,
         const ExtractOptions& options, const Task& task, IntervalMesh& mesh)
      : grid_(grid), array_(array), rules_(rules), active_(active), options_(options), task_(task), mesh_(mesh) {}

  void write() {
    count();
    mesh_.positions.resize(active_.points());
    mesh_.origins.resize(active_.points());
    if (options_.values) mesh_.values.resize(active_.points());
    mesh_.tetrahedra.resize(active_.tetrahedra());
    mesh_.tetrahedron_interval.resize(active_.tetrahedra());
    mesh_.cell_runs.resize(active_.cells());
    mesh_.active_cells = static_cast<std::int64_t>(active_.cells());
    const auto bricks = static_cast<std::int64_t>(active_.bricks().size());
    const bool more = options_.facets || options_.measure;
    StageProgress progress(task_, "extracting", 0.4, more ? 0.7 : 1.0, bricks);
    std::visit(
        [&](auto values) {
          parallel_for(bricks, kBricksPerTask, [&](std::int64_t begin, std::int64_t end) {
            Scratch scratch(grid_, active_.layout());
            for (std::int64_t b = begin; b < end; ++b) {
              write_points(static_cast<std::size_t>(b), values, scratch);
              write_cells(static_cast<std::size_t>(b), scratch);
              if (b % 4 == 3) task_.check();
            }
            progress.done(end - begin);
          });
        },
        array_.values);
  }

 private:
  struct Scratch {
    Scratch(const Grid& grid, const BrickLayout& layout) : positions(grid, layout) {}
    BrickPositions positions;
    std::vector<std::uint32_t> numbers;  // the tables of the brick's intervals
    std::array<const std::uint32_t*, kMaxRecordIntervals> numbers_of{};
  };
  static constexpr std::size_t kTable = HexahedronGather::kSlots * HexahedronGather::kSlot;

  void count() {
    const std::uint64_t bytes =
        active_.tetrahedra() * (sizeof(std::array<std::uint32_t, 4>) + sizeof(std::uint16_t)) +
        active_.points() * (sizeof(Vec3d) + sizeof(PointOrigin) + (options_.values ? sizeof(double) : 0)) +
        active_.cells() * sizeof(CellRun) + active_.bytes() + active_.bricks().size() * 3 * sizeof(std::uint32_t);
    const std::string what =
        std::to_string(active_.tetrahedra()) + " tetrahedra with " + std::to_string(active_.points()) + " points";
    check_budget(what, bytes, options_.max_bytes);
    if (std::max(active_.tetrahedra(), active_.points()) > std::numeric_limits<std::uint32_t>::max())
      throw Error(ErrorCode::too_large, "extraction: " + what + "; expected fewer than 2^32 of each: narrow the intervals");
    for (auto* starts : {&starts_.points, &starts_.tetrahedra, &starts_.runs}) starts->assign(1, 0);
    for (const ActiveBrick& brick : active_.bricks()) {
      starts_.points.push_back(starts_.points.back() + brick.points);
      starts_.tetrahedra.push_back(starts_.tetrahedra.back() + brick.tetrahedra);
      starts_.runs.push_back(starts_.runs.back() + brick.cells);
    }
  }

  /// The mesh points that the brick owns.
  template <class T>
  void write_points(std::size_t b, std::span<const T> values, Scratch& scratch) {
    const ActiveBrick& brick = active_.bricks()[b];
    if (brick.points == 0) return;
    const BrickLayout& layout = active_.layout();
    const BrickLayout::Place place = layout.place(brick.number);
    scratch.positions.turn_to(place);
    const std::array<std::int64_t, 3> stride = layout.stride();
    const std::int64_t first = layout.point(place.first);
    const int slots = 1 + 3 * static_cast<int>(brick.isovalues);
    const std::uint64_t* words = active_.words(brick);
    std::uint32_t to = starts_.points[b];
    for (int k = 0; k < place.own[2]; ++k)
      for (int s = 0; s < slots; ++s, ++words) {
        const int axis = s == 0 ? -1 : (s - 1) % 3;
        const double isovalue = s == 0 ? 0 : rules_.isovalues()[brick.first_isovalue + static_cast<std::uint32_t>(s - 1) / 3];
        for (std::uint64_t rest = *words; rest; rest &= rest - 1, ++to) {
          const int at = std::countr_zero(rest), i = at & 7, j = at >> 3;
          const std::int64_t a = first + i + j * stride[1] + k * stride[2];
          const Vec3d at_a = scratch.positions.at(a, i, j, k);
          const auto fa = static_cast<double>(values[a]);
          if (axis < 0) {
            set_kept_point(mesh_, to, a, at_a, fa);
            continue;
          }
          const std::int64_t b_point = a + stride[axis];
          const Vec3d at_b = scratch.positions.at(b_point, i + (axis == 0), j + (axis == 1), k + (axis == 2));
          set_crossing(mesh_, to, a, at_a, fa, b_point, at_b, static_cast<double>(values[b_point]), isovalue);
        }
      }
  }

  /// The brick's cells.
  void write_cells(std::size_t b, Scratch& scratch) {
    const std::span<const CellRecord> records = active_.records(b);
    if (records.empty()) return;
    const ActiveBrick& brick = active_.bricks()[b];
    make_tables(b, records, scratch);
    const std::uint32_t first = starts_.tetrahedra[b];
    write_records(records, scratch.numbers_of.data(), active_.turned(), mesh_.tetrahedra.data() + first);

    const HexahedronGather& gather = hexahedron_gather();
    const BrickLayout& layout = active_.layout();
    const std::int64_t first_cell = layout.cell(layout.place(brick.number).first);
    const std::int64_t row = layout.dims[0] - 1, plane = row * (layout.dims[1] - 1);
    CellRun* run = mesh_.cell_runs.data() + starts_.runs[b];
    std::uint16_t* interval = mesh_.tetrahedron_interval.data() + first;
    const bool one_interval = rules_.rules().size() == 1;
    if (one_interval) std::fill_n(interval, brick.tetrahedra, std::uint16_t{0});
    std::uint32_t to = first;
    int last = -1;
    for (const CellRecord& record : records) {
      const int at = record.cell();
      if (at != last) *run++ = {first_cell + (at & 7) + (at >> 3 & 7) * row + (at >> 6) * plane, to};
      last = at;
      const std::uint32_t count = gather.count[record.case_index()];
      if (!one_interval) interval = std::fill_n(interval, count, static_cast<std::uint16_t>(record.interval()));
      to += count;
    }
  }

  /// The numbers of the mesh points that the records use.
  void make_tables(std::size_t b, std::span<const CellRecord> records, Scratch& scratch) {
    std::array<std::uint64_t, kMaxRecordIntervals / 64> used{};
    if (rules_.rules().size() == 1)
      used[0] = 1;
    else
      for (const CellRecord& record : records) used[record.interval() / 64] |= std::uint64_t{1} << record.interval() % 64;
    std::size_t tables = 0;
    for (const std::uint64_t word : used) tables += static_cast<std::size_t>(std::popcount(word));
    if (scratch.numbers.size() < tables * kTable) scratch.numbers.resize(tables * kTable);

    const ActiveBrick& brick = active_.bricks()[b];
    const BrickLayout& layout = active_.layout();
    const auto at = layout.indices(brick.number);
    std::array<BrickPoints, 8> owners;
    std::array<std::uint32_t, 8> first_isovalues{};
    for (int o = 0; o < 8; ++o) {
      const std::array<std::int64_t, 3> other{at[0] + (o & 1), at[1] + (o >> 1 & 1), at[2] + (o >> 2)};
      if (other[0] >= layout.bricks[0] || other[1] >= layout.bricks[1] || other[2] >= layout.bricks[2]) continue;
      const std::uint32_t owner = active_.find(other[0] + layout.bricks[0] * (other[1] + layout.bricks[1] * other[2]));
      if (owner == ActiveBricks::kNotActive) continue;
      const ActiveBrick& owning = active_.bricks()[owner];
      owners[o].words = active_.words(owning);
      owners[o].bases = active_.bases(owning);
      owners[o].first_point = starts_.points[owner];
      owners[o].isovalues = static_cast<int>(owning.isovalues);
      first_isovalues[o] = owning.first_isovalue;
    }
    std::uint32_t* numbers = scratch.numbers.data();
    for (std::size_t w = 0; w < used.size(); ++w)
      for (std::uint64_t rest = used[w]; rest; rest &= rest - 1) {
        const std::size_t interval = 64 * w + static_cast<std::size_t>(std::countr_zero(rest));
        const IsoRule& rule = rules_.rules()[interval];
        for (int o = 0; o < 8; ++o) {
          owners[o].lower = static_cast<int>(rule.lower_index) - static_cast<int>(first_isovalues[o]);
          owners[o].upper = static_cast<int>(rule.upper_index) - static_cast<int>(first_isovalues[o]);
        }
        fill_numbers(owners, numbers);
        scratch.numbers_of[interval] = numbers;
        numbers += kTable;
      }
  }

  const Grid& grid_;
  const PointArray& array_;
  const IsoRules& rules_;
  const ActiveBricks& active_;
  const ExtractOptions& options_;
  const Task& task_;
  IntervalMesh& mesh_;
  Starts starts_;
};

std::shared_ptr<const ActiveBricks> find_bricks(const Grid& grid, const PointArray& array, const IsoRules& rules,
                                                const ExtractOptions& options, const Task& task) {
  if (!options.bricks) {
    const MinMaxBricks ranges(grid, array, task);
    return std::make_shared<const ActiveBricks>(grid, array, ranges, rules, options.max_bytes, task);
  }
  const std::shared_ptr<const MinMaxBricks> ranges = options.bricks->ranges(grid, array, task);
  const std::shared_ptr<const ActiveBricks> last = options.bricks->last(grid, array);
  auto found = std::make_shared<const ActiveBricks>(grid, array, *ranges, rules, options.max_bytes, task, last.get());
  options.bricks->keep(grid, array, found);
  return found;
}

}  // namespace

std::optional<IntervalMesh> extract_structured(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                                               const ExtractOptions& options, const Task& task) {
  if (!grid.structured()) return std::nullopt;
  const IsoRules rules(intervals, options.complement);
  if (rules.rules().size() > kMaxRecordIntervals) return std::nullopt;
  IntervalMesh mesh;
  mesh.cells = grid.cell_count();
  for (const IsoRule& rule : rules.rules()) {
    mesh.summaries.emplace_back();
    mesh.summaries.back().interval = with_open_ends(rule.lower, rule.upper);
  }
  if (mesh.cells > 0) {
    task.report(0.0, "searching");
    const std::shared_ptr<const ActiveBricks> found = find_bricks(grid, array, rules, options, task);
    const ActiveBricks& active = *found;
    count_records(active, mesh.summaries);
    Writer(grid, array, rules, active, options, task, mesh).write();
    if (options.measure) measure_records(grid, active, mesh, task);
    if (options.facets) mesh.facets = structured_facets(grid, array, active, mesh, options.max_bytes, task);
  }
  task.report(1.0, "extracted");
  return mesh;
}

}  // namespace isostrata
