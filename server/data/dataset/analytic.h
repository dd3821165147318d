// Data without files: scalar fields with known answers, by name wherever a file may stand.
//
//   torus[:N]            N^3 float32 points on [-1,1]^3 (default 256); "distance" is the distance to the circle of radius 0.6
//   about the z axis in
//                        the plane z = 0, so distance = 0.25 is a torus and an interval a hollow ring
//   sphere[:N]           the same points; "distance" to the origin
//   marschner-lobb[:N]   the same points (default 64); "rho" of S. Marschner, R. Lobb, "An Evaluation of Reconstruction Filters
//   for Volume
//                        Rendering", 1994, with their alpha = 0.25 and f = 6
//   cylinder[:NIxNJxNK[xNT]]  flow around a tapered cylinder on a curvilinear O-grid (default 64x64x32, one step); see
//                        cylinder_flow.h
//   implicit-flow[:N]    the same points as torus (default 64); "implicit", "advection_time" and "streamline" of a swirling flow
//                        past a sphere; see implicit_flow.h
//   tets[:N]             N^3 points (default 32) on [-1,1]^3, every cube split into six tetrahedra about its main diagonal
//                        (H. W. Kuhn); "distance" as of torus
//   mixed[:N]            N points along each side (default 17, at least 5) and the middles of some cubes: quarters of hexahedra,
//   wedges,
//                        pyramids and tetrahedra along x, conforming; "distance" as of torus
//
//   diamond[:N]          N^2 points (default 9) of the plane z = 0 on [-1,1]^2: a flat grid; "value" is |x| + |y|, the function of
//                        Figure 1 of P. Bhaniramka and others, "Volume Interval Segmentation and Rendering", 2004
//
// A file whose name looks like one of these is reached with its directory: "./torus".
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string_view>

#include "base/vec.h"
#include "data/dataset/dataset.h"

namespace isostrata {

/// "torus", "sphere" and so on.
std::span<const std::string_view> analytic_names();

/// Whether `name` is one of the names above or one of them with ":...".
bool is_analytic(std::string_view name);

/// Makes it, in parallel. Throws invalid_argument (a size that is not a number, or too small), too_large (above the stated limit or
/// options.max_bytes), not_found (no such step), cancelled. Any thread.
std::shared_ptr<const Dataset> make_analytic(std::string_view name, const OpenOptions& options, const Task& task);

/// The fields themselves.
double torus_distance(Vec3d p);
double sphere_distance(Vec3d p);
double diamond(Vec3d p);
double marschner_lobb(Vec3d p);

}  // namespace isostrata
