// Which reader a file is for, from its first bytes, and from its name where the bytes do not say.
#pragma once

#include <filesystem>
#include <string>

namespace isostrata {

enum class FileKind { vtk_legacy, vtk_xml, pvd, nrrd, plot3d, exodus, meta_image, slc };

struct Recognised {
  FileKind kind;
  std::string vtk_type;  // of vtk_xml: the type attribute of VTKFile ("UnstructuredGrid", "PImageData", ...)
};

/// Throws not_found (no such file), bad_data (a directory, an empty file), unsupported naming what can be read.
Recognised recognise(const std::filesystem::path& file);

}  // namespace isostrata
