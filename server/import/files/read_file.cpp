#include "import/imported/read_file.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include "data/files/file_series.h"
#include "data/files/recognise.h"
#include "import/images/read_nrrd.h"
#include "import/imported/read_own.h"
#include "import/meshes/read_plot3d.h"
#include "import/vtk/read_vtk.h"

namespace isostrata {
namespace {

using Reader = Imported (*)(const ReadRequest&);

constexpr std::pair<FileKind, Reader> kReaders[] = {
    {FileKind::vtk_legacy, read_vtk_legacy}, {FileKind::multi_block, read_multi_block},
    {FileKind::pvd, read_pvd},               {FileKind::series, read_series_file},
    {FileKind::nrrd, read_nrrd},             {FileKind::meta_image, read_meta_image},
    {FileKind::nifti, read_nifti},           {FileKind::dicom, read_dicom},
    {FileKind::numpy, read_numpy},           {FileKind::tiff, read_tiff},
    {FileKind::npz, read_npz},               {FileKind::fits, read_fits},
    {FileKind::mrc, read_mrc},
    {FileKind::slc, read_slc},               {FileKind::gaussian_cube, read_gaussian_cube},
    {FileKind::xsf, read_xsf},               {FileKind::vasp, read_vasp},
    {FileKind::mgh, read_mgh},               {FileKind::gmsh, read_gmsh},
    {FileKind::frd, read_frd},               {FileKind::tecplot, read_tecplot},
    {FileKind::raw, read_raw},               {FileKind::bov, read_bov},
    {FileKind::volume_text, read_volume_text}, {FileKind::mrtrix, read_mrtrix},
    {FileKind::ucd, read_ucd},               {FileKind::opendx, read_opendx},         {FileKind::amira, read_amira},
    {FileKind::plot3d, read_plot3d},         {FileKind::gzip, read_gzip},
    {FileKind::zarr, read_zarr},             {FileKind::vtk_levels, read_vtk_levels},
    {FileKind::amrex, read_amrex},           {FileKind::hyper_tree, read_hyper_tree},
#ifdef ISOSTRATA_READS_EXODUS
    {FileKind::exodus, read_exodus},
#endif
#ifdef ISOSTRATA_READS_VTKHDF
    {FileKind::vtkhdf, read_vtkhdf},
#endif
#ifdef ISOSTRATA_READS_OPENFOAM
    {FileKind::openfoam, read_openfoam},
#endif
#ifdef ISOSTRATA_READS_ENSIGHT
    {FileKind::ensight, read_ensight},
#endif
#ifdef ISOSTRATA_READS_CGNS
    {FileKind::cgns, read_cgns},
#endif
#ifdef ISOSTRATA_READS_NETCDF
    {FileKind::netcdf, read_netcdf},
#endif
#ifdef ISOSTRATA_READS_XDMF
    {FileKind::xdmf, read_xdmf},
#endif
#ifdef ISOSTRATA_READS_HDF5
    {FileKind::hdf5, read_hdf5}, {FileKind::med, read_med},
#endif
};

const std::pair<FileKind, Reader>* reader_of(FileKind kind) {
  const auto found = std::find_if(std::begin(kReaders), std::end(kReaders), [&](const auto& of) { return of.first == kind; });
  return found == std::end(kReaders) ? nullptr : found;
}

Imported read_by_kind(const ReadRequest& request) {
  if (is_series_pattern(request.file)) return names_pictures(request.file) ? read_pictures(request) : read_numbered(request);
  const Recognised recognised = recognise(request.file);
  if (recognised.kind == FileKind::vtk_xml) return read_vtk_xml(request, recognised.vtk_type);
  if (const auto* reader = reader_of(recognised.kind)) return reader->second(request);
  throw Error(ErrorCode::unsupported, request.file.filename().string() + ": is " + std::string(format_of(recognised.kind).name) +
                                          ", for which the VTK that this program was built with has no reader");
}

}  // namespace

Imported read_file(const ReadRequest& request) {
  Imported imported = read_by_kind(request);
  for (Block& block : imported.blocks)
    for (std::size_t i = 0; i < block.arrays.size(); ++i) block.arrays[i].name = name_or_place(block.arrays[i].name, i + 1);
  return imported;
}

}  // namespace isostrata
