#include "import/vtk/read_image_in_place.h"

#include <vtkDataObject.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkMetaImageReader.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkXMLImageDataReader.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "data/open/import_door.h"
#include "import/bytes/parsed_number.h"
#include "import/imported/declared_time.h"
#include "import/imported/vtk_messages.h"
#include "import/imported/xml_arrays.h"
#include "import/vtk/vtk_blocks.h"

namespace isostrata {
namespace {

/// The values at `from`, where all of them are there. They may lie at any address.
std::optional<FileArray> array_at(const std::shared_ptr<const MappedFile>& file, std::uint64_t from, std::uint64_t points, ScalarType type) {
  const auto all = file->bytes();
  const std::uint64_t element = size_of(type);
  if (from > all.size() || points > (all.size() - from) / element) return std::nullopt;
  FileArray array;
  array.type = type;
  array.values = all.subspan(static_cast<std::size_t>(from), static_cast<std::size_t>(points * element));
  array.storage = file;
  return array;
}

/// Of its extent; nothing if that is none.
std::optional<std::uint64_t> point_count(const int (&extent)[6]) {
  std::uint64_t points = 1;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t n = std::int64_t{extent[2 * a + 1]} - extent[2 * a] + 1;
    if (n < 1 || __builtin_mul_overflow(points, static_cast<std::uint64_t>(n), &points)) return std::nullopt;
  }
  return points;
}

/// The image without values as the reader places it, and the arrays on it.
template <class Reader>
std::optional<Imported> placed(const ReadRequest& request, const std::filesystem::path& file, Reader* reader, std::vector<FileArray> arrays, std::uint64_t points) {
  reader->SetFileName(file.c_str());
  reader->UpdateInformation();
  throw_on_vtk_error(request.file.filename().string());
  vtkInformation* information = reader->GetOutputInformation(0);
  int extent[6] = {0, -1, 0, -1, 0, -1};
  if (!information->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT())) return std::nullopt;
  information->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent);
  if (point_count(extent) != points) return std::nullopt;
  check_step(request, 1);
  vtkNew<vtkImageData> image;
  image->SetExtent(extent);
  if (information->Has(vtkDataObject::ORIGIN())) image->SetOrigin(information->Get(vtkDataObject::ORIGIN()));
  if (information->Has(vtkDataObject::SPACING())) image->SetSpacing(information->Get(vtkDataObject::SPACING()));
  if (information->Has(vtkDataObject::DIRECTION())) image->SetDirectionMatrix(information->Get(vtkDataObject::DIRECTION()));
  Imported imported;
  append_vtk_blocks(image, request, false, imported.blocks, imported.notes);
  imported.blocks.front().arrays = std::move(arrays);
  for (const std::string& warning : vtk_warnings()) imported.notes.push_back("reader: " + warning);
  return imported;
}

/// The arrays on points and on cells; none if the file holds anything else.
std::vector<XmlArray> arrays_of(const XmlArrays& xml, std::uint64_t& points) {
  const auto image = xml.only_piece("ImageData");
  int whole[6], extent[6];
  if (!image || image->grid->GetVectorAttribute("WholeExtent", 6, whole) != 6 || image->piece->GetVectorAttribute("Extent", 6, extent) != 6 ||
      std::memcmp(whole, extent, sizeof whole) != 0)
    return {};
  const auto count = point_count(extent);
  if (!count) return {};
  points = *count;
  std::uint64_t cells = 1;  // of a flat image none: its cells have other corners
  for (int a = 0; a < 3; ++a) cells *= static_cast<std::uint64_t>(extent[2 * a + 1] - extent[2 * a]);
  std::vector<XmlArray> arrays;
  for (int i = 0; i < image->piece->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* const part = image->piece->GetNestedElement(i);
    if (part->GetNumberOfNestedElements() == 0) continue;
    const bool on_cells = std::string_view(part->GetName()) == "CellData";
    if ((!on_cells && std::string_view(part->GetName()) != "PointData") || (on_cells && cells == 0)) return {};
    if (!xml.add_values(part, on_cells, on_cells ? cells : points, arrays)) return {};
  }
  return arrays;
}

}  // namespace

std::optional<Imported> vti_in_place(const ReadRequest& request) {
  const auto xml = XmlArrays::open(request.file);
  if (!xml) return std::nullopt;
  std::uint64_t points = 0;
  const std::vector<XmlArray> found = arrays_of(*xml, points);
  if (found.empty()) return std::nullopt;
  check_bytes(request, decoded_bytes(found), request.file.filename().string());
  auto arrays = decoded(found);
  if (!arrays) return std::nullopt;
  vtkNew<vtkXMLImageDataReader> reader;
  auto imported = placed(request, request.file, reader.Get(), std::move(*arrays), points);
  if (imported) imported->times = {declared_time(request.file).value_or(0)};
  return imported;
}

std::optional<Imported> meta_image_in_place(const ReadRequest& request, const MetaHeader& header) {
  const auto type = header.type();
  const std::vector<std::int64_t> sizes = header.sizes();
  if (!type || !header.binary() || header.compressed() || (header.big_endian() && size_of(*type) > 1) || sizes.size() != 3 || header.channels() != 1 ||
      header.data.starts_with("LIST") || header.data.find_first_of("% ") != std::string::npos)
    return std::nullopt;
  std::uint64_t points = 1;
  for (const std::int64_t size : sizes)
    if (__builtin_mul_overflow(points, static_cast<std::uint64_t>(size), &points)) return std::nullopt;
  const auto mapped = std::make_shared<const MappedFile>(header.local() ? request.file : referred_file(request.file, header.data));
  std::uint64_t from = header.local() ? header.end : 0, bytes = 0;
  if (__builtin_mul_overflow(points, std::uint64_t{size_of(*type)}, &bytes) || bytes < kLeastInPlace || bytes > mapped->bytes().size())
    return std::nullopt;
  if (const std::string_view skip = header.field("HeaderSize"); skip == "-1") {
    from = mapped->bytes().size() - bytes;
  } else if (!skip.empty()) {
    const auto given = parsed_number<std::uint64_t>(skip);
    if (!given || (header.local() && *given != 0)) return std::nullopt;
    from += *given;
  }
  auto array = array_at(mapped, from, points, *type);
  if (!array) return std::nullopt;
  array->name = "MetaImage";  // as VTK's reader calls it
  return placed_meta_image(request, header, std::move(*array));
}

std::optional<Imported> placed_meta_image(const ReadRequest& request, const MetaHeader& header, FileArray array) {
  const std::uint64_t points = array.values.size() / size_of(array.type) / static_cast<std::uint64_t>(array.components);
  std::vector<FileArray> arrays;
  arrays.push_back(std::move(array));
  vtkNew<vtkMetaImageReader> reader;
  if (size_of(arrays.front().type) < 8 || arrays.front().type == ScalarType::float64) return placed(request, request.file, reader.Get(), std::move(arrays), points);
  const std::filesystem::path other = request.scratch / "bytes.mhd";  // of a type that VTK's reader knows
  std::ofstream out(other);
  out << "NDims = " << header.field("NDims") << '\n';
  for (const auto& [field, value] : header.fields)
    if (field != "NDims" && field != "ElementType") out << field << " = " << value << '\n';
  out << "ElementType = MET_CHAR\nElementDataFile = LOCAL\n";
  out.close();
  return placed(request, other, reader.Get(), std::move(arrays), points);
}

}  // namespace isostrata
