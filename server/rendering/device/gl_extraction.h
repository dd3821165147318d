// Extraction of interval volumes on a device, in OpenGL 4.5 compute, for uniform, rectilinear and curvilinear grids: compact cell
// records for a renderer and, where asked for, indexed tetrahedra. The same tables, the same rule of equality and the same counts
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
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/buffer.h"
#include "base/task.h"
#include "data/array.h"
#include "data/grid.h"
#include "extraction/cells/active_cells.h"
#include "extraction/intervals/extract_intervals.h"
#include "rendering/gl/gl_functions.h"
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
  std::int64_t points = 0;      // 0 where only records are asked for
  std::int64_t bricks = 0, active_bricks = 0;
  std::vector<GlIntervalCount> intervals;  // in the order of the request
  double extract_ms = 0;                   // of the attempt that succeeded: the device's clock; software: wall clock
  int attempts = 1;                        // 2 or more where buffers had to grow
  std::uint64_t device_bytes = 0;          // in buffers, the field included
};

struct GlLoadTimes {
  double upload_ms = 0;  // wall clock
  double index_ms = 0;   // extremes of the bricks, wall clock
};

/// What a mesh is made of, as the device holds it (shaders/layout.h has the structs).
struct GlMeshParts {
  std::vector<shaders::CellRecord> records;
  std::vector<std::uint32_t> first_tetrahedron;     // [records]
  Buffer<std::array<std::uint32_t, 4>> tetrahedra;  // positively oriented where their cell is
  std::vector<shaders::MeshPointOrigin> origins;    // [points]
  bool left_handed = false;                         // cells whose own handedness is not known are taken to be
};

/// Buffers for a renderer in the same context; valid until the next call. Positions are less `anchor`.
struct GlMeshBuffers {
  GLuint records = 0;            // CellRecord [records]
  GLuint first_tetrahedron = 0;  // uint [records]
  GLuint positions = 0;          // vec4 [points]: position less anchor, value of the array
  GLuint origins = 0;            // MeshPointOrigin [points]
  GLuint tetrahedra = 0;         // uvec4 [tetrahedra]
  GLuint counters = 0;           // ExtractionCounters
  Vec3d anchor;
};

/// One field on one device. Belongs to the thread that made it. After an Error of extract() other than invalid_argument,
/// unsupported and cancelled the field is gone; load() then opens the device anew. After any Error of load() no field is loaded.
class GlExtraction {
 public:
  /// device as make_renderer takes it. Throws unavailable: no device, or one without what extraction needs, saying which.
  explicit GlExtraction(std::string_view device);
  ~GlExtraction();
  GlExtraction(const GlExtraction&) = delete;
  GlExtraction& operator=(const GlExtraction&) = delete;

  const std::string& device() const { return device_; }
  bool software() const { return software_; }

  /// From the next load() on. bytes: the most that this object may take on the device; 0: nine tenths of what is free, where the
  /// driver says so, else 4 GiB. largest_part: the grid is cut into parts of at most that;
  /// 0: what one buffer holds (the driver's limit, at most 2 GiB).
  void set_budget(std::uint64_t bytes, std::uint64_t largest_part = 0) {
    budget_ = bytes;
    largest_part_ = largest_part;
  }

  /// Copies the field to the device in its own type. Nothing of the host's memory is kept. Throws as load_field (gl_field.h)
  /// does.
  GlLoadTimes load(const Grid& grid, const PointArray& array, const Task& task);

  /// Throws invalid_argument as extract_intervals does and where nothing is loaded; unsupported (tetrahedra of more than 21
  /// distinct isovalues); too_large (device memory; 2^32 or more of anything); unavailable (the device was lost); cancelled. Each
  /// message that the CPU would not give says to extract there.
  GlCounts extract(std::span<const Interval> intervals, GlExtent extent, const Task& task);

  /// Copies what the last extract() left. Each throws invalid_argument where it left no such thing.
  std::vector<CellCase> read_records(const Task& task);
  std::vector<std::array<float, 4>> read_positions(const Task& task);  // less anchor; the fourth is the array's value
  GlMeshParts read_mesh(const Task& task);
  GlMeshBuffers buffers() const;

 private:
  class State;
  State& state();
  void drop_after_error();
  std::string wanted_, device_;
  bool software_ = false;
  std::uint64_t budget_ = 0, largest_part_ = 0;
  std::unique_ptr<State> state_;  // null after an Error that may have hurt the device
};

}  // namespace isostrata
