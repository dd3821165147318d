#include "extraction/boundary_facets.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <tuple>

#include "base/parallel.h"
#include "extraction/active_cells.h"
#include "extraction/keyed_lists.h"

namespace isostrata {
namespace {

constexpr std::int64_t kRunsPerBlock = 2048;

// Facet i of a positive tetrahedron, opposite vertex i, counter-clockwise seen from outside.
constexpr std::array<std::array<int, 3>, 4> kFacets{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

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

/// A cell face under its smallest point: the points it has besides, and whose it is.
struct FaceUse {
  std::array<std::int64_t, 3> others{-1, -1, -1};  // increasing; -1 where the face has fewer points
  std::uint32_t run = 0;
  std::uint32_t face = 0;
};

/// Only faces of active cells are looked at: where a face holds a part of an interval, every cell that shares it does.
OpenFaces open_faces_unstructured(const Grid& grid, std::span<const CellRun> runs, std::uint64_t max_bytes, const Task& task) {
  const auto visit = [&](std::int64_t begin, std::int64_t end, const auto& emit) {
    task.check();
    std::array<std::int64_t, kMaxCellVertices> ids;
    for (std::int64_t r = begin; r < end; ++r) {
      grid.cell_points(runs[r].cell, ids);
      const CellTopology& cell = topology(grid.cell_type(runs[r].cell));
      for (std::size_t f = 0; f < cell.faces.size(); ++f) {
        const CellFace& face = cell.faces[f];
        std::array<std::int64_t, 4> points{};  // [size] increasing, without repeats
        int size = 0;
        for (int i = 0; i < face.size; ++i) {
          const std::int64_t id = ids[face.vertex[i]];
          int to = size;
          while (to > 0 && points[to - 1] > id) --to;
          if (to > 0 && points[to - 1] == id) continue;
          for (int k = size++; k > to; --k) points[k] = points[k - 1];
          points[to] = id;
        }
        if (size < 3) continue;  // collapsed to an edge: it holds no facet
        FaceUse use;
        for (int i = 1; i < size; ++i) use.others[i - 1] = points[i];
        use.run = static_cast<std::uint32_t>(r);
        use.face = static_cast<std::uint32_t>(f);
        emit(points[0], use);
      }
    }
  };
  auto uses = list_by_key<FaceUse>(grid.point_count(), static_cast<std::int64_t>(runs.size()), kRunsPerBlock,
                                   "the faces of the active cells", max_bytes, visit);
  OpenFaces open(runs.size());
  parallel_for(uses.keys(), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t key = begin; key < end; ++key) {
      const auto list = uses.of(key);
      std::sort(list.begin(), list.end(), [](const FaceUse& a, const FaceUse& b) { return a.others < b.others; });
      for (std::size_t i = 0; i < list.size();) {
        std::size_t next = i + 1;
        while (next < list.size() && list[next].others == list[i].others) ++next;
        if (next == i + 1)
          std::atomic_ref(open[list[i].run]).fetch_or(static_cast<std::uint8_t>(1u << list[i].face), std::memory_order_relaxed);
        i = next;
      }
    }
  });
  return open;
}

}  // namespace

FacetLabels label_facets(FaceMask a, FaceMask b, FaceMask c, FaceMask d) {
  const std::array<FaceMask, 4> mask{a, b, c, d};
  FacetLabels labels{};
  for (int i = 0; i < 4; ++i) {
    const auto& v = kFacets[i];
    const unsigned common = mask[v[0]] & mask[v[1]] & mask[v[2]];
    labels[i] = static_cast<std::uint8_t>(common ? std::countr_zero(common) + 1 : 0);  // bits as in FaceMask
  }
  return labels;
}

std::vector<std::uint8_t> open_cell_faces(const Grid& grid, const PointArray& array, std::span<const CellRun> runs,
                                          std::uint64_t max_bytes, const Task& task) {
  return grid.structured() ? open_faces_structured(grid, array, runs, task) : open_faces_unstructured(grid, runs, max_bytes, task);
}

std::vector<BoundaryFacet> boundary_facets(const Grid& grid, const PointArray& array, const IntervalMesh& mesh,
                                           std::span<const FacetLabels> labels, std::uint64_t max_bytes, const Task& task) {
  const std::span<const CellRun> runs = mesh.cell_runs;
  const auto count = static_cast<std::int64_t>(runs.size());
  task.report(0.8, "facets");
  const OpenFaces open = open_cell_faces(grid, array, runs, max_bytes, task);

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
  std::vector<BoundaryFacet> facets(before[blocks]);
  parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t b = begin; b < end; ++b) {
      task.check();
      std::size_t to = before[b];
      visit_boundary(b * kRunsPerBlock, block_end(b), [&](std::uint32_t t, int i, FacetLabel label) {
        const auto& points = mesh.tetrahedra[t];
        const auto& v = kFacets[i];
        const std::uint16_t interval = mesh.tetrahedron_interval[t];
        facets[to++] = {{points[v[0]], points[v[1]], points[v[2]]}, t, interval, label, interval};
      });
    }
  });
  return facets;
}

std::int64_t count_unmatched_facets(const IntervalMesh& mesh, const Task& task) {
  std::vector<std::uint8_t> listed(mesh.tetrahedra.size());  // bit i: facet i is in mesh.facets
  for (const BoundaryFacet& facet : mesh.facets) {
    const auto& points = mesh.tetrahedra[facet.tetrahedron];
    for (int i = 0; i < 4; ++i)
      if (std::find(facet.points.begin(), facet.points.end(), points[i]) == facet.points.end())
        listed[facet.tetrahedron] |= static_cast<std::uint8_t>(1u << i);
  }

  struct FacetUse {
    std::uint32_t middle, largest;  // of the three points
    std::uint16_t interval;
    bool odd;  // the points, counter-clockwise from outside, are an odd permutation of their sorted order
    bool boundary;
  };
  const auto same = [](const FacetUse& a, const FacetUse& b) {
    return a.middle == b.middle && a.largest == b.largest && a.interval == b.interval;
  };
  const auto visit = [&](std::int64_t begin, std::int64_t end, const auto& emit) {
    task.check();
    for (std::int64_t t = begin; t < end; ++t)
      for (int i = 0; i < 4; ++i) {
        std::array<std::uint32_t, 3> p;
        for (int k = 0; k < 3; ++k) p[k] = mesh.tetrahedra[t][kFacets[i][k]];
        bool odd = false;
        const auto order = [&](int a, int b) {
          if (p[a] > p[b]) {
            std::swap(p[a], p[b]);
            odd = !odd;
          }
        };
        order(0, 1);
        order(1, 2);
        order(0, 1);
        emit(p[0], {p[1], p[2], mesh.tetrahedron_interval[t], odd, (listed[t] >> i & 1) != 0});
      }
  };
  auto uses =
      list_by_key<FacetUse>(static_cast<std::int64_t>(mesh.positions.size()), static_cast<std::int64_t>(mesh.tetrahedra.size()),
                            8192, "the facets of the mesh", ~std::uint64_t{0}, visit);
  std::atomic<std::int64_t> unmatched{0};
  parallel_for(uses.keys(), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    std::int64_t own = 0;
    for (std::int64_t key = begin; key < end; ++key) {
      const auto list = uses.of(key);
      std::sort(list.begin(), list.end(), [](const FacetUse& a, const FacetUse& b) {
        return std::tie(a.middle, a.largest, a.interval) < std::tie(b.middle, b.largest, b.interval);
      });
      for (std::size_t i = 0; i < list.size();) {
        std::size_t next = i + 1;
        while (next < list.size() && same(list[next], list[i])) ++next;
        // Boundary facets may coincide where the grid itself does not conform (a tetrahedron standing on half of a hexahedron's
        // face).
        const bool bounds = std::all_of(list.begin() + i, list.begin() + next, [](const FacetUse& use) { return use.boundary; });
        const bool meets = next == i + 2 && !list[i].boundary && !list[i + 1].boundary && list[i].odd != list[i + 1].odd;
        if (!bounds && !meets) own += static_cast<std::int64_t>(next - i);
        i = next;
      }
    }
    unmatched.fetch_add(own, std::memory_order_relaxed);
  });
  return unmatched.load();
}

}  // namespace isostrata
