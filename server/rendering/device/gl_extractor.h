// Extraction of interval volumes on a device, in OpenGL 4.5 compute, for uniform, rectilinear and curvilinear grids: compact cell
// records for a renderer and, if asked for, indexed tetrahedra. The same tables, the same rule of equality and the same counts
// as extract_intervals; records in the order of find_active_cells.
//
// Method: min/max bricks of 8^3 cells; brick culling and compaction; base-3 case indices; count, prefix sums, write (G. E.
// Blelloch, "Prefix Sums and Their Applications", 1990: reduce, then scan; no work group ever waits for another); every grid
// point owns itself and its three edges towards larger indices, so a mesh point's number is a sum and a count of bits. Sizes stay
// on the device: what depends on them is dispatched indirectly, and the host reads counters once, at the end. What did not fit is
// made anew at the right size and done again.
//
// Dispatches of a request, with what each reads > writes (brackets: once per slice, see ComputeDevice::groups_a_dispatch):
//   cull_bricks            ranges, rules > active bricks in each tile of 256
//   scan SPINE             those > sums before each tile; counters.bricks
//   cull_bricks COMPACT    ranges, rules, those > bricks, ranks, row_first
//   plan                   counters.bricks > work groups, twice: over bricks (for each part of the grid), over tiles of the next
//   scan classify [.]           9^3 values of each active brick > records and tetrahedra of each of its 64 rows of cells; tally
//   scan REDUCE [.], SPINE, APPLY [.]   those > sums before each row, in the order of the grid's cells; counters
//   plan                   counters.records > work groups
//   classify WRITE [.]     the same values again (by now in a cache), sums > records, first_tetrahedron
// and for tetrahedra:
//   number_points [.]      values of active bricks > slots of each of their points; points of each brick
//   scan REDUCE, SPINE, APPLY           those > sums before each brick; counters.points
//   number_points LOCATE [.]            values, slots, sums > positions, origins
//   write_tetrahedra [.]   records, slots, sums, tables > tetrahedra
// Traffic: 16 bytes a brick (three times), the values of active bricks 2 to 4 times, 8 bytes a row of cells, 12 bytes a record,
// 24 bytes a point, 16 bytes a tetrahedron.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/cells/iso_rules.h"
#include "rendering/device/gl_field.h"
#include "rendering/gl/gl_compute.h"
#include "rendering/gl/layout.h"

namespace isostrata {

/// What a request leaves on the device.
enum class GlExtent {
  records,    // CellRecords (shaders/layout.h)
  tetrahedra  // and positions, origins and tetrahedra
};

struct GlIntervalCount {
  std::int64_t active_cells = 0;
  std::int64_t tetrahedra = 0;
};

struct GlCounts {
  std::int64_t cells = 0;         // of the grid, hidden ones included
  std::int64_t active_cells = 0;  // active in at least one interval
  std::int64_t records = 0;
  std::int64_t tetrahedra = 0;  // also where only records are asked for
  std::int64_t points = 0;      // 0 if only records are asked for
  std::int64_t bricks = 0, active_bricks = 0;
  std::vector<GlIntervalCount> intervals;  // in the order of the request
  double extract_ms = 0;                   // of the attempt that succeeded: the device's clock; software: wall clock
  int attempts = 1;                        // 2 or more where buffers had to grow
  std::uint64_t device_bytes = 0;          // in buffers, the field included
};

/// One field on a device that others may use beside it. Its buffers are deleted in the device's context: who owns the device makes it current before.
/// After an Error of load() or extract() other than invalid_argument, unsupported and cancelled the device is not to be trusted.
class GlExtractor {
 public:
  explicit GlExtractor(ComputeDevice& device) : device_(device) {}
  ~GlExtractor();
  GlExtractor(const GlExtractor&) = delete;
  GlExtractor& operator=(const GlExtractor&) = delete;

  /// Copies the field there in its own type; nothing of the host's memory is kept. largest_part as GlExtraction::set_budget. Throws as load_field does.
  void load(const Grid& grid, const PointArray& array, std::uint64_t largest_part, const Task& task);
  const GlField* field() const { return field_ ? &*field_ : nullptr; }  // null until one is loaded
  /// Of the loaded field. Throws as GlExtraction::extract.
  GlCounts extract(std::span<const Interval> intervals, GlExtent extent, const Task& task);

  // What the last extract() left; the buffers may be longer.
  const GlCounts& counts() const { return counts_; }
  bool has_records() const { return has_records_; }
  bool has_mesh() const { return has_mesh_; }
  bool left_handed() const { return left_handed_; }                        // cells whose own handedness is not known are taken to be
  const ComputeBuffer& records() const { return records_; }                // CellRecord [records]
  const ComputeBuffer& first_tetrahedron() const { return first_; }        // uint [records]
  const ComputeBuffer& positions() const { return positions_; }            // vec4 [points]: position less field()->anchor, value of the array
  const ComputeBuffer& origins() const { return origins_; }                // MeshPointOrigin [points]
  const ComputeBuffer& tetrahedra() const { return tetrahedra_; }          // uvec4 [tetrahedra], positively oriented where their cell is

 private:
  struct Capacities {
    std::uint32_t bricks = 0, records = 0, tetrahedra = 0, points = 0;
  };
  /// Work groups of one list that is gone through in slices.
  struct Slices {
    std::uint32_t first = 0, count = 0;
  };

  void free_all();
  void prepare(const IsoRules& rules, GlExtent extent, const Task& task);
  void reserve(GlExtent extent);
  void plan_slices();
  void find_bricks(const Task& task);
  void find_records(const Task& task);
  void expand(const Task& task);
  void classify(bool write, const Task& task);
  void number_points(bool locate, const Task& task);
  void scan(const ComputeBuffer& sums, std::uint32_t elements, const Slices& slices, std::uint32_t total_x, std::uint32_t total_y,
            const Task& task);
  void plan(const char* defines, const Slices& slices, std::array<std::uint32_t, 3> span, const Task& task);
  bool grow(const shaders::ExtractionCounters& found, GlExtent extent);

  /// Over the slices of each part that the bricks lie in, with the part's buffers bound.
  template <class Each>
  void for_parts(bool points, GLuint program, const Each& each) {
    for (std::size_t p = 0; p < field_->parts.size(); ++p) {
      const FieldPart& part = field_->parts[p];
      device_.bind(BUFFER_FIELD, part.values);
      if (points) device_.bind(BUFFER_POINTS, part.points);
      device_.gl().ProgramUniform1ui(program, UNIFORM_PART_LAYER, 8 * part.first_layer);
      each(brick_slices_[p]);
    }
  }
  void dispatch_slices(GLuint program, const Slices& slices, const Task& task) {
    for (std::uint32_t s = slices.first; s < slices.first + slices.count; ++s) {
      device_.gl().ProgramUniform1ui(program, UNIFORM_SLICE, s);
      device_.dispatch_indirect(program, groups_, s, task);
    }
    device_.barrier();
  }

  ComputeDevice& device_;
  GlCounts counts_;
  bool has_records_ = false, has_mesh_ = false, left_handed_ = false;
  ComputeBuffer records_, first_, positions_, origins_, tetrahedra_, counters_;

  std::optional<GlField> field_;
  ComputeBuffer tables_;
  ComputeBuffer grid_block_, rules_, levels_, tally_, bricks_, ranks_, rows_, groups_, sums_, partials_, slots_, owned_;
  Capacities capacities_;
  bool packed_slots_ = false;         // SLOT_WORDS 1
  std::vector<Slices> brick_slices_;  // [parts]
  Slices row_tiles_, owned_tiles_, record_groups_;
};

}  // namespace isostrata
