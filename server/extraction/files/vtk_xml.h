// VTK's XML formats, binary: one piece with arrays behind it, compressed or not, in blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/task.h"
#include "extraction/files/output_file.h"

namespace isostrata {

/// Values that are made when they are written.
struct VtkArray {
  std::string type, name;  // VTK's name of the type: "Float64", ...
  int components = 1;
  std::uint64_t count = 0;                                                           // of items
  std::uint64_t item_bytes = 0;                                                      // of all components of an item
  std::function<void(std::uint64_t first, std::uint64_t last, std::byte* to)> fill;  // called from any thread
  std::string unit = {};                                                             // may be empty
};

/// value(i) for item i: of a type that lies in memory as it is written.
template <class Value>
VtkArray vtk_array(std::string type, std::string name, std::uint64_t count, int components, Value value) {
  using Item = decltype(value(std::uint64_t{0}));
  return {std::move(type),
          std::move(name),
          components,
          count,
          sizeof(Item),
          [value](std::uint64_t first, std::uint64_t last, std::byte* to) {
            for (std::uint64_t i = first; i < last; ++i, to += sizeof(Item)) {
              const Item item = value(i);
              std::memcpy(to, &item, sizeof item);
            }
          }};
}

struct VtkSection {
  const char* tag;  // "PointData", ...
  std::vector<VtkArray> arrays;
  std::string attributes;  // of the tag, each after a blank: ` Scalars="f"`
};

/// A file of one piece.
struct VtkXml {
  std::string type;               // "UnstructuredGrid", ...
  std::string attributes, piece;  // of that element and of the piece, each after a blank
  std::vector<VtkSection> sections;
};

/// For an attribute or a text: letters that XML keeps for itself are escaped, and what is below the blank becomes _.
std::string xml_text(const std::string& text);

/// Writes the file. Values lie at multiples of 8 bytes. Throws unavailable, cancelled.
void write_vtk_xml(OutputFile& out, const VtkXml& file, int compression, const Task& task);

/// Writes the list of files (type "PUnstructuredGrid" for "UnstructuredGrid") that are one grid, each with the sections of `file`, whose values are not
/// looked at. pieces: the attributes of each, Source among them. Throws unavailable.
void write_vtk_list(OutputFile& out, const VtkXml& file, std::span<const std::string> pieces);

/// Writes the items' bytes and nothing else, in blocks as write_appended. Throws unavailable, cancelled.
void write_plain(OutputFile& out, const VtkArray& array, const Task& task);

/// Writes items in blocks of about 256 KiB, some at a time on the pool: with compression 0 their byte count and bytes, else
/// vtkZLibDataCompressor's table (number of blocks, bytes in a block, bytes in the last one if it is shorter, compressed bytes
/// of each) and compressed blocks. All sizes have 64 bits. Throws unavailable, cancelled.
void write_appended(OutputFile& out, const VtkArray& array, int compression, const Task& task);

}  // namespace isostrata
