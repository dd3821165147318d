#include "extraction/bricks/extract_structured.h"

#include <optional>
#include <string>

#include "base/parallel.h"
#include "extraction/bricks/active_bricks.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/bricks/brick_writer.h"
#include "extraction/bricks/hexahedron_gather.h"
#include "extraction/bricks/minmax_bricks.h"
#include "extraction/bricks/structured_facets.h"
#include "extraction/bricks/structured_measure.h"
#include "extraction/cells/active_cells.h"
#include "extraction/facets/weld_seams.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/mesh/open_ends.h"

namespace isostrata {
namespace {

constexpr std::int64_t kBricksPerTask = 8;

/// Where each brick's parts of the mesh begin: [bricks + 1].
struct Starts {
  std::vector<std::uint32_t> tetrahedra, runs;
};

class Writer {
 public:
  Writer(const Grid& grid, const PointArray& array, const IsoRules& rules, const ActiveBricks& active,
         const ExtractOptions& options, const Task& task, IntervalMesh& mesh)
      : grid_(grid), array_(array), rules_(rules), active_(active), options_(options), task_(task), mesh_(mesh), writer_(grid, array, rules, active) {}

  /// The points alone, and the facets on them.
  void write_facets_alone() {
    count(0);
    resize_points();
    const auto bricks = static_cast<std::int64_t>(active_.bricks().size());
    StageProgress progress(task_, "extracting", 0.4, 0.85, bricks);
    parallel_for(bricks, kBricksPerTask, [&](std::int64_t begin, std::int64_t end) {
      BrickWriter::Scratch scratch(writer_);
      for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b) writer_.write_points(b, 0, BrickLayout::kSide, true, scratch, mesh_);
      task_.check();
      progress.done(end - begin);
    });
    mesh_.facets = structured_facets(grid_, array_, active_, writer_, options_.max_bytes, task_);
  }

  void write() {
    count(active_.tetrahedra());
    resize_points();
    mesh_.tetrahedra.resize(active_.tetrahedra());
    mesh_.tetrahedron_interval.resize(active_.tetrahedra());
    mesh_.cell_runs.resize(active_.cells());
    const auto bricks = static_cast<std::int64_t>(active_.bricks().size());
    const bool more = options_.facets || options_.measure;
    StageProgress progress(task_, "extracting", 0.4, more ? 0.7 : 1.0, bricks);
    parallel_for(bricks, kBricksPerTask, [&](std::int64_t begin, std::int64_t end) {
      BrickWriter::Scratch scratch(writer_);
      for (std::int64_t b = begin; b < end; ++b) {
        writer_.write_points(static_cast<std::size_t>(b), 0, BrickLayout::kSide, true, scratch, mesh_);
        write_cells(static_cast<std::size_t>(b), scratch);
        if (b % 4 == 3) task_.check();
      }
      progress.done(end - begin);
    });
  }

 private:
  void resize_points() {
    mesh_.positions.resize(active_.points());
    mesh_.origins.resize(active_.points());
    if (options_.values) mesh_.values.resize(active_.points());
    mesh_.active_cells = static_cast<std::int64_t>(active_.cells());
  }

  void count(std::uint64_t tetrahedra) {
    const std::uint64_t bytes =
        tetrahedra * (sizeof(std::array<std::uint32_t, 4>) + sizeof(std::uint16_t)) +
        active_.points() * (sizeof(Vec3d) + sizeof(PointOrigin) + (options_.values ? sizeof(double) : 0)) +
        (tetrahedra > 0 ? active_.cells() * sizeof(CellRun) : 0) + active_.bytes() + active_.bricks().size() * 3 * sizeof(std::uint32_t);
    const std::string what =
        std::to_string(active_.tetrahedra()) + " tetrahedra with " + std::to_string(active_.points()) + " points";
    check_budget(what, bytes, options_.max_bytes);
    check_numbers(std::max(active_.tetrahedra(), active_.points()), what);
    for (auto* starts : {&starts_.tetrahedra, &starts_.runs}) starts->assign(1, 0);
    for (const ActiveBrick& brick : active_.bricks()) {
      starts_.tetrahedra.push_back(starts_.tetrahedra.back() + brick.tetrahedra);
      starts_.runs.push_back(starts_.runs.back() + brick.cells);
    }
  }

  /// The brick's cells.
  void write_cells(std::size_t b, BrickWriter::Scratch& scratch) {
    const std::span<const CellRecord> records = active_.records(b);
    if (records.empty()) return;
    const ActiveBrick& brick = active_.bricks()[b];
    writer_.make_tables(b, scratch);
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

  const Grid& grid_;
  const PointArray& array_;
  const IsoRules& rules_;
  const ActiveBricks& active_;
  const ExtractOptions& options_;
  const Task& task_;
  IntervalMesh& mesh_;
  const BrickWriter writer_;
  Starts starts_;
};

/// Where a grid meets itself its two sides become one by their tetrahedra.
bool facets_suffice(const Grid& grid, const PointArray& array, const ExtractOptions& options) {
  const auto seams = [&] {
    const std::array<bool, 3> found = find_seams(grid, array);
    return found[0] || found[1] || found[2];
  };
  return options.facets && !options.tetrahedra && !seams();
}

std::shared_ptr<const ActiveBricks> find_bricks(const Grid& grid, const PointArray& array, const IsoRules& rules,
                                                const ExtractOptions& options, const Task& task) {
  if (!options.bricks) {
    const MinMaxBricks ranges(grid, array, task);
    return std::make_shared<const ActiveBricks>(grid, array, ranges, rules, options.max_bytes, task);
  }
  return options.bricks->find_active(grid, array, rules, options.max_bytes, task);
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
    Writer writer(grid, array, rules, active, options, task, mesh);
    if (facets_suffice(grid, array, options)) {
      writer.write_facets_alone();
      if (options.measure) measure_facets(mesh, task);
    } else {
      writer.write();
      if (options.measure) measure_records(grid, active, mesh, task);
      if (options.facets) mesh.facets = structured_facets(grid, array, active, mesh, options.max_bytes, task);
    }
  }
  task.report(1.0, "extracted");
  return mesh;
}

}  // namespace isostrata
