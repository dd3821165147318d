// Projected tetrahedra: each tetrahedron becomes one or two triangles on the screen.
//
// Source: P. Shirley, A. Tuchman, "A Polygonal Approximation to Direct Scalar Volume Rendering", 1990: the silhouette of a
// projected tetrahedron is a triangle (class 1: one vertex projects into the other three) or a quadrilateral (class 2), and the
// ray is longest at the *thick vertex*, where that vertex lies or where the two diagonals cross; the degenerate classes 3 and 4
// are the limits of these two. They draw the fan of three or four triangles around the thick vertex and interpolate the
// thickness.
//
// What is different here. Inverse depth q = 1/z is linear on the screen over every plane, so the difference d of the inverse
// depths of entry and exit is linear over each triangle of the fan, 0 on the silhouette and D at the thick vertex: a tent, which
// is concave and therefore the least of the linear functions of its sides. So the fan need not be drawn. The tetrahedron's own
// face below the tent (class 1), or the two faces that meet in the nearer diagonal (class 2), are drawn with those linear
// functions as three numbers per vertex, and the fragment takes their least. That is 1.5 triangles instead of 3.5, and the ray's
// length d / (q (q -+ d)) * |ray| is exact in perspective, where interpolated thickness is not. Where rays are parallel depth
// itself is linear, and q is a constant less the depth: *nearness* stands for either.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "extraction/mesh/interval_mesh.h"
#include "rendering/picture/renderer.h"
#include "rendering/raster/surface_facets.h"
#include "scene/camera.h"

namespace isostrata {

/// How the world reaches the screen. Lengths are divided by `scale` first, so that the arithmetic does not depend on the data's
/// units.
struct Projection {
  Mat4d view_from_world;
  double scale = 1;          // world units
  double focal = 1;          // pixels; orthographic: pixels for a length of 1
  double near_depth = 1e-4;  // in units of scale; what is nearer to the eye is cut off
  bool orthographic = false;
  double base = 0;                // orthographic: nearness is base - depth, and above 0 in the bounds
  double axis_x = 0, axis_y = 0;  // where the axis of view meets the picture: pixels right of and above its middle
  int width = 1, height = 1;

  double nearness(double depth) const { return orthographic ? base - depth : 1 / depth; }
  /// In units of scale.
  double depth(double nearness) const { return orthographic ? base - nearness : 1 / nearness; }
  int guard() const;  // pixels from the middle of the picture; what reaches beyond is clipped there
};

/// Of the farthest and the nearest vertex of a tetrahedron, in perspective; beyond it the difference of two inverse depths loses
/// the digits by which they differ in size, and the tetrahedron is treated apart.
inline constexpr double kLargestDepthRatio = 8;

Projection make_projection(const Camera& camera, const Box3d& bounds, int width, int height);
/// For the part of a picture that the input asks for.
Projection make_projection(const DrawInput& input);

/// A point of the mesh on the screen.
struct ScreenPoint {
  double x = 0, y = 0;        // pixels right of and above the middle of the picture
  double q = 0;               // nearness; 0 if the point is nearer than near_depth
  std::uint32_t outside = 0;  // bits: near, left, right, below, above the picture; kBeyondGuard
};
inline constexpr std::uint32_t kTooNear = 1, kLeft = 2, kRight = 4, kBelow = 8, kAbove = 16, kBeyondGuard = 32;

/// All points of the mesh. Parallel.
std::vector<ScreenPoint> project_points(const IntervalMesh& mesh, const Projection& projection);

/// What crosses to the vertex shader (shaders/layout.h has the attributes).
struct ConstantVertex {
  float x, y, q;
  float tent[3];
  float q_min;  // the least nearness of the tetrahedron: bounds the ray's length however thin the sliver
  std::uint32_t style_kind;
};
struct LinearVertex : ConstantVertex {
  float scalar_q, slope;
};
/// Of bodies that are shaded (picture/body_shading.h), whatever their colours.
struct ShadedVertex : LinearVertex {
  float shade_q, shade_slope;
};
static_assert(sizeof(ShadedVertex) == 4 * SHADED_VERTEX_WORDS);
static_assert(sizeof(ConstantVertex) == 4 * VERTEX_WORDS && sizeof(LinearVertex) == 4 * LINEAR_VERTEX_WORDS);

struct TetrahedraSource {
  const IntervalMesh* mesh = nullptr;
  const std::vector<float>* color_values = nullptr;  // [np], for LinearVertex; of a ShadedVertex null if all colours are constant
  std::span<const ScreenPoint> points;               // [np]
  const Projection* projection = nullptr;
  const SurfaceFacets* facets = nullptr;   // null: none is drawn
  std::span<const std::uint32_t> parts{};  // [intervals] drawn_parts(); empty: the volume of all
  std::span<const float> shades{};         // [np], for ShadedVertex
};

/// Appends the triangles of these tetrahedra, in this order: three or six vertices each, none for those that cover no pixel
/// centre, more for those that must be clipped. A tetrahedron's facets that are drawn come with it, those behind it before it
/// and those in front after it. Any thread.
void emit_tetrahedra(const TetrahedraSource& source, std::span<const std::uint32_t> tetrahedra, std::vector<ConstantVertex>& out);
void emit_tetrahedra(const TetrahedraSource& source, std::span<const std::uint32_t> tetrahedra, std::vector<LinearVertex>& out);
void emit_tetrahedra(const TetrahedraSource& source, std::span<const std::uint32_t> tetrahedra, std::vector<ShadedVertex>& out);

}  // namespace isostrata
