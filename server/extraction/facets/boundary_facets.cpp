#include "extraction/facets/boundary_facets.h"

#include <algorithm>
#include <atomic>
#include <bit>

#include "base/parallel.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/facets/face_key.h"
#include "extraction/mesh/match_table.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/mesh/partitioned_items.h"

namespace isostrata {
namespace {

constexpr std::int64_t kRunsPerBlock = 2048;

using OpenFaces = std::vector<std::uint8_t>;  // [runs] bit k: no other cell shares the cell's face k

OpenFaces open_faces_structured(const Grid& grid, const PointArray& array, std::span<const CellRun> runs, const Task& task) {
  const auto dims = grid.dims();
  const std::array<std::int64_t, 3> cells{dims[0] - 1, dims[1] - 1, dims[2] - 1};
  const std::array<std::int64_t, 3> stride{1, cells[0], cells[0] * cells[1]};
  OpenFaces open(runs.size());
  parallel_for(static_cast<std::int64_t>(runs.size()), kRunsPerBlock, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t r = begin; r < end; ++r) {
      const std::int64_t cell = runs[r].cell;
      for (int face = 0; face < 6; ++face) {  // -x, +x, -y, +y, -z, +z
        const int axis = face / 2;
        const std::int64_t index = cell / stride[axis] % cells[axis];
        const bool last = face % 2 ? index + 1 == cells[axis] : index == 0;
        const std::int64_t neighbour = face % 2 ? cell + stride[axis] : cell - stride[axis];
        if (last || cell_is_absent(grid, array, neighbour)) open[r] |= static_cast<std::uint8_t>(1u << face);
      }
    }
  });
  return open;
}

/// Whose a face is, while it is only one cell's.
struct FaceMeeting {
  FaceKey points;
  bool shared = false;
  std::uint8_t face = 0;  // + 1; 0 for none yet
  std::uint32_t run = 0;

  const FaceKey& key() const { return points; }
  void set_key(const FaceKey& key) { points = key; }
  bool used() const { return face != 0; }
};

/// Only faces of active cells are looked at: where a face holds a part of an interval, every cell that shares it does. Like
/// count_unmatched_facets(): runs are listed by the ranges that the smallest points of their faces are in.
OpenFaces open_faces_unstructured(const Grid& grid, std::span<const CellRun> runs, std::uint64_t max_bytes, const Task& task) {
  const auto count = static_cast<std::int64_t>(runs.size());
  const KeyRanges ranges = KeyRanges::of(grid.point_count(), 2 * count);
  const auto at_range =
      partition_items<std::uint32_t>(ranges.parts, count, "the faces of the active cells", max_bytes, task,
                                     [&](std::int64_t begin, std::int64_t end, const auto& emit) {
                                       std::array<std::int64_t, kMaxCellVertices> ids;
                                       for (std::int64_t r = begin; r < end; ++r) {
                                         grid.cell_points(runs[r].cell, ids);
                                         std::array<std::int64_t, 6> seen;
                                         int parts = 0;
                                         for (const CellFace& face : topology(grid.cell_type(runs[r].cell)).faces) {
                                           std::int64_t smallest = ids[face.vertex[0]];
                                           for (int i = 1; i < face.size; ++i) smallest = std::min(smallest, ids[face.vertex[i]]);
                                           const std::int64_t part = ranges.part(smallest);
                                           if (std::find(seen.begin(), seen.begin() + parts, part) != seen.begin() + parts)
                                             continue;
                                           seen[parts++] = part;
                                           emit(part, static_cast<std::uint32_t>(r));
                                         }
                                       }
                                     });
  OpenFaces open(runs.size());
  parallel_for(at_range.parts(), 1, [&](std::int64_t begin, std::int64_t end) {
    MatchTable<FaceMeeting> table;
    std::array<std::int64_t, kMaxCellVertices> ids;
    for (std::int64_t part = begin; part < end; ++part) {
      task.check();
      table.start(3 * at_range.of(part).size());
      std::size_t done = 0;
      for (const std::uint32_t r : at_range.of(part)) {
        if (++done % 4096 == 0) task.check();
        grid.cell_points(runs[r].cell, ids);
        const auto& faces = topology(grid.cell_type(runs[r].cell)).faces;
        for (std::size_t f = 0; f < faces.size(); ++f) {
          const FaceKey key = face_key(faces[f], ids);
          if (ranges.part(key.points[0]) != part || key.collapsed()) continue;
          FaceMeeting& meeting = table.at(key);
          meeting.shared = meeting.face != 0;
          meeting.face = static_cast<std::uint8_t>(f + 1);
          meeting.run = r;
        }
      }
      for (const FaceMeeting& meeting : table.entries())
        if (meeting.used() && !meeting.shared)
          std::atomic_ref(open[meeting.run])
              .fetch_or(static_cast<std::uint8_t>(1u << (meeting.face - 1)), std::memory_order_relaxed);
    }
  });
  return open;
}

}  // namespace

FacetLabels label_facets(FaceMask a, FaceMask b, FaceMask c, FaceMask d) {
  const std::array<FaceMask, 4> mask{a, b, c, d};
  FacetLabels labels{};
  for (int i = 0; i < 4; ++i) {
    const auto& v = kTetrahedronFacets[i];
    const unsigned common = mask[v[0]] & mask[v[1]] & mask[v[2]];
    labels[i] = static_cast<std::uint8_t>(common ? std::countr_zero(common) + 1 : 0);  // bits as in FaceMask
  }
  return labels;
}

std::vector<std::uint8_t> open_cell_faces(const Grid& grid, const PointArray& array, std::span<const CellRun> runs,
                                          std::uint64_t max_bytes, const Task& task) {
  return grid.structured() ? open_faces_structured(grid, array, runs, task)
                           : open_faces_unstructured(grid, runs, max_bytes, task);
}

Buffer<BoundaryFacet> boundary_facets(const Grid& grid, const PointArray& array, const IntervalMesh& mesh,
                                           std::span<const FacetLabels> labels, std::uint64_t max_bytes, const Task& task) {
  task.report(0.8, "facets");
  return boundary_facets(mesh, labels, open_cell_faces(grid, array, mesh.cell_runs, max_bytes, task), max_bytes, task);
}

Buffer<BoundaryFacet> boundary_facets(const IntervalMesh& mesh, std::span<const FacetLabels> labels, std::span<const std::uint8_t> open,
                                           std::uint64_t max_bytes, const Task& task) {
  const std::span<const CellRun> runs = mesh.cell_runs;
  const auto count = static_cast<std::int64_t>(runs.size());
  task.report(0.8, "facets");

  // visit(tetrahedron, facet, label) in the order of the tetrahedra.
  const auto visit_boundary = [&](std::int64_t begin, std::int64_t end, const auto& visit) {
    for (std::int64_t r = begin; r < end; ++r) {
      const std::uint32_t last =
          r + 1 < count ? runs[r + 1].first_tetrahedron : static_cast<std::uint32_t>(mesh.tetrahedra.size());
      for (std::uint32_t t = runs[r].first_tetrahedron; t < last; ++t)
        for (int i = 0; i < 4; ++i) {
          const std::uint8_t label = labels[t][i];
          if (label == kLowerFacet)
            visit(t, i, FacetLabel::lower);
          else if (label == kUpperFacet)
            visit(t, i, FacetLabel::upper);
          else if (label >= kFirstCellFace && (open[r] >> (label - kFirstCellFace) & 1))
            visit(t, i, FacetLabel::domain);
        }
    }
  };
  const std::int64_t blocks = (count + kRunsPerBlock - 1) / kRunsPerBlock;
  const auto block_end = [&](std::int64_t block) { return std::min(count, (block + 1) * kRunsPerBlock); };
  std::vector<std::size_t> before(blocks + 1);
  parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t b = begin; b < end; ++b) {
      task.check();
      visit_boundary(b * kRunsPerBlock, block_end(b), [&](std::uint32_t, int, FacetLabel) { ++before[b + 1]; });
    }
  });
  for (std::int64_t b = 0; b < blocks; ++b) before[b + 1] += before[b];
  check_budget(std::to_string(before[blocks]) + " boundary facets", before[blocks] * sizeof(BoundaryFacet), max_bytes);
  Buffer<BoundaryFacet> facets(before[blocks]);
  parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t b = begin; b < end; ++b) {
      task.check();
      std::size_t to = before[b];
      visit_boundary(b * kRunsPerBlock, block_end(b), [&](std::uint32_t t, int i, FacetLabel label) {
        const auto& points = mesh.tetrahedra[t];
        const auto& v = kTetrahedronFacets[i];
        const std::uint16_t interval = mesh.tetrahedron_interval[t];
        facets[to++] = {{points[v[0]], points[v[1]], points[v[2]]}, t, interval, label, interval};
      });
    }
  });
  return facets;
}

}  // namespace isostrata
