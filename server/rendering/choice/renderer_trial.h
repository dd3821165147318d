// Which of the renderers raster and compute is the faster on a device: graphics chips have units for triangles, and some that are
// made for arithmetic have few of them, so that no rule of thumb holds.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "rendering/picture/renderer.h"

namespace isostrata {

/// Frames of a built-in mesh, from several sides, by one renderer after the other.
struct RendererTrial {
  std::string device;
  double raster_ms = 0, compute_ms = 0;  // the fastest frame's; 0 if it does not work
  std::string raster_error, compute_error;

  bool compute_is_faster() const { return compute_ms > 0 && !(raster_ms > 0 && raster_ms <= compute_ms); }
  /// "compute: 1.2 ms a frame in the trial, raster 14.5 ms (NVIDIA H200, ...)"
  std::string report() const;
};

/// The faster of both on the device, as open_context takes it; the trial is made once in a process and device and its outcome
/// kept; on a software device the mesh is smaller. Throws unavailable if neither works. Any thread.
std::unique_ptr<Renderer> make_faster_renderer(const std::string& device);

}  // namespace isostrata
