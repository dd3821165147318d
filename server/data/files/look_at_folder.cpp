#include "data/files/look_at_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <memory>
#include <set>

#include "base/error.h"
#include "data/files/file_series.h"
#include "data/files/openfoam_case.h"
#include "data/files/picture_size.h"
#include "data/files/plotfile_folder.h"
#include "data/files/referred_names.h"
#include "data/files/zarr_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSolution = "a PLOT3D solution, which is read with its grid";

bool inside(const fs::path& path, const fs::path& folder) { return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end(); }

/// Of a file that is damaged, or that the first bytes say nothing of.
std::optional<FileKind> kind_by_name(const std::string& name) {
  for (const FileFormat& format : file_formats())
    if (format.kind != FileKind::gzip && format.kind != FileKind::pictures && ends_with_one_of(name, format.extensions)) return format.kind;
  return std::nullopt;
}

/// Why a file of a format that is read is none to open by itself; empty if it is.
std::string not_a_grid(const std::string& name, const Recognised& of) {
  if (of.kind == FileKind::plot3d && !ends_with_one_of(small_letters(name), ".xyz .p3d .x .g xyz.bin")) return kSolution;
  if (of.kind == FileKind::openfoam) return "a mark of an OpenFOAM case without the case around it";
  if (of.vtk_type == "PolyData" || of.vtk_type == "PPolyData") return "a surface; expected a grid whose cells have a volume";
  if (of.kind != FileKind::vtk_xml) return {};
  if (!of.vtk_type.ends_with("ImageData") && !of.vtk_type.ends_with("Grid")) return "XML VTK of a type that is not a grid";
  return {};
}

std::string without_name(std::string message, const std::string& name) {
  if (message.starts_with(name + ": ")) message.erase(0, name.size() + 2);
  return message;
}

void look_inside(const fs::path& path, LookedAt& file) {
  try {
    file.of = recognise(path);
    if (file.of.kind == FileKind::dicom) {
      file.use = LookedAt::Use::dicom;
    } else if (file.of.kind == FileKind::tiff && names_pictures(path)) {
      file.use = LookedAt::Use::picture;
    } else {
      file.why_not = not_a_grid(file.name, file.of);
      file.use = file.why_not.empty() ? LookedAt::Use::open : LookedAt::Use::none;
    }
  } catch (const Error& failure) {
    const auto kind = kind_by_name(small_letters(file.name));
    if (failure.code() == ErrorCode::bad_data && kind) {
      file.of = {*kind, {}};
      file.use = LookedAt::Use::open;  // opening it says what is wrong with it
    } else if (names_pictures(path)) {
      file.use = LookedAt::Use::picture;
    } else {
      file.why_not = without_name(failure.what(), file.name);
    }
  }
  if (file.use == LookedAt::Use::picture) file.picture = picture_size(path);
  if (file.use == LookedAt::Use::open) file.refers_to = referred_names(path, file.of);
  const auto is_surface = [](const std::string& name) { return ends_with_one_of(small_letters(name), ".vtp .pvtp"); };
  if (file.of.kind == FileKind::multi_block && !file.refers_to.empty() && std::all_of(file.refers_to.begin(), file.refers_to.end(), is_surface)) {  // foamToVTK's boundary.vtm
    file.use = LookedAt::Use::none;
    file.why_not = "a list of surfaces; expected a grid whose cells have a volume";
  }
}

using Directory = std::unique_ptr<DIR, int (*)(DIR*)>;

/// The times of an OpenFOAM case; of one that processors have computed, those that the first and the last of their folders have, since a run may be between the two.
void look_at_times(const fs::path& folder, FolderContents& out) {
  const std::vector<fs::path> parts = openfoam_parts(folder);
  const fs::path& first = parts.empty() ? folder : parts.front();
  const fs::path& last = parts.empty() ? folder : parts.back();
  const auto at_last = openfoam_times(last);
  for (const auto& [time, name] : openfoam_times(first)) {
    const auto stamp = file_stamp(first / name);
    const auto also = at_last.find(time);
    if (!stamp || also == at_last.end()) continue;
    LookedAt& found = out.files.emplace_back(LookedAt{.name = name, .stamp = *stamp});
    if (const auto other = file_stamp(last / also->second)) found.stamp.changed_ns = std::max(found.stamp.changed_ns, other->changed_ns);
  }
  for (const fs::path& part : std::set{first, last})
    if (part != folder) out.folders.push_back(part.filename().string());
  out.dataset = FileKind::openfoam;
}

/// All that is in a folder of Zarr, a plotfile or a case of OpenFOAM, links aside; nothing if that is too much to look at.
void weigh(const fs::path& folder, FolderContents& out) {
  constexpr int kMostFiles = 10'000;
  int left = kMostFiles;
  std::uint64_t bytes = 0;
  std::int64_t changed_ns = out.changed_ns;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, error), end; !error && it != end; it.increment(error)) {
    if (--left < 0) return;
    struct stat about {};
    if (lstat(it->path().c_str(), &about) != 0) continue;
    const FileStamp stamp = stamp_of(about);
    bytes += stamp.bytes;
    changed_ns = std::max(changed_ns, stamp.changed_ns);
  }
  out.bytes = bytes;
  out.changed_ns = changed_ns;
}

/// The metadata of a Zarr folder, of its levels, and the levels' folders. Chunks are only weighed, since there are many of them.
void look_at_levels(int descriptor, DIR* listed, FolderContents& out) {
  constexpr int kMostNames = 1000;
  const auto note = [&](const std::string& name) {
    struct stat about {};
    if (fstatat(descriptor, name.c_str(), &about, 0) != 0) return false;
    out.files.push_back({.name = name, .stamp = stamp_of(about)});
    return true;
  };
  int left = kMostNames;
  for (const dirent* it = readdir(listed); it && --left > 0; it = readdir(listed)) {
    const std::string name = it->d_name;
    if (is_zarr_metadata(name)) note(name);
    if (name == "." || name == ".." || (it->d_type != DT_DIR && it->d_type != DT_UNKNOWN)) continue;
    if (const bool array = note(name + "/.zarray"), node = note(name + "/zarr.json"); array || node) note(name);
  }
  std::sort(out.files.begin(), out.files.end(), [](const LookedAt& a, const LookedAt& b) { return a.name < b.name; });
  out.dataset = FileKind::zarr;
}

/// What says what a plotfile holds; the values are only weighed.
void look_at_plotfile(int descriptor, DIR* listed, FolderContents& out) {
  constexpr int kMostNames = 1000;
  int left = kMostNames;
  for (const dirent* it = readdir(listed); it && --left > 0; it = readdir(listed)) {
    const std::string name = it->d_name, said = name.starts_with("Level_") ? name + "/Cell_H" : name;
    struct stat about {};
    if ((name == "Header" || said != name) && fstatat(descriptor, said.c_str(), &about, 0) == 0) out.files.push_back({.name = said, .stamp = stamp_of(about)});
  }
  std::sort(out.files.begin(), out.files.end(), [](const LookedAt& a, const LookedAt& b) { return a.name < b.name; });
  out.dataset = FileKind::amrex;
}

}  // namespace

FileStamp stamp_of(const struct stat& about) {
  return {S_ISREG(about.st_mode) ? static_cast<std::uint64_t>(about.st_size) : 0,
          std::int64_t{about.st_mtim.tv_sec} * 1'000'000'000 + about.st_mtim.tv_nsec, about.st_ino};
}

std::optional<FileStamp> file_stamp(const fs::path& file) {
  struct stat about {};
  if (stat(file.c_str(), &about) != 0) return std::nullopt;
  return stamp_of(about);
}

// FNV-1a: nothing depends on its strength, since a stamp is not a proof either.
std::uint64_t mark_of(std::uint64_t before, const std::string& name, const FileStamp& stamp) {
  std::uint64_t hash = before ? before : 14695981039346656037u;
  const auto add = [&hash](const void* bytes, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) hash = (hash ^ static_cast<const unsigned char*>(bytes)[i]) * 1099511628211u;
  };
  add(name.data(), name.size());
  for (const std::uint64_t number : {stamp.bytes, static_cast<std::uint64_t>(stamp.changed_ns), stamp.inode}) add(&number, sizeof number);
  return hash ? hash : 1;
}

std::uint64_t mark_on_disk(const fs::path& source, int files) {
  std::error_code error;
  std::uint64_t mark = 0;
  if (is_series_pattern(source)) {
    try {
      for (const SeriesFile& file : series_files(source)) {
        if (files-- <= 0) break;
        const auto stamp = file_stamp(file.path);
        if (!stamp) return 0;
        mark = mark_of(mark, file.path.filename().string(), *stamp);
      }
    } catch (const Error&) {
      return 0;
    }
    return files > 0 ? 0 : mark;
  }
  const auto stamp = fs::is_directory(source, error) ? std::nullopt : file_stamp(source);
  return stamp ? mark_of(0, source.filename().string(), *stamp) : 0;
}

const LookedAt* FolderContents::find(const std::string& name) const {
  const auto at = std::lower_bound(files.begin(), files.end(), name, [](const LookedAt& file, const std::string& wanted) { return file.name < wanted; });
  return dataset || at == files.end() || at->name != name ? nullptr : &*at;
}

std::optional<FolderContents> look_at_folder(const fs::path& folder, const fs::path& root, std::int64_t most, const FolderContents* before) {
  const Directory listed(opendir(folder.c_str()), closedir);
  if (!listed) return std::nullopt;
  const int descriptor = dirfd(listed.get());
  FolderContents out;
  struct stat about {};
  if (fstat(descriptor, &about) == 0) out.changed_ns = stamp_of(about).changed_ns;
  if (is_openfoam_case(folder)) {
    FolderContents all;
    weigh(folder, all);
    out.bytes = all.bytes;  // and not when the newest of them was: times have theirs
    look_at_times(folder, out);
    return out;
  }
  if (is_zarr(folder)) {
    look_at_levels(descriptor, listed.get(), out);
    weigh(folder, out);
    return out;
  }
  if (is_plotfile(folder)) {
    look_at_plotfile(descriptor, listed.get(), out);
    weigh(folder, out);
    return out;
  }
  for (const dirent* it = readdir(listed.get()); it; it = readdir(listed.get())) {
    const std::string name = it->d_name;
    if (name == "." || name == "..") continue;
    if (--most < 0) {
      out.cut_off = true;
      break;
    }
    const auto pass_over = [&](const char* why) { out.passed_over.emplace_back(name, why); };
    if (name.starts_with('.')) {
      pass_over("hidden: its name begins with a dot");
      continue;
    }
    if (fstatat(descriptor, it->d_name, &about, AT_SYMLINK_NOFOLLOW) != 0) continue;  // it has gone meanwhile
    if (S_ISLNK(about.st_mode)) {
      if (fstatat(descriptor, it->d_name, &about, 0) != 0) {
        pass_over("a link that leads nowhere");
        continue;
      }
      if (S_ISDIR(about.st_mode)) continue;  // it may lead round in a circle
      std::error_code error;
      if (const fs::path real = fs::canonical(folder / name, error); S_ISREG(about.st_mode) && (error || !inside(real, root))) {
        pass_over("a link that leads out of the folder");
        continue;
      }
    }
    if (S_ISDIR(about.st_mode))
      out.folders.push_back(name);
    else if (!S_ISREG(about.st_mode))
      pass_over("a pipe, a socket or a device");
    else
      out.files.push_back({.name = name, .stamp = stamp_of(about)});
  }
  std::sort(out.folders.begin(), out.folders.end());
  std::sort(out.files.begin(), out.files.end(), [](const LookedAt& a, const LookedAt& b) { return a.name < b.name; });
  for (LookedAt& file : out.files) {
    const LookedAt* same = before ? before->find(file.name) : nullptr;
    if (same && same->stamp == file.stamp)
      file = *same;
    else
      look_inside(folder / file.name, file);
  }
  return out;
}

}  // namespace isostrata
