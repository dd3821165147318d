// What all sessions share of datasets beside their arrays: each is made once, and kept for whoever needs it next.
#pragma once

#include <cstdint>
#include <utility>

#include "data/derived/scaled_dataset.h"
#include "engine/picture/base_meshes.h"
#include "engine/picture/coarse_scene.h"
#include "extraction/bricks/brick_memory.h"
#include "extraction/layers/extract_layers.h"
#include "extraction/unstructured/face_memory.h"
#include "extraction/unstructured/ordered_memory.h"

namespace isostrata {

/// Any thread may use any of them.
struct SharedMeshes {
  SharedMeshes(std::int64_t least_coarse_cells, std::uint64_t max_bytes) : coarse(least_coarse_cells), bases(max_bytes), ordered(max_bytes), faces(max_bytes) {}

  CoarseScenes coarse;
  BrickMemory bricks;
  BaseMeshes bases;
  OrderedMemory ordered;
  FaceMemory faces;
  ScaledDatasets scaled;

  StepSource scaled_steps(StepSource steps, Vec3d axis_scale) {
    return [this, steps = std::move(steps), axis_scale](int step, const Task& task) { return scaled.scaled(steps(step, task), axis_scale); };
  }

  /// Of --max-memory.
  std::uint64_t held_bytes() { return bases.held_bytes() + ordered.bytes() + faces.bytes() + coarse.held_bytes(); }
};

}  // namespace isostrata
