// What a file says of its cells is looked at before it is used.
#pragma once

#include <vtkType.h>

#include <cstdint>
#include <string>
#include <utility>

class vtkCellArray;

namespace isostrata {

/// Each throws bad_data, with the file's name and with what is wrong.
class CellChecks {
 public:
  /// points: that the file has.
  CellChecks(std::string name, std::int64_t points) : name_(std::move(name)), points_(points) {}

  [[noreturn]] void broken(const std::string& what) const;
  /// VTK's IsValid and GetCellAtId trust them.
  void offsets(vtkCellArray* cells, const std::string& what) const;
  /// That the cell uses. Returns it.
  std::int64_t point(vtkIdType cell, vtkIdType id) const {
    if (id < 0 || id >= points_) broken("cell " + std::to_string(cell) + " uses point " + std::to_string(id) + " of " + std::to_string(points_));
    return id;
  }
  /// How many points the cell has.
  void count(vtkIdType cell, int vtk_type, vtkIdType given, vtkIdType wanted, bool or_more) const;

 private:
  const std::string name_;
  const std::int64_t points_;
};

}  // namespace isostrata
