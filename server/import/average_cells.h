// Cell arrays as point arrays.
#pragma once

#include "import/imported.h"

namespace isostrata {

/// Each point gets the mean over the cells of the file that use it, from both sides of a seam, and are not hidden, NaN where there
/// is none. float32 stays
/// float32 and integers of up to 16 bits become it; everything else becomes float64. on_cells stays set, as the mark of where the
/// values come from.
FileArray average_cells(const Block& block, const FileArray& array);

}  // namespace isostrata
