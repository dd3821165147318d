// What all sessions share of datasets beside their arrays: each is made once, and kept for whoever needs it next.
#pragma once

#include <cstdint>

#include "engine/picture/base_meshes.h"
#include "engine/picture/coarse_scene.h"
#include "extraction/bricks/brick_memory.h"
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

  /// Of --max-memory.
  std::uint64_t held_bytes() { return bases.held_bytes() + ordered.bytes() + faces.bytes() + coarse.held_bytes(); }
};

}  // namespace isostrata
