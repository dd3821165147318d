#include "engine/picture/extracted_scene.h"

#include "extraction/layers/join_meshes.h"

namespace isostrata {

std::int64_t tetrahedra_of(const ExtractedScene& extracted) {
  std::int64_t sum = 0;
  for (const IntervalSummary& summary : extracted.summaries()) sum += summary.tetrahedra;
  return sum;
}

std::uint64_t scene_bytes(const ExtractedScene& extracted) {
  const auto bytes = [](const auto& values) -> std::uint64_t { return values ? values->size() * sizeof((*values)[0]) : 0; };
  if (extracted.base) return 0;  // everybody's
  if (extracted.bricks) return extracted.bricks->bytes();
  // What is drawn is the mesh's points and tetrahedra, or its facets, once more.
  return 2 * mesh_bytes(*extracted.mesh) + bytes(extracted.color_values) + bytes(extracted.texture_values) + bytes(extracted.normals) +
         (extracted.body_normals != extracted.normals ? bytes(extracted.body_normals) : 0) + extracted.time.bytes;
}

void set_range(const PointArray& array, FieldValues values, double& lower, double& upper) {
  const bool whole = values == FieldValues::whole && array.cells;
  const double least = whole ? array.cells->lower : array.lower, most = whole ? array.cells->upper : array.upper;
  if (!(least <= most)) return;
  lower = least;
  upper = most;
}

}  // namespace isostrata
