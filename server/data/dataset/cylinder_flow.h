// Analytic flow past a tapered cylinder with a shedding wake, in the shape of the tapered-cylinder data that papers on flow
// visualisation use (D. Jespersen, C. Levit, "Numerical Simulation of Flow Past a Tapered Cylinder", 1991). A model with the
// right look, not a solution of the Navier-Stokes equations: the potential flow of a circular cylinder, slowed down in a boundary
// layer, plus two staggered rows of Lamb-Oseen vortices (T. von Karman's street) that travel downstream; the taper makes the
// shedding's phase vary along the span. Density and energy follow the speed isentropically at Mach 0.15, so density stays within
// a few per cent of 1.
//
// Grid: i runs once around (the last point repeats the first), j from the surface outwards to 10 mean radii, k along the span.
#pragma once

#include <cstdint>

#include "data/dataset/dataset.h"

namespace isostrata {

struct CylinderSize {
  std::int64_t around = 64, outward = 64, span = 32;  // points; at least 4, 2 and 2
  std::int64_t steps = 1;                             // twenty of them are one shedding period at mid-span
};

/// What points and arrays take in memory.
std::uint64_t cylinder_bytes(const CylinderSize& size);

/// Fills grid, times and the float32 arrays Density, Momentum (magnitude), Momentum_x, Momentum_y, Momentum_z, Energy.
void fill_cylinder(Dataset& dataset, const CylinderSize& size, std::int64_t step, const Task& task);

}  // namespace isostrata
