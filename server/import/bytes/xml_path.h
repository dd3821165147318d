// Where in a tree of XML something is: the part of XPath, and of XPointer's element(), that references in files of data use.
#pragma once

#include <vtkXMLDataElement.h>

#include <optional>
#include <string_view>
#include <vector>

namespace isostrata {

/// The elements that a path leads to from the root, in the order of the file: "/Xdmf/Domain/Grid[1]/Topology", "//Grid[@Name='a']/*[self::Topology or self::Geometry]", each also within
/// "xpointer(...)", and "element(/1/2)". Nothing for a path of another form.
std::optional<std::vector<vtkXMLDataElement*>> elements_at(vtkXMLDataElement* root, std::string_view path);

}  // namespace isostrata
