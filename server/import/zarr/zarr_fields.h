// A group of Zarr whose arrays have named axes, as xarray writes it: variables by the conventions of climate and forecast.
//
// "Zarr encoding specification", docs.xarray.dev: the attribute _ARRAY_DIMENSIONS in version 2, dimension_names in version 3.
#pragma once

#include <optional>

#include "import/imported/imported.h"
#include "import/zarr/zarr_store.h"

namespace isostrata {

/// The variables over the most axes of space, at a step along their axis of time, placed by the arrays of one axis that have its name. Nothing if no array of the group names its axes, or none is
/// over two or three axes of space.
std::optional<Imported> read_zarr_fields(ZarrStore& store, const ReadRequest& request);

}  // namespace isostrata
