#include "import/recognise.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <string_view>
#include <system_error>

#include "base/error.h"

namespace isostrata {
namespace {

constexpr const char* kReadable =
    "legacy .vtk, .vti, .vtr, .vts, .vtu and their parallel forms, .pvd, PLOT3D grids (.xyz, .x, .g, .p3d, NAMExyz.bin), NRRD, "
    "Exodus II, "
    ".mhd, .slc";

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// The value of `attribute` in the first <VTKFile ...> element.
std::string vtk_file_attribute(std::string_view head, std::string_view attribute) {
  const auto element = head.find("<VTKFile");
  if (element == std::string_view::npos) return {};
  head = head.substr(element, head.find('>', element) - element);
  for (auto at = head.find(attribute); at != std::string_view::npos; at = head.find(attribute, at + 1)) {
    std::string_view rest = head.substr(at + attribute.size());
    if (at == 0 || !std::isspace(static_cast<unsigned char>(head[at - 1]))) continue;
    const auto quote = rest.find_first_not_of(" \t\r\n=");
    if (quote == std::string_view::npos || (rest[quote] != '"' && rest[quote] != '\'')) continue;
    const auto close = rest.find(rest[quote], quote + 1);
    if (close != std::string_view::npos) return std::string(rest.substr(quote + 1, close - quote - 1));
  }
  return {};
}

}  // namespace

Recognised recognise(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  const std::string name = file.filename().string();
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) throw Error(ErrorCode::not_found, file.string() + ": no such file");
  if (fs::is_directory(status)) throw Error(ErrorCode::bad_data, file.string() + ": is a directory; expected a file");
  if (!fs::is_regular_file(status)) throw Error(ErrorCode::bad_data, file.string() + ": is not a regular file");
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Error(ErrorCode::unavailable, file.string() + ": cannot be opened for reading");
  std::string head(8192, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  if (head.empty()) throw Error(ErrorCode::bad_data, name + ": is empty");

  if (head.starts_with("# vtk DataFile")) return {FileKind::vtk_legacy, {}};
  if (head.starts_with("NRRD0")) return {FileKind::nrrd, {}};
  const std::string extension = lower(file.extension().string());
  if (head.find("<VTKFile") != std::string::npos) {
    std::string type = vtk_file_attribute(head, "type");
    if (type == "Collection") return {FileKind::pvd, {}};
    return {FileKind::vtk_xml, std::move(type)};
  }
  if (head.starts_with("CDF\x01") || head.starts_with("CDF\x02") || head.starts_with("CDF\x05") ||
      head.starts_with("\x89HDF\r\n")) {
    if (extension == ".e" || extension == ".ex2" || extension == ".exo" || extension == ".g" || extension == ".exii" ||
        extension == ".gen")
      return {FileKind::exodus, {}};
    throw Error(ErrorCode::unsupported, name + ": netCDF or HDF5, but not named as an Exodus II file (.e, .ex2, .exo, .g)");
  }
  if (extension == ".mhd" || extension == ".mha") return {FileKind::meta_image, {}};
  if (extension == ".slc") return {FileKind::slc, {}};
  const std::string stem = lower(file.stem().string());
  if (extension == ".xyz" || extension == ".x" || extension == ".g" || extension == ".grd" || extension == ".p3d" ||
      extension == ".q" || extension == ".f" || stem.ends_with("xyz") || stem.ends_with("grid") ||
      (stem.ends_with("q") && (extension == ".bin" || extension == ".dat")))
    return {FileKind::plot3d, {}};
  if (extension == ".vtk") throw Error(ErrorCode::bad_data, name + ": expected '# vtk DataFile' at its start");
  if (extension == ".nrrd" || extension == ".nhdr")
    throw Error(ErrorCode::bad_data, name + ": expected 'NRRD000' and a digit at its start");
  if (extension.size() == 4 && (extension.starts_with(".vt") || extension == ".pvd"))
    throw Error(ErrorCode::bad_data, name + ": expected a <VTKFile> element");
  if (extension == ".e" || extension == ".ex2" || extension == ".exo")
    throw Error(ErrorCode::bad_data, name + ": expected netCDF or HDF5, as Exodus II files are");
  throw Error(ErrorCode::unsupported, name + ": not a known kind of file; expected one of " + kReadable);
}

}  // namespace isostrata
