// A cell cut into interval volumes around one point inside it: what the strict triangulation falls back on.
//
// The cell's faces are divided as the interval tables divide them: into triangles that lie each in one *slab*, a piece of the
// range between isovalues that follow one another (the intervals, the gaps between them, what is below and what is above). All
// triangles are joined to a point c inside the cell. In each of these tetrahedra the field is taken to be linear, so the
// isovalues cut it in parallel to its base, and the slices are prisms. No slice can be turned unless its whole tetrahedron is,
// and that is the case only where c does not see the triangle from inside. So wherever the cell has a point that sees all of its
// faces, its intervals have a triangulation without a turned tetrahedron, with the facets on the cell's faces unchanged; and
// because the slices tile the cell, the volumes of intervals that tile the range still add up to the cell's.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "extraction/cells/cell_point.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Numbers are into points; those with a >= 0 lie on the cell's edges.
struct StarCell {
  struct Tetrahedron {
    std::array<std::uint32_t, 4> points{};  // into points
    std::uint16_t interval = 0;             // as given
  };
  struct Facet {
    std::array<std::uint32_t, 3> points{};
    std::uint16_t interval = 0;
    FacetLabel label = FacetLabel::lower;  // or upper
  };
  std::vector<CellPoint> points;
  std::vector<Tetrahedron> tetrahedra;  // positive, in left-handed cells too
  std::vector<Facet> facets;            // on the isosurfaces, in no particular direction
};

/// The parts of `intervals` (into rules.rules(), by increasing `lower`, not overlapping) in the cell. Empty if no point inside
/// the cell sees all triangles of its faces: the cell is tangled, or without volume. Any thread.
std::optional<StarCell> star_cell(const CellGeometry& cell, const IsoRules& rules, std::span<const std::uint16_t> intervals);

}  // namespace isostrata
