// A scene's layers as a mesh file.
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/task.h"
#include "engine/messages/exported_mesh.h"
#include "extraction/files/write_mesh.h"
#include "extraction/layers/extract_layers.h"
#include "scene/scene.h"

namespace isostrata {

/// Extracts all intervals of the scene, hidden ones too, with its terms, time and triangulation (of a smear: the scene's step),
/// and writes them as write_mesh does, the colour array with them. Throws what extract_layers and write_mesh throw, and not_found
/// if there is no array or no interval; too_large, with the numbers, if it would take more memory or more of the disk than `room`. Any thread.
struct ExportRoom {
  std::uint64_t memory = 16ull << 30;
  std::uint64_t exports = 16ull << 30;  // of all files in the path's folder, of which two at most are being written
};
ExportedMesh export_mesh(const StepSource& steps, const Scene& scene, const std::filesystem::path& path,
                         const WriteOptions& options, const ExportRoom& room, const Task& task);

}  // namespace isostrata
