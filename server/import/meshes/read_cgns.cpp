#include <vtkCGNSReader.h>
#include <vtkNew.h>

#include "import/imported/vtk_messages.h"
#include "import/vtk/read_vtk.h"
#include "import/vtk/vtk_pipeline.h"

namespace isostrata {

Imported read_cgns(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  vtkNew<vtkCGNSReader> reader;
  if (!reader->CanReadFile(request.file.c_str())) throw Error(ErrorCode::bad_data, name + ": is not a CGNS file");
  reader->SetFileName(request.file.c_str());
  report_progress(reader, request);
  reader->UpdateInformation();
  throw_on_vtk_error(name);
  reader->EnableAllBases();
  for (int i = 0; i < reader->GetNumberOfPointArrays(); ++i) reader->SetPointArrayStatus(reader->GetPointArrayName(i), 1);
  for (int i = 0; i < reader->GetNumberOfCellArrays(); ++i) reader->SetCellArrayStatus(reader->GetCellArrayName(i), 1);
  reader->UpdateInformation();
  return read_step(reader, request);
}

}  // namespace isostrata
