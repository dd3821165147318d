#include "extraction/files/vtk_xml.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>

#include "base/error.h"
#include "base/parallel.h"

namespace isostrata {
namespace {

static_assert(std::endian::native == std::endian::little,
              "formats are written in little-endian byte order as they lie in memory");

constexpr std::uint64_t kBlockBytes = 256 << 10;
constexpr std::uint64_t kBlocksAtATime = 32;

constexpr std::uint64_t kAlignment = 8;

void compress_block(const std::vector<std::byte>& from, int level, std::vector<std::byte>& to) {
  auto size = static_cast<uLongf>(compressBound(static_cast<uLong>(from.size())));
  to.resize(size);
  const int status = compress2(reinterpret_cast<Bytef*>(to.data()), &size, reinterpret_cast<const Bytef*>(from.data()),
                               static_cast<uLong>(from.size()), level);
  if (status != Z_OK) throw Error(ErrorCode::internal, "zlib: compress2 returned " + std::to_string(status));
  to.resize(size);
}

std::uint64_t items_per_block(const VtkArray& array) { return std::max<std::uint64_t>(1, kBlockBytes / array.item_bytes); }

/// Calls put(block, its bytes) in the order of the blocks; compressed ones at a level above 0.
template <class Put>
void for_blocks(const VtkArray& array, int compression, const Task& task, const Put& put) {
  const std::uint64_t per_block = items_per_block(array), blocks = (array.count + per_block - 1) / per_block;
  std::array<std::vector<std::byte>, kBlocksAtATime> plain, packed;
  for (std::uint64_t first = 0; first < blocks; first += kBlocksAtATime) {
    const std::uint64_t count = std::min(kBlocksAtATime, blocks - first);
    parallel_for(static_cast<std::int64_t>(count), 1, [&](std::int64_t from, std::int64_t to) {
      for (std::int64_t b = from; b < to; ++b) {
        task.check();
        const std::uint64_t item = (first + static_cast<std::uint64_t>(b)) * per_block;
        const std::uint64_t last = std::min(array.count, item + per_block);
        plain[b].resize((last - item) * array.item_bytes);
        array.fill(item, last, plain[b].data());
        if (compression != 0) compress_block(plain[b], compression, packed[b]);
      }
    });
    for (std::uint64_t b = 0; b < count; ++b) put(first + b, compression == 0 ? plain[b] : packed[b]);
  }
}

}  // namespace

std::string xml_text(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += static_cast<unsigned char>(c) < 0x20 ? '_' : c;
    }
  }
  return out;
}

void write_plain(OutputFile& out, const VtkArray& array, const Task& task) {
  for_blocks(array, 0, task, [&](std::uint64_t, const std::vector<std::byte>& bytes) { out.write(bytes); });
}

void write_appended(OutputFile& out, const VtkArray& array, int compression, const Task& task) {
  if (compression == 0) {
    out.put(array.count * array.item_bytes);
    return write_plain(out, array, task);
  }
  const std::uint64_t per_block = items_per_block(array), blocks = (array.count + per_block - 1) / per_block;
  const std::uint64_t begin = out.size();
  std::vector<std::uint64_t> table(3 + blocks);
  table[0] = blocks;
  table[1] = per_block * array.item_bytes;
  table[2] = array.count % per_block * array.item_bytes;
  out.write(std::as_bytes(std::span(table)));  // the sizes are filled in afterwards
  for_blocks(array, compression, task, [&](std::uint64_t block, const std::vector<std::byte>& bytes) {
    out.write(bytes);
    table[3 + block] = bytes.size();
  });
  out.patch(begin, std::as_bytes(std::span(table)));
}

void write_vtk_xml(OutputFile& out, const VtkXml& file, int compression, const Task& task) {
  out.text("<?xml version=\"1.0\"?>\n<VTKFile type=\"" + file.type +
           "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"");
  if (compression != 0) out.text(" compressor=\"vtkZLibDataCompressor\"");
  out.text(">\n  <" + file.type + file.attributes + ">\n    <Piece" + file.piece + ">\n");
  std::vector<std::uint64_t> offset_at;  // where each array's offset stands, filled in once it is known
  const std::string room(21, ' ');       // for 20 digits and the closing quote
  for (const VtkSection& section : file.sections) {
    out.text(std::string("      <") + section.tag + section.attributes + ">\n");
    for (const VtkArray& array : section.arrays) {
      out.text("        <DataArray type=\"" + array.type + "\" Name=\"" + xml_text(array.name) + "\" NumberOfComponents=\"" +
               std::to_string(array.components) + "\" format=\"appended\" offset=\"");
      offset_at.push_back(out.size());
      out.text(room + (array.unit.empty() ? "/>\n" : ">\n          <InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">" + xml_text(array.unit) + "</InformationKey>\n        </DataArray>\n"));
    }
    out.text(std::string("      </") + section.tag + ">\n");
  }
  out.text("    </Piece>\n  </" + file.type + ">\n  <AppendedData encoding=\"raw\">\n   _");
  const std::uint64_t base = out.size();
  auto at = offset_at.begin();
  for (const VtkSection& section : file.sections)
    for (const VtkArray& array : section.arrays) {
      static constexpr std::array<std::byte, kAlignment> kNothing{};
      out.write(std::span(kNothing).first(static_cast<std::size_t>(-out.size() % kAlignment)));  // values that lie so can be mapped where they lie
      const std::string offset = std::to_string(out.size() - base) + "\"";
      out.patch(*at++, std::as_bytes(std::span(offset)));
      write_appended(out, array, compression, task);
    }
  out.text("\n  </AppendedData>\n</VTKFile>\n");
}

void write_vtk_list(OutputFile& out, const VtkXml& file, std::span<const std::string> pieces) {
  out.text("<?xml version=\"1.0\"?>\n<VTKFile type=\"P" + file.type + "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <P" +
           file.type + file.attributes + ">\n");
  for (const VtkSection& section : file.sections) {
    if (section.tag == std::string_view("Cells")) continue;  // of each piece
    out.text(std::string("    <P") + section.tag + section.attributes + ">\n");
    for (const VtkArray& array : section.arrays)
      out.text("      <PDataArray type=\"" + array.type + "\" Name=\"" + xml_text(array.name) + "\" NumberOfComponents=\"" +
               std::to_string(array.components) + "\"/>\n");
    out.text(std::string("    </P") + section.tag + ">\n");
  }
  for (const std::string& piece : pieces) out.text("    <Piece" + piece + "/>\n");
  out.text("  </P" + file.type + ">\n</VTKFile>\n");
}

}  // namespace isostrata
