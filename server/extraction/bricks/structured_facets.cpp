#include "extraction/bricks/structured_facets.h"

#include <string>
#include <vector>

#include "base/parallel.h"
#include "extraction/bricks/case_facets.h"
#include "extraction/bricks/hexahedron_gather.h"
#include "extraction/bricks/open_faces.h"
#include "extraction/mesh/memory_budget.h"

namespace isostrata {
namespace {

constexpr std::int64_t kBricksPerFacetTask = 16;

/// [bricks + 1] how many facets the bricks before have.
std::vector<std::uint64_t> count_facets(const Grid& grid, const PointArray& array, const ActiveBricks& active, std::uint64_t max_bytes,
                                        StageProgress& progress, const Task& task) {
  const HexahedronGather& gather = hexahedron_gather();
  const auto bricks = static_cast<std::int64_t>(active.bricks().size());
  std::vector<std::uint64_t> before(active.bricks().size() + 1);
  parallel_for(bricks, kBricksPerFacetTask, [&](std::int64_t begin, std::int64_t end) {
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
  for (std::size_t b = 1; b < before.size(); ++b) before[b] += before[b - 1];
  check_budget(std::to_string(before.back()) + " boundary facets", before.back() * sizeof(BoundaryFacet), max_bytes);
  return before;
}

/// begin(b, scratch): what gives the facets of the records of brick b, in their order: a call put(record, open, to) writes them and moves `to`.
template <class Scratch, class Begin>
Buffer<BoundaryFacet> write_facets(const Grid& grid, const PointArray& array, const ActiveBricks& active, std::uint64_t max_bytes, const Task& task,
                                   const Scratch& scratch, const Begin& begin_brick) {
  const auto bricks = static_cast<std::int64_t>(active.bricks().size());
  StageProgress progress(task, "facets", 0.85, 1.0, 2 * bricks);
  const std::vector<std::uint64_t> before = count_facets(grid, array, active, max_bytes, progress, task);
  Buffer<BoundaryFacet> facets(before.back());
  parallel_for(bricks, kBricksPerFacetTask, [&](std::int64_t begin, std::int64_t end) {
    auto own = scratch();
    for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b) {
      task.check();
      if (before[b] == before[b + 1]) continue;
      BoundaryFacet* to = facets.data() + before[b];
      auto put = begin_brick(b, own);
      visit_open_faces(grid, array, active, b, [&](const CellRecord& record, unsigned open) { put(record, open, to); });
    }
    progress.done(end - begin);
  });
  return facets;
}

}  // namespace

Buffer<BoundaryFacet> structured_facets(const Grid& grid, const PointArray& array, const ActiveBricks& active,
                                             const IntervalMesh& mesh, std::uint64_t max_bytes, const Task& task) {
  const HexahedronGather& gather = hexahedron_gather();
  const std::span<const ActiveBrick> bricks = active.bricks();
  std::vector<std::uint32_t> first(bricks.size());  // tetrahedra of earlier bricks
  for (std::size_t b = 1; b < bricks.size(); ++b) first[b] = first[b - 1] + bricks[b - 1].tetrahedra;
  return write_facets(grid, array, active, max_bytes, task, [] { return 0; }, [&](std::size_t b, int) {
    return [&, t = first[b]](const CellRecord& record, unsigned open, BoundaryFacet*& to) mutable {
      const auto interval = static_cast<std::uint16_t>(record.interval());
      visit_case_facets(gather, active.turned(record), record.case_index(), open, [&](int tetrahedron, int facet, const auto&, FacetLabel label) {
        const auto& points = mesh.tetrahedra[t + static_cast<std::uint32_t>(tetrahedron)];
        const auto& v = kTetrahedronFacets[static_cast<std::size_t>(facet)];
        *to++ = {{points[v[0]], points[v[1]], points[v[2]]}, t + static_cast<std::uint32_t>(tetrahedron), interval, label, interval};
      });
      t += gather.count[record.case_index()];
    };
  });
}

Buffer<BoundaryFacet> structured_facets(const Grid& grid, const PointArray& array, const ActiveBricks& active, const BrickWriter& writer,
                                        std::uint64_t max_bytes, const Task& task) {
  const HexahedronGather& gather = hexahedron_gather();
  return write_facets(grid, array, active, max_bytes, task, [&] { return BrickWriter::Scratch(writer); }, [&](std::size_t b, BrickWriter::Scratch& scratch) {
    writer.make_tables(b, scratch);
    return [&](const CellRecord& record, unsigned open, BoundaryFacet*& to) {
      const int cell = record.cell();
      const auto interval = static_cast<std::uint16_t>(record.interval());
      const std::uint32_t* const numbers = scratch.numbers_of[interval] + HexahedronGather::place(cell & 7, cell >> 3 & 7, cell >> 6);
      visit_case_facets(gather, active.turned(record), record.case_index(), open, [&](int, int, const std::array<std::uint16_t, 3>& at, FacetLabel label) {
        *to++ = {{numbers[at[0]], numbers[at[1]], numbers[at[2]]}, 0, interval, label, interval};
      });
    };
  });
}

}  // namespace isostrata
