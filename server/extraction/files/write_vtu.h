// VTK's XML format for unstructured grids, binary, compressed or not, in blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/task.h"
#include "extraction/files/output_file.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Values that are made when they are written.
struct VtuArray {
  std::string type, name;  // VTK's name of the type: "Float64", ...
  int components = 1;
  std::uint64_t count = 0;                                                           // of items
  std::uint64_t item_bytes = 0;                                                      // of all components of an item
  std::function<void(std::uint64_t first, std::uint64_t last, std::byte* to)> fill;  // called from any thread
};

/// Writes items in blocks of about 256 KiB, some at a time on the pool: with compression 0 their byte count and bytes, else
/// vtkZLibDataCompressor's table (number of blocks, bytes in a block, bytes in the last one where it is shorter, compressed bytes
/// of each) and compressed blocks. All sizes have 64 bits. Throws unavailable, cancelled.
void write_appended(OutputFile& out, const VtuArray& array, int compression, const Task& task);

/// What write_mesh writes for .vtu.
void write_vtu(OutputFile& out, const IntervalMesh& mesh, const std::string& array_name, std::span<const MeshArray> more,
               int compression, const Task& task);

/// The list of .vtu files (.pvtu) that are one mesh: their names, and the arrays that write_vtu gave each of them. array_name: empty where they have no
/// values. Throws unavailable.
void write_pvtu(OutputFile& out, std::span<const std::string> pieces, const std::string& array_name, std::span<const std::string> more);

}  // namespace isostrata
