#include "rendering/device/gl_extractor.h"

#include <algorithm>
#include <limits>

#include "base/error.h"
#include "extraction/cells/structured_points.h"
#include "rendering/device/table_words.h"
#include "rendering/shader_sources.h"

namespace isostrata {
namespace {

using shaders::ExtractionCounters;
using shaders::WorkGroups;

constexpr std::uint32_t kSaturated = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kMinCapacity = 4096;
constexpr const char* kAnyFormat = "#define BYTES_PER_VALUE 4\n";  // programs that look at no values are compiled once

std::uint32_t pieces(std::uint64_t items, std::uint64_t each) { return static_cast<std::uint32_t>((items + each - 1) / each); }

}  // namespace

GlExtractor::~GlExtractor() {
  free_all();
  device_.free(tables_);
}

/// All but the tables.
void GlExtractor::free_all() {
  if (field_) field_->free(device_);
  field_.reset();
  for (ComputeBuffer* buffer : {&records_, &first_, &positions_, &origins_, &tetrahedra_, &counters_, &grid_block_, &rules_,
                                &levels_, &tally_, &bricks_, &ranks_, &rows_, &groups_, &sums_, &partials_, &slots_, &owned_})
    device_.free(*buffer);
}

void GlExtractor::load(const Grid& grid, const PointArray& array, std::uint64_t largest_part, const Task& task) {
  device_.make_current();
  if (!tables_.object) {
    const std::vector<std::uint32_t> words = table_words();
    device_.reserve(tables_, words.size() * sizeof(std::uint32_t), "the interval table");
    try {
      device_.upload(tables_, 0, std::as_bytes(std::span(words)), task);
    } catch (...) {
      device_.free(tables_);  // or a cancelled load would leave a table of zeros
      throw;
    }
  }
  free_all();
  has_records_ = has_mesh_ = false;
  field_ = load_field(device_, grid, array, largest_part, task);
  // A guess: most requests are for thin layers. What turns out larger is done again.
  constexpr std::uint64_t kMostBytesABrick = 512 * 12;  // slots of three words
  const std::uint32_t bricks = std::max(field_->bricks(), 1u);
  const auto room = static_cast<std::uint32_t>(device_.largest_buffer() / 4 / kMostBytesABrick);
  capacities_.bricks = std::min(bricks, std::min(room, std::max(kMinCapacity, bricks / 8)));
  const std::int64_t cells = std::max<std::int64_t>(field_->cells / 16, kMinCapacity);
  capacities_.records = static_cast<std::uint32_t>(std::min<std::int64_t>(cells, 1 << 21));
  capacities_.tetrahedra = 4 * capacities_.records;
  capacities_.points = 2 * capacities_.records;
}

void GlExtractor::plan_slices() {
  const std::uint32_t most = device_.groups_a_dispatch();
  std::uint32_t next = 0;
  const auto take = [&](std::uint64_t groups) {
    const Slices slices{next, std::max(1u, pieces(groups, most))};
    next += slices.count;
    return slices;
  };
  const std::uint32_t layer = field_->grid.bricks_x * field_->grid.bricks_y;
  brick_slices_.clear();
  for (const FieldPart& part : field_->parts)
    brick_slices_.push_back(take(std::min<std::uint64_t>(capacities_.bricks, (part.end_layer - part.first_layer) * layer)));
  row_tiles_ = take(pieces(capacities_.bricks, SCAN_TILE / 64));
  owned_tiles_ = take(pieces(capacities_.bricks, SCAN_TILE));
  record_groups_ = take(pieces(capacities_.records, RECORD_GROUP));
  device_.reserve(groups_, next * sizeof(WorkGroups), "work groups");
}

void GlExtractor::reserve(GlExtent extent) {
  const Capacities& c = capacities_;
  device_.reserve(bricks_, c.bricks * 4ull, "the active bricks");
  device_.reserve(sums_, c.bricks * 64ull * 8, "room for sums of " + std::to_string(c.bricks) + " active bricks");
  const std::uint64_t tiles = std::max(pieces(field_->bricks(), SCAN_GROUP), pieces(c.bricks, SCAN_TILE / 64));
  device_.reserve(partials_, tiles * 8, "sums of tiles");
  device_.reserve(records_, c.records * sizeof(shaders::CellRecord),
                  "room for " + std::to_string(c.records) + " records of cells");
  device_.reserve(first_, c.records * 4ull, "the records' tetrahedra");
  if (extent == GlExtent::records) return;
  device_.reserve(slots_, c.bricks * 512ull * (packed_slots_ ? 4 : 12),
                  "room for the points of " + std::to_string(c.bricks) + " active bricks");
  device_.reserve(owned_, c.bricks * 8ull, "the active bricks' points");
  device_.reserve(positions_, c.points * 16ull, "room for " + std::to_string(c.points) + " points");
  device_.reserve(origins_, c.points * sizeof(shaders::MeshPointOrigin),
                  "room for the origins of " + std::to_string(c.points) + " points");
  device_.reserve(tetrahedra_, c.tetrahedra * 16ull, "room for " + std::to_string(c.tetrahedra) + " tetrahedra");
}

/// Sends the request: its rules, its sizes, zeros.
void GlExtractor::prepare(const IsoRules& rules, GlExtent extent, const Task& task) {
  const KeyedRules keyed = keyed_rules(field_->format, rules);
  const std::size_t isovalues = rules.isovalues().size();
  packed_slots_ = 1 + 3 * isovalues <= 16;
  field_->grid.rules = static_cast<std::uint32_t>(keyed.rules.size());
  field_->grid.isovalues = static_cast<std::uint32_t>(isovalues);
  field_->grid.brick_capacity = capacities_.bricks;
  field_->grid.record_capacity = capacities_.records;
  field_->grid.tetrahedron_capacity = capacities_.tetrahedra;
  field_->grid.point_capacity = capacities_.points;

  reserve(extent);
  plan_slices();
  const auto send = [&](ComputeBuffer& buffer, auto span, const char* what) {
    device_.reserve(buffer, span.size_bytes(), what);
    device_.upload(buffer, 0, std::as_bytes(span), task);
  };
  send(grid_block_, std::span(&field_->grid, 1), "the grid");
  send(rules_, std::span(keyed.rules), "the intervals");
  std::vector<shaders::IsoLevel> levels = keyed.levels;
  for (const IsoRule& rule : rules.rules()) levels.push_back({rule.lower_index, rule.upper_index, 0, 0});
  send(levels_, std::span(levels), "the isovalues");
  device_.reserve(tally_, rules.rules().size() * sizeof(shaders::IntervalTally), "the intervals' counts");
  device_.clear(tally_, rules.rules().size() * sizeof(shaders::IntervalTally));
  ExtractionCounters counters{};
  counters.tiles = pieces(field_->bricks(), SCAN_GROUP);
  send(counters_, std::span(&counters, 1), "counters");
  device_.reserve(ranks_, field_->bricks() * 4ull, "the bricks' ranks");
  device_.reserve(rows_, (static_cast<std::uint64_t>(field_->grid.bricks_y) * field_->grid.bricks_z + 1) * 4,
                  "the rows of bricks");
  device_.gl().BindBufferBase(GL_UNIFORM_BUFFER, BLOCK_GRID, grid_block_.name());
}

void GlExtractor::plan(const char* defines, const Slices& slices, std::array<std::uint32_t, 3> span, const Task& task) {
  const GLuint program = device_.program(shaders::plan_comp, std::string(kAnyFormat) + defines);
  device_.bind(BUFFER_COUNTERS, counters_);
  device_.bind(BUFFER_ROWS, rows_);
  device_.bind(BUFFER_GROUPS, groups_);
  device_.gl().ProgramUniform1ui(program, UNIFORM_FIRST, slices.first);
  device_.gl().ProgramUniform1ui(program, UNIFORM_COUNT, slices.count);
  device_.gl().ProgramUniform4ui(program, UNIFORM_SPAN, device_.groups_a_dispatch(), span[0], span[1], span[2]);
  device_.dispatch(program, pieces(slices.count, 64), task);
  device_.barrier();
}

/// Sums of all before of `elements` pairs per active brick; the totals go to two counters.
void GlExtractor::scan(const ComputeBuffer& sums, std::uint32_t elements, const Slices& slices, std::uint32_t total_x,
                               std::uint32_t total_y, const Task& task) {
  device_.bind(BUFFER_COUNTERS, counters_);
  device_.bind(BUFFER_SUMS, sums);
  device_.bind(BUFFER_PARTIALS, partials_);
  device_.bind(BUFFER_GROUPS, groups_);
  for (const char* pass : {"#define REDUCE\n", "#define SPINE\n", "#define APPLY\n"}) {
    const GLuint program = device_.program(shaders::scan_comp, std::string(kAnyFormat) + pass);
    device_.gl().ProgramUniform1ui(program, UNIFORM_FIRST, COUNT_BRICKS);
    device_.gl().ProgramUniform1ui(program, UNIFORM_COUNT, elements);
    if (pass[8] == 'S') {
      device_.gl().ProgramUniform4ui(program, UNIFORM_SPAN, total_x, total_y, 0, 0);
      device_.dispatch(program, 1, task);
      device_.barrier();
    } else
      dispatch_slices(program, slices, task);
  }
}

void GlExtractor::find_bricks(const Task& task) {
  const std::uint32_t tiles = pieces(field_->bricks(), SCAN_GROUP), most = device_.groups_a_dispatch();
  device_.bind(BUFFER_RANGES, field_->ranges);
  device_.bind(BUFFER_RULES, rules_);
  device_.bind(BUFFER_PARTIALS, partials_);
  device_.bind(BUFFER_COUNTERS, counters_);
  device_.bind(BUFFER_BRICKS, bricks_);
  device_.bind(BUFFER_ROWS, rows_);
  device_.bind(BUFFER_SUMS, ranks_);
  for (const bool compact : {false, true}) {
    const GLuint program =
        device_.program(shaders::cull_bricks_comp,
                        std::string(field_->format.bytes == 8 ? "#define BYTES_PER_VALUE 8\n#define KEY_FLOAT\n" : kAnyFormat) +
                            (compact ? "#define COMPACT\n" : ""));
    for (std::uint32_t first = 0; first < tiles; first += std::min(most, tiles - first)) {
      device_.gl().ProgramUniform1ui(program, UNIFORM_FIRST, first);
      device_.dispatch(program, std::min(most, tiles - first), task);
    }
    device_.barrier();
    if (compact) break;
    const GLuint spine = device_.program(shaders::scan_comp, std::string(kAnyFormat) + "#define SPINE\n");
    device_.gl().ProgramUniform1ui(spine, UNIFORM_FIRST, COUNT_TILES);
    device_.gl().ProgramUniform1ui(spine, UNIFORM_COUNT, 1);
    device_.gl().ProgramUniform4ui(spine, UNIFORM_SPAN, COUNT_BRICKS, COUNT_BRICKS, 0, 0);
    device_.dispatch(spine, 1, task);
    device_.barrier();
  }
  const std::uint32_t rows = field_->grid.bricks_y;
  for (std::size_t p = 0; p < field_->parts.size(); ++p)
    plan("#define PLAN_BRICKS\n", brick_slices_[p], {1, field_->parts[p].first_layer * rows, field_->parts[p].end_layer * rows},
         task);
}

void GlExtractor::classify(bool write, const Task& task) {
  const bool points = write && field_->curvilinear;
  const GLuint program = device_.program(shaders::classify_comp,
                                         "#define LOAD_BRICK\n" + field_->defines(points) + (write ? "#define WRITE\n" : ""));
  device_.bind(BUFFER_RULES, rules_);
  device_.bind(BUFFER_COUNTERS, counters_);
  device_.bind(BUFFER_BRICKS, bricks_);
  device_.bind(BUFFER_ROWS, rows_);
  device_.bind(BUFFER_GROUPS, groups_);
  device_.bind(BUFFER_SUMS, sums_);
  device_.bind(BUFFER_TABLES, tables_);
  device_.bind(BUFFER_RECORDS, records_);
  device_.bind(BUFFER_FIRST, first_);
  device_.bind(BUFFER_TALLY, tally_);
  if (field_->has_absent) device_.bind(BUFFER_ABSENT, field_->absent);
  for_parts(points, program, [&](const Slices& slices) { dispatch_slices(program, slices, task); });
}

void GlExtractor::find_records(const Task& task) {
  classify(false, task);
  plan("", row_tiles_, {SCAN_TILE / 64, COUNT_BRICKS, 0}, task);
  scan(sums_, 64, row_tiles_, COUNT_RECORDS, COUNT_RECORDS + 1, task);
  classify(true, task);
}

void GlExtractor::number_points(bool locate, const Task& task) {
  const bool points = locate && field_->curvilinear;
  const GLuint program = device_.program(shaders::number_points_comp,
                                         "#define LOAD_BRICK\n" + field_->defines(points) + (locate ? "#define LOCATE\n" : "") +
                                             (packed_slots_ ? "#define SLOT_WORDS 1\n" : "#define SLOT_WORDS 3\n"));
  device_.bind(BUFFER_COUNTERS, counters_);
  device_.bind(BUFFER_BRICKS, bricks_);
  device_.bind(BUFFER_GROUPS, groups_);
  device_.bind(BUFFER_ISOVALUES, levels_);
  device_.bind(BUFFER_RULES_OF_POINTS, rules_);
  device_.bind(BUFFER_SLOTS, slots_);
  device_.bind(BUFFER_OWNED, owned_);
  device_.bind(BUFFER_AXES, field_->axes);
  device_.bind(BUFFER_POSITIONS, positions_);
  device_.bind(BUFFER_ORIGINS, origins_);
  if (field_->has_absent) device_.bind(BUFFER_ABSENT, field_->absent);
  for_parts(points, program, [&](const Slices& slices) { dispatch_slices(program, slices, task); });
}

void GlExtractor::expand(const Task& task) {
  number_points(false, task);
  plan("", owned_tiles_, {SCAN_TILE, COUNT_BRICKS, 0}, task);
  scan(owned_, 1, owned_tiles_, COUNT_POINTS, COUNT_POINTS, task);
  number_points(true, task);

  plan("#define PLAN_RECORDS\n", record_groups_, {RECORD_GROUP, COUNT_RECORDS, 0}, task);
  const GLuint program =
      device_.program(shaders::write_tetrahedra_comp,
                      std::string(kAnyFormat) + (packed_slots_ ? "#define SLOT_WORDS 1\n" : "#define SLOT_WORDS 3\n"));
  device_.bind(BUFFER_COUNTERS, counters_);
  device_.bind(BUFFER_GROUPS, groups_);
  device_.bind(BUFFER_RANKS, ranks_);
  device_.bind(BUFFER_SLOTS, slots_);
  device_.bind(BUFFER_OWNED, owned_);
  device_.bind(BUFFER_ISOVALUES, levels_);
  device_.bind(BUFFER_TABLES, tables_);
  device_.bind(BUFFER_RECORDS, records_);
  device_.bind(BUFFER_FIRST, first_);
  device_.bind(BUFFER_TETRAHEDRA, tetrahedra_);
  device_.gl().ProgramUniform1ui(program, UNIFORM_FIRST, field_->mirrored ? 1 : 0);
  dispatch_slices(program, record_groups_, task);
}

/// Whether something did not fit; then there is room for it from now on.
bool GlExtractor::grow(const ExtractionCounters& found, GlExtent extent) {
  const auto refuse_saturated = [&](std::uint32_t count, const char* what) {
    if (count == kSaturated)
      throw Error(ErrorCode::too_large,
                  std::string("extraction on a device: 2^32 ") + what + " or more; expected fewer: narrow the intervals");
  };
  // With an eighth to spare where a buffer holds that: a slider that is dragged asks for a little more each time.
  const auto fit = [&](std::uint32_t count, std::uint32_t& capacity, std::uint64_t bytes_each) {
    if (count <= capacity) return true;
    const std::uint64_t most = std::min<std::uint64_t>(device_.largest_buffer() / bytes_each, kSaturated - 1);
    capacity = static_cast<std::uint32_t>(std::max<std::uint64_t>(count, std::min<std::uint64_t>(count + count / 8ull, most)));
    return false;
  };
  // A stage whose input did not fit has counted nothing yet.
  if (!fit(found.bricks, capacities_.bricks, 512 * 12)) {
    capacities_.bricks = std::min(capacities_.bricks, field_->bricks());
    return true;
  }
  refuse_saturated(found.records, "records of cells");
  refuse_saturated(found.tetrahedra, "tetrahedra");
  bool fits = fit(found.records, capacities_.records, sizeof(shaders::CellRecord));
  if (extent == GlExtent::records) return !fits;
  refuse_saturated(found.points, "points");
  fits = fit(found.tetrahedra, capacities_.tetrahedra, 16) && fits;
  fits = fit(found.points, capacities_.points, 16) && fits;
  return !fits;
}

GlCounts GlExtractor::extract(std::span<const Interval> intervals, GlExtent extent, const Task& task) {
  const IsoRules rules(intervals);
  if (extent == GlExtent::tetrahedra && rules.isovalues().size() > StructuredPoints::kMaxIsovalues)
    throw Error(ErrorCode::unsupported, "extraction on a device: " + std::to_string(rules.isovalues().size()) +
                                            " distinct ends of intervals; expected at most " +
                                            std::to_string(StructuredPoints::kMaxIsovalues) +
                                            " for tetrahedra: extract on the CPU");
  device_.make_current();
  has_records_ = has_mesh_ = false;
  GlCounts counts;
  counts.cells = field_->cells;
  counts.intervals.resize(intervals.size());
  if (field_->cells > 0) {
    ExtractionCounters found;
    std::vector<shaders::IntervalTally> tally(intervals.size());
    for (counts.attempts = 1;; ++counts.attempts) {
      prepare(rules, extent, task);
      task.report(0.1, "extracting on the device");
      ComputeTimer timer(device_);
      find_bricks(task);
      find_records(task);
      if (extent == GlExtent::tetrahedra) expand(task);
      timer.stop();
      device_.finish(task);
      counts.extract_ms = timer.elapsed_ms();
      device_.read(counters_, 0, std::as_writable_bytes(std::span(&found, 1)), task);
      if (!grow(found, extent)) break;
    }
    device_.read(tally_, 0, std::as_writable_bytes(std::span(tally)), task);
    counts.bricks = field_->bricks();
    left_handed_ = field_->mirrored || found.balance < 0;
    counts.active_bricks = found.bricks;
    counts.active_cells = found.active_cells;
    counts.records = found.records;
    counts.tetrahedra = found.tetrahedra;
    counts.points = extent == GlExtent::tetrahedra ? found.points : 0;
    for (std::size_t i = 0; i < tally.size(); ++i) counts.intervals[i] = {tally[i].records, tally[i].tetrahedra};
  }
  counts.device_bytes = device_.allocated();
  counts_ = counts;
  has_records_ = true;
  has_mesh_ = extent == GlExtent::tetrahedra;
  task.report(1.0, "extracted");
  return counts;
}

}  // namespace isostrata
