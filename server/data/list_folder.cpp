#include "data/list_folder.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <set>

#include "base/error.h"
#include "base/utf8.h"
#include "data/file_series.h"
#include "data/recognise.h"
#include "data/referred_names.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
constexpr int kMaxDepth = 8;
constexpr std::int64_t kMostFiles = 200'000;
constexpr std::size_t kLeastSlices = 3;  // two pictures with numbers are two pictures

constexpr const char* kPiece = "belongs to another file: a piece, a part or a step that is listed there";
constexpr const char* kSolution = "a PLOT3D solution, which is read with its grid";

bool inside(const fs::path& path, const fs::path& folder) { return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end(); }

std::int64_t milliseconds(fs::file_time_type time) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::file_clock::to_sys(time).time_since_epoch()).count();
}

/// Of a file that is damaged, or that the first bytes say nothing of.
std::optional<FileKind> kind_by_name(const std::string& name) {
  for (const FileFormat& format : file_formats())
    if (format.kind != FileKind::gzip && format.kind != FileKind::pictures && ends_with_one_of(name, format.extensions)) return format.kind;
  return std::nullopt;
}

/// Kinds whose numbered files are steps.
bool is_step(FileKind kind) {
  switch (kind) {
    case FileKind::pvd: case FileKind::series: case FileKind::openfoam: case FileKind::ensight: case FileKind::plot3d: case FileKind::dicom:
      return false;
    default:
      return true;
  }
}

class Lister {
 public:
  Lister(fs::path root, std::size_t most) : root_(std::move(root)), most_(most) {}

  FolderListing run() {
    visit(root_, 0);
    std::sort(out_.entries.begin(), out_.entries.end(), [](const FolderEntry& a, const FolderEntry& b) { return a.name < b.name; });
    for (auto& [reason, passed] : passed_) out_.passed_over.push_back(std::move(passed));
    std::stable_sort(out_.passed_over.begin(), out_.passed_over.end(), [](const PassedOver& a, const PassedOver& b) { return a.files > b.files; });
    return std::move(out_);
  }

 private:
  struct File {
    std::string name;
    Recognised of;
  };

  std::string below(const fs::path& path) const {
    return path == root_ ? root_.filename().string() : path.lexically_relative(root_).string();
  }

  void pass_over(const fs::path& path, const std::string& reason) {
    PassedOver& passed = passed_[reason];
    passed.reason = reason;
    ++passed.files;
    if (passed.examples.size() < 3) passed.examples.push_back(valid_utf8(below(path)));
  }

  void add(const fs::path& source, FileKind kind, const std::vector<fs::path>& files) {
    if (out_.entries.size() >= most_) {
      out_.cut_off = true;
      return;
    }
    FolderEntry entry{below(source), source.string(), kind, 0, 0, static_cast<int>(files.size())};
    for (const fs::path& file : files) {
      std::error_code no_size, no_time;
      const std::uint64_t bytes = fs::is_regular_file(file, no_size) ? fs::file_size(file, no_size) : 0;
      if (!no_size) entry.bytes += bytes;
      const auto time = fs::last_write_time(file, no_time);
      if (!no_time) entry.changed = std::max(entry.changed, milliseconds(time));
    }
    out_.entries.push_back(std::move(entry));
  }

  void visit(const fs::path& folder, int depth) {
    if (is_openfoam_case(folder)) return add(folder, FileKind::openfoam, {folder});
    std::vector<fs::path> files, folders;
    std::error_code error, ignored;
    for (fs::directory_iterator it(folder, fs::directory_options::skip_permission_denied, error), end; !error && it != end; it.increment(error)) {
      if (++seen_ > kMostFiles) {
        out_.cut_off = true;
        break;
      }
      const fs::path path = it->path();
      const fs::file_status status = it->status(ignored);
      if (path.filename().string().starts_with('.')) {
        pass_over(path, "hidden: its name begins with a dot");
      } else if (fs::is_directory(status)) {
        if (!it->is_symlink(ignored)) folders.push_back(path);  // a link may lead round in a circle
      } else if (!fs::exists(status)) {
        pass_over(path, "a link that leads nowhere");
      } else if (!fs::is_regular_file(status)) {
        pass_over(path, "a pipe, a socket or a device");
      } else if (const fs::path real = fs::canonical(path, ignored); ignored || !inside(real, root_)) {
        pass_over(path, "a link that leads out of the folder");
      } else {
        files.push_back(path);
      }
    }
    std::sort(files.begin(), files.end());
    std::sort(folders.begin(), folders.end());
    list_files(folder, files);
    for (const fs::path& inner : folders) {
      if (depth + 1 <= kMaxDepth)
        visit(inner, depth + 1);
      else
        out_.cut_off = true;
    }
  }

  void list_files(const fs::path& folder, const std::vector<fs::path>& files) {
    std::vector<File> found;
    std::vector<fs::path> dicom, pictures;
    std::vector<std::pair<fs::path, std::string>> refused;
    for (const fs::path& path : files) {
      const std::string name = path.filename().string();
      try {
        const Recognised of = recognise(path);
        if (of.kind == FileKind::dicom)
          dicom.push_back(path);
        else if (of.kind == FileKind::tiff)
          pictures.push_back(path);
        else if (const std::string why = not_a_grid(path, of); !why.empty())
          refused.emplace_back(path, why);
        else
          found.push_back({name, of});
      } catch (const Error& failure) {
        const auto kind = kind_by_name(small_letters(name));
        if (failure.code() == ErrorCode::bad_data && kind)
          found.push_back({name, {*kind, {}}});
        else if (names_pictures(path))
          pictures.push_back(path);
        else
          refused.emplace_back(path, without_name(failure.what(), name));
      }
    }
    if (dicom.size() == 1)
      add(dicom.front(), FileKind::dicom, dicom);
    else if (!dicom.empty())
      add(folder, FileKind::dicom, dicom);
    for (const File& file : found)
      for (const std::string& name : referred_names(folder / file.name, file.of)) refer(folder, name);
    for (const auto& [path, why] : refused) pass_over(path, is_piece(path) ? kPiece : why);
    list_found(folder, found);
    list_pictures(folder, pictures);
  }

  /// A file that another one names is that one's, wherever it lies below the folder.
  void refer(const fs::path& folder, const std::string& name) {
    const fs::path path = (folder / name).lexically_normal();
    if (name.find('*') == std::string::npos) {
      pieces_.insert(path.string());
      return;
    }
    try {
      for (const SeriesFile& file : series_files(path)) pieces_.insert(file.path.string());
    } catch (const Error&) {
    }
  }

  bool is_piece(const fs::path& path) const { return pieces_.contains(path.lexically_normal().string()); }

  void list_found(const fs::path& folder, const std::vector<File>& found) {
    std::map<FileKind, std::vector<std::string>> steps;
    std::map<std::string, FileKind> kinds;
    for (const File& file : found) {
      const fs::path path = folder / file.name;
      if (is_piece(path))
        pass_over(path, kPiece);
      else if (is_step(file.of.kind))
        steps[file.of.kind].push_back(file.name);
      else
        add(path, file.of.kind, {path});
    }
    for (auto& [kind, names] : steps)
      for (const NameGroup& group : group_by_number(std::move(names))) {
        std::vector<fs::path> members;
        for (const std::string& member : group.members) members.push_back(folder / member);
        add(folder / group.name, kind, members);
      }
  }

  void list_pictures(const fs::path& folder, const std::vector<fs::path>& pictures) {
    std::vector<std::string> names;
    for (const fs::path& path : pictures) {
      if (is_piece(path))
        pass_over(path, kPiece);
      else
        names.push_back(path.filename().string());
    }
    for (const NameGroup& group : group_by_number(std::move(names))) {
      std::vector<fs::path> members;
      for (const std::string& member : group.members) members.push_back(folder / member);
      const bool tiff = ends_with_one_of(small_letters(group.name), ".tif .tiff");
      if (members.size() >= kLeastSlices)
        add(folder / group.name, FileKind::pictures, members);
      else
        for (const fs::path& member : members)
          if (tiff)
            add(member, FileKind::tiff, {member});  // its pages may be slices
          else
            pass_over(member, "one picture; a stack of at least 3 numbered ones is listed as a volume");
    }
  }

  /// Why a file of a format that is read is none to open by itself; empty where it is.
  static std::string not_a_grid(const fs::path& path, const Recognised& of) {
    const std::string name = small_letters(path.filename().string());
    if (of.kind == FileKind::plot3d && !ends_with_one_of(name, ".xyz .p3d .x .g xyz.bin")) return kSolution;
    if (of.kind == FileKind::openfoam) return "a mark of an OpenFOAM case without the case around it";
    if (of.vtk_type == "PolyData" || of.vtk_type == "PPolyData") return "a surface; expected a grid whose cells have a volume";
    if (of.kind != FileKind::vtk_xml) return {};
    if (of.vtk_type.starts_with("Hyper") || of.vtk_type.ends_with("AMR")) return "a grid of levels; save it as .vtu or .vti (ParaView: Resample To Image)";
    if (!of.vtk_type.ends_with("ImageData") && !of.vtk_type.ends_with("Grid")) return "XML VTK of a type that is no grid";
    return {};
  }

  static std::string without_name(std::string message, const std::string& name) {
    if (message.starts_with(name + ": ")) message.erase(0, name.size() + 2);
    return message;
  }

  const fs::path root_;
  const std::size_t most_;
  std::int64_t seen_ = 0;
  std::set<std::string> pieces_;
  std::map<std::string, PassedOver> passed_;
  FolderListing out_;
};

}  // namespace

FolderListing list_folder(const fs::path& folder, std::size_t most) {
  std::error_code error;
  const fs::path root = fs::canonical(folder, error);
  if (!error) fs::directory_iterator(root, error);
  if (error) throw Error(ErrorCode::not_found, folder.string() + ": this directory cannot be listed: " + error.message());
  return Lister(root, most).run();
}

}  // namespace isostrata
