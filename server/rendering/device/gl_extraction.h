// A field on a device of its own, its interval volumes extracted there (gl_extractor.h has the method) and read back.
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
#include "extraction/cells/active_cells.h"
#include "rendering/device/gl_extractor.h"

namespace isostrata {

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

  /// Copies what the last extract() left. Each throws invalid_argument if it left no such thing.
  std::vector<CellCase> read_records(const Task& task);
  std::vector<std::array<float, 4>> read_positions(const Task& task);  // less anchor; the fourth is the array's value
  GlMeshParts read_mesh(const Task& task);
  /// Positions on the device are less this, so that they keep their digits as floats.
  Vec3d anchor() const;

 private:
  class State;
  State& state() const;
  void drop_after_error();
  std::string wanted_, device_;
  bool software_ = false;
  std::uint64_t budget_ = 0, largest_part_ = 0;
  std::unique_ptr<State> state_;  // null after an Error that may have hurt the device
};

}  // namespace isostrata
