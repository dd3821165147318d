// Arrays of a block out of Zarr.
#pragma once

#include <functional>
#include <string>

#include "import/imported/imported.h"
#include "import/zarr/zarr_array.h"
#include "import/zarr/zarr_chunks.h"
#include "import/zarr/zarr_store.h"

namespace isostrata {

/// Appends to the block an array for each channel of the box, named by its number, by way of files in request.scratch. Throws what read_zarr_box throws, and too_large if a chunk
/// is larger than the request allows.
ZarrCount add_zarr_arrays(ZarrStore& store, const ZarrArray& array, const ZarrBox& box, const ReadRequest& request, const std::function<std::string(std::size_t)>& name, Block& block);

/// What a note says of chunks that are not there; nothing is said if all are.
void note_missing(const ZarrCount& count, std::vector<std::string>& notes);

}  // namespace isostrata
