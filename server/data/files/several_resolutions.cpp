#include "data/files/several_resolutions.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "data/files/file_beginning.h"

namespace isostrata {
namespace {

constexpr std::size_t kMostResolutions = 16;   // of resolutions; a series may be longer
constexpr double kAlikeBytes = 1.5;      // steps of one grid, packed as well, differ by less, but for the first of a few
constexpr std::size_t kStatement = 4096;

/// Between what begins a header's statement of its sizes and what ends it; empty for kinds whose bytes are as many as their values.
struct Statement {
  std::string_view begin, end;
};
Statement statement_of(FileKind kind) {
  switch (kind) {
    case FileKind::vtk_xml: return {"WholeExtent=\"", "\""};
    case FileKind::vtk_legacy: return {"\nDIMENSIONS ", "\n"};
    case FileKind::nrrd: return {"\nsizes:", "\n"};
    case FileKind::meta_image: return {"\nDimSize", "\n"};
    default: return {};
  }
}

/// Whether a file of the kind is one structured grid. Meshes may be refined from step to step.
bool is_structured(const Recognised& of) {
  switch (of.kind) {
    case FileKind::vtk_xml: return of.vtk_type == "ImageData" || of.vtk_type == "RectilinearGrid" || of.vtk_type == "StructuredGrid";
    case FileKind::vtk_legacy: case FileKind::nrrd: case FileKind::meta_image: case FileKind::nifti: case FileKind::numpy: case FileKind::npz: case FileKind::fits:
    case FileKind::mrc: case FileKind::hdf5: case FileKind::slc: case FileKind::gaussian_cube: case FileKind::xsf: case FileKind::vasp: case FileKind::mgh: case FileKind::raw: case FileKind::bov: case FileKind::volume_text: case FileKind::mrtrix: case FileKind::opendx: case FileKind::amira: case FileKind::netcdf: case FileKind::gzip:
      return true;
    default: return false;
  }
}

bool are_two_alike(std::span<const LookedAt* const> files) {
  std::vector<std::uint64_t> bytes;
  for (const LookedAt* file : files) bytes.push_back(file->stamp.bytes);
  std::sort(bytes.begin(), bytes.end());
  const auto alike = [](std::uint64_t less, std::uint64_t more) { return static_cast<double>(more) < kAlikeBytes * static_cast<double>(less); };
  return bytes.front() == 0 || std::adjacent_find(bytes.begin(), bytes.end(), alike) != bytes.end();
}

std::string said_sizes(const std::filesystem::path& file, const Statement& statement) {
  const std::string head = file_beginning(file, kStatement);
  const auto at = head.find(statement.begin);
  if (at == std::string::npos) return {};
  const auto begin = at + statement.begin.size();
  return head.substr(begin, head.find(statement.end, begin) - begin);
}

}  // namespace

bool are_several_resolutions(const std::filesystem::path& folder, std::span<const LookedAt* const> files) {
  if (files.size() < 2 || files.size() > kMostResolutions || !std::all_of(files.begin(), files.end(), [](const LookedAt* file) { return is_structured(file->of); })) return false;
  if (are_two_alike(files)) return false;
  const Statement statement = statement_of(files.front()->of.kind);
  if (statement.begin.empty()) return true;
  std::set<std::string> sizes;
  for (const LookedAt* file : files) {
    const std::string said = said_sizes(folder / file->name, statement);
    if (said.empty() || !sizes.insert(said).second) return false;
  }
  return true;
}

}  // namespace isostrata
