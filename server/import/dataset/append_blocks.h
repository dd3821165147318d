// Several blocks as one unstructured grid.
#pragma once

#include "import/imported/imported.h"

namespace isostrata {

/// Points that different blocks share are one point each (join_pieces.h); where all blocks have the very same list of points (as
/// the element blocks of one mesh do) it is kept once. Arrays that some block
/// lacks (of cells: one that has cells), or has with another number of components, are left out and noted; types that differ become float64. Of several
/// blocks, ghost cells (kGhostCell) are left out: another one has them. One block is returned as it is.
Block append_blocks(Imported& imported, const ReadRequest& request);

}  // namespace isostrata
