#include <zlib.h>

#include <cstdio>
#include <vector>

#include "data/files/recognise.h"
#include "import/imported/read_file.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

/// Unpacks into a file of the same name without ".gz", which goes with this.
class Unpacked {
 public:
  explicit Unpacked(const ReadRequest& request) : path_(request.scratch / request.file.stem()) {
    const std::string name = request.file.filename().string();
    const gzFile in = gzopen(request.file.c_str(), "rb");
    std::FILE* out = std::fopen(path_.c_str(), "wb");
    std::vector<char> buffer(1 << 20);
    std::uint64_t total = 0;
    int got = 0;
    bool written = out != nullptr;
    while (in && written && (got = gzread(in, buffer.data(), static_cast<unsigned>(buffer.size()))) > 0) {
      total += static_cast<std::uint64_t>(got);
      if (total > request.max_bytes) break;
      written = std::fwrite(buffer.data(), 1, static_cast<std::size_t>(got), out) == static_cast<std::size_t>(got);
    }
    const bool whole = in && got == 0 && gzclose_r(in) == Z_OK;
    if (out) written = std::fclose(out) == 0 && written;
    const auto give_up = [&](ErrorCode code, const std::string& why) {
      std::remove(path_.c_str());
      throw Error(code, name + ": " + why);
    };
    if (total > request.max_bytes) give_up(ErrorCode::too_large, "unpacked it is more than " + std::to_string(request.max_bytes) + " bytes, the limit");
    if (!written) give_up(ErrorCode::unavailable, "cannot be unpacked: no room for a temporary file");
    if (!whole) give_up(ErrorCode::bad_data, "its gzip data is damaged or cut off");
  }
  ~Unpacked() { std::remove(path_.c_str()); }
  Unpacked(const Unpacked&) = delete;
  Unpacked& operator=(const Unpacked&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

bool is_one_file(const Recognised& of) {
  switch (of.kind) {
    case FileKind::vtk_xml:
      return !of.vtk_type.starts_with("P") || of.vtk_type == "PolyData";
    case FileKind::vtk_legacy: case FileKind::vtkhdf: case FileKind::nrrd: case FileKind::meta_image: case FileKind::numpy:
    case FileKind::tiff: case FileKind::slc: case FileKind::gaussian_cube: case FileKind::xsf: case FileKind::vasp: case FileKind::gmsh: case FileKind::frd: case FileKind::tecplot: case FileKind::cgns: case FileKind::exodus: case FileKind::netcdf:
    case FileKind::med: case FileKind::ucd: case FileKind::raw: case FileKind::mrtrix: case FileKind::opendx: case FileKind::amira: case FileKind::fits: case FileKind::mrc: case FileKind::npz: case FileKind::hdf5:
      return true;
    default:
      return false;
  }
}

}  // namespace

Imported read_gzip(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  const Unpacked unpacked(request);
  ReadRequest inner = request;
  inner.file = unpacked.path();
  const Recognised of = recognise(inner.file);
  if (!is_one_file(of)) throw Error(ErrorCode::unsupported, name + ": a format of several files inside gzip; unpack it beside the others");
  return read_file(inner);
}

}  // namespace isostrata
