// A structured grid and one of its arrays on the device: what is done once an array, so that a request only reads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "rendering/device/field_keys.h"
#include "rendering/gl/gl_compute.h"

namespace isostrata {

/// Some layers of bricks with the points around them: as many as one buffer holds.
struct FieldPart {
  std::uint32_t first_layer = 0, end_layer = 0;  // of bricks
  ComputeBuffer values;  // in the array's own type (64-bit integers as doubles), first point of first_layer first
  ComputeBuffer points;  // of a curvilinear grid, in its own precision
};

struct GlField {
  KeyFormat format;
  shaders::ExtractionGrid grid{};  // sizes; counts and capacities are the request's
  std::vector<FieldPart> parts;
  ComputeBuffer ranges;  // IsoRange per brick
  ComputeBuffer absent;  // 512 bits per brick; unused where has_absent is false
  ComputeBuffer axes;    // anchor, then x, y, z of a rectilinear grid
  bool has_absent = false;
  bool curvilinear = false, points_double = false;
  bool mirrored = false;  // the axes of a rectilinear grid make left-handed cells
  Vec3d anchor;           // positions on the device are less this, so that they keep their digits as floats
  std::int64_t cells = 0;
  double upload_ms = 0;  // wall clock: from the host's memory to the device's
  double index_ms = 0;   // extremes of the bricks, and absent cells

  /// Gives its buffers back.
  void free(ComputeDevice& device);
  std::uint32_t bricks() const { return grid.bricks_x * grid.bricks_y * grid.bricks_z; }
  /// What the programs are compiled with for this field.
  std::string defines(bool load_points) const;
};

/// Copies grid and array to the device, in parts of at most largest_part bytes (0: what a buffer holds), and looks once at every
/// value. Dispatches, per part of the grid:
///   brick_range            reads values (and points), writes ranges; one brick of 8^3 cells a work group
///   brick_range HAS_ABSENT only where a cell is hidden or something is not finite: adds to `absent`
/// Throws invalid_argument (lengths), unsupported (an unstructured grid), too_large (device memory; 2^32 points or more; one
/// layer of bricks above a buffer's limit), unavailable, cancelled.
GlField load_field(ComputeDevice& device, const Grid& grid, const PointArray& array, std::uint64_t largest_part,
                   const Task& task);

}  // namespace isostrata
