// Several blocks as one unstructured grid.
#pragma once

#include "import/imported.h"

namespace isostrata {

/// Points are kept as they are, also where blocks share positions; but where all blocks have the very same list of points (as the
/// element blocks of one mesh do) it is kept once, and cells of different blocks meet in common points. Arrays that some block
/// lacks, or has with another number of components, are left out and noted; types that differ become float64. One block is
/// returned as it is.
Block append_blocks(Imported& imported, const ReadRequest& request);

}  // namespace isostrata
