#include "data/files/file_formats.h"

#include <algorithm>
#include <array>

namespace isostrata {
namespace {

constexpr std::array kFormats{
    FileFormat{FileKind::vtk_legacy, "legacy VTK", ".vtk", "every grid, ASCII and binary", "VTK"},
    FileFormat{FileKind::vtk_xml, "XML VTK", ".vti .vtr .vts .vtu .pvti .pvtr .pvts .pvtu", "every grid, serial and parallel, every encoding",
               "VTK"},
    FileFormat{FileKind::multi_block, "XML VTK of blocks", ".vtm .vtmb .vtpd .vtpc", "every block that has cells, as one grid", "ours, for the list"},
    FileFormat{FileKind::pvd, "ParaView collection", ".pvd", "a series; several parts of one time are blocks", "ours, for the list"},
    FileFormat{FileKind::series, "ParaView series", ".series", "a series of files of any other kind: x.vtu.series", "ours, for the list"},
    FileFormat{FileKind::xdmf, "XDMF", ".xdmf .xmf .xdmf2 .xdmf3", "versions 2 and 3: every grid, numbers in HDF5, binary files or the XML; steps of collections, blocks", "ours"},
    FileFormat{FileKind::vtkhdf, "VTKHDF", ".vtkhdf .hdf .h5 .hdf5", "image data and unstructured grids; steps and blocks as the VTK here knows them", "VTK"},
    FileFormat{FileKind::nrrd, "NRRD", ".nrrd .nhdr", "raw, ASCII, hexadecimal, gzip, bzip2; detached files; steps; space directions", "ours"},
    FileFormat{FileKind::meta_image, "MetaImage", ".mhd .mha", "one data file, a list or a pattern of them", "ours, placed by VTK"},
    FileFormat{FileKind::nifti, "NIfTI", ".nii .nii.gz", "NIfTI 1 and 2, also as a pair x.hdr and x.img; steps; sform or qform, scaled values", "VTK, placed by us"},
    FileFormat{FileKind::dicom, "DICOM", ".dcm .ima .dicom", "a file, a folder or a pattern: the largest series, uncompressed, in the patient's space; frames of a dose", "ours"},
    FileFormat{FileKind::numpy, "NumPy array", ".npy", "one to three axes, the last is x; whole or real numbers", "ours"},
    FileFormat{FileKind::npz, "NumPy archive", ".npz", "the largest array, and all that have its axes", "ours"},
    FileFormat{FileKind::fits, "FITS", ".fits .fit .fts .fits.fz", "the first image, also packed in tiles: up to three axes, steps along TIME, an array for each of STOKES; scaled values", "ours"},
    FileFormat{FileKind::mrc, "MRC, CCP4", ".mrc .mrcs .map .ccp4", "density maps in their cell, in ångström; stacks of volumes as steps", "ours"},
    FileFormat{FileKind::hdf5, "HDF5, MATLAB 7.3, Imaris", ".h5 .hdf5 .hdf .mat .ims", "the largest array of two or three axes, and all of its shape, the last axis is x; of Imaris the finest level, time points are steps, channels arrays", "HDF5's"},
    FileFormat{FileKind::tiff, "TIFF", ".tif .tiff", "pages are slices, or the channels, slices and frames of ImageJ and OME-TIFF; 1 to 32 bits and real numbers as they are stored, colours as components; places and missing values of GeoTIFF", "OpenImageIO"},
    FileFormat{FileKind::pictures, "stack of pictures", ".png .tif .tiff .bmp .pnm .pgm .exr", "numbered pictures of one size are slices: 'slice_*.png'", "OpenImageIO"},
    FileFormat{FileKind::raw, "raw numbers", ".raw .bin .img .vol .dat .data .u8 .i8 .s8 .u16 .i16 .s16 .u32 .i32 .s32 .f32 .f64 .uint8 .int8 .uint16 .int16 .float .float32 .double .float64",
               "sizes and type as their name has them: bonsai_256x256x256_uint8.raw; the first size is x, a fourth counts steps", "ours"},
    FileFormat{FileKind::bov, "BOV of VisIt", ".bov", "a brick of values in one raw file, at points or in cells", "ours"},
    FileFormat{FileKind::volume_text, "volvis.org, Inviwo", ".dat", "a text that names a raw file (ObjectFileName, RawFile), its resolution and format", "ours"},
    FileFormat{FileKind::mrtrix, "MRtrix", ".mif .mih", "in the scanner's space, in any layout, scaled values; volumes as steps", "ours"},
    FileFormat{FileKind::opendx, "OpenDX", ".dx", "a regular grid as text, as APBS and VMD write it", "ours"},
    FileFormat{FileKind::amira, "AmiraMesh, Avizo", ".am", "fields on a uniform lattice: binary, packed (HxZip, HxByteRLE) or text", "ours"},
    FileFormat{FileKind::slc, "SLC", ".slc", "volumes of bytes", "VTK"},
    FileFormat{FileKind::gaussian_cube, "Gaussian cube", ".cube .cub", "every field on its grid, in the file's unit of length, named by its number or its remarks", "ours"},
    FileFormat{FileKind::xsf, "XCrySDen", ".xsf .axsf", "every grid of three axes that has the first one's points, in ångström", "ours"},
    FileFormat{FileKind::vasp, "VASP", ".vasp .chgcar", "CHGCAR, CHG, AECCAR0, PARCHG, LOCPOT, ELFCAR: densities by the cell's volume, and those of spins; the cell is closed, in ångström", "ours"},
    FileFormat{FileKind::mgh, "FreeSurfer", ".mgh .mgz", "volumes in the scanner's space, packed or not; frames as steps", "ours"},
    FileFormat{FileKind::gmsh, "Gmsh", ".msh", "2.2 and 4.1, text and binary: elements of first and second order, physical groups, values at nodes and in elements, all steps", "ours"},
    FileFormat{FileKind::tecplot, "Tecplot", ".plt .tec .dat", "text, and binary of version 112: ordered zones and finite elements, values at points and in cells, zones of several times as steps", "ours"},
    FileFormat{FileKind::frd, "CalculiX", ".frd", "text and binary: elements of first and second order, values at nodes, all steps", "ours"},
    FileFormat{FileKind::med, "MED", ".med .rmed .mmed", "of Salome and Code_Aster: elements of first and second order, fields at nodes and in cells, all times", "HDF5's"},
    FileFormat{FileKind::ucd, "AVS UCD", ".inp .ucd .avs", "text: cells of first order, values at nodes and in cells", "ours"},
    FileFormat{FileKind::openfoam, "OpenFOAM", ".foam .openfoam", "a case, also as a folder: the internal mesh and its fields, all times", "VTK"},
    FileFormat{FileKind::ensight, "EnSight Gold", ".case .encas", "every part with cells, all times", "VTK"},
    FileFormat{FileKind::cgns, "CGNS", ".cgns", "structured and unstructured zones, HDF5 and ADF, all times", "VTK"},
    FileFormat{FileKind::exodus, "Exodus II", ".e .ex2 .exo .exii .gen", "all element blocks, nodal and element arrays; restarts x.e-s002 as one series",
               "VTK"},
    FileFormat{FileKind::plot3d, "PLOT3D", ".xyz .x .g .grd .p3d .q .f xyz.bin grid.bin", "grids with the solution beside them, every dialect", "ours"},
    FileFormat{FileKind::netcdf, "netCDF", ".nc .cdf .nc4 .ncdf", "CF conventions: the variables over the most axes, all times, fill values as gaps", "VTK"},
    FileFormat{FileKind::zarr, "Zarr", ".zarr", "a folder: Zarr 2 and 3; of an image the finest level, or one level by its folder, t are steps, c arrays; of xarray's groups CF conventions, as of netCDF; chunks and shards by blosc, zstd, gzip, lz4, bzip2",
               "ours"},
    FileFormat{FileKind::vtk_levels, "XML VTK of levels (AMR)", ".vthb .vth", "boxes of cells in levels: the cells that no finer box covers, as one conforming grid", "ours, for the list"},
    FileFormat{FileKind::hyper_tree, "hyper tree grid", ".htg", "the leaves of its trees as one conforming grid; masked ones are hidden", "ours"},
    FileFormat{FileKind::amrex, "AMReX, BoxLib", "", "a folder, a plotfile: all levels, the cells that no finer box covers, as one conforming grid", "ours"},
    FileFormat{FileKind::gzip, "gzip around another format", ".gz", "of formats that are one file: .vtk.gz, .vtu.gz, .npy.gz ...", "zlib"},
};

constexpr std::array kForeign{
    ForeignFormat{".vtp .pvtp .stl .ply .obj .off .3ds .gltf .glb .iges .step .stp .wrl .stla .stlb .facet", "a surface",
                  "expected a grid whose cells have a volume"},
    ForeignFormat{".bp .bp4 .bp5", "ADIOS", "save it as VTKHDF or .vtu (ParaView: Save Data)"},
    ForeignFormat{".n5", "N5", "save it as OME-Zarr (Python: zarr, ome-zarr)"},
    ForeignFormat{".zarr.zip .ozx", "a Zarr folder in an archive", "unpack it into a folder, NAME.zarr, and open that"},
    ForeignFormat{".czi .nd2 .lif .oir .lsm .stk .svs .ndpi .vsi", "a microscope's own format", "save it as OME-Zarr or OME-TIFF (bioformats2raw, Fiji)"},
    ForeignFormat{".vdb .dx .fld", "a grid of another program", "save it as .vti or .vtu (ParaView: Save Data), or one array as .npy"},
    ForeignFormat{".grib .grb .grib2 .grb2", "GRIB", "save it as netCDF (cdo -f nc copy IN OUT)"},
    ForeignFormat{".mnc", "MINC", "save it as NIfTI (mnc2nii IN OUT)"},
    ForeignFormat{".am", "AmiraMesh of a form that is not read", "expected 'AmiraMesh' at its start, and a field on a Lattice"},
    ForeignFormat{".aux.xml", "what GDAL knows of another file", ""},
    ForeignFormat{".dem", "a map of heights", "save it as netCDF (gdal_translate -of netCDF IN OUT)"},
    ForeignFormat{".plt .szplt .tec", "Tecplot of a form that is not read", "save it as CGNS, or as .vtu (ParaView: Save Data)"},
    ForeignFormat{".visit", "VisIt's list of files", "open the files by their pattern, 'plume_*.vtk', or list them in a .pvd"},
    ForeignFormat{".lammpstrj .dump .xtc .pdb .gro .dcd", "particles", "expected a grid: save their density on one, as Gaussian cube, MRC or .npy"},
    ForeignFormat{".mat", "MATLAB of a form before 7.3", "save it in MATLAB with '-v7.3'"},
    ForeignFormat{".pkl .parquet .feather .root", "an array in a container that is not read",
                  "save one array as .npy (Python: numpy.save)"},
    ForeignFormat{".msh .msh2 .msh4 .inp .unv .bdf .nas .cas .mesh .ucd .rst .odb .xml .key .k .su2 .neu",
                  "a mesh or a case of another program", "save it as .vtu, VTKHDF, CGNS or Exodus (ParaView, or meshio convert)"},
    ForeignFormat{".raw .img .bin .vol .dat .u8 .u16 .f32", "numbers without a header",
                  "say sizes and type in its name (NAME_256x256x256_uint8.raw), or put a header beside it, NAME.nhdr: 'NRRD0004', 'type: float', 'dimension: 3', 'sizes: NX NY NZ', 'encoding: raw', "
                  "'endian: little', 'data file: NAME'"},
    ForeignFormat{".exr .jpg .jpeg .gif .webp .svg .bmp .png .pgm .pnm", "one picture",
                  "a stack of PNG or TIFF pictures is opened by its pattern, 'slice_*.png'"},
    ForeignFormat{".zip .tar .tgz .bz2 .xz .zst .7z .rar .gz", "an archive", "unpack it"},
    ForeignFormat{".csv .tsv .xls .xlsx", "a table", "expected a grid: save it as .npy or NRRD if its rows are one"},
    ForeignFormat{".hdr", "Analyze 7.5 or ENVI", "save it as NIfTI or NRRD"},
    ForeignFormat{".mp4 .webm .avi .mov .mkv", "a film", ""},
    ForeignFormat{".txt .md .rst .log .out .err .pdf .tex .html .htm .doc .docx .ppt .pptx .bib", "text", ""},
    ForeignFormat{".py .sh .c .cc .cpp .h .hpp .f90 .m .jl .ipynb .pvsm .json .yaml .yml .toml .ini .cfg .i .js .ts .css .slurm .sbatch",
                  "a program or its settings", ""},
    ForeignFormat{".bak .tmp .swp .part .lock .pid ~", "left by a program", ""},
};

}  // namespace

std::span<const FileFormat> file_formats() { return kFormats; }
const FileFormat& format_of(FileKind kind) {
  for (const FileFormat& format : kFormats)
    if (format.kind == kind) return format;
  return kFormats.front();
}
std::span<const ForeignFormat> foreign_formats() { return kForeign; }

bool ends_with_one_of(std::string_view name, std::string_view extensions) {
  while (!extensions.empty()) {
    const auto end = std::min(extensions.find(' '), extensions.size());
    if (end > 0 && name.size() > end && name.ends_with(extensions.substr(0, end))) return true;
    extensions.remove_prefix(std::min(end + 1, extensions.size()));
  }
  return false;
}

}  // namespace isostrata
