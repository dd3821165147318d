#include "engine/picture/export_mesh.h"

#include <algorithm>
#include <string>

#include "base/error.h"
#include "data/dataset/array_or_first.h"
#include "engine/picture/layer_request.h"
#include "extraction/files/write_bounded_mesh.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

std::uint64_t megabytes(std::uint64_t bytes) { return bytes / 1'000'000; }

/// Half of what is left for exports, for another one may be written beside it; and a tenth of the disk stays for others. Throws too_large
/// if there is none.
std::uint64_t room_on_disk(const fs::path& folder, std::uint64_t exports) {
  std::uint64_t taken = 0;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code gone;
    const std::uint64_t bytes = it->file_size(gone);
    if (!gone) taken += bytes;
  }
  const fs::space_info space = fs::space(folder, error);
  const std::uint64_t left = exports - std::min(exports, taken), free = error ? left : space.available - std::min(space.available, space.capacity / 10);
  constexpr std::uint64_t kLeast = 1 << 20;
  if (std::min(left / 2, free / 2) < kLeast)
    throw Error(ErrorCode::too_large, "exports take " + std::to_string(megabytes(taken)) + " MB of the " + std::to_string(megabytes(exports)) +
                                          " MB that they may, and " + std::to_string(error ? 0 : megabytes(space.available)) +
                                          " MB of the server's disk are free; DELETE one that is not needed any more");
  return std::min(left / 2, free / 2);
}

}  // namespace

ExportedMesh export_mesh(const StepSource& steps, const Scene& scene, const std::filesystem::path& path,
                         const WriteOptions& options, const ExportRoom& room, const Task& task) {
  check_mesh_path(path);
  room_on_disk(path.parent_path(), room.exports);
  if (scene.intervals.empty()) throw Error(ErrorCode::not_found, "the scene has no interval: there is no mesh to write");
  Scene plain = scene;
  plain.mode = SceneMode::sorted;
  LayerRequest request = layer_request(plain);
  request.facets = path.extension() != ".vtu" && path.extension() != ".vtkhdf";
  request.max_bytes = room.memory;
  if (request.array.empty()) request.array = array_or_first(*steps(request.step, task), "").name;
  request.carry.clear();
  if (request.values == FieldValues::whole) request.carry.push_back(request.array);
  if (!scene.color_by.empty() && scene.color_by != request.array) request.carry.push_back(scene.color_by);
  const Layers layers = extract_layers(request, steps, task);
  task.report(0.9, "writing");
  write_bounded_mesh(path, room_on_disk(path.parent_path(), room.exports), layers.mesh, request.array, layers.carried, options, task);
  ExportedMesh made;
  std::error_code error;
  made.bytes = std::filesystem::file_size(path, error);
  made.tetrahedra = static_cast<std::int64_t>(layers.mesh.tetrahedra.size());
  made.points = static_cast<std::int64_t>(layers.mesh.positions.size());
  made.facets = static_cast<std::int64_t>(layers.mesh.facets.size());
  return made;
}

}  // namespace isostrata
