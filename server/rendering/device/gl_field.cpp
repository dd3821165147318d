#include "rendering/device/gl_field.h"

#include <algorithm>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "base/stopwatch.h"
#include "data/values/check_values.h"
#include "rendering/shader_sources.h"

namespace isostrata {
namespace {

constexpr std::int64_t kBrick = 8;

/// Copies elements [begin, end) of the array as the device holds them.
void upload_values(ComputeDevice& device, const ComputeBuffer& buffer, const PointArray& array, const KeyFormat& format,
                   std::size_t begin, std::size_t end, const Task& task) {
  std::visit(
      [&](auto all) {
        const auto values = all.subspan(begin, end - begin);
        if (!format.promoted) {
          device.upload(buffer, 0, std::as_bytes(values), task);
          return;
        }
        std::vector<double> promoted(std::min<std::size_t>(values.size(), 1 << 20));
        for (std::size_t at = 0; at < values.size(); at += promoted.size()) {
          const std::size_t count = std::min(promoted.size(), values.size() - at);
          for (std::size_t i = 0; i < count; ++i) promoted[i] = static_cast<double>(values[at + i]);
          device.upload(buffer, at * sizeof(double), std::as_bytes(std::span(promoted).first(count)), task);
        }
      },
      array.values);
}

/// A bit for each cell of each brick, i + 8 (j + 8 k) within it; 1 if the cell is hidden.
std::vector<std::uint32_t> hidden_bits(const Grid& grid, const GlField& field, const Task& task) {
  std::vector<std::uint32_t> bits(16 * static_cast<std::size_t>(field.bricks()));
  const std::int64_t cx = field.grid.points_x - 1, cy = field.grid.points_y - 1, cz = field.grid.points_z - 1;
  parallel_for(field.grid.bricks_z, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin * kBrick; k < std::min(cz, end * kBrick); ++k) {
      task.check();
      for (std::int64_t j = 0; j < cy; ++j)
        for (std::int64_t i = 0; i < cx; ++i) {
          if (!grid.hidden(i + cx * (j + cy * k))) continue;
          const std::int64_t brick = i / kBrick + field.grid.bricks_x * (j / kBrick + field.grid.bricks_y * (k / kBrick));
          const std::int64_t bit = i % kBrick + kBrick * (j % kBrick + kBrick * (k % kBrick));
          bits[16 * brick + bit / 32] |= 1u << bit % 32;
        }
    }
  });
  return bits;
}

void load_axes(ComputeDevice& device, const Grid& grid, GlField& field, const Task& task) {
  const Box3d box = grid.bounds();
  if (!box.empty()) field.anchor = box.center();
  for (const double c : {field.anchor.x, field.anchor.y, field.anchor.z})
    if (!std::isfinite(c)) field.anchor = {};
  std::vector<double> axes{field.anchor.x, field.anchor.y, field.anchor.z};
  const auto dims = grid.dims();
  if (grid.rectilinear()) {
    const std::array<std::int64_t, 3> step{1, dims[0], dims[0] * dims[1]};
    for (int axis = 0; axis < 3; ++axis) {
      for (std::int64_t i = 0; i < dims[axis]; ++i) axes.push_back(grid.point(i * step[axis])[axis]);
      const bool falls = dims[axis] > 1 && grid.point(step[axis])[axis] < grid.point(0)[axis];
      field.mirrored = field.mirrored != falls;
    }
  }
  device.reserve(field.axes, axes.size() * sizeof(double), "the grid's axes");
  device.upload(field.axes, 0, std::as_bytes(std::span(axes)), task);
}

/// The extremes of all bricks, or (with `absent`) the bits of what is not finite.
void run_ranges(ComputeDevice& device, GlField& field, GLuint grid_block, const ComputeBuffer& counters, bool absent,
                const Task& task) {
  const GLuint program = device.program(shaders::brick_range_comp, "#define LOAD_BRICK\n" + field.defines(field.curvilinear));
  device.gl().BindBufferBase(GL_UNIFORM_BUFFER, BLOCK_GRID, grid_block);
  if (absent) {
    device.bind(BUFFER_ABSENT, field.absent);
  } else {
    device.bind(BUFFER_RANGES, field.ranges);
    device.bind(BUFFER_COUNTERS, counters);
  }
  const std::uint32_t layer = field.grid.bricks_x * field.grid.bricks_y;
  for (const FieldPart& part : field.parts) {
    device.bind(BUFFER_FIELD, part.values);
    if (field.curvilinear) device.bind(BUFFER_POINTS, part.points);
    device.gl().ProgramUniform1ui(program, UNIFORM_PART_LAYER, part.first_layer * kBrick);
    const std::uint32_t end = part.end_layer * layer, most = device.groups_a_dispatch();
    for (std::uint32_t first = part.first_layer * layer; first < end; first += std::min(most, end - first)) {
      device.gl().ProgramUniform1ui(program, UNIFORM_FIRST, first);
      device.dispatch(program, std::min(most, end - first), task);
    }
  }
  device.barrier();
}

/// Cuts the grid into parts and copies them.
void load_parts(ComputeDevice& device, const Grid& grid, const PointArray& array, std::uint64_t largest_part, GlField& field,
                const Task& task) {
  const auto dims = grid.dims();
  const auto layer = static_cast<std::uint64_t>(dims[0]) * static_cast<std::uint64_t>(dims[1]);
  const auto* curvilinear = std::get_if<CurvilinearGrid>(&grid.shape);
  const std::uint64_t point_bytes = !curvilinear ? 0 : field.points_double ? sizeof(Vec3d) : sizeof(Vec3f);
  const std::uint64_t widest = layer * std::max<std::uint64_t>(field.format.bytes, point_bytes);
  const std::uint64_t room = largest_part > 0 ? std::min(largest_part, device.largest_buffer()) : device.largest_buffer();
  const std::uint64_t fits = room / widest;  // layers of points
  if (fits < kBrick + 1 && fits < static_cast<std::uint64_t>(dims[2]))
    throw Error(ErrorCode::too_large, device.context().device() + ": nine layers of " + std::to_string(dims[0]) + "x" +
                                          std::to_string(dims[1]) + " points would need " + std::to_string(9 * widest) +
                                          " bytes in one buffer, which holds " + std::to_string(room) + ": extract on the CPU");
  const std::uint64_t layers = fits >= static_cast<std::uint64_t>(dims[2]) ? field.grid.bricks_z : (fits - 1) / kBrick;
  for (std::uint64_t first = 0; first < field.grid.bricks_z; first += layers) {
    FieldPart& part = field.parts.emplace_back();
    part.first_layer = static_cast<std::uint32_t>(first);
    part.end_layer = static_cast<std::uint32_t>(std::min<std::uint64_t>(field.grid.bricks_z, first + layers));
    const std::uint64_t begin = layer * kBrick * first;
    const std::uint64_t end = layer * std::min<std::uint64_t>(dims[2], kBrick * part.end_layer + 1);
    device.reserve(part.values, (end - begin) * field.format.bytes, "the array '" + array.name + "'");
    upload_values(device, part.values, array, field.format, begin, end, task);
    if (!curvilinear) continue;
    device.reserve(part.points, (end - begin) * point_bytes, "the grid's points");
    std::visit([&](auto points) { device.upload(part.points, 0, std::as_bytes(points.subspan(begin, end - begin)), task); },
               curvilinear->points);
  }
}

/// Fills the ranges, and `absent` if there is any such cell.
void index_bricks(ComputeDevice& device, const Grid& grid, GlField& field, GLuint grid_block, const ComputeBuffer& counters,
                  const Task& task) {
  run_ranges(device, field, grid_block, counters, false, task);
  bool absent = !grid.hidden_cells.empty();
  if (field.format.is_float || field.curvilinear) {
    shaders::ExtractionCounters found;
    device.read(counters, 0, std::as_writable_bytes(std::span(&found, 1)), task);
    absent = absent || found.any_absent != 0;
  }
  if (absent) {
    field.has_absent = true;
    device.reserve(field.absent, field.bricks() * 64ull, "a bit for each absent cell");
    const std::vector<std::uint32_t> bits = hidden_bits(grid, field, task);
    device.upload(field.absent, 0, std::as_bytes(std::span(bits)), task);
    run_ranges(device, field, grid_block, counters, true, task);
  }
  device.finish(task);
}

}  // namespace

void GlField::free(ComputeDevice& device) {
  for (FieldPart& part : parts)
    for (ComputeBuffer* buffer : {&part.values, &part.points}) device.free(*buffer);
  for (ComputeBuffer* buffer : {&ranges, &absent, &axes}) device.free(*buffer);
}

std::string GlField::defines(bool load_points) const {
  std::string text = "#define BYTES_PER_VALUE " + std::to_string(format.bytes) + "\n";
  if (format.is_float)
    text += "#define KEY_FLOAT\n";
  else if (format.is_signed)
    text += "#define KEY_SIGNED\n";
  if (has_absent) text += "#define HAS_ABSENT\n";
  if (load_points && curvilinear) text += std::string("#define LOAD_POINTS\n") + (points_double ? "#define POINTS_DOUBLE\n" : "");
  return text;
}

GlField load_field(ComputeDevice& device, const Grid& grid, const PointArray& array, std::uint64_t largest_part,
                   const Task& task) {
  if (!grid.structured())
    throw Error(ErrorCode::unsupported,
                "extraction on a device needs a structured grid, this one is unstructured: extract on the CPU");
  check_values(array, grid.point_count());
  if (grid.point_count() > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::too_large, "extraction on a device: " + std::to_string(grid.point_count()) +
                                          " points; expected fewer than 2^32: extract on the CPU");
  GlField field;
  field.cells = grid.cell_count();
  field.format = key_format(static_cast<ScalarType>(array.values.index()));
  if (field.cells == 0) return field;
  Stopwatch watch;
  const auto dims = grid.dims();
  const auto size = [&](int axis) { return static_cast<std::uint32_t>(dims[axis]); };
  const auto bricks = [&](int axis) { return static_cast<std::uint32_t>((dims[axis] + kBrick - 1) / kBrick); };
  field.grid = {size(0), size(1), size(2), bricks(0), bricks(1), bricks(2), 0, 0, 0, 0, 0, 0};
  if (const auto* curvilinear = std::get_if<CurvilinearGrid>(&grid.shape)) {
    field.curvilinear = true;
    field.points_double = std::holds_alternative<std::span<const Vec3d>>(curvilinear->points);
  }
  device.make_current();
  ComputeBuffer grid_block, counters;
  const auto free_own = [&] {
    device.free(grid_block);
    device.free(counters);
  };
  try {
    task.report(0.0, "sending to the device");
    load_parts(device, grid, array, largest_part, field, task);
    load_axes(device, grid, field, task);
    device.reserve(field.ranges, field.bricks() * sizeof(shaders::IsoRange), "the bricks' ranges");
    device.finish(task);
    field.upload_ms = watch.lap_ms();
    device.reserve(grid_block, sizeof field.grid, "the grid");
    device.upload(grid_block, 0, std::as_bytes(std::span(&field.grid, 1)), task);
    device.reserve(counters, sizeof(shaders::ExtractionCounters), "counters");
    device.clear(counters, sizeof(shaders::ExtractionCounters));
    task.report(0.5, "indexing on the device");
    index_bricks(device, grid, field, grid_block.name(), counters, task);
  } catch (...) {
    free_own();
    field.free(device);
    throw;
  }
  free_own();
  field.index_ms = watch.lap_ms();
  return field;
}

}  // namespace isostrata
