#include "extraction/bricks/structured_facets.h"

#include <string>

#include "base/parallel.h"
#include "extraction/bricks/hexahedron_gather.h"
#include "extraction/cells/active_cells.h"
#include "extraction/mesh/memory_budget.h"

namespace isostrata {
namespace {

constexpr std::int64_t kBricksPerTask = 16;

// Facet i of a positive tetrahedron, opposite vertex i, counter-clockwise seen from outside.
constexpr std::array<std::array<int, 3>, 4> kFacets{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// Calls visit(record, bits of the faces that no other cell shares) for a brick's records.
template <class Visit>
void visit_open_faces(const Grid& grid, const PointArray& array, const ActiveBricks& active, std::size_t b, bool may_be_absent,
                      const Visit& visit) {
  const BrickLayout& layout = active.layout();
  const BrickLayout::Place place = layout.place(active.bricks()[b].number);
  const std::array<std::int64_t, 3> stride{1, layout.dims[0] - 1, (layout.dims[0] - 1) * (layout.dims[1] - 1)};
  bool at_end = false;
  for (int axis = 0; axis < 3; ++axis)
    at_end = at_end || place.first[axis] == 0 || place.first[axis] + place.cells[axis] + 1 == layout.dims[axis];
  const bool look = at_end || may_be_absent;
  int last = -1;
  unsigned open = 0;
  for (const CellRecord& record : active.records(b)) {
    if (look && record.cell() != last) {
      last = record.cell();
      open = 0;
      const std::array<std::int64_t, 3> at{place.first[0] + (last & 7), place.first[1] + (last >> 3 & 7),
                                           place.first[2] + (last >> 6)};
      const std::int64_t cell = layout.cell(at);
      for (int face = 0; face < 6; ++face) {  // -x, +x, -y, +y, -z, +z
        const int axis = face / 2;
        const bool end = face % 2 ? at[axis] + 2 == layout.dims[axis] : at[axis] == 0;
        if (end || (may_be_absent && cell_is_absent(grid, array, face % 2 ? cell + stride[axis] : cell - stride[axis])))
          open |= 1u << face;
      }
    }
    visit(record, open);
  }
}

}  // namespace

std::vector<BoundaryFacet> structured_facets(const Grid& grid, const PointArray& array, const ActiveBricks& active,
                                             const IntervalMesh& mesh, std::uint64_t max_bytes, const Task& task) {
  const HexahedronGather& gather = hexahedron_gather();
  const std::span<const ActiveBrick> bricks = active.bricks();
  const auto count = static_cast<std::int64_t>(bricks.size());
  // A cell that shares a face with one of the brick's is in the brick, before it, or in the next one along an axis, which is
  // active where the face holds a part of an interval.
  const auto near_absent = [&](std::size_t b) {
    if (active.near_absent(b)) return true;
    const BrickLayout& layout = active.layout();
    const auto at = layout.indices(bricks[b].number);
    for (int axis = 0; axis < 3; ++axis) {
      auto next = at;
      if (++next[axis] == layout.bricks[axis]) continue;
      const std::uint32_t other = active.find(next[0] + layout.bricks[0] * (next[1] + layout.bricks[1] * next[2]));
      if (other != ActiveBricks::kNotActive && active.near_absent(other)) return true;
    }
    return false;
  };

  std::vector<std::uint64_t> before(bricks.size() + 1);
  StageProgress progress(task, "facets", 0.85, 1.0, 2 * count);
  parallel_for(count, kBricksPerTask, [&](std::int64_t begin, std::int64_t end) {
    for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b) {
      task.check();
      std::uint64_t facets = 0;
      visit_open_faces(grid, array, active, b, near_absent(b), [&](const CellRecord& record, unsigned open) {
        const int case_index = record.case_index();
        facets += gather.first_iso[case_index + 1] - gather.first_iso[case_index];
        for (int face = 0; face < 6; ++face)
          if (open >> face & 1) facets += gather.in_face[case_index][face];
      });
      before[b + 1] = facets;
    }
    progress.done(end - begin);
  });
  for (std::size_t b = 0; b < bricks.size(); ++b) before[b + 1] += before[b];
  check_budget(std::to_string(before.back()) + " boundary facets", before.back() * sizeof(BoundaryFacet), max_bytes);

  std::vector<std::uint32_t> first(bricks.size());  // tetrahedra of earlier bricks
  for (std::size_t b = 1; b < bricks.size(); ++b) first[b] = first[b - 1] + bricks[b - 1].tetrahedra;
  std::vector<BoundaryFacet> facets(before.back());
  parallel_for(count, kBricksPerTask, [&](std::int64_t begin, std::int64_t end) {
    for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b) {
      task.check();
      if (before[b] == before[b + 1]) continue;
      std::uint32_t t = first[b];
      BoundaryFacet* to = facets.data() + before[b];
      visit_open_faces(grid, array, active, b, near_absent(b), [&](const CellRecord& record, unsigned open) {
        const int case_index = record.case_index();
        const std::uint32_t past = t + gather.count[case_index];
        const auto interval = static_cast<std::uint16_t>(record.interval());
        const auto put = [&](std::uint32_t tetrahedron, int facet, FacetLabel label) {
          const auto& points = mesh.tetrahedra[tetrahedron];
          const auto& v = kFacets[static_cast<std::size_t>(facet)];
          *to++ = {{points[v[0]], points[v[1]], points[v[2]]}, tetrahedron, interval, label, interval};
        };
        if (open == 0) {
          const auto* const facet_of = gather.iso_facets[active.turned(record)].data();
          for (std::uint32_t f = gather.first_iso[case_index]; f < gather.first_iso[case_index + 1]; ++f)
            put(t + facet_of[f].tetrahedron, facet_of[f].facet, facet_of[f].label);
          t = past;
          return;
        }
        const FacetLabels* labels = gather.labels[active.turned(record)].data() + gather.first[case_index];
        for (; t < past; ++t, ++labels)
          for (int i = 0; i < 4; ++i) {
            const std::uint8_t label = (*labels)[i];
            const bool in_open_face = label >= kFirstCellFace && (open >> (label - kFirstCellFace) & 1);
            if (label != kLowerFacet && label != kUpperFacet && !in_open_face) continue;
            put(t, i, label == kLowerFacet ? FacetLabel::lower : label == kUpperFacet ? FacetLabel::upper : FacetLabel::domain);
          }
      });
    }
    progress.done(end - begin);
  });
  return facets;
}

}  // namespace isostrata
