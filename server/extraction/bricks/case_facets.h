// The facets of a cell's case that bound its interval.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "extraction/bricks/hexahedron_gather.h"
#include "extraction/cells/cell_geometry.h"

namespace isostrata {

/// Calls put(number of a tetrahedron among the case's, number of its facet, the facet's points as places of HexahedronGather, label) for each facet on
/// an end of the interval or in an open face, counter-clockwise seen from outside, in the order of the tetrahedra. turned: as ActiveBricks has it;
/// open: bits of the faces that no other cell shares.
template <class Put>
void visit_case_facets(const HexahedronGather& gather, std::size_t turned, int case_index, unsigned open, const Put& put) {
  if (open == 0) {
    const auto* const facets = gather.iso_facets[turned].data();
    for (std::uint32_t f = gather.first_iso[case_index]; f < gather.first_iso[case_index + 1]; ++f)
      put(facets[f].tetrahedron, facets[f].facet, facets[f].points, facets[f].label);
    return;
  }
  const std::uint32_t first = gather.first[case_index];
  for (std::uint32_t t = first; t < gather.first[case_index + 1]; ++t)
    for (std::uint8_t i = 0; i < 4; ++i) {
      const std::uint8_t label = gather.labels[turned][t][i];
      const bool in_open_face = label >= kFirstCellFace && (open >> (label - kFirstCellFace) & 1);
      if (label != kLowerFacet && label != kUpperFacet && !in_open_face) continue;
      const std::uint16_t* const offsets = gather.offsets[turned].data() + 4 * std::size_t{t};
      const auto& v = kTetrahedronFacets[i];
      put(static_cast<std::uint8_t>(t - first), i, std::array<std::uint16_t, 3>{offsets[v[0]], offsets[v[1]], offsets[v[2]]},
          label == kLowerFacet ? FacetLabel::lower : label == kUpperFacet ? FacetLabel::upper : FacetLabel::domain);
    }
}

}  // namespace isostrata
