// Files that list others: how long and how deep they may be, and their XML.
#pragma once

#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>

#include <cstdint>
#include <filesystem>

#include "import/imported/imported.h"

namespace isostrata {

/// Throws too_large if a text has more than so many MiB.
void check_text_size(const std::filesystem::path& file, std::uintmax_t most_mib = 64);

/// Throws bad_data if the file is the fifth list that leads to another.
void check_list_depth(const ReadRequest& request);

/// The root of a text as check_text_size has it. Throws bad_data if it is not well-formed.
vtkSmartPointer<vtkXMLDataElement> parse_small_xml(const ReadRequest& request);

}  // namespace isostrata
