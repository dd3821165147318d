// A scene's layers as a mesh file.
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/task.h"
#include "engine/scene.h"
#include "extraction/extract_layers.h"
#include "extraction/write_mesh.h"

namespace isostrata {

struct ExportedMesh {
  std::uint64_t bytes = 0;  // of the file
  std::int64_t tetrahedra = 0, points = 0, facets = 0;
};

/// Extracts all intervals of the scene, hidden ones too, with its terms, time and triangulation (of a smear: the scene's step),
/// and writes them as write_mesh does, the colour array with them. Throws what extract_layers and write_mesh throw, and not_found
/// where there is no array or no interval. Any thread.
ExportedMesh export_mesh(const StepSource& steps, const Scene& scene, const std::filesystem::path& path,
                         const WriteOptions& options, const Task& task);

}  // namespace isostrata
