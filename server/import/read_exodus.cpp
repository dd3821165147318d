#include <vtkDataObject.h>
#include <vtkExodusIIReader.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include "import/read_vtk.h"
#include "import/vtk_blocks.h"
#include "import/vtk_messages.h"

namespace isostrata {

Imported read_exodus(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  vtkNew<vtkExodusIIReader> reader;
  if (!reader->CanReadFile(request.file.c_str())) throw Error(ErrorCode::bad_data, name + ": is not an Exodus II file");
  reader->SetFileName(request.file.c_str());
  reader->SetApplyDisplacements(0);  // the points as they are; displacements are an array like any other
  reader->SetGenerateObjectIdCellArray(0);
  reader->SetSqueezePoints(false);  // every element block over all of the file's points, so that blocks meet in common ones
  reader->UpdateInformation();
  throw_on_vtk_error(name);
  for (const int type : {vtkExodusIIReader::NODAL, vtkExodusIIReader::ELEM_BLOCK})
    for (int i = 0; i < reader->GetNumberOfObjectArrays(type); ++i) reader->SetObjectArrayStatus(type, i, 1);
  for (int i = 0; i < reader->GetNumberOfObjects(vtkExodusIIReader::ELEM_BLOCK); ++i)
    reader->SetObjectStatus(vtkExodusIIReader::ELEM_BLOCK, i, 1);

  std::vector<double> times{0.0};
  vtkInformation* information = reader->GetOutputInformation(0);
  if (information && information->Has(vtkStreamingDemandDrivenPipeline::TIME_STEPS())) {
    const int count = information->Length(vtkStreamingDemandDrivenPipeline::TIME_STEPS());
    const double* steps = information->Get(vtkStreamingDemandDrivenPipeline::TIME_STEPS());
    if (count > 0) times.assign(steps, steps + count);
  }
  check_step(request, times.size());
  request.progress(0.1);
  reader->UpdateTimeStep(times[static_cast<std::size_t>(request.step)]);
  throw_on_vtk_error(name);

  Imported imported;
  append_vtk_blocks(reader->GetOutputDataObject(0), request, false, imported.blocks, imported.notes);
  imported.times = std::move(times);
  for (const std::string& warning : vtk_warnings()) imported.notes.push_back("reader: " + warning);
  return imported;
}

}  // namespace isostrata
