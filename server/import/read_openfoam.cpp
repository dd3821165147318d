#include <vtkNew.h>
#include <vtkPOpenFOAMReader.h>
#include <vtkVersionMacros.h>

#include <string>

#include "data/recognise.h"
#include "import/read_vtk.h"
#include "import/vtk_messages.h"
#include "import/vtk_pipeline.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

/// A case that was run in parallel and not put together has its times in the folders of the processors.
bool decomposed(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder / "processor0", error)) return false;
  if (!fs::is_directory(folder / "constant" / "polyMesh", error)) return true;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name != "0" && name.find_first_not_of("0123456789.e-+") == std::string::npos && entry.is_directory(error)) return false;
  }
  return true;
}

/// We split polyhedra ourselves, in agreement with their neighbours. From VTK 9.6 on the reader never does.
template <class Reader>
void keep_polyhedra(Reader& reader) {
  if constexpr (requires { reader.SetDecomposePolyhedra(0); }) reader.SetDecomposePolyhedra(0);
}

}  // namespace

Imported read_openfoam(const ReadRequest& request) {
  std::error_code error;
  const bool given_folder = fs::is_directory(request.file, error);
  const fs::path folder = given_folder ? request.file : request.file.parent_path();
  const std::string name = request.file.filename().string();
  if (!is_openfoam_case(folder))
    throw Error(ErrorCode::bad_data, name + ": expected an OpenFOAM case around it: system/controlDict and constant/polyMesh");
  vtkNew<vtkPOpenFOAMReader> reader;
  reader->SetFileName((given_folder ? folder / "system" / "controlDict" : request.file).c_str());
  const bool parts = decomposed(folder);
  reader->SetCaseType(parts ? vtkPOpenFOAMReader::DECOMPOSED_CASE : vtkPOpenFOAMReader::RECONSTRUCTED_CASE);
  reader->SetSkipZeroTime(false);
  reader->SetCreateCellToPoint(0);    // cell arrays are averaged as those of any other format
  keep_polyhedra(*reader);
  report_progress(reader, request);
  reader->UpdateInformation();
  throw_on_vtk_error(name);
  int meshes = 0;
  for (int i = 0; i < reader->GetNumberOfPatchArrays(); ++i) {
    const std::string patch = reader->GetPatchArrayName(i);
    const bool mesh = patch == "internalMesh" || patch.ends_with("/internalMesh");
    reader->SetPatchArrayStatus(patch.c_str(), mesh);
    meshes += mesh;
  }
  if (meshes == 0) throw Error(ErrorCode::bad_data, name + ": the case has no internal mesh");
  reader->EnableAllCellArrays();
  reader->EnableAllPointArrays();
  Imported imported = read_step(reader, request);
  if (parts) imported.notes.push_back("read from the folders of the processors");
  return imported;
}

}  // namespace isostrata
