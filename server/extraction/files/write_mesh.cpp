#include "extraction/files/write_mesh.h"

#include <algorithm>
#include <iterator>
#include <vector>

#include "base/error.h"
#include "extraction/files/output_file.h"
#include "extraction/files/write_bounded_mesh.h"
#include "extraction/files/write_surface.h"
#include "extraction/files/write_vtkhdf.h"
#include "extraction/files/write_vtu.h"

namespace isostrata {

void check_mesh_path(const std::filesystem::path& path) {
  const std::string ending = path.extension().string();
  if (ending != ".vtu" && ending != ".vtkhdf" && ending != ".ply" && ending != ".stl")
    throw Error(ErrorCode::unsupported, path.string() + ": unknown ending '" + ending + "'; expected .vtu, .vtkhdf, .ply or .stl");
}

void write_mesh(const std::filesystem::path& path, const IntervalMesh& mesh, const std::string& array_name,
                std::span<const MeshArray> more, const WriteOptions& options, const Task& task) {
  write_bounded_mesh(path, OutputFile::kNoEnd, mesh, array_name, more, options, task);
}

void write_bounded_mesh(const std::filesystem::path& path, std::uint64_t most, const IntervalMesh& mesh, const std::string& array_name,
                        std::span<const MeshArray> more, const WriteOptions& options, const Task& task) {
  check_mesh_path(path);
  const std::string ending = path.extension().string();
  OutputFile out(path, most);
  if (ending == ".vtu") write_vtu(out, mesh, array_name, more, options.compression, task);
  if (ending == ".vtkhdf") write_vtkhdf(out, mesh, array_name, more, task);
  if (ending == ".ply") {
    std::vector<MeshArray> at_points;
    std::copy_if(more.begin(), more.end(), std::back_inserter(at_points), [](const MeshArray& array) { return !array.in_cells; });
    write_ply(out, mesh, at_points, options.facets, task);
  }
  if (ending == ".stl") write_stl(out, mesh, options.facets, task);
  out.finish();
}

}  // namespace isostrata
