#include "import/vtk/read_vtk.h"

#include <vtkDataObject.h>
#include <vtkDataReader.h>
#include <vtkGenericDataObjectReader.h>
#include <vtkNew.h>
#include <vtkRectilinearGridReader.h>
#include <vtkSLCReader.h>
#include <vtkSmartPointer.h>
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

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <ios>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "data/files/file_beginning.h"
#include "data/files/recognise.h"
#include "import/bytes/mapped_file.h"
#include "import/bytes/parsed_number.h"
#include "import/imported/declared_time.h"
#include "import/imported/list_file.h"
#include "import/imported/vtk_messages.h"
#include "import/imported/xml_arrays.h"
#include "import/vtk/check_legacy_cells.h"
#include "import/vtk/read_image_in_place.h"
#include "import/vtk/read_mesh_in_place.h"
#include "import/vtk/vtk_blocks.h"
#include "import/vtk/vtk_pipeline.h"

namespace isostrata {
namespace {

template <class Reader>
Imported run_named(const ReadRequest& request) {
  vtkNew<Reader> reader;
  reader->SetFileName(request.file.c_str());
  return run_reader(reader, request);
}

/// The reader says of a NaN as text that sizes may not match. Throws what it is, if the error is that and there is one.
void refuse_unreadable_word(const ReadRequest& request, const Error& error) {
  if (std::string_view(error.what()).find("reading ascii") == std::string_view::npos) return;
  const MappedFile file(request.file);
  std::string_view text(reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size());
  for (int line = 0; line < 3; ++line) text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
  constexpr std::string_view kBlanks = " \t\r\n";
  while (!text.empty()) {
    text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
    const std::string_view word = text.substr(0, text.find_first_of(kBlanks));
    const std::string plain = small_letters(std::string(word.substr(word.starts_with('-') || word.starts_with('+'), 9)));
    if (plain == "nan" || plain == "inf" || plain == "infinity")
      throw Error(ErrorCode::bad_data, request.file.filename().string() + ": holds '" + std::string(word) +
                                           "' as text, which VTK's reader of legacy files takes for no number; save it as BINARY, or as XML (.vti, .vtu)");
    text.remove_prefix(word.size());
  }
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
  Imported imported = [&] {
    try {
      return run_reader(reader, request);
    } catch (const Error& error) {
      refuse_unreadable_word(request, error);
      throw;
    }
  }();
  imported.times = {declared_time(request.file).value_or(imported.times.front())};  // the reader does not hand TIME on
  return imported;
}

/// Every piece of a parallel file must be a whole file below its directory.
void check_pieces(vtkXMLDataElement* element, const ReadRequest& request) {
  if (!element) return;
  if (const char* source = element->GetAttribute("Source")) check_appended(referred_file(request.file, source));
  for (int i = 0; i < element->GetNumberOfNestedElements(); ++i) check_pieces(element->GetNestedElement(i), request);
}

/// VTK takes the default where these do not parse. They stand in the first element, long before any data.
void check_image_placement(const ReadRequest& request) {
  const std::string head = file_beginning(request.file, 8192);
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

/// Whether the text of an element says a Name that is not empty.
bool says_name(std::string_view element) {
  for (auto at = element.find("Name"); at != std::string_view::npos; at = element.find("Name", at + 1)) {
    const auto value = element.find_first_not_of(" \t\r\n=", at + 4);
    if (std::isspace(static_cast<unsigned char>(element[at - 1])) && value != std::string_view::npos && (element[value] == '"' || element[value] == '\''))
      return element.substr(value + 1, 1) != element.substr(value, 1);
  }
  return false;
}

/// VTK's readers give up where an array has no name, and make a name for each component before they look for values.
void check_arrays(const ReadRequest& request) {
  const std::string head = file_beginning(request.file, 64 << 10);
  constexpr std::string_view kComponents = "NumberOfComponents=\"";
  constexpr std::uint64_t kMostComponents = 100'000;
  for (auto at = head.find(kComponents); at != std::string::npos; at = head.find(kComponents, at + 1)) {
    const auto begin = at + kComponents.size();
    const std::string_view said = std::string_view(head).substr(begin, head.find('"', begin) - begin);
    if (const auto components = parsed_number<std::uint64_t>(said); said.size() > 18 || (components && *components > kMostComponents))
      throw Error(ErrorCode::bad_data, request.file.filename().string() + ": an array has " + std::string(said.substr(0, 40)) + " components; expected at most " + std::to_string(kMostComponents));
  }
  for (const std::string part : {"PointData", "CellData"}) {
    const auto begin = head.find("<" + part), end = head.find("</" + part);
    for (auto at = head.find("<DataArray", begin); at < end && at != std::string::npos; at = head.find("<DataArray", at + 1)) {
      const auto close = head.find('>', at);
      if (close != std::string::npos && !says_name(std::string_view(head).substr(at, close - at)))
        throw Error(ErrorCode::bad_data, request.file.filename().string() + ": an array of its " + part + " has no name; expected an attribute Name");
    }
  }
}

/// VTK 9.1 says which array of PointData cannot be read if it is one of CellData: if there is no such, it crashes.
void check_cell_arrays(vtkXMLDataElement* element, const XmlArrays& xml, const std::string& name) {
  const auto count = [](vtkXMLDataElement* arrays) { return arrays ? arrays->GetNumberOfNestedElements() : 0; };
  vtkXMLDataElement* const cells = element->FindNestedElementWithName("CellData");
  for (int i = count(element->FindNestedElementWithName("PointData")); i < count(cells); ++i) {
    vtkXMLDataElement* const array = cells->GetNestedElement(i);
    const std::string_view type = attribute(array, "type");
    if (std::string_view(array->GetName()) != "DataArray" || type == "String" || type == "Bit" || type.empty()) continue;
    if (!xml.values(array)) throw Error(ErrorCode::bad_data, name + ": array '" + std::string(attribute(array, "Name")) + "' of its CellData is damaged; expected " + std::string(type));
  }
  for (int i = 0; i < count(element); ++i) check_cell_arrays(element->GetNestedElement(i), xml, name);
}

void check_serial(const ReadRequest& request) {
  check_arrays(request);
  if (const auto xml = XmlArrays::open(request.file)) check_cell_arrays(xml->root(), *xml, request.file.filename().string());
}

std::int64_t count_pieces(vtkXMLDataElement* element) {
  std::int64_t count = element->GetName() && std::strcmp(element->GetName(), "Piece") == 0;
  for (int i = 0; i < element->GetNumberOfNestedElements(); ++i) count += count_pieces(element->GetNestedElement(i));
  return count;
}

/// Points have three components. VTK copies those of the pieces, which have, into what the list declares (one if it says nothing).
void check_declared_points(vtkXMLDataElement* root, const std::string& name) {
  vtkXMLDataElement* points = root->LookupElementWithName("PPoints");
  for (int i = 0; points && i < points->GetNumberOfNestedElements(); ++i) {
    const char* components = points->GetNestedElement(i)->GetAttribute("NumberOfComponents");
    if (!components || std::string_view(components) != "3")
      throw Error(ErrorCode::bad_data, name + ": its points have NumberOfComponents '" + (components ? components : "") + "'; expected 3");
  }
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
  if (type == VTK_RECTILINEAR_GRID || type == VTK_STRUCTURED_GRID || type == VTK_UNSTRUCTURED_GRID) {
    const MappedFile file(request.file);
    check_legacy_counts(file.bytes(), name);
    if (type == VTK_UNSTRUCTURED_GRID) check_legacy_cells(file.bytes(), name);
  }
  switch (type) {
    case VTK_STRUCTURED_POINTS:
    case VTK_IMAGE_DATA:
      return run_legacy<vtkStructuredPointsReader>(request);
    case VTK_RECTILINEAR_GRID:
      return run_legacy<vtkRectilinearGridReader>(request);
    case VTK_STRUCTURED_GRID:
      return run_legacy<vtkStructuredGridReader>(request);
    case VTK_UNSTRUCTURED_GRID:
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
  if (type == "ImageData" || type == "RectilinearGrid" || type == "StructuredGrid" || type == "UnstructuredGrid") check_appended(request.file);
  if (type == "ImageData") {
    if (auto in_place = vti_in_place(request)) return std::move(*in_place);
    check_serial(request);
    return run_named<vtkXMLImageDataReader>(request);
  }
  if (type == "RectilinearGrid" || type == "StructuredGrid") check_serial(request);
  if (type == "RectilinearGrid") return run_named<vtkXMLRectilinearGridReader>(request);
  if (type == "StructuredGrid") return run_named<vtkXMLStructuredGridReader>(request);
  if (type == "UnstructuredGrid") {
    if (auto in_place = vtu_in_place(request)) return std::move(*in_place);
    check_serial(request);
    return run_named<vtkXMLUnstructuredGridReader>(request);
  }
  if (type == "PImageData" || type == "PRectilinearGrid" || type == "PStructuredGrid" || type == "PUnstructuredGrid") {
    const auto root = parse_small_xml(request);
    check_pieces(root, request);
    check_declared_points(root, name);
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

Imported read_slc(const ReadRequest& request) { return run_named<vtkSLCReader>(request); }

}  // namespace isostrata
