#include "import/vtk/vtk_pipeline.h"

#include <vtkAlgorithm.h>
#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkDataObject.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkXMLPDataReader.h>

#include <algorithm>
#include <cmath>

#include "import/imported/vtk_messages.h"
#include "import/vtk/vtk_blocks.h"

namespace isostrata {
namespace {

/// Points that the header declares, before memory is asked for.
void check_declared_extent(vtkAlgorithm* reader, const ReadRequest& request, const std::string& name) {
  vtkInformation* information = reader->GetOutputInformation(0);
  if (!information || !information->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT())) return;
  int e[6];
  information->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), e);
  const auto size = [&](int a) { return static_cast<std::int64_t>(e[2 * a + 1]) - e[2 * a] + 1; };
  for (int a = 0; a < 3; ++a)
    if (size(a) < 1)
      throw Error(ErrorCode::bad_data, name + ": an extent of " + std::to_string(size(a)) + " points; expected at least 1");
  const std::int64_t points = checked_product({size(0), size(1), size(2)}, name);
  check_bytes(request, static_cast<std::uint64_t>(points), name + ": " + std::to_string(points) + " points declared");
}

}  // namespace

std::vector<double> declared_times(vtkDataObject* object) {
  if (object && object->GetFieldData())
    for (const char* name : {"TimeValue", "TIME"})
      if (vtkDataArray* time = object->GetFieldData()->GetArray(name))
        if (time->GetNumberOfTuples() == 1 && std::isfinite(time->GetComponent(0, 0))) return {time->GetComponent(0, 0)};
  return {0.0};
}

void report_progress(vtkAlgorithm* reader, const ReadRequest& request) {
  vtkNew<vtkCallbackCommand> command;
  command->SetClientData(const_cast<ReadRequest*>(&request));
  command->SetCallback([](vtkObject* caller, unsigned long, void* client, void*) {
    static_cast<const ReadRequest*>(client)->progress(static_cast<vtkAlgorithm*>(caller)->GetProgress());
  });
  reader->AddObserver(vtkCommand::ProgressEvent, command);
}

std::vector<double> listed_times(vtkAlgorithm* reader, const std::string& name) {
  vtkInformation* information = reader->GetOutputInformation(0);
  const auto key = vtkStreamingDemandDrivenPipeline::TIME_STEPS();
  const int count = information && information->Has(key) ? information->Length(key) : 0;
  if (count <= 0) return {};
  const double* times = information->Get(key);
  std::vector<double> out(times, times + count);
  if (!std::all_of(out.begin(), out.end(), [](double time) { return std::isfinite(time); }))
    throw Error(ErrorCode::bad_data, name + ": a time is not a finite number");
  return out;
}

Imported read_step(vtkAlgorithm* reader, const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  throw_on_vtk_error(name);
  check_declared_extent(reader, request, name);
  const std::vector<double> listed = listed_times(reader, name);
  check_step(request, std::max<std::size_t>(listed.size(), 1));
  if (request.times_only) {
    Imported times;
    if (!listed.empty()) times.times = listed;
    return times;
  }
  if (listed.empty())
    reader->Update();
  else
    reader->UpdateTimeStep(listed[static_cast<std::size_t>(request.step)]);
  throw_on_vtk_error(name);
  if (reader->GetErrorCode() != 0)
    throw Error(ErrorCode::bad_data, name + ": VTK's reader reported error " + std::to_string(reader->GetErrorCode()));
  Imported imported;
  vtkDataObject* object = reader->GetOutputDataObject(0);
  const bool joined_pieces = vtkXMLPDataReader::SafeDownCast(reader) != nullptr;
  append_vtk_blocks(object, request, joined_pieces, imported.blocks, imported.notes);
  imported.times = listed.empty() ? declared_times(object) : listed;
  for (const std::string& warning : vtk_warnings()) imported.notes.push_back("reader: " + warning);
  return imported;
}

Imported run_reader(vtkAlgorithm* reader, const ReadRequest& request) {
  report_progress(reader, request);
  reader->UpdateInformation();
  return read_step(reader, request);
}

}  // namespace isostrata
