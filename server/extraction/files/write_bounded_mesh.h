// Mesh files on a disk that has other uses.
#pragma once

#include "extraction/files/write_mesh.h"

namespace isostrata {

/// As write_mesh, and throws too_large, leaving nothing, if the file would have more than `most` bytes.
void write_bounded_mesh(const std::filesystem::path& path, std::uint64_t most, const IntervalMesh& mesh, const std::string& array_name,
                        std::span<const MeshArray> more, const WriteOptions& options, const Task& task);

}  // namespace isostrata
