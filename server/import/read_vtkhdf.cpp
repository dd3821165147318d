#include <vtkHDFReader.h>
#include <vtkNew.h>

#include "import/read_vtk.h"
#include "import/vtk_pipeline.h"

namespace isostrata {

Imported read_vtkhdf(const ReadRequest& request) {
  vtkNew<vtkHDFReader> reader;
  if (!reader->CanReadFile(request.file.c_str()))
    throw Error(ErrorCode::bad_data, request.file.filename().string() + ": has no group VTKHDF of a version and a type that this VTK reads");
  reader->SetFileName(request.file.c_str());
  return run_reader(reader, request);
}

}  // namespace isostrata
