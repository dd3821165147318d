#include "import/read_vtk.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkDataObject.h>
#include <vtkDataReader.h>
#include <vtkFieldData.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkInformation.h>
#include <vtkMetaImageReader.h>
#include <vtkNew.h>
#include <vtkRectilinearGridReader.h>
#include <vtkSLCReader.h>
#include <vtkSmartPointer.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkStructuredGridReader.h>
#include <vtkStructuredPointsReader.h>
#include <vtkUnstructuredGridReader.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLPDataReader.h>
#include <vtkXMLPImageDataReader.h>
#include <vtkXMLPRectilinearGridReader.h>
#include <vtkXMLPStructuredGridReader.h>
#include <vtkXMLPUnstructuredGridReader.h>
#include <vtkXMLRectilinearGridReader.h>
#include <vtkXMLStructuredGridReader.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUtilities.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

#include "import/check_legacy_cells.h"
#include "import/mapped_file.h"
#include "import/vtk_blocks.h"
#include "import/vtk_messages.h"

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

/// The time that a file says it has, as ParaView and VTK write it.
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

Imported finish(vtkAlgorithm* reader, const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  throw_on_vtk_error(name);
  if (reader->GetErrorCode() != 0)
    throw Error(ErrorCode::bad_data, name + ": VTK's reader reported error " + std::to_string(reader->GetErrorCode()));
  Imported imported;
  vtkDataObject* object = reader->GetOutputDataObject(0);
  const bool joined_pieces = vtkXMLPDataReader::SafeDownCast(reader) != nullptr;
  append_vtk_blocks(object, request, joined_pieces, imported.blocks, imported.notes);
  imported.times = declared_times(object);
  for (const std::string& warning : vtk_warnings()) imported.notes.push_back("reader: " + warning);
  return imported;
}

Imported run(vtkAlgorithm* reader, const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_step(request, 1);
  report_progress(reader, request);
  reader->UpdateInformation();
  throw_on_vtk_error(name);
  check_declared_extent(reader, request, name);
  reader->Update();
  return finish(reader, request);
}

template <class Reader>
Imported run_named(const ReadRequest& request) {
  vtkNew<Reader> reader;
  reader->SetFileName(request.file.c_str());
  return run(reader, request);
}

template <class Reader>
Imported run_legacy(const ReadRequest& request) {
  vtkNew<Reader> reader;
  reader->SetFileName(request.file.c_str());
  reader->ReadAllScalarsOn();
  reader->ReadAllVectorsOn();
  reader->ReadAllNormalsOn();
  reader->ReadAllTensorsOn();
  reader->ReadAllColorScalarsOn();
  reader->ReadAllTCoordsOn();
  reader->ReadAllFieldsOn();
  return run(reader, request);
}

/// Every piece of a parallel file must be a file below its directory.
void check_pieces(vtkXMLDataElement* element, const ReadRequest& request) {
  if (!element) return;
  if (const char* source = element->GetAttribute("Source")) referred_file(request.file, source);
  for (int i = 0; i < element->GetNumberOfNestedElements(); ++i) check_pieces(element->GetNestedElement(i), request);
}

/// VTK takes the default where these do not parse. They stand in the first element, long before any data.
void check_image_placement(const ReadRequest& request) {
  std::ifstream in(request.file, std::ios::binary);
  std::string head(8192, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  for (const std::string attribute : {"Origin", "Spacing"}) {
    const auto at = head.find(" " + attribute + "=");
    if (at == std::string::npos) continue;
    const auto quote = at + attribute.size() + 2;
    const auto close = quote < head.size() ? head.find(head[quote], quote + 1) : std::string::npos;
    if (close == std::string::npos) continue;
    std::istringstream numbers(head.substr(quote + 1, close - quote - 1));
    double value = 0;
    for (int axis = 0; axis < 3; ++axis)
      if (!(numbers >> value) || !std::isfinite(value))
        throw Error(ErrorCode::bad_data, request.file.filename().string() + ": " + attribute + " is not three finite numbers");
  }
}

vtkSmartPointer<vtkXMLDataElement> parse_small_xml(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  constexpr std::uintmax_t kMost = 64u << 20;
  if (std::filesystem::file_size(request.file) > kMost)
    throw Error(ErrorCode::too_large, name + ": above 64 MiB; a list of files is not that long");
  auto root = vtkSmartPointer<vtkXMLDataElement>::Take(vtkXMLUtilities::ReadElementFromFile(request.file.c_str()));
  throw_on_vtk_error(name);
  if (!root) throw Error(ErrorCode::bad_data, name + ": is not well-formed XML");
  return root;
}

/// "12 vtkQuad skipped" of one piece and "3 vtkQuad skipped" of another are 15.
void add_note(std::vector<std::string>& notes, const std::string& note) {
  const auto digits = [](const std::string& text) { return text.find_first_not_of("0123456789"); };
  const auto at = digits(note);
  if (at == 0 || at > 15 || at == std::string::npos) {
    if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
    return;
  }
  for (std::string& other : notes)
    if (const auto there = digits(other); there != 0 && there <= 15 && other.substr(there) == note.substr(at)) {
      other = std::to_string(std::stoll(other) + std::stoll(note)) + note.substr(at);
      return;
    }
  notes.push_back(note);
}

std::int64_t count_pieces(vtkXMLDataElement* element) {
  std::int64_t count = element->GetName() && std::strcmp(element->GetName(), "Piece") == 0;
  for (int i = 0; i < element->GetNumberOfNestedElements(); ++i) count += count_pieces(element->GetNestedElement(i));
  return count;
}

/// Each piece is a block of its own, so that it is known which points are of which.
Imported read_unstructured_pieces(const ReadRequest& request, int pieces) {
  const std::string name = request.file.filename().string();
  vtkNew<vtkXMLPUnstructuredGridReader> reader;
  reader->SetFileName(request.file.c_str());
  check_step(request, 1);
  reader->UpdateInformation();
  throw_on_vtk_error(name);
  Imported imported;
  for (int piece = 0; piece < pieces; ++piece) {
    reader->UpdatePiece(piece, pieces, 0);
    throw_on_vtk_error(name);
    if (reader->GetErrorCode() != 0)
      throw Error(ErrorCode::bad_data, name + ": VTK's reader reported error " + std::to_string(reader->GetErrorCode()));
    vtkNew<vtkUnstructuredGrid> own;
    own->ShallowCopy(reader->GetOutput());
    if (piece == 0) imported.times = declared_times(own);
    std::vector<std::string> notes;
    if (own->GetNumberOfPoints() > 0) append_vtk_blocks(own, request, true, imported.blocks, notes);
    for (const std::string& note : notes) add_note(imported.notes, note);
    request.progress((piece + 1.0) / pieces);
  }
  if (imported.blocks.empty()) throw Error(ErrorCode::bad_data, name + ": holds no points");
  for (const std::string& warning : vtk_warnings()) imported.notes.push_back("reader: " + warning);
  return imported;
}

}  // namespace

Imported read_vtk_legacy(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  vtkNew<vtkGenericDataObjectReader> peek;
  peek->SetFileName(request.file.c_str());
  const int type = peek->ReadOutputType();
  throw_on_vtk_error(name);
  switch (type) {
    case VTK_STRUCTURED_POINTS:
    case VTK_IMAGE_DATA:
      return run_legacy<vtkStructuredPointsReader>(request);
    case VTK_RECTILINEAR_GRID:
      return run_legacy<vtkRectilinearGridReader>(request);
    case VTK_STRUCTURED_GRID:
      return run_legacy<vtkStructuredGridReader>(request);
    case VTK_UNSTRUCTURED_GRID:
      check_legacy_cells(MappedFile(request.file).bytes(), name);
      return run_legacy<vtkUnstructuredGridReader>(request);
    case VTK_POLY_DATA:
      throw Error(ErrorCode::unsupported, name + ": holds polygonal data (surfaces); expected a grid with 3-D cells");
    default:
      throw Error(type < 0 ? ErrorCode::bad_data : ErrorCode::unsupported,
                  name + ": expected DATASET STRUCTURED_POINTS, RECTILINEAR_GRID, STRUCTURED_GRID or UNSTRUCTURED_GRID");
  }
}

Imported read_vtk_xml(const ReadRequest& request, const std::string& type) {
  const std::string name = request.file.filename().string();
  if (type == "ImageData" || type == "PImageData") check_image_placement(request);
  if (type == "ImageData") return run_named<vtkXMLImageDataReader>(request);
  if (type == "RectilinearGrid") return run_named<vtkXMLRectilinearGridReader>(request);
  if (type == "StructuredGrid") return run_named<vtkXMLStructuredGridReader>(request);
  if (type == "UnstructuredGrid") return run_named<vtkXMLUnstructuredGridReader>(request);
  if (type == "PImageData" || type == "PRectilinearGrid" || type == "PStructuredGrid" || type == "PUnstructuredGrid") {
    const auto root = parse_small_xml(request);
    check_pieces(root, request);
    if (type == "PImageData") return run_named<vtkXMLPImageDataReader>(request);
    if (type == "PRectilinearGrid") return run_named<vtkXMLPRectilinearGridReader>(request);
    if (type == "PStructuredGrid") return run_named<vtkXMLPStructuredGridReader>(request);
    return read_unstructured_pieces(request, static_cast<int>(std::min<std::int64_t>(count_pieces(root), 1 << 20)));
  }
  if (type == "PolyData" || type == "PPolyData")
    throw Error(ErrorCode::unsupported, name + ": holds polygonal data (surfaces); expected a grid with 3-D cells");
  throw Error(ErrorCode::unsupported,
              name + ": VTKFile of type '" + type +
                  "'; expected ImageData, RectilinearGrid, StructuredGrid, UnstructuredGrid, one of their parallel "
                  "forms, or Collection");
}

Imported read_meta_image(const ReadRequest& request) {
  std::ifstream header(request.file, std::ios::binary);
  std::string line;
  for (int i = 0; i < 1000 && std::getline(header, line); ++i) {
    const auto equals = line.find('=');
    if (!line.starts_with("ElementDataFile") || equals == std::string::npos) continue;
    line = line.substr(equals + 1);
    line.erase(0, line.find_first_not_of(" \t"));
    line.erase(line.find_last_not_of(" \t\r") + 1);
    if (line.starts_with("LIST") || line.find('%') != std::string::npos)
      throw Error(ErrorCode::unsupported, request.file.filename().string() + ": a list of data files; expected one");
    if (line != "LOCAL" && line != "local") referred_file(request.file, line);
    return run_named<vtkMetaImageReader>(request);
  }
  throw Error(ErrorCode::bad_data, request.file.filename().string() + ": expected a line 'ElementDataFile = ...'");
}

Imported read_slc(const ReadRequest& request) { return run_named<vtkSLCReader>(request); }

}  // namespace isostrata
