#include <vtkGenericEnSightReader.h>
#include <vtkNew.h>

#include <fstream>
#include <sstream>

#include "import/read_vtk.h"
#include "import/vtk_messages.h"
#include "import/vtk_pipeline.h"

namespace isostrata {
namespace {

/// A case names its files, with * where the number of a step stands: none may lie elsewhere.
void check_names(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  std::ifstream in(request.file);
  std::string line;
  bool format = false;
  for (int lines = 0; std::getline(in, line); ++lines) {
    if (lines > 1'000'000) throw Error(ErrorCode::too_large, name + ": above a million lines; a case is not that long");
    if (line.starts_with("#")) continue;
    if (line.starts_with("FORMAT")) format = true;
    const auto colon = line.find(':');
    if (colon == std::string::npos || line.starts_with("time")) continue;
    std::istringstream words(line.substr(colon + 1));
    for (std::string word; words >> word;) check_name_below(request.file, word);
  }
  if (!format) throw Error(ErrorCode::bad_data, name + ": expected a line FORMAT, as EnSight's cases have");
}

}  // namespace

Imported read_ensight(const ReadRequest& request) {
  check_names(request);
  vtkNew<vtkGenericEnSightReader> reader;
  reader->SetCaseFileName(request.file.c_str());
  reader->ReadAllVariablesOn();
  return run_reader(reader, request);
}

}  // namespace isostrata
