// The zones of a Tecplot file: grids or meshes with values of the file's variables, whether it is text or binary.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "import/imported/imported.h"

namespace isostrata {

enum class TecplotKind { ordered, line, triangle, quadrilateral, tetrahedron, brick };

/// Nodes of an element; 0 for ordered.
int tecplot_nodes(TecplotKind kind);

/// What a zone has of a variable.
struct TecplotValues {
  bool on_cells = false;
  int shared_with = -1;           // the zone whose values these are
  bool passive = false;           // none
  std::size_t at = 0;             // where they begin, in a binary file
  std::size_t stored = 0;         // how many there are, in a binary file: with the places beside cells
  ScalarType type = ScalarType::float64;
};

struct TecplotZone {
  std::string name;
  double time = 0;
  bool timed = false;  // it is of that time alone; else of all
  TecplotKind kind = TecplotKind::ordered;
  std::array<std::int64_t, 3> dims{1, 1, 1};  // of ordered zones
  std::int64_t points = 0, cells = 0;
  std::vector<TecplotValues> values;  // of each variable
  bool by_points = false;             // text: all values of a point stand together
  int mesh_of = -1;                   // the zone whose elements these are
  std::size_t at = 0;                 // where the numbers begin, or in a binary file the elements

  /// 3 for what has a volume, 2 for surfaces, 1 or 0 for the rest.
  int dimension() const;
  std::int64_t count(const TecplotValues& of) const { return of.on_cells ? cells : points; }
  void set_ordered(const std::array<std::int64_t, 3>& size, const std::string& file);
};

struct TecplotFile {
  std::vector<std::string> variables;
  std::vector<TecplotZone> zones;
};

/// What was read of a zone: values[variable], empty if it has none of its own, and the elements' nodes from 0.
struct TecplotNumbers {
  std::vector<FileArray> values;
  std::vector<std::int64_t> nodes;
};

/// Of a file that begins with "#!TDV". Throws bad_data, unsupported, too_large.
TecplotFile tecplot_binary(std::span<const std::byte> bytes, const std::string& name);
TecplotNumbers load_tecplot_binary(std::span<const std::byte> bytes, const TecplotFile& file, const TecplotZone& zone, const std::string& name);
/// Of any other.
TecplotFile tecplot_text(std::string_view text, const std::string& name);
TecplotNumbers load_tecplot_text(std::string_view text, const TecplotFile& file, const TecplotZone& zone, const std::string& name);

}  // namespace isostrata
