#include <vtkCompositeDataSet.h>
#include <vtkDataSet.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkPOpenFOAMReader.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "data/files/openfoam_case.h"
#include "data/files/recognise.h"
#include "import/imported/vtk_messages.h"
#include "import/meshes/openfoam_collated.h"
#include "import/meshes/openfoam_originals.h"
#include "import/vtk/read_vtk.h"
#include "import/vtk/vtk_pipeline.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMesh = "internalMesh";

/// We split polyhedra ourselves, in agreement with their neighbours. From VTK 9.6 on the reader never does.
template <class Reader>
void keep_polyhedra(Reader& reader) {
  if constexpr (requires { reader.SetDecomposePolyhedra(0); }) reader.SetDecomposePolyhedra(0);
}

/// Reads the internal meshes of a folder as a case of its own, and their fields. mark: a file or a folder's place in it, by which VTK knows the case.
vtkSmartPointer<vtkPOpenFOAMReader> reader_of(const fs::path& folder, const std::string& mark, const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  auto reader = vtkSmartPointer<vtkPOpenFOAMReader>::New();
  reader->SetFileName(mark.c_str());
  reader->SetCaseType(vtkPOpenFOAMReader::RECONSTRUCTED_CASE);
  reader->SetSkipZeroTime(false);
  reader->SetCreateCellToPoint(0);    // cell arrays are averaged as those of any other format
  reader->SetAddDimensionsToArrayNames(1);
  keep_polyhedra(*reader);
  report_progress(reader, request);
  reader->UpdateInformation();
  throw_on_vtk_error(name);
  std::vector<std::string> meshes;
  for (int i = 0; i < reader->GetNumberOfPatchArrays(); ++i) {
    const std::string patch = reader->GetPatchArrayName(i);
    const bool mesh = patch == kMesh || patch.ends_with(std::string("/") + kMesh);
    reader->SetPatchArrayStatus(patch.c_str(), mesh);
    if (mesh) meshes.push_back(patch);
  }
  if (meshes.size() > 1 && has_fields_in_regions_alone(folder)) reader->SetPatchArrayStatus(kMesh, false);
  if (meshes.empty()) throw Error(ErrorCode::bad_data, name + ": the case has no internal mesh");
  reader->EnableAllCellArrays();
  reader->EnableAllPointArrays();
  return reader;
}

/// "p [m2/s2]", as the reader was told to call them, is p in m2/s2.
void take_units(Block& block) {
  for (FileArray& array : block.arrays)
    if (const auto at = array.name.find(" ["); at != std::string::npos && array.name.ends_with(']')) {
      array.unit = array.name.substr(at + 2, array.name.size() - at - 3);
      array.name.resize(at);
    }
}

/// read_step, whose blocks get the names of the case's regions.
Imported read_meshes(vtkPOpenFOAMReader* reader, const ReadRequest& request) {
  Imported imported = read_step(reader, request);
  for (Block& block : imported.blocks) take_units(block);
  imported.axes = axes_in("m");
  vtkMultiBlockDataSet* regions = reader->GetOutput();
  std::vector<std::string> names;
  for (unsigned i = 0; regions && i < regions->GetNumberOfBlocks(); ++i) {
    auto* region = vtkMultiBlockDataSet::SafeDownCast(regions->GetBlock(i));
    auto* mesh = vtkDataSet::SafeDownCast(region && region->GetNumberOfBlocks() > 0 ? region->GetBlock(0) : nullptr);
    if (mesh && mesh->GetNumberOfPoints() > 0) names.emplace_back(regions->HasMetaData(i) ? regions->GetMetaData(i)->Get(vtkCompositeDataSet::NAME()) : kMesh);
  }
  for (std::size_t i = 0; names.size() == imported.blocks.size() && i < names.size(); ++i) imported.blocks[i].name = names[i];
  return imported;
}

/// Those that all of them have: a run that was stopped may have written its last time in some folders alone.
std::vector<double> common_times(const std::vector<vtkSmartPointer<vtkPOpenFOAMReader>>& readers, const std::string& name) {
  std::vector<double> common = listed_times(readers.front(), name);
  for (const auto& reader : readers) {
    const std::vector<double> own = listed_times(reader, name);
    std::erase_if(common, [&](double time) { return std::find(own.begin(), own.end(), time) == own.end(); });
  }
  return common;
}

/// Each folder is a block of its own, so that points on the border of two processors are joined and the values there are means over the cells of both. VTK would
/// put the parts into one grid with such points twice. `times` may be those of a whole of which the folders have one.
Imported read_parts(const std::vector<fs::path>& folders, const std::vector<vtkSmartPointer<vtkPOpenFOAMReader>>& readers, std::vector<double> times, const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  Imported imported;
  imported.times = std::move(times);
  const double time = imported.times[static_cast<std::size_t>(request.step)];
  for (std::size_t i = 0; i < readers.size(); ++i) {
    const std::vector<double> own = listed_times(readers[i], name);
    ReadRequest part = request;
    part.step = static_cast<int>(std::find(own.begin(), own.end(), time) - own.begin());
    Imported one = read_meshes(readers[i], part);
    for (Block& block : one.blocks) {
      block.name = folders[i].filename().string() + (block.name == kMesh ? "" : "/" + block.name);
      imported.blocks.push_back(std::move(block));
    }
    imported.axes = std::move(one.axes);
    for (const std::string& note : one.notes) add_note(imported.notes, note);
  }
  return imported;
}

std::vector<vtkSmartPointer<vtkPOpenFOAMReader>> readers_of(const std::vector<fs::path>& folders, const ReadRequest& request) {
  std::vector<vtkSmartPointer<vtkPOpenFOAMReader>> readers;
  for (const fs::path& folder : folders) readers.push_back(reader_of(folder, folder / "case.foam", request));
  return readers;
}

Imported read_processors(const std::vector<fs::path>& processors, const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  const auto readers = readers_of(processors, request);
  Imported imported;
  imported.times = common_times(readers, name);
  if (imported.times.empty()) throw Error(ErrorCode::bad_data, name + ": its folders processor0 to processor" + std::to_string(readers.size() - 1) + " have no time in common");
  check_step(request, imported.times.size());
  if (request.times_only) return imported;
  imported = read_parts(processors, readers, imported.times, request);
  imported.notes.push_back("read from the folders of the processors");
  return imported;
}

Imported read_collated(const std::vector<fs::path>& folders, const ReadRequest& request) {
  const CollatedCase collated = collated_case(folders, request.file.filename().string());
  Imported imported;
  imported.times = collated.times;
  check_step(request, imported.times.size());
  if (request.times_only) return imported;
  const TakenApart processors(collated, request);
  imported = read_parts(processors.folders(), readers_of(processors.folders(), request), imported.times, request);
  imported.notes.push_back("read from the files of " + std::to_string(processors.folders().size()) + " processors in " + collated.folders.front().filename().string() + (collated.folders.size() > 1 ? " and others" : ""));
  return imported;
}

}  // namespace

Imported read_openfoam(const ReadRequest& request) {
  std::error_code error;
  const bool given_folder = fs::is_directory(request.file, error);
  const fs::path folder = given_folder ? request.file : request.file.parent_path();
  if (!is_openfoam_case(folder))
    throw Error(ErrorCode::bad_data, request.file.filename().string() + ": expected an OpenFOAM case around it: system/controlDict and constant/polyMesh");
  if (const std::vector<fs::path> parts = openfoam_parts(folder); !parts.empty())  // it was run in parallel
    return is_collated_name(parts.front().filename().string()) ? read_collated(parts, request) : read_processors(parts, request);
  const fs::path read = case_without_originals(folder, request);
  Imported imported = read_meshes(reader_of(read, given_folder || read != folder ? read / "system" / "controlDict" : request.file, request), request);
  remove_links_without_originals(request);
  return imported;
}

}  // namespace isostrata
