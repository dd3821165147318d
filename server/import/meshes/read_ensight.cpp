#include <vtkGenericEnSightReader.h>
#include <vtkNew.h>

#include <filesystem>
#include <string>

#include "import/imported/vtk_messages.h"
#include "import/meshes/check_ensight.h"
#include "import/meshes/ensight_quotes.h"
#include "import/vtk/read_vtk.h"
#include "import/vtk/vtk_pipeline.h"

namespace isostrata {

Imported read_ensight(const ReadRequest& request) {
  const std::filesystem::path file = case_for_reader(request);
  check_ensight_case(request.file);
  vtkNew<vtkGenericEnSightReader> reader;
  reader->SetCaseFileName(file.c_str());
  reader->ReadAllVariablesOn();
  for (const char* section : {"MATERIAL", "SCRIPTS", "BLOCK_CONTINUATION"})  // where the reader stops, it has read all that it wants
    pass_over_vtk_errors(std::string("invalid VARIABLE line: ") + section);
  Imported imported = run_reader(reader, request);
  remove_links(request);
  return imported;
}

}  // namespace isostrata
