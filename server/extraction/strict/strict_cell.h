// One cell of an extracted mesh, triangulated without turned tetrahedra.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/cells/cell_point.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/mesh/interval_mesh.h"
#include "extraction/strict/pulled_region.h"
#include "extraction/strict/star_cell.h"

namespace isostrata {

/// What replaces the tetrahedra and the boundary facets of a run of the mesh.
struct CellFix {
  std::int64_t run = 0;
  std::vector<TetrahedronPoints> tetrahedra;  // numbers from the mesh's number of points on are new_points, in order
  std::vector<std::uint16_t> intervals;       // [tetrahedra]
  std::vector<BoundaryFacet> facets;          // numbered likewise; tetrahedron: counted from the cell's first
  std::vector<CellPoint> new_points;
  std::array<std::int64_t, kMaxCellVertices> ids{};
  int vertices = 0;
};

/// The mesh of one request, cell by cell. Any thread; what is given must outlive it.
class StrictCells {
 public:
  StrictCells(const Grid& grid, const PointArray& array, const IsoRules& rules, bool facets, const IntervalMesh& mesh)
      : grid_(grid), array_(array), rules_(rules), facets_(facets), mesh_(mesh) {}

  /// Where the cell of a run has turned tetrahedra: counts it in `done`, and returns what replaces them, if anything.
  std::optional<CellFix> fix(std::int64_t run, StrictSummary& done) const;

  /// The volume of a tetrahedron in the run is taken for flat within this.
  double tolerance(std::int64_t run) const { return read_cell(mesh_.cell_runs[static_cast<std::size_t>(run)].cell).tolerance; }

 private:
  /// The tetrahedra of one interval in the cell.
  struct Part {
    std::vector<TetrahedronPoints> tetrahedra;
    bool turned = false;  // has one that is
    bool star = false;    // cut around a point: its isosurfaces are new
  };
  using Parts = std::map<std::uint16_t, Part>;  // by interval

  struct Tetrahedra {
    std::size_t first = 0, last = 0;
  };

  CellGeometry read_cell(std::int64_t cell) const;
  double volume_of(const TetrahedronPoints& t) const;
  std::map<std::uint32_t, unsigned> faces_of_points(const CellGeometry& cell, Tetrahedra old) const;
  std::vector<std::vector<std::uint16_t>> chains_of(const Parts& parts) const;
  bool cut_around_a_point(const CellGeometry& cell, Tetrahedra old, std::span<const std::uint16_t> chain, Parts& parts,
                          CellFix& fix, std::vector<StarCell::Facet>& facets) const;
  std::optional<std::uint32_t> find_point(const CellGeometry& cell, const CellPoint& point, Tetrahedra old) const;
  void find_facets(Tetrahedra old, const Parts& parts, std::span<const StarCell::Facet> on_isosurfaces, CellFix& fix) const;

  const Grid& grid_;
  const PointArray& array_;
  const IsoRules& rules_;
  const bool facets_;
  const IntervalMesh& mesh_;
};

}  // namespace isostrata
