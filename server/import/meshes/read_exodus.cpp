#include <vtkDataObject.h>
#include <vtkExodusIIReader.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#if __has_include(<vtkExodusIIReaderPrivate.h>)
#include <vtkExodusIIReaderPrivate.h>
#endif

#include "import/bytes/mapped_file.h"
#include "import/imported/vtk_messages.h"
#include "import/netcdf/check_netcdf.h"
#ifdef ISOSTRATA_READS_NETCDF
#include "import/netcdf/netcdf_file.h"
#endif
#include "import/vtk/read_vtk.h"
#include "import/vtk/vtk_blocks.h"

namespace isostrata {
namespace {

constexpr int kBlocks = vtkExodusIIReader::ELEM_BLOCK;

#if __has_include(<vtkExodusIIReaderPrivate.h>)
/// VTK knows what a file calls the elements of a block ("HEX8"), and keeps it to itself.
struct Blocks : vtkExodusIIReaderPrivate {
  static std::string element_type(vtkExodusIIReaderPrivate* of, int block) {
    return static_cast<BlockInfoType*>((of->*&Blocks::GetSortedObjectInfo)(kBlocks, block))->TypeName;
  }
};
class ExodusReader : public vtkExodusIIReader {
 public:
  static ExodusReader* New();
  vtkTypeMacro(ExodusReader, vtkExodusIIReader);
  std::string element_type(int block) { return Blocks::element_type(GetMetadata(), block); }
};
vtkStandardNewMacro(ExodusReader);
#else
using ExodusReader = vtkExodusIIReader;
#endif

/// Turns off blocks of elements that VTK does not know: it would take them for cells of another kind. It has complained of
/// each of their types.
void pass_over_unknown(ExodusReader& reader, const std::string& name, std::vector<std::string>& notes) {
  const std::vector<std::string> unknown = take_vtk_errors("Unsupported element type: ");
  int known_blocks = reader.GetNumberOfObjects(kBlocks);
#if __has_include(<vtkExodusIIReaderPrivate.h>)
  for (int i = 0; !unknown.empty() && i < reader.GetNumberOfObjects(kBlocks); ++i) {
    const std::string type = reader.element_type(i);
    if (std::find(unknown.begin(), unknown.end(), type) == unknown.end()) continue;
    reader.SetObjectStatus(kBlocks, i, 0);
    --known_blocks;
    notes.push_back(std::to_string(reader.GetNumberOfEntriesInObject(kBlocks, i)) + " elements of type '" + type +
                    "' skipped: only tetrahedra, pyramids, wedges and hexahedra are read");
  }
  if (!unknown.empty() && known_blocks == 0)
    throw Error(ErrorCode::unsupported, name + ": has no elements but of type '" + unknown.front() +
                                            "'; expected tetrahedra, pyramids, wedges or hexahedra (TETRA, PYRAMID, WEDGE, HEX)");
#else
  if (!unknown.empty()) throw Error(ErrorCode::unsupported, name + ": has elements of type '" + unknown.front() + "', which VTK does not know");
#endif
  throw_on_vtk_error(name);
}

/// The library of VTK looks for arrays on nodes by what an attribute says of the file, and if they are elsewhere tells of it in a way that VTK does not hear: what VTK
/// gives is then what was in its memory. meshio writes such files.
void check_places_of_arrays(const std::string& name, const std::filesystem::path& file) {
#ifdef ISOSTRATA_READS_NETCDF
  const NetcdfFile of(file);
  const std::vector<double> said = of.numbers(NC_GLOBAL, "file_size");
  const bool large = !said.empty() && said.front() != 0;
  if (!large && of.variable("vals_nod_var1") && !of.variable("vals_nod_var"))
    throw Error(ErrorCode::unsupported, name + ": its arrays on nodes lie as in files whose attribute 'file_size' is 1, and it has none; save it as .vtu or VTKHDF (meshio convert)");
#else
  static_cast<void>(name), static_cast<void>(file);
#endif
}

}  // namespace

Imported read_exodus(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_netcdf_classic(MappedFile(request.file).bytes(), name);
  vtkNew<ExodusReader> reader;
  if (!reader->CanReadFile(request.file.c_str())) throw Error(ErrorCode::bad_data, name + ": is not an Exodus II file");
  check_places_of_arrays(name, request.file);
  reader->SetFileName(request.file.c_str());
  reader->SetApplyDisplacements(0);  // the points as they are; displacements are an array like any other
  reader->SetGenerateObjectIdCellArray(0);
  reader->SetSqueezePoints(false);  // every element block over all of the file's points, so that blocks meet in common ones
  reader->UpdateInformation();
  if (!take_vtk_errors("Could not read block params").empty())
    throw Error(ErrorCode::bad_data, name + ": the Exodus library of VTK cannot read the sizes of one of its blocks of edges, faces or elements; write it anew without blocks of edges and faces");
  Imported imported;
  const int blocks = reader->GetNumberOfObjects(kBlocks);
  for (int i = 0; i < blocks; ++i) reader->SetObjectStatus(kBlocks, i, 1);
  pass_over_unknown(*reader, name, imported.notes);
  if (blocks == 0)
    throw Error(ErrorCode::bad_data, name + ": has no element blocks; expected at least one with tetrahedra, pyramids, wedges or hexahedra");

  // A mesh alone has no time steps, and values only at those. VTK must then not be asked for a time.
  vtkInformation* information = reader->GetOutputInformation(0);
  const auto key = vtkStreamingDemandDrivenPipeline::TIME_STEPS();
  const int count = information && information->Has(key) ? information->Length(key) : 0;
  if (count > 0) imported.times.assign(information->Get(key), information->Get(key) + count);
  check_step(request, imported.times.size());
  if (request.times_only) return imported;
  int without_values = 0;
  for (const int type : {static_cast<int>(vtkExodusIIReader::NODAL), kBlocks})
    for (int i = 0; i < reader->GetNumberOfObjectArrays(type); ++i) {
      reader->SetObjectArrayStatus(type, i, count > 0);
      without_values += count == 0;
    }
  if (without_values > 0)
    imported.notes.push_back(std::to_string(without_values) + " arrays skipped: the file has no time steps, so they have no values");
  request.progress(0.1);
  if (count > 0)
    reader->UpdateTimeStep(imported.times[static_cast<std::size_t>(request.step)]);
  else
    reader->Update();
  throw_on_vtk_error(name);

  append_vtk_blocks(reader->GetOutputDataObject(0), request, false, imported.blocks, imported.notes);
  for (const std::string& warning : vtk_warnings()) imported.notes.push_back("reader: " + warning);
  return imported;
}

}  // namespace isostrata
