#include "import/xdmf/xdmf_file.h"

#include <vtkNew.h>
#include <vtkXMLDataParser.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "data/files/recognise.h"
#include "import/bytes/xml_path.h"
#include "import/imported/vtk_messages.h"

namespace isostrata {
namespace {

constexpr int kDeepestReferences = 8;            // of references to references
constexpr std::size_t kMostXdmfFiles = 10'000;
constexpr std::uintmax_t kMostXdmfBytes = std::uintmax_t{1} << 30;

}  // namespace

std::string XdmfElement::attribute(const char* name) const {
  const char* text = xml->GetAttribute(name);
  return text ? text : "";
}

std::string XdmfElement::word(std::initializer_list<const char*> attributes) const {
  for (const char* name : attributes)
    if (std::string text = attribute(name); !text.empty()) return small_letters(std::move(text));
  return {};
}

std::string_view XdmfElement::text() const {
  const char* all = xml->GetCharacterData();
  std::string_view text = all ? all : "";
  constexpr std::string_view kBlanks = " \t\r\n";
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

XdmfFile::XdmfFile(const ReadRequest& request) : request_(request) { open(request.file); }

XdmfElement XdmfFile::open(const std::filesystem::path& file) {
  auto known = files_.find(file);
  if (known == files_.end()) {
    const std::string name = file.filename().string();
    if (files_.size() == kMostXdmfFiles) throw Error(ErrorCode::too_large, name + ": refers to more than " + std::to_string(kMostXdmfFiles) + " files");
    if (std::filesystem::file_size(file) > kMostXdmfBytes) throw Error(ErrorCode::too_large, name + ": more than 1 GiB of XML; write the values as HDF5 beside it");
    vtkNew<vtkXMLDataParser> parser;
    parser->SetFileName(file.c_str());
    parser->SetIgnoreCharacterData(0);
    const bool parsed = parser->Parse() != 0;
    throw_on_vtk_error(name);
    if (!parsed || !parser->GetRootElement()) throw Error(ErrorCode::bad_data, name + ": is not well-formed XML");
    if (std::string_view(parser->GetRootElement()->GetName()) != "Xdmf")
      throw Error(ErrorCode::bad_data, name + ": its first element is <" + std::string(parser->GetRootElement()->GetName()).substr(0, 40) + ">; expected <Xdmf>");
    known = files_.emplace(file, parser->GetRootElement()).first;
  }
  return {known->second, &known->first};
}

std::vector<XdmfElement> XdmfFile::at(const XdmfElement& from, std::string_view path) {
  const std::string name = from.file->filename().string();
  const auto found = elements_at(files_.at(*from.file), path);
  if (!found) throw Error(ErrorCode::unsupported, name + ": refers to '" + std::string(path.substr(0, 200)) + "'; expected a path like /Xdmf/Domain/Grid[1]/Topology or //Grid[@Name='a']/*");
  if (found->empty()) throw Error(ErrorCode::bad_data, name + ": refers to '" + std::string(path.substr(0, 200)) + "', but nothing is there");
  std::vector<XdmfElement> out;
  for (vtkXMLDataElement* one : *found) out.push_back({one, from.file});
  return out;
}

void XdmfFile::put(const XdmfElement& element, int depth, std::vector<XdmfElement>& to) {
  const std::string_view name = element.xml->GetName();
  const bool include = name == "include" || name.ends_with(":include");
  const std::string reference = element.attribute("Reference");
  if (!include && reference.empty()) {
    to.push_back(element);
    return;
  }
  if (depth >= kDeepestReferences) throw Error(ErrorCode::bad_data, element.file->filename().string() + ": references to references, more than " + std::to_string(kDeepestReferences) + " deep");
  std::vector<XdmfElement> found;
  if (include) {
    const std::string file = element.attribute("href"), path = element.attribute("xpointer");
    XdmfElement from = file.empty() ? element : open(referred_file(*element.file, file));
    found = at(from, path.empty() ? "/Xdmf/Domain/Grid" : path);
  } else {
    found = at(element, reference == "XML" ? element.text() : std::string_view(reference));
    found.resize(1);
    if (!found.front().is(name))
      throw Error(ErrorCode::bad_data, element.file->filename().string() + ": a <" + std::string(name) + "> refers to a <" + found.front().xml->GetName() + ">");
  }
  for (const XdmfElement& one : found) put(one, depth + 1, to);
}

std::vector<XdmfElement> XdmfFile::children(const XdmfElement& of) {
  std::vector<XdmfElement> out;
  for (int i = 0; i < of.xml->GetNumberOfNestedElements(); ++i) put({of.xml->GetNestedElement(i), of.file}, 0, out);
  return out;
}

std::vector<XdmfElement> XdmfFile::children(const XdmfElement& of, std::string_view name) {
  std::vector<XdmfElement> out = children(of);
  std::erase_if(out, [&](const XdmfElement& one) { return !one.is(name); });
  return out;
}

XdmfElement XdmfFile::child(const XdmfElement& of, std::string_view name) {
  const std::vector<XdmfElement> all = children(of, name);
  return all.empty() ? XdmfElement{} : all.front();
}

}  // namespace isostrata
