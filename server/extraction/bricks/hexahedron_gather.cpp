#include "extraction/bricks/hexahedron_gather.h"

#include <utility>

#include "data/grids/grid.h"
#include "extraction/cells/cell_geometry.h"
#include "tables/cell_type.h"
#include "tables/interval_table.h"

namespace isostrata {
namespace {

/// Where the number of an isovertex lies, relative to the cell's first point.
std::uint16_t offset_of(int isovertex) {
  constexpr int kVertices = 8, kEdges = 12;
  if (isovertex < kVertices) {
    const auto& at = kHexahedronCorners[isovertex];
    return static_cast<std::uint16_t>(
        HexahedronGather::place(static_cast<int>(at[0]), static_cast<int>(at[1]), static_cast<int>(at[2])));
  }
  const bool upper = isovertex >= kVertices + kEdges;
  const auto& edge = topology(CellType::hexahedron).edges[isovertex - kVertices - (upper ? kEdges : 0)];
  auto a = kHexahedronCorners[edge[0]], b = kHexahedronCorners[edge[1]];
  int axis = 0;
  while (a[axis] == b[axis]) ++axis;
  if (a[axis] > b[axis]) std::swap(a, b);
  return static_cast<std::uint16_t>(
      (1 + axis + (upper ? 3 : 0)) * HexahedronGather::kSlot +
      HexahedronGather::place(static_cast<int>(a[0]), static_cast<int>(a[1]), static_cast<int>(a[2])));
}

HexahedronGather build() {
  const HexahedronTable& table = hexahedron_table();
  const int cases = case_count(8);
  HexahedronGather gather;
  gather.first = table.first;
  gather.count.resize(cases);
  gather.first_iso.assign(1, 0);
  gather.in_face.resize(cases);
  for (int i = 0; i < cases; ++i) {
    gather.count[i] = static_cast<std::uint8_t>(table.of(i).size());
    std::uint8_t number = 0;
    for (auto tetrahedron : table.of(i)) {
      for (int left_handed = 0; left_handed < 2; ++left_handed) {
        if (left_handed) std::swap(tetrahedron[0], tetrahedron[1]);  // positive if the cell's own orientation is
        for (const IsoVertex v : tetrahedron) gather.offsets[left_handed].push_back(offset_of(v));
        gather.labels[left_handed].push_back(label_facets(table.masks[tetrahedron[0]], table.masks[tetrahedron[1]],
                                                          table.masks[tetrahedron[2]], table.masks[tetrahedron[3]]));
      }
      for (const std::uint8_t label : gather.labels[0].back())
        if (label >= kFirstCellFace) ++gather.in_face[i][label - kFirstCellFace];
      for (std::size_t turned = 0; turned < 2; ++turned)
        for (std::uint8_t f = 0; f < 4; ++f)
          if (const std::uint8_t label = gather.labels[turned].back()[f]; label == kLowerFacet || label == kUpperFacet) {
            const std::uint16_t* const offsets = gather.offsets[turned].data() + gather.offsets[turned].size() - 4;
            const auto& v = kTetrahedronFacets[f];
            gather.iso_facets[turned].push_back({number, f, label == kLowerFacet ? FacetLabel::lower : FacetLabel::upper,
                                                 {offsets[v[0]], offsets[v[1]], offsets[v[2]]}});
          }
      ++number;
    }
    gather.first_iso.push_back(static_cast<std::uint32_t>(gather.iso_facets[0].size()));
  }
  constexpr std::array<int, 8> kVtkVertex{0, 1, 3, 2, 4, 5, 7, 6};  // of corner di + 2 dj + 4 dk
  for (int set = 0; set < 256; ++set) {
    int sum = 0;
    for (int corner = 0; corner < 8; ++corner)
      if (set >> corner & 1) sum += case_count(kVtkVertex[corner]);
    gather.powers[set] = static_cast<std::uint16_t>(sum);
  }
  return gather;
}

}  // namespace

const HexahedronGather& hexahedron_gather() {
  static const HexahedronGather gather = build();
  return gather;
}

}  // namespace isostrata
