#include "data/files/recognise.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <ios>
#include <iterator>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/error.h"
#include "data/files/file_beginning.h"
#include "data/files/file_series.h"
#include "data/files/nifti_mark.h"
#include "data/files/openfoam_case.h"
#include "data/files/plotfile_folder.h"
#include "data/files/raw_name.h"
#include "data/files/zarr_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

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

/// Whether the text's first element is this one: before it stand white space, declarations and comments alone. A program that holds the word is not such a file.
bool begins_as_xml(std::string_view head, std::string_view element) {
  const auto skip = [&head](std::size_t count) { head.remove_prefix(std::min(count, head.size())); };
  if (head.starts_with("\xef\xbb\xbf")) skip(3);
  for (;;) {
    skip(head.find_first_not_of(" \t\r\n"));
    const std::string_view end = head.starts_with("<?") ? "?>" : head.starts_with("<!--") ? "-->" : head.starts_with("<!") ? ">" : "";
    if (end.empty()) return head.starts_with(element);
    const auto at = head.find(end);
    if (at == std::string_view::npos) return false;
    skip(at + end.size());
  }
}

std::string_view extensions_of(FileKind kind) { return format_of(kind).extensions; }

std::string head_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Error(ErrorCode::unavailable, file.filename().string() + ": cannot be opened for reading");
  std::string head(8192, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
  return head;
}

bool begins_as_dicom(std::string_view head) { return head.size() > 132 && head.substr(128, 4) == "DICM"; }

/// By its own first bytes, or those of the header beside it.
bool is_nifti(const fs::path& path, const std::string& file, std::string_view head) {
  if (file.ends_with(".hdr")) return begins_as_nifti_pair(head);
  if (!file.ends_with(".img")) return begins_as_nifti(head);
  std::error_code error;
  const fs::path header = other_of_nifti_pair(path);
  return fs::is_regular_file(header, error) && begins_as_nifti_pair(head_of(header));
}

/// "ObjectType = Image" first, as writers of MetaImage have it, and a line that says where the values are.
bool begins_as_meta_image(std::string_view head) {
  return head.starts_with("ObjectType") && head.substr(0, head.find('\n')).find("Image") != std::string_view::npos && head.find("\nElementDataFile") != std::string_view::npos;
}

/// Behind remarks a record of Tecplot's text, and a list of variables.
bool begins_as_tecplot(std::string_view head) {
  const auto skip = [&] { head.remove_prefix(std::min(head.find_first_not_of(" \t\r\n"), head.size())); };
  for (skip(); head.starts_with('#'); skip()) head.remove_prefix(std::min(head.find('\n'), head.size()));
  const std::string small = small_letters(std::string(head));
  const std::string first = small.substr(0, small.find_first_of(" \t\r\n=\""));
  return (first == "title" || first == "variables" || first == "filetype") && small.find("variables") != std::string::npos;
}

/// A text of lines that name a raw file and say how many values it has: volvis.org's and Inviwo's.
bool begins_as_volume_text(std::string_view head) {
  const std::string small = small_letters(std::string(head));
  const auto has_line = [&](const std::string& key) { return small.starts_with(key) || small.find("\n" + key) != std::string::npos; };
  return (has_line("objectfilename:") || has_line("rawfile:")) && has_line("resolution:") && small.find('\0') == std::string::npos;
}

/// Behind remarks five whole numbers. Abaqus has the same name, and asterisks.
bool begins_as_ucd(std::string_view head) {
  while (head.starts_with('#')) head.remove_prefix(std::min(head.find('\n'), head.size() - 1) + 1);
  std::istringstream words(std::string(head.substr(0, head.find('\n'))));
  const std::vector<std::string> numbers{std::istream_iterator<std::string>(words), {}};
  return numbers.size() == 5 && std::all_of(numbers.begin(), numbers.end(), [](const std::string& word) { return word.find_first_not_of("0123456789") == std::string::npos; });
}

/// The first files of a folder, in no order.
bool any_file(const fs::path& folder, int most, bool (*is)(const fs::path&)) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end && most > 0; it.increment(error), --most) {
    std::error_code ignored;
    if (it->is_regular_file(ignored) && is(it->path())) return true;
  }
  return false;
}

[[noreturn]] void refuse(const ForeignFormat& foreign, const std::string& name) {
  throw Error(ErrorCode::unsupported, name + ": this is " + std::string(foreign.what) + (foreign.advice.empty() ? "" : "; ") + std::string(foreign.advice));
}

const ForeignFormat& foreign_format(std::string_view what) {
  return *std::find_if(foreign_formats().begin(), foreign_formats().end(), [&](const ForeignFormat& of) { return of.what == what; });
}

Recognised recognise_folder(const fs::path& folder) {
  const std::string name = folder.filename().string();
  if (is_openfoam_case(folder)) return {FileKind::openfoam, {}};
  if (is_zarr(folder)) return {FileKind::zarr, {}};
  if (is_plotfile(folder)) return {FileKind::amrex, {}};
  if (any_file(folder, 64, is_dicom)) return {FileKind::dicom, {}};
  for (const ForeignFormat& foreign : foreign_formats())
    if ((foreign.what == "ADIOS" || foreign.what == "N5") && ends_with_one_of("x" + small_letters(folder.extension().string()), foreign.extensions)) refuse(foreign, name);
  throw Error(ErrorCode::bad_data, folder.string() + ": is a directory; expected a file, an OpenFOAM case, a Zarr folder, a plotfile of AMReX, or a folder of DICOM slices");
}

/// HDF5 may begin with a block of something else, of 512 bytes times a power of two; empty if it does not.
std::string_view past_user_block(std::string_view head) {
  for (std::size_t at = 512; at + 8 <= head.size(); at *= 2)
    if (head.substr(at, 8) == "\x89HDF\r\n\x1a\n") return head.substr(at);
  return {};
}

/// netCDF and HDF5 are containers: what is inside is said by a name at their root, or by the file's name.
Recognised recognise_container(std::string_view head, const std::string& file, const std::string& name) {
  if (file.ends_with(".mnc") || head.find("minc-2.0") != std::string_view::npos) refuse(foreign_format("MINC"), name);
  if (ends_with_one_of(file, extensions_of(FileKind::med)) || head.find("ENS_MAA") != std::string_view::npos) return {FileKind::med, {}};
  const auto holds = [&](const char* dimension) { return head.find(dimension) != std::string_view::npos; };
  if (ends_with_one_of(file, extensions_of(FileKind::exodus)) || (holds("num_nodes") && holds("num_el_blk"))) return {FileKind::exodus, {}};
  if (ends_with_one_of(file, extensions_of(FileKind::cgns)) || head.find("CGNSLibraryVersion") != std::string_view::npos)
    return {FileKind::cgns, {}};
  if (ends_with_one_of(file, extensions_of(FileKind::netcdf)) || head.starts_with("CDF")) return {FileKind::netcdf, {}};
  if (head.find("VTKHDF") != std::string_view::npos || ends_with_one_of(file, ".vtkhdf")) return {FileKind::vtkhdf, {}};
  return {FileKind::hdf5, {}};
}

std::vector<std::string> words_of_line(std::string_view text, int line) {
  for (; line > 0; --line) text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
  std::istringstream words(std::string(text.substr(0, text.find('\n'))));
  return {std::istream_iterator<std::string>(words), {}};
}

/// Atoms as text (.xyz), surfaces of Movie.BYU (.g) and maps of Surfer (.grd) have PLOT3D's names.
void refuse_others_of_plot3d(std::string_view head, const std::string& name) {
  if (head.starts_with("DSAA") || head.starts_with("DSBB") || head.starts_with("DSRB")) refuse(foreign_format("a map of heights"), name);
  const auto numbers = [](std::span<const std::string> words, const char* digits) {
    return std::all_of(words.begin(), words.end(), [&](const std::string& word) { return word.find_first_not_of(digits) == std::string::npos; });
  };
  const auto first = words_of_line(head, 0), second = words_of_line(head, 1), third = words_of_line(head, 2);
  const bool atom = third.size() >= 4 && (std::isalpha(static_cast<unsigned char>(third[0][0])) || !numbers(second, "0123456789")) && numbers(std::span(third).subspan(1, 3), "0123456789.+-eE");
  if (first.size() == 1 && numbers(first, "0123456789") && atom)
    throw Error(ErrorCode::unsupported, name + ": this is a list of atoms; expected a grid: save their density on one, as Gaussian cube, MRC or .npy");
  if (first.size() == 4 && second.size() == 2 && numbers(first, "0123456789") && numbers(second, "0123456789") && second[1] == first[2])
    throw Error(ErrorCode::unsupported, name + ": this is a surface (Movie.BYU); expected a grid whose cells have a volume");
}

/// VASP's densities, potentials and localizations by their names: CHGCAR, AECCAR2, LOCPOT.up. The two lines behind the title, and these names, are nobody else's.
bool is_vasp(const std::string& file, std::string_view head) {
  constexpr std::array<std::string_view, 6> kNames{"chgcar", "chg", "aeccar", "parchg", "locpot", "elfcar"};
  const bool named = std::any_of(kNames.begin(), kNames.end(), [&](std::string_view of) {
    return file.starts_with(of) && (file.size() == of.size() || std::isalpha(static_cast<unsigned char>(file[of.size()])) == 0);
  });
  const auto numbers = [&](int line, std::size_t most) {
    const auto words = words_of_line(head, line);
    return !words.empty() && words.size() <= most && std::all_of(words.begin(), words.end(), [](const std::string& word) { return word.find_first_not_of("0123456789.+-eEdD") == std::string::npos; });
  };
  return (named || ends_with_one_of(file, extensions_of(FileKind::vasp))) && numbers(1, 3) && numbers(2, 3) && numbers(3, 3) && numbers(4, 3);
}

/// What is inside gzip, its name says.
void check_packed(const std::string& inner, const std::string& name) {
  if (says_raw_sizes(inner)) return;
  for (const ForeignFormat& foreign : foreign_formats())
    if (ends_with_one_of(inner, foreign.extensions)) refuse(foreign, name);
  const bool known = std::any_of(file_formats().begin(), file_formats().end(), [&](const FileFormat& of) { return ends_with_one_of(inner, of.extensions); });
  if (!known && !is_vasp(inner, " \n1\n0 0 0\n0 0 0\n0 0 0\n"))
    throw Error(ErrorCode::unsupported, name + ": its name does not say what is in it; expected NAME.vtk.gz, NAME.vtu.gz or the like");
}

/// TIFFs whose pages are not what they are in others, by the names that their makers give them.
void refuse_microscope(const std::string& file, const std::string& name) {
  for (const ForeignFormat& foreign : foreign_formats())
    if (foreign.what == "a microscope's own format" && ends_with_one_of(file, foreign.extensions)) refuse(foreign, name);
}

/// By what the name alone says.
[[noreturn]] void refuse(const std::string& file, const std::string& name, std::string_view head) {
  if (file.ends_with(".vtk")) throw Error(ErrorCode::bad_data, name + ": expected '# vtk DataFile' at its start");
  if (ends_with_one_of(file, extensions_of(FileKind::nrrd)))
    throw Error(ErrorCode::bad_data, name + ": expected 'NRRD000' and a digit at its start");
  if (ends_with_one_of(file, ".vti .vtr .vts .vtu .vtm .pvd .vtp .vthb .vth .htg")) throw Error(ErrorCode::bad_data, name + ": expected a <VTKFile> element");
  if (ends_with_one_of(file, ".e .ex2 .exo")) throw Error(ErrorCode::bad_data, name + ": expected netCDF or HDF5, as Exodus II files are");
  if (ends_with_one_of(file, ".nc .cdf .nc4 .vtkhdf .h5 .hdf5 .hdf"))
    throw Error(ErrorCode::bad_data, name + ": expected netCDF or HDF5 by its name; it begins as neither");
  if (file.ends_with(".zarr")) throw Error(ErrorCode::bad_data, name + ": expected a folder, as a Zarr array or image is; this is a file");
  if (ends_with_one_of(file, extensions_of(FileKind::mrtrix))) throw Error(ErrorCode::bad_data, name + ": expected 'mrtrix image' at its start");
  if (file.ends_with(".npz")) throw Error(ErrorCode::bad_data, name + ": expected a ZIP archive, as NumPy's .npz is");
  if (ends_with_one_of(file, extensions_of(FileKind::fits))) throw Error(ErrorCode::bad_data, name + ": expected 'SIMPLE  =' at its start, as FITS has it");
  if (file.ends_with(".npy")) throw Error(ErrorCode::bad_data, name + ": expected '\\x93NUMPY' at its start");
  if (file.ends_with(".plt") && (head.starts_with(std::string_view("\3\0\0\0", 4)) || head.starts_with(std::string_view("\0\0\0\3", 4))))
    throw Error(ErrorCode::unsupported, name + ": this is a density of gOpenMol; save it as MRC or Gaussian cube, or as .npy (Python: gridData)");
  for (const ForeignFormat& foreign : foreign_formats())
    if (ends_with_one_of(file, foreign.extensions)) refuse(foreign, name);
  if (words_of_line(head, 0).size() == 2 && small_letters(words_of_line(head, 0)[0]) == "ncols") refuse(foreign_format("a map of heights"), name);
  if (head.starts_with("#!TDV")) throw Error(ErrorCode::unsupported, name + ": this is Tecplot; save it as CGNS, or as .vtu (ParaView: Save Data)");
  if (head.starts_with("\x7f" "ELF") || head.starts_with("#!")) throw Error(ErrorCode::unsupported, name + ": this is a program");
  throw Error(ErrorCode::unsupported, name + ": this is not a known kind of file; docs/formats.md lists those that are read");
}

/// "mesh.e-s0003" is a restart of "mesh.e".
std::string without_restart(const std::string& file) {
  const auto at = file.rfind("-s");
  const bool number = at != std::string::npos && at + 2 < file.size() && file.find_first_not_of("0123456789", at + 2) == std::string::npos;
  return number ? file.substr(0, at) : file;
}

}  // namespace

std::string small_letters(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_openfoam_case(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_regular_file(folder / "system" / "controlDict", error)) return false;
  for (const char* mesh : {"constant/polyMesh", "processor0/constant/polyMesh", "constant/regionProperties"})
    if (fs::exists(folder / mesh, error)) return true;
  return !openfoam_parts(folder).empty();
}

bool is_dicom(const fs::path& file) {
  const std::string head = file_beginning(file, 132);
  return head.size() == 132 && head.ends_with("DICM");
}

ReaderNeeds reader_needs(const fs::path& file) {
  // What server/import/CMakeLists.txt gives that program alone, and lists and wrappers of any kind.
  static constexpr std::array kKinds{FileKind::exodus, FileKind::vtkhdf, FileKind::openfoam, FileKind::ensight, FileKind::cgns, FileKind::netcdf, FileKind::hdf5, FileKind::med,
                                     FileKind::multi_block, FileKind::pvd, FileKind::series, FileKind::xdmf, FileKind::gzip};
  try {
    const FileKind kind = recognise(is_series_pattern(file) ? series_files(file).front().path : file).kind;
    return {.all_readers = std::find(kKinds.begin(), kKinds.end(), kind) != kKinds.end(), .pictures = kind == FileKind::tiff && !names_pictures(file)};
  } catch (const Error&) {
    return {};
  }
}

Recognised recognise(const fs::path& path) {
  const std::string name = path.filename().string();
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw Error(ErrorCode::not_found, path.string() + ": no such file");
  if (fs::is_directory(status)) return recognise_folder(path);
  if (!fs::is_regular_file(status)) throw Error(ErrorCode::bad_data, path.string() + ": is not a regular file");
  const std::string file = without_restart(small_letters(name));
  const std::string head = head_of(path);
  if (ends_with_one_of(file, extensions_of(FileKind::openfoam))) return {FileKind::openfoam, {}};  // a mark without contents
  if (head.empty()) throw Error(ErrorCode::bad_data, name + ": is empty");

  if (head.starts_with("# vtk DataFile")) {
    const std::string_view lines = std::string_view(head).substr(0, 1024);
    return {FileKind::vtk_legacy, lines.find("\nDATASET POLYDATA") != std::string_view::npos ? "PolyData" : ""};
  }
  if (head.starts_with("NRRD0")) return {FileKind::nrrd, {}};
  if (head.starts_with("\x93NUMPY")) return {FileKind::numpy, {}};
  if (head.starts_with("PK\x03\x04") && file.ends_with(".npz")) return {FileKind::npz, {}};
  if (head.starts_with("SIMPLE  =")) return {FileKind::fits, {}};
  if (head.size() >= 1024 && head.substr(208, 3) == "MAP") return {FileKind::mrc, {}};
  if (head.starts_with("MATLAB 7.3 MAT-file")) return {FileKind::hdf5, {}};
  if (begins_as_dicom(head)) return {FileKind::dicom, {}};
  if (begins_as_xml(head, "<VTKFile")) {
    std::string type = vtk_file_attribute(head, "type");
    if (type == "Collection") return {FileKind::pvd, {}};
    if (type == "HyperTreeGrid") return {FileKind::hyper_tree, {}};
    if (type == "vtkOverlappingAMR" || type == "vtkNonOverlappingAMR" || type == "vtkHierarchicalBoxDataSet") return {FileKind::vtk_levels, std::move(type)};
    const bool blocks = type == "vtkMultiBlockDataSet" || type == "vtkPartitionedDataSet" || type == "vtkPartitionedDataSetCollection";
    return {blocks ? FileKind::multi_block : FileKind::vtk_xml, std::move(type)};
  }
  if (begins_as_xml(head, "<Xdmf")) return {FileKind::xdmf, {}};
  if (const std::string_view inside = past_user_block(head); !inside.empty()) return recognise_container(inside, file, name);
  if (head.starts_with("CDF\x01") || head.starts_with("CDF\x02") || head.starts_with("CDF\x05") || head.starts_with("\x89HDF\r\n"))
    return recognise_container(head, file, name);
  if (ends_with_one_of(file, extensions_of(FileKind::nifti)) || is_nifti(path, file, head)) return {FileKind::nifti, {}};
  if (ends_with_one_of(file, extensions_of(FileKind::mgh))) return {FileKind::mgh, {}};  // packed or not
  if (head.starts_with("\x1f\x8b") && file.ends_with(".gz") && !file.ends_with(".tar.gz")) {
    check_packed(file.substr(0, file.size() - 3), name);
    return {FileKind::gzip, {}};
  }
  if (head.starts_with(std::string_view("II*\0", 4)) || head.starts_with(std::string_view("MM\0*", 4)) || head.starts_with("II+") || head.starts_with(std::string_view("MM\0+", 4))) {
    refuse_microscope(file, name);
    return {FileKind::tiff, {}};
  }
  if (head.starts_with("$MeshFormat") || (head.starts_with("$Comments") && head.find("\n$MeshFormat") != std::string::npos)) return {FileKind::gmsh, {}};
  if (head.starts_with("#!TDV") || (ends_with_one_of(file, extensions_of(FileKind::tecplot)) && begins_as_tecplot(head))) return {FileKind::tecplot, {}};
  if (head.starts_with("$NOD")) throw Error(ErrorCode::unsupported, name + ": is of version 1 of Gmsh's format; expected 2.2 or 4.1: gmsh IN.msh -save -format msh41 -o OUT.msh");
  if (begins_as_meta_image(head)) return {FileKind::meta_image, {}};
  if (head.starts_with("mrtrix image")) return {FileKind::mrtrix, {}};
  if (head.starts_with("# AmiraMesh") || head.starts_with("# Avizo")) return {FileKind::amira, {}};
  if (ends_with_one_of(file, extensions_of(FileKind::ucd)) && begins_as_ucd(head)) return {FileKind::ucd, {}};
  if (begins_as_volume_text(head)) return {FileKind::volume_text, {}};
  if (ends_with_one_of(file, extensions_of(FileKind::opendx)) && head.find("class gridpositions") != std::string::npos) return {FileKind::opendx, {}};
  for (const FileKind kind : {FileKind::meta_image, FileKind::slc, FileKind::series, FileKind::xdmf, FileKind::gaussian_cube, FileKind::xsf, FileKind::frd, FileKind::ensight, FileKind::cgns, FileKind::bov})
    if (ends_with_one_of(file, extensions_of(kind))) return {kind, {}};
  if (is_vasp(file, head)) return {FileKind::vasp, {}};
  const std::uintmax_t bytes = fs::file_size(path, error);
  if (!error && raw_name(name, bytes)) return {FileKind::raw, {}};
  if (ends_with_one_of(file, ".mrc .mrcs")) return {FileKind::mrc, {}};  // before 2000 without a mark
  const std::string stem = small_letters(path.stem().string());
  const bool text = std::any_of(foreign_formats().begin(), foreign_formats().end(),
                                [&](const ForeignFormat& foreign) { return foreign.advice.empty() && ends_with_one_of(file, foreign.extensions); });
  if (ends_with_one_of(file, extensions_of(FileKind::plot3d)) || (!text && (stem.ends_with("xyz") || stem.ends_with("grid"))) ||
      (stem.ends_with("q") && ends_with_one_of(file, ".bin .dat"))) {
    refuse_others_of_plot3d(head, name);
    return {FileKind::plot3d, {}};
  }
  if (file.ends_with(".dcm")) return {FileKind::dicom, {}};
  refuse(file, name, head);
}

}  // namespace isostrata
