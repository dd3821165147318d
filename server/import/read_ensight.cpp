#include <vtkGenericEnSightReader.h>
#include <vtkNew.h>

#include "import/check_ensight.h"
#include "import/read_vtk.h"
#include "import/vtk_pipeline.h"

namespace isostrata {

Imported read_ensight(const ReadRequest& request) {
  check_ensight_case(request.file);
  vtkNew<vtkGenericEnSightReader> reader;
  reader->SetCaseFileName(request.file.c_str());
  reader->ReadAllVariablesOn();
  return run_reader(reader, request);
}

}  // namespace isostrata
