// How many threads VTK may use.
#pragma once

#include <string>

namespace isostrata::peers {

/// Sets the threads that vtkSMPTools may use, on its oneTBB back end if it was built with one. Returns what it will use, for
/// the report: "VTK 9.1.0, TBB, 2 threads".
std::string prepare_vtk(int threads);

}  // namespace isostrata::peers
