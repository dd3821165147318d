// NRRD volumes: .nrrd, and .nhdr with detached data below its own directory.
#pragma once

#include "import/imported/imported.h"

namespace isostrata {

/// One array, "scalars" (its components where the file has vector, colour or list axes). Axes of space become x, y, z in the
/// file's order; a time axis becomes time steps. Space directions along x, y, z give a uniform grid, others a curvilinear one;
/// the file's own space is kept. Throws not_found (detached data, step), bad_data, unsupported, too_large.
Imported read_nrrd(const ReadRequest& request);

}  // namespace isostrata
