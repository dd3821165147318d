// Compiled as C++17: VTK 9.1's vtkSMPTools.h is not valid C++20 (a constructor declared by the template's name with arguments).
#include "vtk_threads.h"

#include <vtkSMPTools.h>
#include <vtkVersion.h>

namespace isostrata::peers {

std::string prepare_vtk(int threads) {
  vtkSMPTools::SetBackend("TBB");  // if there is none, the back end stays as it is
  vtkSMPTools::Initialize(threads);
  return std::string("VTK ") + vtkVersion::GetVTKVersion() + ", " + vtkSMPTools::GetBackend() + ", " +
         std::to_string(vtkSMPTools::GetEstimatedNumberOfThreads()) + " threads";
}

}  // namespace isostrata::peers
