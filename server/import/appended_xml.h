// A VTK XML file whose arrays lie behind its elements as they lie in memory: raw, not compressed, in the machine's byte order.
//
// Simulations that write such files themselves mostly do so. VTK's readers copy such arrays into memory one by one; here they are found in the mapped file.
#pragma once

#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "import/imported.h"
#include "import/mapped_file.h"

namespace isostrata {

class AppendedXml {
 public:
  /// Nothing for every other file, and for one shorter than kLeastInPlace. What is wrong with a file is VTK's readers' to say.
  static std::optional<AppendedXml> open(const std::filesystem::path& file);

  struct Piece {
    vtkXMLDataElement *grid, *piece;
  };
  /// The only piece of a file of this kind ("ImageData"). Beside it there may be fields, of which readers want the time alone (declared_time.h).
  std::optional<Piece> only_piece(std::string_view kind) const;

  /// Name, type, components and bytes of a DataArray of at least this many whole tuples and no more. Values may lie at any address.
  std::optional<FileArray> array(vtkXMLDataElement* element, std::uint64_t tuples) const;
  /// Appends the arrays of a PointData or CellData, aligned if somebody has to read them as numbers. False if one of them is no such array, or says what
  /// belongs to no array: ghosts, numbers in a whole.
  bool add_values(vtkXMLDataElement* attributes, bool on_cells, std::uint64_t tuples, std::vector<FileArray>& to) const;

 private:
  AppendedXml() = default;

  std::shared_ptr<const MappedFile> file_;
  vtkSmartPointer<vtkXMLDataElement> root_;
  std::uint64_t data_ = 0;  // where offsets count from
  bool wide_ = false;       // an array's length has 8 bytes
};

std::string_view attribute(vtkXMLDataElement* element, const char* name);

/// With its own values where those in the file may not be read as numbers where they lie.
FileArray aligned(FileArray array);

}  // namespace isostrata
