#include "tables/cell_symmetry.h"

#include <algorithm>
#include <optional>

namespace isostrata {
namespace {

bool has_edge(const CellTopology& cell, int a, int b) {
  const std::array<int, 2> edge{std::min(a, b), std::max(a, b)};
  return std::find(cell.edges.begin(), cell.edges.end(), edge) != cell.edges.end();
}

/// Whether a cycle of vertices is a face of the cell: 1 in the face's own direction, -1 in the other, 0 no face.
int direction_of_face(const CellTopology& cell, int size, const std::array<int, 4>& cycle) {
  for (const CellFace& face : cell.faces) {
    if (face.size != size) continue;
    for (int turn = 0; turn < size; ++turn) {
      bool forwards = true, backwards = true;
      for (int i = 0; i < size; ++i) {
        forwards = forwards && cycle[i] == face.vertex[(turn + i) % size];
        backwards = backwards && cycle[i] == face.vertex[(turn - i + size) % size];
      }
      if (forwards) return 1;
      if (backwards) return -1;
    }
  }
  return 0;
}

/// The symmetry with these images of the vertices, if it is one. Edges are known to go to edges.
std::optional<CellSymmetry> symmetry(const CellTopology& cell, const std::vector<int>& vertex) {
  CellSymmetry out;
  out.vertex = vertex;
  for (const CellFace& face : cell.faces) {
    std::array<int, 4> cycle{};
    for (int i = 0; i < face.size; ++i) cycle[i] = vertex[face.vertex[i]];
    const int direction = direction_of_face(cell, face.size, cycle);
    if (direction == 0) return std::nullopt;
    out.reverses = direction < 0;
  }
  const int n = cell.vertex_count, e = static_cast<int>(cell.edges.size());
  out.isovertex.resize(n + 2 * e);
  for (int v = 0; v < n; ++v) out.isovertex[v] = static_cast<IsoVertex>(vertex[v]);
  for (int i = 0; i < e; ++i) {
    const int a = vertex[cell.edges[i][0]], b = vertex[cell.edges[i][1]];
    const std::array<int, 2> image{std::min(a, b), std::max(a, b)};
    const auto to = std::find(cell.edges.begin(), cell.edges.end(), image) - cell.edges.begin();
    out.isovertex[n + i] = static_cast<IsoVertex>(n + to);
    out.isovertex[n + e + i] = static_cast<IsoVertex>(n + e + to);
  }
  return out;
}

/// Tries all images of the next vertex that keep edges edges.
void extend(const CellTopology& cell, std::vector<int>& vertex, std::vector<CellSymmetry>& out) {
  const int next = static_cast<int>(vertex.size());
  if (next == cell.vertex_count) {
    if (auto found = symmetry(cell, vertex)) out.push_back(std::move(*found));
    return;
  }
  for (int image = 0; image < cell.vertex_count; ++image) {
    if (std::find(vertex.begin(), vertex.end(), image) != vertex.end()) continue;
    bool keeps = true;
    for (int v = 0; v < next && keeps; ++v) keeps = has_edge(cell, v, next) == has_edge(cell, vertex[v], image);
    if (!keeps) continue;
    vertex.push_back(image);
    extend(cell, vertex, out);
    vertex.pop_back();
  }
}

}  // namespace

int CellSymmetry::map_case(int case_index) const {
  int mapped = 0;
  for (const int to : vertex) {
    mapped += case_index % 3 * case_count(to);
    case_index /= 3;
  }
  return mapped;
}

std::vector<CellSymmetry> cell_symmetries(const CellTopology& cell) {
  std::vector<CellSymmetry> out;
  std::vector<int> vertex;
  extend(cell, vertex, out);
  return out;
}

}  // namespace isostrata
