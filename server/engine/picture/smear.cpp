#include "engine/picture/smear.h"

#include <cstddef>
#include <span>
#include <string>
#include <variant>

#include "base/stopwatch.h"
#include "extraction/layers/join_meshes.h"

namespace isostrata {
namespace {

template <class T>
std::shared_ptr<const std::vector<T>> joined(std::span<const std::shared_ptr<const ExtractedScene>> parts,
                                             std::shared_ptr<const std::vector<T>> ExtractedScene::*member) {
  std::vector<T> all;
  for (const auto& part : parts) {
    const auto& values = (*part).*member;
    if (!values) return nullptr;
    all.insert(all.end(), values->begin(), values->end());
  }
  return std::make_shared<const std::vector<T>>(std::move(all));
}

bool same_shape(const Grid& a, const Grid& b) {
  const auto* ua = std::get_if<UniformGrid>(&a.shape);
  const auto* ub = std::get_if<UniformGrid>(&b.shape);
  if (ua && ub) return ua->dims == ub->dims && ua->origin == ub->origin && ua->spacing == ub->spacing;
  const auto* ra = std::get_if<RectilinearGrid>(&a.shape);
  const auto* rb = std::get_if<RectilinearGrid>(&b.shape);
  return ra && rb && ra->axes == rb->axes;
}

}  // namespace

std::shared_ptr<const ExtractedScene> extract_smear(const Scene& scene, const std::vector<SmearMoment>& moments, std::uint64_t max_bytes,
                                                    const std::function<std::shared_ptr<const ExtractedScene>(const Scene&)>& extract) {
  const Stopwatch watch;
  std::vector<std::shared_ptr<const ExtractedScene>> parts;
  std::uint64_t bytes = 0;
  for (const SmearMoment& moment : moments) {
    Scene one = scene;
    one.mode = SceneMode::sorted;
    one.step = moment.step;
    one.time = moment.time;
    parts.push_back(extract(one));
    bytes += mesh_bytes(*parts.back()->mesh);
    // All parts and the joined mesh are there at once. Steps are much alike, so the first ones tell of the others.
    const std::uint64_t foreseen = 2 * (bytes / parts.size()) * moments.size();
    if (foreseen > max_bytes)
      throw Error(ErrorCode::too_large, "a smear of " + std::to_string(moments.size()) + " steps or times needs about " +
                                            std::to_string(foreseen >> 20) + " MiB; " + std::to_string(max_bytes >> 20) +
                                            " MiB are allowed");
  }
  auto made = std::make_shared<ExtractedScene>(*parts.front());
  made->steps.clear();
  std::vector<const IntervalMesh*> meshes;
  for (std::size_t i = 0, summaries = 0; i < parts.size(); ++i) {
    made->steps.insert(made->steps.end(), parts[i]->steps.begin(), parts[i]->steps.end());
    made->parts.push_back({moments[i], summaries});
    summaries += parts[i]->mesh->summaries.size();
    made->bounds.include(parts[i]->bounds.lower);
    made->bounds.include(parts[i]->bounds.upper);
    made->same_grid = made->same_grid && same_shape(parts[i]->dataset->grid, made->dataset->grid);
    meshes.push_back(parts[i]->mesh.get());
  }
  made->mesh = std::make_shared<const IntervalMesh>(join_meshes(meshes, max_bytes));
  made->color_values = joined(parts, &ExtractedScene::color_values);
  made->texture_values = joined(parts, &ExtractedScene::texture_values);
  made->normals = joined(parts, &ExtractedScene::normals);
  made->body_normals = joined(parts, &ExtractedScene::body_normals);
  made->extract_ms = watch.elapsed_ms();
  return made;
}

}  // namespace isostrata
