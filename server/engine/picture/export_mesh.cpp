#include "engine/picture/export_mesh.h"

#include "engine/picture/draw_scene.h"

namespace isostrata {

ExportedMesh export_mesh(const StepSource& steps, const Scene& scene, const std::filesystem::path& path,
                         const WriteOptions& options, const Task& task) {
  check_mesh_path(path);
  if (scene.intervals.empty()) throw Error(ErrorCode::not_found, "the scene has no interval: there is no mesh to write");
  Scene plain = scene;
  plain.mode = SceneMode::sorted;
  LayerRequest request = layer_request(plain);
  request.facets = path.extension() != ".vtu";
  if (request.array.empty()) {
    const auto dataset = steps(request.step, task);
    if (dataset->arrays.empty()) throw Error(ErrorCode::not_found, dataset->name + ": no point array; expected at least one");
    request.array = dataset->arrays.front().name;
  }
  request.carry.clear();
  if (!scene.color_by.empty() && scene.color_by != request.array) request.carry.push_back(scene.color_by);
  const Layers layers = extract_layers(request, steps, task);
  task.report(0.9, "writing");
  write_mesh(path, layers.mesh, request.array, layers.carried, options, task);
  ExportedMesh made;
  std::error_code error;
  made.bytes = std::filesystem::file_size(path, error);
  made.tetrahedra = static_cast<std::int64_t>(layers.mesh.tetrahedra.size());
  made.points = static_cast<std::int64_t>(layers.mesh.positions.size());
  made.facets = static_cast<std::int64_t>(layers.mesh.facets.size());
  return made;
}

}  // namespace isostrata
