#include "import/imported/xml_arrays.h"

#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkInformationStringKey.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLUtilities.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.h"
#include "data/parts/partition.h"
#include "import/bytes/parsed_number.h"
#include "import/bytes/swap_bytes.h"
#include "import/bytes/trimmed.h"

namespace isostrata {
namespace {

constexpr std::size_t kLongestXmlHead = 16u << 20;
constexpr std::size_t kLongestKey = 1000;  // bytes of what an element InformationKey says
constexpr const char* kText = "IsostrataText";  // an element that says where the text in another one begins

std::optional<ScalarType> vtk_type(std::string_view name) {
  static const std::map<std::string_view, ScalarType> names{
      {"Int8", ScalarType::int8},     {"UInt8", ScalarType::uint8},   {"Int16", ScalarType::int16},     {"UInt16", ScalarType::uint16},
      {"Int32", ScalarType::int32},   {"UInt32", ScalarType::uint32}, {"Int64", ScalarType::int64},     {"UInt64", ScalarType::uint64},
      {"Float32", ScalarType::float32}, {"Float64", ScalarType::float64}};
  const auto at = names.find(name);
  return at == names.end() ? std::nullopt : std::optional(at->second);
}

/// Of its UNITS_LABEL, which VTK's writers put into the element.
std::string unit_of(vtkXMLDataElement* element) {
  for (int i = 0; i < element->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* const key = element->GetNestedElement(i);
    if (attribute(key, "name") != vtkDataArray::UNITS_LABEL()->GetName() || !key->GetCharacterData()) continue;
    return std::string(trimmed(key->GetCharacterData()));
  }
  return {};
}

/// Name, type, components and unit of a DataArray of numbers.
std::optional<FileArray> head_of(vtkXMLDataElement* element) {
  const auto type = vtk_type(attribute(element, "type"));
  const std::string_view said = attribute(element, "NumberOfComponents");
  const auto components = said.empty() || said == "0" ? std::optional<std::uint64_t>(1) : parsed_number<std::uint64_t>(said);
  if (std::string_view(element->GetName()) != "DataArray" || !type || !components || *components > 100'000) return std::nullopt;
  FileArray out;
  out.name = attribute(element, "Name");
  out.type = *type;
  out.components = static_cast<int>(*components);
  out.unit = unit_of(element);
  return out;
}

/// False as soon as use says so.
template <class Use>
bool for_each_word(std::string_view text, const Use& use) {
  constexpr std::string_view kBlanks = " \t\r\n";
  for (auto at = text.find_first_not_of(kBlanks); at != std::string_view::npos; at = text.find_first_not_of(kBlanks, at)) {
    const std::string_view word = text.substr(at, text.find_first_of(kBlanks, at) - at);
    if (!use(word)) return false;
    at += word.size();
  }
  return true;
}

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

struct Elements {
  std::string text;          // all elements in front of what is appended, without the texts in them but InformationKeys'; those of DataArrays are where kText says
  std::size_t appended = 0;  // where it begins, behind its '_'
  bool base64 = false;
};

/// The end of the element that begins there: a '>' in quotes is none.
std::size_t end_of_element(std::string_view text, std::size_t at) {
  for (char quote = 0; at < text.size(); ++at) {
    if (quote ? text[at] == quote : text[at] == '>') {
      if (!quote) return at;
      quote = 0;
    } else if (!quote && (text[at] == '"' || text[at] == '\'')) {
      quote = text[at];
    }
  }
  return std::string_view::npos;
}

std::optional<Elements> elements_of(std::string_view text) {
  Elements out;
  for (auto at = text.find('<'); at != std::string_view::npos; at = text.find('<', at)) {
    const std::string_view rest = text.substr(at);
    if (rest.starts_with("<!--") || rest.starts_with("<?")) {
      const auto end = text.find(rest[1] == '?' ? "?>" : "-->", at);
      if (end == std::string_view::npos) return std::nullopt;
      at = end;
      continue;
    }
    const auto close = end_of_element(text, at);
    if (close == std::string_view::npos || out.text.size() + (close - at) > kLongestXmlHead) return std::nullopt;
    const std::string_view element = text.substr(at, close + 1 - at);
    at = close + 1;
    if (element.starts_with("<AppendedData")) {
      const bool raw = element.find("\"raw\"") != std::string_view::npos;
      out.base64 = !raw;
      while (at < text.size() && is_space(text[at])) ++at;
      if ((!raw && element.find("\"base64\"") == std::string_view::npos) || at == text.size() || text[at] != '_') return std::nullopt;
      out.appended = at + 1;
      out.text += "</VTKFile>";
      return out;
    }
    out.text += element;
    if (element.starts_with("<InformationKey ") && !element.ends_with("/>"))
      if (const std::string_view said = text.substr(at, kLongestKey); said.find('<') != std::string_view::npos) out.text += said.substr(0, said.find('<'));
    if (element.starts_with("<DataArray") && !element.ends_with("/>")) out.text += std::string("<") + kText + " at=\"" + std::to_string(at) + "\"/>";
    if (element.starts_with("</VTKFile")) return out;
  }
  return std::nullopt;
}

vtkSmartPointer<vtkXMLDataElement> tree_of(const Elements& elements) {
  return vtkSmartPointer<vtkXMLDataElement>::Take(vtkXMLUtilities::ReadElementFromString(elements.text.c_str()));
}

void check_ends(vtkXMLDataElement* element, std::span<const std::byte> appended, const XmlCoding& coding, const std::string& file) {
  const auto offset = attribute(element, "format") == "appended" ? parsed_number<std::uint64_t>(attribute(element, "offset")) : std::nullopt;
  if (offset && (*offset > appended.size() || !coded_values(appended.subspan(static_cast<std::size_t>(*offset)), coding)))
    throw Error(ErrorCode::bad_data, file + ": is cut off: it ends before its array '" + std::string(attribute(element, "Name")) + "' does");
  for (int i = 0; i < element->GetNumberOfNestedElements(); ++i) check_ends(element->GetNestedElement(i), appended, coding, file);
}

}  // namespace

std::string_view attribute(vtkXMLDataElement* element, const char* name) {
  const char* text = element->GetAttribute(name);
  return text ? text : "";
}

void check_appended(const std::filesystem::path& file) {
  const MappedFile mapped(file);
  const auto bytes = mapped.bytes();
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto last = text.find_last_not_of(std::string_view(" \t\r\n\0", 5));
  if (last == std::string_view::npos || text.substr(0, last + 1).ends_with("</VTKFile>")) return;
  const auto elements = elements_of(text);
  if (!elements || elements->appended == 0) return;
  const auto root = tree_of(*elements);
  if (!root || !attribute(root, "compressor").empty()) return;
  check_ends(root, bytes.subspan(elements->appended),
             {.base64 = elements->base64, .wide = attribute(root, "header_type") == "UInt64", .swapped = attribute(root, "byte_order") == "BigEndian"},
             file.filename().string());
}

std::optional<XmlArrays> XmlArrays::open(const std::filesystem::path& file) {
  XmlArrays out;
  out.file_ = std::make_shared<const MappedFile>(file);
  const auto bytes = out.file_->bytes();
  const auto elements = elements_of({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (!elements) return std::nullopt;
  out.root_ = tree_of(*elements);
  if (!out.root_ || std::string_view(out.root_->GetName()) != "VTKFile") return std::nullopt;
  const std::string_view length = attribute(out.root_, "header_type"), compressor = attribute(out.root_, "compressor"), order = attribute(out.root_, "byte_order");
  out.appended_ = elements->appended;
  out.coding_ = {.packing = compressor == "vtkZLibDataCompressor" ? Packing::zlib : compressor == "vtkLZ4DataCompressor" ? Packing::lz4 : Packing::none,
                 .base64 = elements->base64,
                 .wide = length == "UInt64",
                 .swapped = order == "BigEndian"};
  const bool ours = (out.coding_.swapped || order.empty() || order == "LittleEndian") && (compressor.empty() || out.coding_.packing != Packing::none) &&
                    (out.coding_.wide || length == "UInt32" || length.empty());
  return ours ? std::optional(std::move(out)) : std::nullopt;
}

std::optional<XmlArrays::Piece> XmlArrays::only_piece(std::string_view kind) const {
  if (root_->GetNumberOfNestedElements() != 1 || std::string_view(root_->GetNestedElement(0)->GetName()) != kind) return std::nullopt;
  Piece found{root_->GetNestedElement(0), nullptr};
  if (!attribute(found.grid, "TimeValues").empty()) return std::nullopt;
  for (int i = 0; i < found.grid->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* part = found.grid->GetNestedElement(i);
    const std::string_view name = part->GetName();
    if (name == "FieldData") continue;
    if (name != "Piece" || found.piece) return std::nullopt;
    found.piece = part;
  }
  return found.piece ? std::optional(found) : std::nullopt;
}

std::optional<double> XmlArrays::field(std::string_view name) const {
  vtkXMLDataElement* const fields = root_->LookupElementWithName("FieldData");
  for (int i = 0; fields && i < fields->GetNumberOfNestedElements(); ++i) {
    if (attribute(fields->GetNestedElement(i), "Name") != name) continue;
    const auto found = array(fields->GetNestedElement(i));
    const auto values = found && found->coded.bytes == size_of(found->as.type) ? decoded(*found) : std::nullopt;
    if (!values || (values->type != ScalarType::float64 && values->type != ScalarType::float32)) return std::nullopt;
    double number = 0;
    float shorter = 0;
    std::memcpy(values->type == ScalarType::float64 ? static_cast<void*>(&number) : &shorter, values->values.data(), values->values.size());
    return values->type == ScalarType::float64 ? number : static_cast<double>(shorter);
  }
  return std::nullopt;
}

std::optional<std::uint64_t> XmlArrays::text_begin(vtkXMLDataElement* element) const {
  vtkXMLDataElement* const place = element->FindNestedElementWithName(kText);
  return place ? parsed_number<std::uint64_t>(attribute(place, "at")) : std::nullopt;
}

std::optional<CodedValues> XmlArrays::coded(vtkXMLDataElement* element) const {
  const auto all = file_->bytes();
  const std::string_view format = attribute(element, "format");
  XmlCoding coding = coding_;
  std::uint64_t from = 0;
  if (format == "appended") {
    const auto offset = parsed_number<std::uint64_t>(attribute(element, "offset"));
    if (appended_ == 0 || !offset || __builtin_add_overflow(appended_, *offset, &from)) return std::nullopt;
  } else if (format == "binary") {
    const auto text = text_begin(element);
    if (!text) return std::nullopt;
    from = *text;
    while (from < all.size() && is_space(static_cast<char>(all[from]))) ++from;
    coding.base64 = true;
  }
  if (from == 0 || from > all.size()) return std::nullopt;
  return coded_values(all.subspan(static_cast<std::size_t>(from)), coding);
}

std::string_view XmlArrays::text(vtkXMLDataElement* element) const {
  const auto bytes = file_->bytes();
  const auto at = text_begin(element);
  if (!at) return {};
  const std::string_view behind = std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()).substr(static_cast<std::size_t>(*at));
  return behind.substr(0, behind.find('<'));
}

std::optional<XmlArray> XmlArrays::array(vtkXMLDataElement* element) const {
  auto head = head_of(element);
  auto values = coded(element);
  if (!head || !values || values->bytes % (static_cast<std::uint64_t>(head->components) * size_of(head->type)) != 0) return std::nullopt;
  XmlArray array{.as = std::move(*head), .coded = std::move(*values)};
  array.as.storage = file_;
  if (array.coded.plain()) array.as.values = array.coded.as_they_lie();
  return array;
}

std::optional<FileArray> XmlArrays::values(vtkXMLDataElement* element) const {
  if (const auto format = attribute(element, "format"); !format.empty() && format != "ascii") {
    const auto found = array(element);
    return found ? decoded(*found) : std::nullopt;
  }
  auto out = head_of(element);
  const auto read = [&](const auto& like) {
    using T = std::remove_cvref_t<decltype(like[0])>;
    const auto words = std::make_shared<std::vector<T>>();
    const bool good = for_each_word(text(element), [&](std::string_view word) {
      const auto value = parsed_number<T>(word);
      if (value) words->push_back(*value);
      return value.has_value();
    });
    out->values = std::as_bytes(std::span<const T>(*words));
    out->storage = words;
    return good && words->size() % static_cast<std::size_t>(out->components) == 0;
  };
  return out && std::visit(read, scalar_span(out->type, {})) ? std::move(out) : std::nullopt;
}

void XmlBits::append(const XmlBits& others, std::uint64_t many) {
  const std::uint64_t known = std::min(many, others.count);
  const unsigned int shift = static_cast<unsigned int>(count % 8);
  bytes.resize(static_cast<std::size_t>((count + many + 7) / 8));
  std::size_t to = static_cast<std::size_t>(count / 8);
  for (std::uint64_t at = 0; at < known; at += 8, ++to) {
    // What is beyond the last one is not a value of theirs.
    const auto eight = static_cast<std::uint8_t>(others.bytes[static_cast<std::size_t>(at / 8)] & (known - at < 8 ? 0xff00u >> (known - at) : 0xffu));
    bytes[to] |= static_cast<std::uint8_t>(eight >> shift);
    if (shift > 0 && to + 1 < bytes.size()) bytes[to + 1] = static_cast<std::uint8_t>(eight << (8 - shift));
  }
  count += many;
}

std::optional<XmlBits> XmlArrays::bits(vtkXMLDataElement* element) const {
  XmlBits out;
  if (attribute(element, "format") == "ascii") {
    const bool good = for_each_word(text(element), [&](std::string_view word) {
      if (word == "1" || word == "0") out.append(word == "1");
      return word == "1" || word == "0";
    });
    return good ? std::optional(std::move(out)) : std::nullopt;
  }
  const auto values = coded(element);
  if (!values) return std::nullopt;
  out.bytes.resize(static_cast<std::size_t>(values->bytes));
  if (!decode(*values, std::as_writable_bytes(std::span(out.bytes)))) return std::nullopt;
  out.count = 8 * values->bytes;  // the last byte is filled up by anything
  if (const auto said = parsed_number<std::uint64_t>(attribute(element, "NumberOfTuples"))) out.count = std::min(out.count, *said);
  return out;
}

std::optional<XmlArray> XmlArrays::array(vtkXMLDataElement* element, std::uint64_t tuples) const {
  auto found = array(element);
  std::uint64_t wanted = 0;
  if (!found || __builtin_mul_overflow(tuples, static_cast<std::uint64_t>(found->as.components) * size_of(found->as.type), &wanted) || found->coded.bytes != wanted)
    return std::nullopt;
  return found;
}

bool XmlArrays::add_values(vtkXMLDataElement* attributes, bool on_cells, std::uint64_t tuples, std::vector<XmlArray>& to) const {
  if (!attribute(attributes, "GlobalIds").empty()) return false;
  for (int i = 0; i < attributes->GetNumberOfNestedElements(); ++i) {
    auto found = array(attributes->GetNestedElement(i), tuples);
    if (!found || found->as.name.empty() || found->as.name == vtkDataSetAttributes::GhostArrayName() || found->as.name == kGlobalPoints) return false;
    found->as.on_cells = on_cells;
    to.push_back(std::move(*found));
  }
  return true;
}

FileArray aligned(FileArray array) {
  if (reinterpret_cast<std::uintptr_t>(array.values.data()) % size_of(array.type) == 0) return array;
  auto [storage, bytes] = allocate<std::byte>(array.values.size());
  std::memcpy(bytes.data(), array.values.data(), bytes.size());
  array.values = bytes;
  array.storage = storage;
  return array;
}

std::uint64_t decoded_bytes(const std::vector<XmlArray>& arrays) {
  std::uint64_t bytes = 0;
  for (const XmlArray& array : arrays) bytes += array.coded.plain() ? 0 : array.coded.bytes;
  return bytes;
}

std::optional<FileArray> decoded(const XmlArray& array) {
  FileArray out = array.as;
  if (array.coded.plain()) return out;
  auto [storage, values] = allocate<std::byte>(static_cast<std::size_t>(array.coded.bytes));
  if (!decode(array.coded, values)) return std::nullopt;
  if (array.coded.coding.swapped) swap_bytes(values, size_of(out.type));
  out.values = values;
  out.storage = storage;
  return out;
}

std::optional<std::vector<FileArray>> decoded(const std::vector<XmlArray>& arrays) {
  std::vector<FileArray> out;
  for (const XmlArray& array : arrays) {
    auto values = decoded(array);
    if (!values) return std::nullopt;
    out.push_back(values->components > 1 ? aligned(std::move(*values)) : std::move(*values));
  }
  return out;
}

}  // namespace isostrata
