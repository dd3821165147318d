// Files that VTK's readers read.
#pragma once

#include <string>

#include "import/imported/imported.h"

namespace isostrata {

/// Legacy .vtk of any grid kind, ASCII or binary.
Imported read_vtk_legacy(const ReadRequest& request);

/// type: the VTKFile element's. A parallel file's pieces must lie below its own directory.
Imported read_vtk_xml(const ReadRequest& request, const std::string& type);

/// Exodus II: all element blocks, nodal and element arrays, undisplaced.
Imported read_exodus(const ReadRequest& request);

/// MetaImage; the data file must lie below the header's directory.
Imported read_meta_image(const ReadRequest& request);

/// SLC volumes.
Imported read_slc(const ReadRequest& request);

/// NIfTI, placed by its sform or qform.
Imported read_nifti(const ReadRequest& request);

// Of modules that a VTK may lack: this build has those whose files CMake found (CMakeLists.txt).

/// A case: a mark "x.foam" in its folder, or the folder itself. Internal meshes alone.
Imported read_openfoam(const ReadRequest& request);

/// EnSight Gold or 6, by its case file. The files that it names must lie below the case's directory.
Imported read_ensight(const ReadRequest& request);

/// CGNS: all bases and zones.
Imported read_cgns(const ReadRequest& request);

/// netCDF with CF conventions: the variables over the dimensions that most variables of the most axes have.
Imported read_netcdf(const ReadRequest& request);

/// VTKHDF as this VTK knows it: image data and unstructured grids in 9.1.
Imported read_vtkhdf(const ReadRequest& request);

}  // namespace isostrata
