// Which reader a file is for, from its first bytes, and from its name where the bytes do not say. Reads at most 8 KiB.
#pragma once

#include <filesystem>
#include <string>

#include "data/files/file_formats.h"

namespace isostrata {

struct Recognised {
  FileKind kind;
  std::string vtk_type;  // of XML VTK: the type attribute of VTKFile ("UnstructuredGrid", "PImageData", ...); "PolyData" of a legacy file of surfaces
};

/// Of a file, or of a folder that is one dataset (an OpenFOAM case, a Zarr image, slices of DICOM). Throws not_found (no such file), bad_data (an empty
/// file, a folder of other things), unsupported saying what it is and what to do.
Recognised recognise(const std::filesystem::path& file);

/// What must be known of a file before a reader is started for it, which itself looks at no file until it is confined.
struct ReaderNeeds {
  bool all_readers = false;  // a format that isostrata-import-all alone reads, or that may hold others that are
  /// A picture by its first bytes, but not by its name, which the reader sees itself: what reads pictures takes as long to load as many small files to read, and cannot be loaded
  /// once the reader is confined.
  bool pictures = false;
};

/// Recognises the file once, of a pattern (file_series.h) its first. Neither if it cannot be told: what is wrong with such a file any reader says.
ReaderNeeds reader_needs(const std::filesystem::path& file);

/// Of the reader: any value says ReaderNeeds::pictures.
inline constexpr const char* kPictureVariable = "ISOSTRATA_PICTURE";

/// A folder that holds an OpenFOAM case, whole or in parts for processors.
bool is_openfoam_case(const std::filesystem::path& folder);

/// Begins as DICOM files do, or is named as one.
bool is_dicom(const std::filesystem::path& file);

std::string small_letters(std::string text);

}  // namespace isostrata
