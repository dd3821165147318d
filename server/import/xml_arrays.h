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

#include "import/imported.h"
#include "import/mapped_file.h"
#include "import/xml_coding.h"

namespace isostrata {

/// An array where it stands. Those of `as` are its name, type, components and association; its values as well, where they lie as in memory.
struct XmlArray {
  FileArray as;
  CodedValues coded;
};

class XmlArrays {
 public:
  /// Nothing for files of the other byte order, and for values packed by other than zlib and LZ4. What is wrong with a file is VTK's readers' to say.
  static std::optional<XmlArrays> open(const std::filesystem::path& file);

  struct Piece {
    vtkXMLDataElement *grid, *piece;
  };
  /// The only piece of a file of this kind ("ImageData"), of one step. Beside it there may be fields, of which readers want the time alone (declared_time.h).
  std::optional<Piece> only_piece(std::string_view kind) const;

  /// The only number of a field of this name, if it is a real one.
  std::optional<double> field(std::string_view name) const;

  /// A DataArray of whole tuples, as many as are there.
  std::optional<XmlArray> array(vtkXMLDataElement* element) const;
  /// Of this many tuples and no more.
  std::optional<XmlArray> array(vtkXMLDataElement* element, std::uint64_t tuples) const;
  /// Appends the arrays of a PointData or CellData. False if one of them is no such array, or says what belongs to no array: ghosts, numbers in a whole.
  bool add_values(vtkXMLDataElement* attributes, bool on_cells, std::uint64_t tuples, std::vector<XmlArray>& to) const;

 private:
  XmlArrays() = default;

  std::shared_ptr<const MappedFile> file_;
  vtkSmartPointer<vtkXMLDataElement> root_;
  std::size_t appended_ = 0;  // where offsets count from; 0: nothing is appended
  XmlCoding coding_;          // of what is appended
};

/// Throws bad_data where a file ends before one of its appended arrays that are not packed does, of any byte order: VTK's readers take what is missing for zeros.
/// Of packed ones, and of what is not appended, they see it.
void check_appended(const std::filesystem::path& file);

std::string_view attribute(vtkXMLDataElement* element, const char* name);

/// What those of them take in memory that do not lie in the file as there.
std::uint64_t decoded_bytes(const std::vector<XmlArray>& arrays);
/// Its values as in memory; nothing where they are damaged. Somebody has said that there is room for them.
std::optional<FileArray> decoded(const XmlArray& array);
/// All of them, at addresses where several components can be read as numbers.
std::optional<std::vector<FileArray>> decoded(const std::vector<XmlArray>& arrays);

/// With its own values where those in the file may not be read as numbers where they lie.
FileArray aligned(FileArray array);

}  // namespace isostrata
