// The table of formats: what is read, by which names, and what is known but not read. The listing of a folder, the messages of refusals and
// the table of docs/formats.md all come from here.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace isostrata {

enum class FileKind : std::uint8_t {
  vtk_legacy, vtk_xml, multi_block, pvd, series, xdmf, vtkhdf, nrrd, meta_image, nifti, dicom, numpy, npz, fits, mrc, hdf5, tiff, pictures, raw, bov, volume_text, mrtrix, opendx, amira, slc, gaussian_cube, xsf, vasp, mgh, gmsh, frd, tecplot, med, ucd, openfoam,
  ensight, cgns, exodus, plot3d, netcdf, zarr, vtk_levels, hyper_tree, amrex, gzip
};

struct FileFormat {
  FileKind kind;
  std::string_view name;        // what people call it
  std::string_view extensions;  // in small letters, a space between two
  std::string_view what;        // what of it is read
  std::string_view reader;      // whose code reads it
};

/// One row for each kind.
std::span<const FileFormat> file_formats();
const FileFormat& format_of(FileKind kind);

/// What is known by its name and is not read.
struct ForeignFormat {
  std::string_view extensions;  // as above
  std::string_view what;        // "a surface"
  std::string_view advice;      // "expected ...", "save it as ..."; empty for what is not data
};
std::span<const ForeignFormat> foreign_formats();

/// Whether `name`, a file's name in small letters, ends with one of the extensions: ".nii.gz" is one, and so is ".gz".
bool ends_with_one_of(std::string_view name, std::string_view extensions);

}  // namespace isostrata
