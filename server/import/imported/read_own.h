// Formats that are read without VTK, and lists of files of any format.
#pragma once

#include "import/imported/imported.h"

namespace isostrata {

/// NumPy's .npy; the last axis is x.
Imported read_numpy(const ReadRequest& request);

/// NumPy's .npz: the largest array, and all that have its axes.
Imported read_npz(const ReadRequest& request);

/// FITS: the first image of a file, by its own places if its axes are straight and have one unit.
Imported read_fits(const ReadRequest& request);

/// MRC and CCP4: a density map, mapped where it lies if it can be.
Imported read_mrc(const ReadRequest& request);

/// HDF5 without a convention of its own: the largest array of two or three axes, and all of its shape.
Imported read_hdf5(const ReadRequest& request);

/// Imaris: the finest level; time points are steps, channels arrays.
Imported read_imaris(const ReadRequest& request);

/// MED, of Salome and Code_Aster.
Imported read_med(const ReadRequest& request);

/// The same of netCDF whose axes do not say what they are.
Imported read_netcdf_plainly(const ReadRequest& request);

/// Raw numbers whose name says what they are (data/files/raw_name.h).
Imported read_raw(const ReadRequest& request);

/// VisIt's .bov: one raw file, at points or in cells.
Imported read_bov(const ReadRequest& request);

/// The text beside a raw file of volvis.org and of Inviwo.
Imported read_volume_text(const ReadRequest& request);

/// MRtrix's .mif and .mih.
Imported read_mrtrix(const ReadRequest& request);

/// OpenDX: a regular grid as text.
Imported read_opendx(const ReadRequest& request);

/// AmiraMesh: fields on a uniform lattice.
Imported read_amira(const ReadRequest& request);

/// Gaussian's .cube: every field on its grid.
Imported read_gaussian_cube(const ReadRequest& request);

/// XCrySDen's .xsf: every grid of three axes that has the points of the first.
Imported read_xsf(const ReadRequest& request);

/// VASP's CHGCAR, LOCPOT and the like: one grid, or those of the spins too. The cell's far sides have the values of the near ones.
Imported read_vasp(const ReadRequest& request);

/// FreeSurfer's .mgh and .mgz.
Imported read_mgh(const ReadRequest& request);

/// Gmsh's .msh: its nodes and elements, with the values that stand there too.
Imported read_gmsh(const ReadRequest& request);

/// Tecplot's text, and its binary format since 2009.
Imported read_tecplot(const ReadRequest& request);

/// AVS UCD, text.
Imported read_ucd(const ReadRequest& request);

/// CalculiX's .frd.
Imported read_frd(const ReadRequest& request);

/// A folder of DICOM slices, the files of a pattern, a file with its siblings of one series, or a file of many frames. Uncompressed.
Imported read_dicom(const ReadRequest& request);
/// DICOM with one picture, which is a slice of a volume rather than a step.
bool is_dicom_slice(const std::filesystem::path& file);

/// A folder of Zarr, version 2 or 3: an image of OME-Zarr, one level of it, or one array. Steps along t, an array for each channel.
Imported read_zarr(const ReadRequest& request);

/// XDMF: the grids of its domains, by their times. Numbers in HDF5, binary files or the XML; all files lie below the directory of the one that names them.
Imported read_xdmf(const ReadRequest& request);

/// A list of time steps; each entry is a file below the .pvd's directory, read by its own kind. Several parts of one time become blocks.
Imported read_pvd(const ReadRequest& request);

/// ParaView's list of files in JSON, "x.vtu.series".
Imported read_series_file(const ReadRequest& request);

/// Files that differ by numbers in their names: the request's file is their pattern, "plume_*.vtu" (data/files/file_series.h).
Imported read_numbered(const ReadRequest& request);

/// A tree of blocks, each a file below the list's directory.
Imported read_multi_block(const ReadRequest& request);

/// Boxes of cells in levels, each a .vti below the list's directory; values on cells alone.
Imported read_vtk_levels(const ReadRequest& request);

/// A hyper tree grid in VTK's XML: the leaves of its trees, masked ones hidden.
Imported read_hyper_tree(const ReadRequest& request);

/// A plotfile of AMReX or BoxLib, which is a folder.
Imported read_amrex(const ReadRequest& request);

/// A file inside gzip, of a format that is one file. It is unpacked into request.scratch.
Imported read_gzip(const ReadRequest& request);

/// Loads what pictures are read with, if the file is one by its name or by kPictureVariable (data/files/recognise.h): once a process is confined it can load nothing.
void prepare_pictures(const std::filesystem::path& file);

/// One TIFF file; its pages are what ImageJ or OME-TIFF says that they are, else slices, as far as they are like the first.
Imported read_tiff(const ReadRequest& request);

/// Numbered pictures of one size as the slices of a volume; the request's file is their pattern.
Imported read_pictures(const ReadRequest& request);

}  // namespace isostrata
