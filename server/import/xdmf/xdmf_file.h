// The XML of XDMF: elements as if what they refer to stood in their place.
//
// The format is that of the XDMF model and format, versions 2 and 3. Meshes of time series are said once and referred to: by <xi:include xpointer="..."/> (FEniCS, meshio, XDMF's own
// library) or by an attribute Reference.
#pragma once

#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>

#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "import/imported/imported.h"

namespace isostrata {

/// An element, and the file that it stands in: names of other files count from there. As long as its XdmfFile.
struct XdmfElement {
  vtkXMLDataElement* xml = nullptr;
  const std::filesystem::path* file = nullptr;

  explicit operator bool() const { return xml != nullptr; }
  bool is(std::string_view name) const { return name == xml->GetName(); }
  /// The first of these attributes that is there, in small letters; empty if none is.
  std::string word(std::initializer_list<const char*> attributes) const;
  /// As it stands.
  std::string attribute(const char* name) const;
  /// What stands between its marks, without white space around it.
  std::string_view text() const;
};

class XdmfFile {
 public:
  /// Throws bad_data if it is not XML, or its first element is not <Xdmf>; too_large above 1 GiB.
  explicit XdmfFile(const ReadRequest& request);

  XdmfElement root() { return open(request_.file); }
  /// The elements in one, with what is referred to in place of what refers. Throws bad_data if nothing is there, or references go round; unsupported for paths that are not understood.
  std::vector<XdmfElement> children(const XdmfElement& of);
  /// Of this name, in the same way.
  std::vector<XdmfElement> children(const XdmfElement& of, std::string_view name);
  /// The first of them; nothing if there is none.
  XdmfElement child(const XdmfElement& of, std::string_view name);

 private:
  XdmfElement open(const std::filesystem::path& file);
  void put(const XdmfElement& element, int depth, std::vector<XdmfElement>& to);
  std::vector<XdmfElement> at(const XdmfElement& from, std::string_view path);

  const ReadRequest& request_;
  std::map<std::filesystem::path, vtkSmartPointer<vtkXMLDataElement>> files_;
};

}  // namespace isostrata
