// Files that VTK 9.1's readers read.
#pragma once

#include <string>

#include "import/imported.h"

namespace isostrata {

/// Legacy .vtk of any grid kind, ASCII or binary.
Imported read_vtk_legacy(const ReadRequest& request);

/// type: the VTKFile element's. A parallel file's pieces must lie below its own directory.
Imported read_vtk_xml(const ReadRequest& request, const std::string& type);

/// A list of time steps; each entry is a file below the .pvd's directory, read by its own kind. Several parts of one time become
/// blocks.
Imported read_pvd(const ReadRequest& request);

/// Exodus II: all element blocks, nodal and element arrays, undisplaced.
Imported read_exodus(const ReadRequest& request);

/// MetaImage; the data file must lie below the header's directory.
Imported read_meta_image(const ReadRequest& request);

/// SLC volumes.
Imported read_slc(const ReadRequest& request);

}  // namespace isostrata
