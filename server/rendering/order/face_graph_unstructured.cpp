// Faces of unstructured cells are matched by their global point ids: all faces with the same lowest id lie in one short list,
// which is sorted. O(faces), parallel over the points.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <tuple>

#include "base/parallel.h"
#include "rendering/order/face_graph.h"

namespace isostrata {
namespace {

constexpr std::int64_t kGrain = 4096;

struct SortedFace {
  std::array<std::int64_t, 4> ids{};  // increasing, without repetitions; -1 behind
};

SortedFace sorted_face(const UnstructuredGrid& grid, std::size_t cell, int slot, std::array<std::int64_t, 4>& in_order,
                       int& corners) {
  const CellFace& face = topology(static_cast<CellType>(grid.types[cell])).faces[static_cast<std::size_t>(slot)];
  SortedFace sorted;
  corners = face.size;
  for (int v = 0; v < face.size; ++v)
    in_order[static_cast<std::size_t>(v)] = grid.connectivity[static_cast<std::size_t>(grid.offsets[cell]) +
                                                              static_cast<std::size_t>(face.vertex[static_cast<std::size_t>(v)])];
  sorted.ids = in_order;
  if (face.size == 3) sorted.ids[3] = in_order[2];  // a repetition
  std::sort(sorted.ids.begin(), sorted.ids.end());
  const auto end = std::unique(sorted.ids.begin(), sorted.ids.end());
  std::fill(end, sorted.ids.end(), -1);
  return sorted;
}

struct FaceShape {
  Vec3d normal, middle;  // of the face; the normal's length is twice the area
  bool plane = true;
};

/// rounding: how far from its plane a point may be for its own imprecision.
FaceShape face_of(const Grid& grid, const std::array<std::int64_t, 4>& ids, int corners, double rounding) {
  Vec3d p[4];
  for (int v = 0; v < corners; ++v) p[v] = grid.point(ids[static_cast<std::size_t>(v)]);
  if (corners == 3) return {cross(p[1] - p[0], p[2] - p[0]), (p[0] + p[1] + p[2]) / 3.0, true};
  const Vec3d a = p[2] - p[0], b = p[3] - p[1], n = cross(a, b);
  const double size = std::max(length(a), length(b));
  return {n, (p[0] + p[1] + p[2] + p[3]) * 0.25, std::abs(dot(n, p[1] - p[0])) <= (rounding + 1e-6 * size) * length(n)};
}

struct Entry {
  std::array<std::int64_t, 4> ids;
  std::uint32_t face;  // cell * slots + slot
  bool operator<(const Entry& other) const { return std::tie(ids, face) < std::tie(other.ids, other.face); }
};

class Matching {
 public:
  Matching(const Grid& grid, FaceGraph& graph)
      : grid_(grid),
        shape_(*std::get_if<UnstructuredGrid>(&grid.shape)),
        graph_(graph),
        rounding_(2e-7 * std::max(graph.diagonal, length(graph.center))) {}

  void run() {
    const auto n = static_cast<std::int64_t>(graph_.cells);
    graph_.slots = std::all_of(shape_.types.begin(), shape_.types.end(),
                               [](std::uint8_t t) { return t == static_cast<std::uint8_t>(CellType::tetrahedron); })
                       ? 4
                       : 6;
    const auto slots = static_cast<std::size_t>(graph_.slots);
    graph_.neighbor.resize(graph_.cells * slots);
    graph_.planes.resize(graph_.cells * slots);
    std::fill(graph_.neighbor.begin(), graph_.neighbor.end(), kNoCell);
    const auto points = static_cast<std::size_t>(grid_.point_count());
    std::vector<std::atomic<std::uint32_t>> next(points + 1);  // faces by their lowest point
    for_faces(n, [&](std::size_t, std::size_t lowest) { next[lowest].fetch_add(1, std::memory_order_relaxed); });
    std::uint32_t sum = 0;
    for (auto& count : next) {
      const std::uint32_t own = count.load(std::memory_order_relaxed);
      count.store(sum, std::memory_order_relaxed);
      sum += own;
    }
    faces_.resize(sum);
    for_faces(n, [&](std::size_t face, std::size_t lowest) {
      faces_[next[lowest].fetch_add(1, std::memory_order_relaxed)] = static_cast<std::uint32_t>(face);
    });
    std::atomic<bool> plane{true};
    parallel_for(static_cast<std::int64_t>(points), kGrain, [&](std::int64_t begin, std::int64_t end) {
      std::vector<Entry> entries;
      bool all_plane = true;
      for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end); ++p) {
        const std::uint32_t first = p == 0 ? 0 : next[p - 1].load(std::memory_order_relaxed);
        all_plane =
            match(std::span(faces_).subspan(first, next[p].load(std::memory_order_relaxed) - first), entries) && all_plane;
      }
      if (!all_plane) plane = false;
    });
    graph_.plane_faces = plane;
    gather_exterior();
  }

 private:
  template <class Body>
  void for_faces(std::int64_t cells, Body body) const {
    parallel_for(cells, kGrain, [&](std::int64_t begin, std::int64_t end) {
      std::array<std::int64_t, 4> ids{};
      int corners = 0;
      for (auto c = static_cast<std::size_t>(begin); c < static_cast<std::size_t>(end); ++c) {
        if (grid_.hidden(static_cast<std::int64_t>(c))) continue;
        const std::size_t count = topology(static_cast<CellType>(shape_.types[c])).faces.size();
        for (std::size_t s = 0; s < count; ++s)
          body(c * static_cast<std::size_t>(graph_.slots) + s,
               static_cast<std::size_t>(sorted_face(shape_, c, static_cast<int>(s), ids, corners).ids[0]));
      }
    });
  }

  /// Returns whether the matched faces are plane.
  bool match(std::span<const std::uint32_t> faces, std::vector<Entry>& entries) {
    const auto slots = static_cast<std::uint32_t>(graph_.slots);
    entries.clear();
    std::array<std::int64_t, 4> ids{};
    int corners = 0;
    for (const std::uint32_t face : faces)
      entries.push_back({sorted_face(shape_, face / slots, static_cast<int>(face % slots), ids, corners).ids, face});
    std::sort(entries.begin(), entries.end());
    bool plane = true;
    for (std::size_t i = 0; i + 1 < entries.size(); ++i) {
      const Entry &a = entries[i], &b = entries[i + 1];
      const std::uint32_t cell_a = a.face / slots, cell_b = b.face / slots;
      if (a.ids != b.ids || cell_a == cell_b) continue;
      sorted_face(shape_, cell_a, static_cast<int>(a.face % slots), ids, corners);
      const FaceShape face = face_of(grid_, ids, corners, rounding_);
      plane = plane && face.plane;
      // From the middle of one cell to that of the other: cells may be numbered inside out.
      const Vec3d across = cell_middle(grid_, cell_b) - cell_middle(grid_, cell_a);
      const double size = length(face.normal);
      const Vec3d n = size > 1e-24 * graph_.diagonal * graph_.diagonal
                          ? face.normal * ((dot(face.normal, across) < 0 ? -1 : 1) / size)
                          : Vec3d{};
      const FacePlane out{{static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)},
                          static_cast<float>(dot(n, face.middle - graph_.center))};
      graph_.planes[a.face] = out;
      graph_.planes[b.face] = {{-out.normal[0], -out.normal[1], -out.normal[2]}, -out.offset};
      graph_.neighbor[a.face] = cell_b;
      graph_.neighbor[b.face] = cell_a;
      ++i;  // a third cell at the same face stays outside
    }
    return plane;
  }

  void gather_exterior() {
    const auto slots = static_cast<std::size_t>(graph_.slots);
    std::array<std::int64_t, 4> ids{};
    int corners = 0;
    for (std::size_t c = 0; c < graph_.cells; ++c) {
      if (grid_.hidden(static_cast<std::int64_t>(c))) continue;
      const std::size_t count = topology(static_cast<CellType>(shape_.types[c])).faces.size();
      for (std::size_t s = 0; s < count; ++s) {
        if (graph_.neighbor[c * slots + s] != kNoCell) continue;
        sorted_face(shape_, c, static_cast<int>(s), ids, corners);
        const FaceShape face = face_of(grid_, ids, corners, rounding_);
        if (dot(face.normal, face.middle - cell_middle(grid_, static_cast<std::int64_t>(c))) < 0)
          std::reverse(ids.begin(), ids.begin() + corners);
        if (corners == 3) ids[3] = ids[2];
        ExteriorFace& out = graph_.exterior.emplace_back();
        for (std::size_t v = 0; v < 4; ++v) out.points[v] = static_cast<std::uint32_t>(ids[v]);
        out.cell = static_cast<std::uint32_t>(c);
      }
    }
  }

  const Grid& grid_;
  const UnstructuredGrid& shape_;
  FaceGraph& graph_;
  double rounding_;  // of positions in single precision
  Buffer<std::uint32_t> faces_;
};

}  // namespace

void build_unstructured(const Grid& grid, FaceGraph& graph) { Matching(grid, graph).run(); }

}  // namespace isostrata
