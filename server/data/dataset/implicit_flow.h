// A steady flow as *implicit* data: stream surfaces are isosurfaces.
//
// Source: J. J. van Wijk, "Implicit Stream Surfaces", 1993: a function that is constant along streamlines is made by following
// each grid point backwards to where its streamline comes in and taking a function of that place; its isosurfaces are stream
// surfaces. D. Xue, C. Zhang, R. Crawfis, "Rendering Implicit Flow Volumes", 2004, keep the time that it takes, too, and so does
// section 4.1.4 of the paper: an interval of either is a flow volume, of both a piece of one.
//
// The flow, on [-1,1]^3, lengths in halves of the box: along x past a sphere of radius a = 0.3 at (-0.25, 0, 0), turning about
// that axis. The streamlines are those of the potential flow past a sphere (G. G. Stokes' stream function psi = r^2/2 (1 -
// a^3/R^3), r the distance from the axis, R from the sphere's middle) with an angular momentum r u_phi = 2 w psi, constant along
// each: undisturbed, the fluid turns like a rigid body, by w = 3 radians per unit of length. All of the velocity is multiplied by
// 0.4 + 0.6 / (1 + psi / 0.06), fast near the axis and slow outside, which changes no streamline and makes fronts of equal time
// bulge. It is steady, free of divergence, and outside the sphere always on its way along +x. What it does to the pressure is
// left out: a model, no solution of Euler's equations.
//
// Arrays, float32. NaN inside the sphere, and where the streamline takes longer than kLongest (just behind the sphere on the
// axis, where it never arrives).
//   implicit        the distance, on the inlet plane x = -1, of the place where the streamline crosses it from (y, z) =
//                   (0, 0.32): an isosurface is a stream tube that begins as a circle
//   advection_time  how long the fluid was on its way from there
//   streamline      the angle there about that point, from the z axis, as (1 - cos(angle)) / 2: constant along streamlines,
//   without
//                   a seam or a fold, and so a texture coordinate that draws them on a stream tube. NaN on the seed's own
//                   streamline
// The inlet is the whole plane: a streamline that comes in through a side of the box is followed on to the plane, so that the
// functions are smooth within the box.
#pragma once

#include <cstdint>

#include "base/vec.h"
#include "data/dataset/dataset.h"

namespace isostrata {

inline constexpr double kFlowStep = 0.02;   // of time, of the classical fourth-order Runge-Kutta method; the last one is cut
inline constexpr double kFlowLongest = 16;  // a stream at the axis' speed passes the box in 2, one at the edge in less than 5

Vec3d implicit_flow_velocity(Vec3d p);

/// Where and how long ago what is at a point crossed the inlet plane.
struct InletCrossing {
  bool found = false;
  double y = 0, z = 0;
  double time = 0;
};

/// Follows the flow backwards. Deterministic.
InletCrossing trace_to_inlet(Vec3d p);

/// What the arrays take in memory.
std::uint64_t implicit_flow_bytes(std::int64_t n);

/// n^3 points and the three arrays. Parallel.
void fill_implicit_flow(Dataset& dataset, std::int64_t n, const Task& task);

}  // namespace isostrata
