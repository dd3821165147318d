#include "tables/interval_complex.h"

#include <algorithm>
#include <map>
#include <stdexcept>

#include "base/parallel.h"
#include "tables/cell_symmetry.h"

namespace isostrata {
namespace {

using VertexPair = std::array<IsoVertex, 2>;
using Triangle = std::array<IsoVertex, 3>;

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

/// The four facets of a positive tetrahedron, counter-clockwise seen from outside.
std::array<Triangle, 4> facets_of(const IsoSimplex& s) {
  const auto& v = s.vertex;
  return {{{v[1], v[2], v[3]}, {v[0], v[3], v[2]}, {v[0], v[1], v[3]}, {v[0], v[2], v[1]}}};
}

/// What lies beyond a triangle of a polytope's boundary: another polytope of the case, or a facet of the lifted cell. Triangles
/// with the same beyond make one face.
struct Beyond {
  int plane = -1;
  FaceMask mask = 0;
  auto operator<=>(const Beyond&) const = default;
};

/// The cycle of vertices around oriented triangles that make up one convex polygon.
std::vector<IsoVertex> outline(const std::vector<Triangle>& triangles) {
  std::map<IsoVertex, IsoVertex> next;
  const auto has = [&](const VertexPair& wanted) {
    for (const Triangle& t : triangles)
      for (int i = 0; i < 3; ++i)
        if (t[i] == wanted[0] && t[(i + 1) % 3] == wanted[1]) return true;
    return false;
  };
  for (const Triangle& t : triangles)
    for (int i = 0; i < 3; ++i)
      if (!has({t[(i + 1) % 3], t[i]})) next[t[i]] = t[(i + 1) % 3];
  std::vector<IsoVertex> cycle;
  IsoVertex at = next.begin()->first;
  do {
    cycle.push_back(at);
    at = next.at(at);
  } while (at != cycle.front() && cycle.size() <= next.size());
  if (cycle.size() != next.size() || cycle.size() != triangles.size() + 2)
    throw std::logic_error("interval_complex: a face of " + std::to_string(triangles.size()) + " triangles has an outline of " +
                           std::to_string(cycle.size()) + " vertices");
  return cycle;
}

std::vector<IsoVertex> encode_case(const std::vector<IsoSimplex>& simplices, const std::vector<FaceMask>& masks) {
  std::map<Triangle, std::vector<int>> planes_at;  // the polytopes on both sides of each triangle
  int plane_count = 0;
  for (const IsoSimplex& simplex : simplices) {
    plane_count = std::max(plane_count, simplex.plane + 1);
    for (const Triangle& t : facets_of(simplex)) planes_at[sorted(t)].push_back(simplex.plane);
  }
  std::vector<IsoVertex> code;
  for (int plane = 0; plane < plane_count; ++plane) {
    std::map<Beyond, std::vector<Triangle>> faces;
    for (const IsoSimplex& simplex : simplices) {
      if (simplex.plane != plane) continue;
      for (const Triangle& t : facets_of(simplex)) {
        const std::vector<int>& sides = planes_at.at(sorted(t));
        Beyond beyond;
        if (sides.size() == 1)
          beyond.mask = masks[t[0]] & masks[t[1]] & masks[t[2]];
        else if (sides[0] == sides[1])
          continue;  // inside the polytope
        else
          beyond.plane = sides[0] == plane ? sides[1] : sides[0];
        faces[beyond].push_back(t);
      }
    }
    code.push_back(static_cast<IsoVertex>(faces.size()));
    for (const auto& [beyond, triangles] : faces) {
      const std::vector<IsoVertex> cycle = outline(triangles);
      code.push_back(static_cast<IsoVertex>(cycle.size()));
      code.insert(code.end(), cycle.begin(), cycle.end());
    }
  }
  return code;
}

/// Calls face(vertices, size) for every face of every polytope of a case.
template <class Code, class Face>
void visit_faces(Code& code, const Face& face) {
  for (std::size_t at = 0; at < code.size();) {
    const int faces = code[at++];
    for (int f = 0; f < faces; ++f) {
      const int size = code[at++];
      face(code.data() + at, size);
      at += static_cast<std::size_t>(size);
    }
  }
}

std::vector<IsoVertex> image_of(std::vector<IsoVertex> code, const CellSymmetry& symmetry) {
  visit_faces(code, [&](IsoVertex* cycle, int size) {
    for (int i = 0; i < size; ++i) cycle[i] = symmetry.isovertex[cycle[i]];
    if (symmetry.reverses) std::reverse(cycle, cycle + size);
  });
  return code;
}

std::uint32_t isovertices_of(const std::vector<IsoVertex>& code) {
  std::uint32_t set = 0;
  visit_faces(code, [&](const IsoVertex* cycle, int size) {
    for (int i = 0; i < size; ++i) set |= 1u << cycle[i];
  });
  return set;
}

IntervalComplex build(CellType type) {
  const LatticeCell cell = lattice_cell(type);
  IntervalComplex complex;
  complex.type = type;
  complex.masks = face_masks(cell);
  const int cases = case_count(cell.vertex_count());
  const std::vector<CellSymmetry> symmetries = cell_symmetries(topology(type));

  // One hull for all cases that a symmetry of the cell maps to each other: 267 instead of 6561 for the hexahedron.
  std::vector<int> model(cases, -1);           // the case that this one is an image of
  std::vector<const CellSymmetry*> by(cases);  // and the symmetry that maps it here
  std::vector<int> models;
  for (int i = 0; i < cases; ++i) {
    if (model[i] >= 0) continue;
    models.push_back(i);
    for (const CellSymmetry& symmetry : symmetries) {
      const int image = symmetry.map_case(i);
      model[image] = i;
      by[image] = &symmetry;
    }
  }
  std::vector<std::vector<IsoVertex>> codes(cases);
  parallel_for(static_cast<std::int64_t>(models.size()), 4, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) codes[models[i]] = encode_case(interval_case(cell, models[i]), complex.masks);
  });
  // The identity is not the only symmetry that maps a symmetric case to itself: images are made from copies of the models.
  const std::vector<std::vector<IsoVertex>> originals = codes;
  complex.isovertices.resize(cases);
  for (int i = 0; i < cases; ++i) {
    codes[i] = image_of(originals[model[i]], *by[i]);
    complex.isovertices[i] = isovertices_of(codes[i]);
  }
  complex.first.push_back(0);
  for (const auto& code : codes) {
    complex.code.insert(complex.code.end(), code.begin(), code.end());
    complex.first.push_back(static_cast<std::uint32_t>(complex.code.size()));
  }
  return complex;
}

}  // namespace

const IntervalComplex& interval_complex(CellType type) {
  switch (type) {  // one static for each: whoever needs only tetrahedra does not wait for the hexahedron
    case CellType::tetrahedron: {
      static const IntervalComplex complex = build(CellType::tetrahedron);
      return complex;
    }
    case CellType::pyramid: {
      static const IntervalComplex complex = build(CellType::pyramid);
      return complex;
    }
    case CellType::wedge: {
      static const IntervalComplex complex = build(CellType::wedge);
      return complex;
    }
    case CellType::triangle:
    case CellType::quadrilateral:
      throw std::logic_error("interval_complex: a flat cell has an area_table");
    case CellType::hexahedron:
      break;
  }
  static const IntervalComplex complex = build(CellType::hexahedron);
  return complex;
}

void order_isovertices(const CellTopology& cell, std::span<const std::int64_t> point_ids, std::span<std::uint8_t> keys) {
  const int n = cell.vertex_count;
  const int e = static_cast<int>(cell.edges.size());
  std::array<int, kMaxCellVertices> rank{};
  for (int v = 1; v < n; ++v)
    for (int w = 0; w < v; ++w) {
      const bool before = point_ids[w] <= point_ids[v];
      rank[v] += before;
      rank[w] += !before;
    }
  for (int v = 0; v < n; ++v) keys[v] = static_cast<std::uint8_t>(rank[v]);
  for (int i = 0; i < e; ++i) {
    const auto [a, b] = cell.edges[i];
    const int lower = std::min(rank[a], rank[b]), upper = std::max(rank[a], rank[b]);
    const int key = kMaxCellVertices + 2 * (kMaxCellVertices * lower + upper);
    keys[n + i] = static_cast<std::uint8_t>(key);
    keys[n + e + i] = static_cast<std::uint8_t>(key + 1);
  }
}

int pull(const IntervalComplex& complex, int case_index, std::span<const std::uint8_t> keys, std::array<IsoVertex, 4>* out) {
  const IsoVertex* at = complex.code.data() + complex.first[case_index];
  const IsoVertex* const end = complex.code.data() + complex.first[case_index + 1];
  int count = 0;
  while (at != end) {
    const int face_count = *at++;
    const IsoVertex* const faces = at;
    IsoVertex apex = faces[1];
    for (int f = 0; f < face_count; ++f) {
      const int size = *at++;
      for (int i = 0; i < size; ++i, ++at)
        if (keys[*at] < keys[apex]) apex = *at;
    }
    at = faces;
    for (int f = 0; f < face_count; ++f) {
      const int size = *at++;
      const IsoVertex* const cycle = at;
      at += size;
      int smallest = 0;
      bool has_apex = false;
      for (int i = 0; i < size; ++i) {
        has_apex |= cycle[i] == apex;
        if (keys[cycle[i]] < keys[cycle[smallest]]) smallest = i;
      }
      if (has_apex) continue;
      const auto vertex = [&](int i) { return cycle[i < size ? i : i - size]; };
      for (int i = smallest + 1; i + 1 < smallest + size; ++i) out[count++] = {apex, cycle[smallest], vertex(i), vertex(i + 1)};
    }
  }
  return count;
}

}  // namespace isostrata
