// VTK's XML files, read past VTK's readers: where each array stands, as it lies in memory or coded (xml_coding.h).
//
// Simulations that write such files themselves mostly append raw arrays, which are found in the mapped file and not copied. What ParaView, PyVista and meshio
// write is packed in blocks, and is unpacked on all threads.
#pragma once

#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "import/bytes/mapped_file.h"
#include "import/bytes/xml_coding.h"
#include "import/imported/imported.h"

namespace isostrata {

/// An array where it stands. Those of `as` are its name, type, components and association; its values as well, where they lie as in memory.
struct XmlArray {
  FileArray as;
  CodedValues coded;
};

/// Values of one bit each, the highest bit of a byte first.
struct XmlBits {
  std::vector<std::uint8_t> bytes;
  std::uint64_t count = 0;

  /// 0 if there is none.
  bool operator[](std::uint64_t at) const { return at < count && (bytes[at / 8] >> (7 - at % 8) & 1) != 0; }
  void append(bool value) {
    if (count % 8 == 0) bytes.push_back(0);
    bytes[count / 8] |= static_cast<std::uint8_t>(value << (7 - count % 8));
    ++count;
  }
  /// The first `many` of these others; 0 for those that they lack.
  void append(const XmlBits& others, std::uint64_t many);
};

class XmlArrays {
 public:
  /// Nothing for values packed by other than zlib and LZ4. What is wrong with a file is its reader's to say.
  static std::optional<XmlArrays> open(const std::filesystem::path& file);

  struct Piece {
    vtkXMLDataElement *grid, *piece;
  };
  /// The only piece of a file of this kind ("ImageData"), of one step. Beside it there may be fields, of which readers want the time alone (declared_time.h).
  std::optional<Piece> only_piece(std::string_view kind) const;

  /// The only number of a field of this name, if it is a real one.
  std::optional<double> field(std::string_view name) const;

  vtkXMLDataElement* root() const { return root_; }

  /// Where the values of a DataArray stand that are not text, of any type; nothing if none stand there.
  std::optional<CodedValues> coded(vtkXMLDataElement* element) const;
  /// What a DataArray of numbers, or one of bits, holds, as text or not. Nothing if it is damaged. Somebody has said that there is room for it.
  std::optional<FileArray> values(vtkXMLDataElement* element) const;
  std::optional<XmlBits> bits(vtkXMLDataElement* element) const;

  /// A DataArray of whole tuples that are not text, as many as are there.
  std::optional<XmlArray> array(vtkXMLDataElement* element) const;
  /// Of this many tuples and no more.
  std::optional<XmlArray> array(vtkXMLDataElement* element, std::uint64_t tuples) const;
  /// Appends the arrays of a PointData or CellData. False if one of them is not such an array, or says what belongs to no array: ghosts, numbers in a whole.
  bool add_values(vtkXMLDataElement* attributes, bool on_cells, std::uint64_t tuples, std::vector<XmlArray>& to) const;

 private:
  XmlArrays() = default;
  std::optional<std::uint64_t> text_begin(vtkXMLDataElement* element) const;
  std::string_view text(vtkXMLDataElement* element) const;  // between its tags

  std::shared_ptr<const MappedFile> file_;
  vtkSmartPointer<vtkXMLDataElement> root_;
  std::size_t appended_ = 0;  // where offsets count from; 0: nothing is appended
  XmlCoding coding_;          // of what is appended
};

/// Throws bad_data if a file ends before one of its appended arrays that are not packed does, of any byte order: VTK's readers take what is missing for zeros.
/// Of packed ones, and of what is not appended, they see it.
void check_appended(const std::filesystem::path& file);

std::string_view attribute(vtkXMLDataElement* element, const char* name);

/// What those of them take in memory that do not lie in the file as there.
std::uint64_t decoded_bytes(const std::vector<XmlArray>& arrays);
/// Its values as in memory; nothing if they are damaged. Somebody has said that there is room for them.
std::optional<FileArray> decoded(const XmlArray& array);
/// All of them, at addresses where several components can be read as numbers.
std::optional<std::vector<FileArray>> decoded(const std::vector<XmlArray>& arrays);

/// With its own values where those in the file may not be read as numbers where they lie.
FileArray aligned(FileArray array);

}  // namespace isostrata
