// The door to the renderers. One renderer owns one device and lives on one thread.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/image.h"
#include "data/grids/grid.h"
#include "extraction/mesh/interval_mesh.h"
#include "extraction/surfaces/base_tetrahedra.h"
#include "scene/camera.h"
#include "scene/clip_plane.h"
#include "scene/integral.h"
#include "scene/style.h"

namespace isostrata {

class LayerBricks;  // extraction/bricks/layer_bricks.h

enum class RenderMode {
  sorted,      // back to front over all intervals: the volume as it is
  prioritized  // painted by priority, nearer or not (section 4.1.3 of the paper)
};

/// The part of a larger picture that is drawn: pixel (i, j) of it is pixel (x + i, y + j) of the whole one, ray for ray.
struct PictureWindow {
  int x = 0, y = 0;           // row 0 is the top row
  int width = 0, height = 0;  // of the whole picture; 0: the picture is the whole one
  bool operator==(const PictureWindow&) const = default;
};

/// What a picture is made of. Everything pointed to outlives the call.
struct DrawInput {
  const Grid* grid = nullptr;                              // the mesh's base grid, for the visibility order
  Box3d bounds;                                            // of the grid
  std::shared_ptr<const IntervalMesh> mesh;                // the renderer may keep device copies by this pointer's identity
  std::shared_ptr<const std::vector<float>> color_values;  // [np] or null if all styles are constant()
  std::vector<IntervalStyle> styles;                       // one per interval of the mesh
  // Not empty: what is drawn of interval i, with style i, is where base's field lies in it; mesh and color_values are base's.
  // Then other ends need no other mesh. Surfaces among constant colours, without textures; only renderers that cuts_intervals().
  std::vector<Interval> cut_intervals;
  std::shared_ptr<const BaseTetrahedra> base;  // null without cut_intervals
  // Not null: the mesh has summaries and no points; what is seen of its layers is made of these. In constant colours by renderers that draws_bricks();
  // colours and opacities that run with the layers' own array, and no surfaces, by those that extracts().
  std::shared_ptr<const LayerBricks> bricks;
  RenderMode mode = RenderMode::sorted;
  Integral integral = Integral::exact;
  std::vector<ClipPlane> clip_planes;  // what is kept by all of them is drawn; the cut is exact, to the pixel
  // Where a style draws a surface: the mesh then has facets. Unit vectors along the gradient of the extracted array; of either
  // sign (surfaces are shaded from both sides). Null: the facets' own normals.
  std::shared_ptr<const std::vector<Vec3f>> normals;         // [np] or null
  std::shared_ptr<const std::vector<float>> texture_values;  // [np] or null if no surface has a texture
  // How far interiors are shaded along these, in [0, 1] (rendering/picture/body_shading.h): unit vectors, zero if there is no gradient. Only of meshes,
  // without cut_intervals and bricks.
  double body_shading = 0;
  std::shared_ptr<const std::vector<Vec3f>> body_normals;  // [np] or null if nothing is shaded
  Camera camera;
  int width = 800, height = 600;  // 1..16384
  PictureWindow window;           // where it lies in a larger picture; the camera is the larger one's (rendering/picture/pixel_grid.h)
  double unit_distance = 0;       // scalar_opacity_unit_distance in world units; 0: default_unit_distance
  Rgb background{0, 0, 0};
  bool transparent = false;      // leave the background out and keep alpha
  bool float_image = false;      // ask for the float target as it is (EXR, tests), never composited over the background
  bool mean_depth = false;       // of a float_image: fill FloatImage::mean_depth
  bool rounded = false;          // of a float_image: it will be 8 bits, so that it need be no more exact than these, and has no depth
  bool count_fragments = false;  // fill DrawFacts::fragments (costs a little)
};

/// How long one stage of a frame took.
struct StageTime {
  std::string name;
  double ms = 0;
};

/// Facts of a frame, as they are sent to clients and printed by bench.
struct DrawFacts {
  std::string renderer;  // "native", "raster", "compute"
  std::string device;    // "llvmpipe (LLVM 15.0.6, 256 bits), EGL surfaceless"
  std::string order;     // "index distance (exact)", "centroid (approximate)", "none needed"
  bool order_exact = false;
  std::int64_t tetrahedra = 0;  // drawn
  std::int64_t fragments = 0;   // pixels of tetrahedra that were blended, each tetrahedron for itself; 0 if not asked for
  double order_ms = 0, draw_ms = 0, readback_ms = 0;
  std::vector<StageTime> stages;  // of those, as far as the renderer tells; on a GPU by its own clock
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
  /// Whether DrawInput::cut_intervals can be drawn, and DrawInput::bricks. The same as long as it lives.
  virtual bool cuts_intervals() const { return false; }
  virtual bool draws_bricks() const { return cuts_intervals(); }
  /// Whether the mesh of DrawInput::bricks is made where it is drawn: of grids of boxes.
  virtual bool extracts() const { return false; }
};

/// One attempt at a device, for `isostrata doctor`.
struct DeviceAttempt {
  std::string name;  // "EGL device 0 (/dev/dri/renderD128)", "EGL surfaceless", "OSMesa"
  bool ok = false;
  std::string detail;  // the GL renderer and version, or why it failed
  bool software = false;
  std::string device = "";  // as make_renderer takes it: "egl:0", "surfaceless", "osmesa"
};

/// What draws, as it is asked for.
struct RendererChoice {
  std::string renderer = "auto";  // "auto", "native", "raster", "compute"
  std::string device = "auto";    // "auto", "native", "egl:INDEX", "egl:UUID", "surfaceless", "osmesa"
  bool trial = false;             // renderer auto: hold the trial of raster and compute on a software device, too
};

/// native draws on the CPU's cores and needs no device. raster and compute draw with OpenGL on `device`: auto takes the first
/// that works of each EGL device that is hardware, EGL surfaceless, OSMesa. renderer auto: native where the device is "native" or
/// no device is hardware; else the faster of raster and compute in a short trial on that device (renderer_trial.h), held once in
/// a process, and native beside it (choice/quicker_renderer.h) where the device is "auto", too; raster on a named software device. What a device has no
/// room for is drawn by native (choice/device_or_native.h). The renderer must be used and destroyed on the thread that made it. Throws
/// unavailable saying what was tried and why each failed, invalid_argument for words that are none of these.
std::unique_ptr<Renderer> make_renderer(const RendererChoice& choice);
/// All devices, tried in a process of its own, which a driver may end: those of EGL, EGL surfaceless, and OSMesa if EGL gave nothing.
std::vector<DeviceAttempt> probe_devices();
/// How the last trial of this process went, for the log; empty if there was none. Any thread.
std::string renderer_trial_report();

}  // namespace isostrata
