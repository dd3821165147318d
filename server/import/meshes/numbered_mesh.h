// Meshes of programs that number their nodes and elements themselves, in any order and with gaps: Gmsh, CalculiX.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "import/imported/imported.h"

namespace isostrata {

/// An element of such a program that is one of VTK's cells.
struct ElementKind {
  int type = 0;   // the program's
  int nodes = 0;  // in the file
  int vtk_type = 0;
  int dimension = 3;
  std::vector<int> order;  // which of its nodes VTK has where; empty: as in the file. Nodes that VTK's cell lacks are left out
};

/// Null if there is none of this type.
const ElementKind* find_kind(std::span<const ElementKind> kinds, std::int64_t type);

/// by_step: by the numbers of steps, the times. Those, if they increase; else the numbers, since some programs give all steps one time.
std::vector<double> times_of(const std::map<std::int64_t, double>& by_step);

/// Where in the file each number stands: the first is at place 0.
class Numbering {
 public:
  void add(std::int64_t number) { all_.emplace_back(number, std::ssize(all_)); }
  /// After the last. Throws bad_data if two are one: "NAME: has two WHAT of number 7".
  void close(const std::string& name, const char* what);
  std::optional<std::int64_t> place(std::int64_t number) const;
  std::int64_t size() const { return std::ssize(all_); }

 private:
  std::vector<std::pair<std::int64_t, std::int64_t>> all_;  // number, place; in order once it is closed
};

/// One array, without a value (NaN) where the file gives none.
struct NumberedArray {
  NumberedArray(std::string called, bool cells, int components, std::int64_t tuples)
      : name(std::move(called)), on_cells(cells), components(components), values(static_cast<std::size_t>(tuples * components), std::numeric_limits<double>::quiet_NaN()) {}
  std::span<double> tuple(std::int64_t at) { return std::span(values).subspan(static_cast<std::size_t>(at * components), static_cast<std::size_t>(components)); }

  std::string name;
  bool on_cells;
  int components;
  std::vector<double> values;  // [tuples][components]
};

struct NumberedMesh {
  Numbering nodes, elements;
  std::vector<Vec3d> points;             // by the places of nodes
  std::vector<std::uint8_t> types;       // VTK's, by the places of elements
  std::vector<std::int64_t> ends{0}, ids;  // places of nodes, in VTK's order
  std::vector<NumberedArray> arrays;

  /// nodes: their numbers, in the file's order; once the nodes are closed. Throws bad_data if there is no such node.
  void add_element(std::int64_t number, const ElementKind& kind, std::span<const std::int64_t> nodes, const std::string& name);
  /// As one block. NaN stands for values that are not there.
  void append_to(Imported& imported, const ReadRequest& request);
};

}  // namespace isostrata
