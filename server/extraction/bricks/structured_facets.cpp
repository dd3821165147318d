#include "extraction/bricks/structured_facets.h"

#include <string>

#include "base/parallel.h"
#include "extraction/bricks/hexahedron_gather.h"
#include "extraction/bricks/open_faces.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/mesh/memory_budget.h"

namespace isostrata {
namespace {

constexpr std::int64_t kBricksPerFacetTask = 16;

}  // namespace

Buffer<BoundaryFacet> structured_facets(const Grid& grid, const PointArray& array, const ActiveBricks& active,
                                             const IntervalMesh& mesh, std::uint64_t max_bytes, const Task& task) {
  const HexahedronGather& gather = hexahedron_gather();
  const std::span<const ActiveBrick> bricks = active.bricks();
  const auto count = static_cast<std::int64_t>(bricks.size());
  std::vector<std::uint64_t> before(bricks.size() + 1);
  StageProgress progress(task, "facets", 0.85, 1.0, 2 * count);
  parallel_for(count, kBricksPerFacetTask, [&](std::int64_t begin, std::int64_t end) {
    for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b) {
      task.check();
      std::uint64_t facets = 0;
      visit_open_faces(grid, array, active, b, [&](const CellRecord& record, unsigned open) {
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
  Buffer<BoundaryFacet> facets(before.back());
  parallel_for(count, kBricksPerFacetTask, [&](std::int64_t begin, std::int64_t end) {
    for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b) {
      task.check();
      if (before[b] == before[b + 1]) continue;
      std::uint32_t t = first[b];
      BoundaryFacet* to = facets.data() + before[b];
      visit_open_faces(grid, array, active, b, [&](const CellRecord& record, unsigned open) {
        const int case_index = record.case_index();
        const std::uint32_t past = t + gather.count[case_index];
        const auto interval = static_cast<std::uint16_t>(record.interval());
        const auto put = [&](std::uint32_t tetrahedron, int facet, FacetLabel label) {
          const auto& points = mesh.tetrahedra[tetrahedron];
          const auto& v = kTetrahedronFacets[static_cast<std::size_t>(facet)];
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
