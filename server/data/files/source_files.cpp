#include "data/files/source_files.h"

#include <algorithm>
#include <array>
#include <set>

#include "base/error.h"
#include "data/files/file_series.h"
#include "data/files/look_at_folder.h"
#include "data/files/recognise.h"
#include "data/files/referred_names.h"
#include "data/files/zarr_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMost = 10'000;

/// Formats of which referred_names tells all that a reader opens beside the file itself.
bool says_what_it_reads(FileKind kind) {
  switch (kind) {
    case FileKind::vtk_legacy:
    case FileKind::vtk_xml:
    case FileKind::multi_block:
    case FileKind::vtk_levels:
    case FileKind::hyper_tree:
    case FileKind::pvd:
    case FileKind::series:
    case FileKind::vtkhdf:
    case FileKind::nrrd:
    case FileKind::numpy:
    case FileKind::npz:
    case FileKind::fits:
    case FileKind::mrc:
    case FileKind::hdf5:
    case FileKind::tiff:
    case FileKind::gaussian_cube:
    case FileKind::xsf:
    case FileKind::vasp:
    case FileKind::mgh:
    case FileKind::gmsh:
    case FileKind::frd:
    case FileKind::tecplot:
    case FileKind::med:
    case FileKind::ucd:
    case FileKind::raw:
    case FileKind::bov:
    case FileKind::volume_text:
    case FileKind::mrtrix:
    case FileKind::opendx:
    case FileKind::amira:
    case FileKind::netcdf:
    case FileKind::slc:
      return true;
    default:
      return false;
  }
}

/// Files of this name need no look to know that they lead to no other: a series of thousands is told by names and times.
bool reads_itself_alone(const fs::path& file) {
  const std::string ending = file.extension().string();
  return std::ranges::any_of(std::array{".vtk", ".vti", ".vtr", ".vts", ".vtu", ".npy"}, [&](const char* one) { return ending == one; });
}

class Files {
 public:
  void add(const fs::path& file, int depth) {
    if (full() || !seen_.insert(file).second) return;
    std::error_code error;
    if (is_series_pattern(file)) {
      const bool alone = reads_itself_alone(file);
      for (const SeriesFile& member : series_files(file))
        if (!alone)
          add(member.path, depth);
        else if (!full() && seen_.insert(member.path).second)
          note(member.path);
      return;
    }
    note(file);
    if (fs::is_directory(file, error)) {
      for (const fs::path& above : zarr_files_above(file)) note(above);
      return add_below(file);
    }
    const Recognised of = recognise(file);
    if (!says_what_it_reads(of.kind)) return add_below(file.parent_path());
    if (depth >= 4) return;
    for (const std::string& name : referred_names(file, of)) {
      const fs::path referred = file.parent_path() / name;
      if (fs::is_regular_file(referred, error))
        add_referred(referred, depth + 1);
      else
        add_below(referred.parent_path());  // a pattern, or what is not there yet
    }
  }
  bool full() const { return seen_.size() > kMost; }
  const std::string& lines() const { return lines_; }

 private:
  void add_referred(const fs::path& file, int depth) {
    try {
      add(file, depth);
    } catch (const Error&) {  // raw numbers are of no format
    }
  }
  void add_below(const fs::path& folder) {
    std::error_code error;
    const int deepest = deepest_file(folder);
    for (fs::recursive_directory_iterator it(folder.empty() ? "." : folder, fs::directory_options::skip_permission_denied, error), end;
         !error && it != end && !full(); it.increment(error)) {
      if (it.depth() >= deepest) it.disable_recursion_pending();
      if (seen_.insert(it->path()).second) note(it->path());
    }
  }
  void note(const fs::path& file) {
    const FileStamp stamp = file_stamp(file).value_or(FileStamp{});
    lines_ += fs::absolute(file).string() + ' ' + std::to_string(stamp.bytes) + ' ' + std::to_string(stamp.changed_ns) + '\n';
  }

  std::set<fs::path> seen_;
  std::string lines_;
};

}  // namespace

std::optional<std::string> source_files(const fs::path& file) {
  Files files;
  try {
    files.add(file, 0);
  } catch (const Error&) {
    return std::nullopt;
  }
  if (files.full()) return std::nullopt;
  return files.lines();
}

}  // namespace isostrata
