#include "main/extract_device.h"

#include <cstdio>

#include "extraction/intervals/extract_intervals.h"
#include "rendering/device/gl_extraction_mesh.h"

namespace isostrata {

void add_device_option(CLI::App& command, ExtractDevice& device) {
  command
      .add_option("--device", device.wanted,
                  "Where to extract: cpu; auto (a GPU if there is one); egl:INDEX, egl:UUID, surfaceless or osmesa: OpenGL "
                  "compute, for "
                  "uniform, rectilinear and curvilinear grids")
      ->capture_default_str();
}

Extractor device_extractor(ExtractDevice& device) {
  if (device.wanted == "cpu") return {};
  auto extraction = std::make_shared<std::unique_ptr<GlExtraction>>();
  return [&device, extraction](const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                               const ExtractOptions& options, const Task& task) {
    const bool choose = device.wanted == "auto";
    try {
      if (!*extraction) *extraction = std::make_unique<GlExtraction>(device.wanted);
      GlExtraction& there = **extraction;
      if (!choose || (!there.software() && grid.structured() && !grid.flat())) {
        IntervalMesh mesh = extract_intervals_on(there, grid, array, intervals, options, task);
        device.used = there.device();
        return mesh;
      }
    } catch (const Error& error) {
      if (!choose || error.code() == ErrorCode::cancelled || error.code() == ErrorCode::invalid_argument) throw;
      if (*extraction) std::fprintf(stderr, "isostrata: on the CPU instead: %s\n", error.what());
    }
    device.used = "cpu";
    return extract_intervals(grid, array, intervals, options, task);
  };
}

}  // namespace isostrata
