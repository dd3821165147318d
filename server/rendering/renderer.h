// The door to the renderers. One renderer owns one device and lives on one thread.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/image.h"
#include "data/grid.h"
#include "extraction/interval_mesh.h"
#include "rendering/camera.h"
#include "rendering/style.h"

namespace isostrata {

enum class RenderMode {
  sorted,      // back to front over all intervals: the volume as it is
  prioritized  // painted by priority, nearer or not (section 4.1.3 of the paper)
};

/// What a picture is made of. Everything pointed to outlives the call.
struct DrawInput {
  const Grid* grid = nullptr;                              // the mesh's base grid, for the visibility order
  Box3d bounds;                                            // of the grid
  std::shared_ptr<const IntervalMesh> mesh;                // the renderer may keep device copies by this pointer's identity
  std::shared_ptr<const std::vector<float>> color_values;  // [np] or null where no style has a colour map
  std::vector<IntervalStyle> styles;                       // one per interval of the mesh
  RenderMode mode = RenderMode::sorted;
  Camera camera;
  int width = 800, height = 600;  // 1..16384
  double unit_distance = 0;       // scalar_opacity_unit_distance in world units; 0: default_unit_distance
  Rgb background{0, 0, 0};
  bool transparent = false;      // leave the background out and keep alpha
  bool float_image = false;      // ask for the float target as it is (EXR, tests), never composited over the background
  bool count_fragments = false;  // fill DrawFacts::fragments (costs a little)
};

/// Facts of a frame, as they are sent to clients and printed by bench.
struct DrawFacts {
  std::string device;  // "llvmpipe (LLVM 15.0.6, 256 bits), EGL surfaceless"
  std::string order;   // "index distance (exact)", "centroid (approximate)", "none needed"
  bool order_exact = false;
  std::int64_t tetrahedra = 0;  // drawn
  std::int64_t fragments = 0;   // pixels of tetrahedra that were blended, each tetrahedron for itself; 0 where not asked for
  double order_ms = 0, draw_ms = 0, readback_ms = 0;
};

struct DrawResult {
  std::variant<Image, FloatImage> image;
  DrawFacts facts;
};

class Renderer {
 public:
  virtual ~Renderer() = default;
  /// Throws invalid_argument (size, camera, NaN colours), too_large, unavailable. After an Error the next call works.
  virtual DrawResult draw(const DrawInput& input) = 0;
  virtual const std::string& device() const = 0;
};

/// One attempt at a device, for `isostrata doctor`.
struct DeviceAttempt {
  std::string name;  // "EGL device 0 (/dev/dri/renderD128)", "EGL surfaceless", "OSMesa"
  bool ok = false;
  std::string detail;  // the GL renderer and version, or why it failed
  bool software = false;
};

/// device: "auto", "egl:INDEX", "egl:UUID", "surfaceless", "osmesa". auto takes the first that works of: each EGL device that is
/// hardware, EGL surfaceless, OSMesa. The renderer must be used and destroyed on the thread that made it. Throws unavailable
/// saying what was tried and why each failed.
std::unique_ptr<Renderer> make_renderer(std::string_view device);
std::vector<DeviceAttempt> probe_devices();

}  // namespace isostrata
