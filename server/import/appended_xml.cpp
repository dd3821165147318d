#include "import/appended_xml.h"

#include <vtkDataSetAttributes.h>
#include <vtkXMLUtilities.h>

#include <cstring>
#include <map>
#include <string>

#include "data/import_door.h"
#include "data/partition.h"
#include "import/parsed_number.h"

namespace isostrata {
namespace {

constexpr std::size_t kLongestHead = 1u << 20;

std::optional<ScalarType> vtk_type(std::string_view name) {
  static const std::map<std::string_view, ScalarType> names{
      {"Int8", ScalarType::int8},     {"UInt8", ScalarType::uint8},   {"Int16", ScalarType::int16},     {"UInt16", ScalarType::uint16},
      {"Int32", ScalarType::int32},   {"UInt32", ScalarType::uint32}, {"Int64", ScalarType::int64},     {"UInt64", ScalarType::uint64},
      {"Float32", ScalarType::float32}, {"Float64", ScalarType::float64}};
  const auto at = names.find(name);
  return at == names.end() ? std::nullopt : std::optional(at->second);
}

}  // namespace

std::string_view attribute(vtkXMLDataElement* element, const char* name) {
  const char* text = element->GetAttribute(name);
  return text ? text : "";
}

FileArray aligned(FileArray array) {
  if (reinterpret_cast<std::uintptr_t>(array.values.data()) % size_of(array.type) == 0) return array;
  auto [storage, bytes] = allocate<std::byte>(array.values.size());
  std::memcpy(bytes.data(), array.values.data(), bytes.size());
  array.values = bytes;
  array.storage = storage;
  return array;
}

std::optional<AppendedXml> AppendedXml::open(const std::filesystem::path& file) {
  if (std::filesystem::file_size(file) < kLeastInPlace) return std::nullopt;
  AppendedXml out;
  out.file_ = std::make_shared<const MappedFile>(file);
  const auto bytes = out.file_->bytes();
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), kLongestHead));
  const auto appended = text.find("<AppendedData");
  const auto close = appended == std::string_view::npos ? appended : text.find('>', appended);
  if (close == std::string_view::npos || text.substr(appended, close - appended).find("\"raw\"") == std::string_view::npos) return std::nullopt;
  const auto mark = text.find_first_not_of(" \t\r\n", close + 1);
  if (mark == std::string_view::npos || text[mark] != '_') return std::nullopt;
  const std::string head = std::string(text.substr(0, appended)) + "</VTKFile>";
  out.root_ = vtkSmartPointer<vtkXMLDataElement>::Take(vtkXMLUtilities::ReadElementFromString(head.c_str()));
  if (!out.root_ || std::string_view(out.root_->GetName()) != "VTKFile") return std::nullopt;
  const std::string_view length = attribute(out.root_, "header_type");
  out.wide_ = length == "UInt64";
  out.data_ = mark + 1;
  const bool plain = attribute(out.root_, "byte_order") == "LittleEndian" && attribute(out.root_, "compressor").empty() &&
                     (out.wide_ || length == "UInt32" || length.empty());
  return plain ? std::optional(std::move(out)) : std::nullopt;
}

std::optional<AppendedXml::Piece> AppendedXml::only_piece(std::string_view kind) const {
  if (root_->GetNumberOfNestedElements() != 1 || std::string_view(root_->GetNestedElement(0)->GetName()) != kind) return std::nullopt;
  Piece found{root_->GetNestedElement(0), nullptr};
  for (int i = 0; i < found.grid->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* part = found.grid->GetNestedElement(i);
    const std::string_view name = part->GetName();
    if (name == "FieldData") continue;
    if (name != "Piece" || found.piece) return std::nullopt;
    found.piece = part;
  }
  return found.piece ? std::optional(found) : std::nullopt;
}

std::optional<FileArray> AppendedXml::array(vtkXMLDataElement* element, std::uint64_t tuples) const {
  const auto type = vtk_type(attribute(element, "type"));
  const auto offset = parsed_number<std::uint64_t>(attribute(element, "offset"));
  const std::string_view said = attribute(element, "NumberOfComponents");
  const auto components = said.empty() || said == "0" ? std::optional<std::uint64_t>(1) : parsed_number<std::uint64_t>(said);
  if (std::string_view(element->GetName()) != "DataArray" || !type || !offset || !components || *components > 1000 ||
      attribute(element, "format") != "appended" || element->GetNumberOfNestedElements() > 0)
    return std::nullopt;
  const auto all = file_->bytes();
  const std::uint64_t head = wide_ ? 8 : 4;
  std::uint64_t from = 0, bytes = 0, wanted = 0;
  if (__builtin_add_overflow(data_, *offset, &from) || from > all.size() || all.size() - from < head) return std::nullopt;
  std::memcpy(&bytes, all.data() + from, static_cast<std::size_t>(head));
  if (__builtin_mul_overflow(tuples, *components * size_of(*type), &wanted) || bytes != wanted || bytes > all.size() - from - head)
    return std::nullopt;
  FileArray array;
  array.name = attribute(element, "Name");
  array.type = *type;
  array.components = static_cast<int>(*components);
  array.values = all.subspan(static_cast<std::size_t>(from + head), static_cast<std::size_t>(bytes));
  array.storage = file_;
  return array;
}

bool AppendedXml::add_values(vtkXMLDataElement* attributes, bool on_cells, std::uint64_t tuples, std::vector<FileArray>& to) const {
  if (!attribute(attributes, "GlobalIds").empty()) return false;
  for (int i = 0; i < attributes->GetNumberOfNestedElements(); ++i) {
    auto array = this->array(attributes->GetNestedElement(i), tuples);
    if (!array || array->name.empty() || array->name == vtkDataSetAttributes::GhostArrayName() || array->name == kGlobalPoints) return false;
    array->on_cells = on_cells;
    to.push_back(array->components > 1 ? aligned(std::move(*array)) : std::move(*array));
  }
  return true;
}

}  // namespace isostrata
