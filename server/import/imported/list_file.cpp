#include "import/imported/list_file.h"

#include <vtkXMLUtilities.h>

#include <string>

#include "import/imported/vtk_messages.h"

namespace isostrata {
namespace {

constexpr int kDeepestLists = 4;

}  // namespace

void check_text_size(const std::filesystem::path& file, std::uintmax_t most_mib) {
  const std::uintmax_t bytes = std::filesystem::file_size(file);
  if (bytes > most_mib << 20)
    throw Error(ErrorCode::too_large, file.filename().string() + ": has " + std::to_string(bytes) + " bytes; a text of its kind has at most " + std::to_string(most_mib) + " MiB");
}

void check_list_depth(const ReadRequest& request) {
  if (request.depth >= kDeepestLists)
    throw Error(ErrorCode::bad_data, request.file.filename().string() + ": lists within lists; expected at most " + std::to_string(kDeepestLists) + " within each other");
}

vtkSmartPointer<vtkXMLDataElement> parse_small_xml(const ReadRequest& request) {
  check_text_size(request.file);
  auto root = vtkSmartPointer<vtkXMLDataElement>::Take(vtkXMLUtilities::ReadElementFromFile(request.file.c_str()));
  throw_on_vtk_error(request.file.filename().string());
  if (!root) throw Error(ErrorCode::bad_data, request.file.filename().string() + ": is not well-formed XML");
  return root;
}

}  // namespace isostrata
