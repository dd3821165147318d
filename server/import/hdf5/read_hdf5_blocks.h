// Blocks of cells of several levels in HDF5, as FLASH and Athena++ write them.
#pragma once

#include <optional>

#include "import/hdf5/hdf5_file.h"
#include "import/imported/imported.h"

namespace isostrata {

/// Nothing if the file is none of FLASH: "bounding box", "node type" and "refine level" beside arrays of all blocks. Blocks that have no children are read.
std::optional<Imported> read_flash(const Hdf5File& file, const ReadRequest& request);

/// Nothing if the file is none of Athena++ (.athdf): "x1f", "x2f", "x3f" and "Levels" beside arrays of all variables and blocks.
std::optional<Imported> read_athena(const Hdf5File& file, const ReadRequest& request);

}  // namespace isostrata
