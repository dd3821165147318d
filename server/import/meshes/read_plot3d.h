// PLOT3D: a grid file, its solution file beside it, and its function file if there is one.
#pragma once

#include "import/imported/imported.h"

namespace isostrata {

/// request.file is the grid (NAMExyz.EXT, NAME.xyz, .x, .g, .p3d, ...), whose solution is looked for under the same name with q;
/// or the solution
/// (.q, NAMEq.EXT), whose grid is looked for. Arrays are named as VTK names them: Density, Momentum, StagnationEnergy, IBlank;
/// OVERFLOW's Gamma, Species Density N and Turb Field Quantity N; Function N of a function file. Cells that use a point with
/// IBLANK 0 are hidden. Throws not_found naming what was looked for, bad_data, too_large.
Imported read_plot3d(const ReadRequest& request);

}  // namespace isostrata
