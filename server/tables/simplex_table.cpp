#include "tables/simplex_table.h"

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <string>
#include <utility>

namespace isostrata {
namespace {

using Set = std::uint64_t;  // of isovertices, bit i for isovertex i
using Row = std::array<std::int64_t, kMaxLatticeDimension>;
using Corners = std::array<IsoVertex, kMaxLatticeDimension>;

/// Of the first n columns of n rows, by fraction-free elimination (E. Bareiss, 1968).
std::int64_t determinant(std::vector<Row> rows, int n) {
  std::int64_t previous = 1, sign = 1;
  for (int k = 0; k + 1 < n; ++k) {
    int pivot = k;
    while (pivot < n && rows[pivot][k] == 0) ++pivot;
    if (pivot == n) return 0;
    if (pivot != k) {
      std::swap(rows[pivot], rows[k]);
      sign = -sign;
    }
    for (int i = k + 1; i < n; ++i)
      for (int j = k + 1; j < n; ++j) rows[i][j] = (rows[i][j] * rows[k][k] - rows[i][k] * rows[k][j]) / previous;
    previous = rows[k][k];
  }
  return n == 0 ? 1 : sign * rows[n - 1][n - 1];
}

std::int64_t orientation(const std::vector<Row>& points, int n) {
  std::vector<Row> rows;
  for (int r = 1; r <= n; ++r) {
    rows.push_back(points[r]);
    for (int i = 0; i < n; ++i) rows.back()[i] -= points[0][i];
  }
  const std::int64_t det = determinant(rows, n);
  if (det == 0) throw std::logic_error("simplex_table: a simplex without volume");
  return det;
}

class Pulling {
 public:
  Pulling(const LatticeCell& cell, const std::vector<FaceMask>& masks) : masks_(masks), bits_(kFirstFaceBit) {
    bits_ += static_cast<int>(cell.facets.size());
    const int n = cell.vertex_count(), e = cell.edge_count();
    key_.resize(n + 2 * e);
    for (int v = 0; v < n; ++v) key_[v] = v;
    for (int i = 0; i < e; ++i) {  // edges are in lexicographic order
      key_[n + i] = n + 2 * i;
      key_[n + e + i] = n + 2 * i + 1;
    }
  }

  /// Appends the simplices of a face, each joined to the corners that were pulled before.
  void triangulate(Set face, Corners pulled, int depth, std::vector<Corners>& out) const {
    IsoVertex apex = static_cast<IsoVertex>(std::countr_zero(face));
    for (Set rest = face; rest; rest &= rest - 1) {
      const auto v = static_cast<IsoVertex>(std::countr_zero(rest));
      if (key_[v] < key_[apex]) apex = v;
    }
    pulled.at(static_cast<std::size_t>(depth)) = apex;
    if (std::has_single_bit(face)) {
      out.push_back(pulled);
      return;
    }
    for (const Set facet : facets(face))
      if (!(facet >> apex & 1)) triangulate(facet, pulled, depth + 1, out);
  }

 private:
  /// The largest proper ones among the face's intersections with the facets of the polytope.
  std::vector<Set> facets(Set face) const {
    std::vector<Set> out;
    for (int bit = 0; bit < bits_; ++bit) {
      Set part = 0;
      for (Set rest = face; rest; rest &= rest - 1) {
        const int v = std::countr_zero(rest);
        if (masks_[v] >> bit & 1) part |= Set{1} << v;
      }
      if (part == 0 || part == face) continue;
      if (std::any_of(out.begin(), out.end(), [&](Set other) { return (part & ~other) == 0; })) continue;
      std::erase_if(out, [&](Set other) { return (other & ~part) == 0; });
      out.push_back(part);
    }
    return out;
  }

  const std::vector<FaceMask>& masks_;
  int bits_;
  std::vector<int> key_;  // [n + 2 e] the order of pulling
};

/// Three times the position of an isovertex where vertices of class 0, 1, 2 have the values 0, 3, 6 and the ends are 2 and 4:
/// whole numbers.
Row thrice(const LatticeCell& cell, const std::vector<int>& classes, IsoVertex code) {
  const int n = cell.vertex_count(), e = cell.edge_count();
  Row out{};
  if (code < n) {
    for (int i = 0; i < cell.dimension; ++i) out[i] = 3 * cell.vertices[code][i];
    return out;
  }
  const auto [a, b] = cell.edges[(code - n) % e];
  const int isovalue = code < n + e ? 2 : 4;
  for (int i = 0; i < cell.dimension; ++i)
    out[i] = 3 * cell.vertices[a][i] +
             3 * (cell.vertices[b][i] - cell.vertices[a][i]) * (isovalue - 3 * classes[a]) / (3 * (classes[b] - classes[a]));
  return out;
}

SimplexTable build_intervals(int n) {
  const LatticeCell cell = lattice_simplex(n);
  SimplexTable table;
  table.dimension = n;
  table.masks = face_masks(cell);
  const Pulling pulling(cell, table.masks);
  const int e = cell.edge_count();
  table.first.push_back(0);
  const auto cases = static_cast<int>(case_count(n + 1));
  for (int i = 0; i < cases; ++i) {
    std::vector<int> classes;
    for (int v = 0, rest = i; v <= n; ++v, rest /= 3) classes.push_back(rest % 3);
    Set used = 0;
    for (int v = 0; v <= n; ++v) used |= static_cast<Set>(classes[v] == 1) << v;
    for (int k = 0; k < e; ++k) {
      const int a = classes[cell.edges[k][0]], b = classes[cell.edges[k][1]];
      used |= static_cast<Set>((a > 0) != (b > 0)) << (n + 1 + k);
      used |= static_cast<Set>((a > 1) != (b > 1)) << (n + 1 + e + k);
    }
    table.isovertices.push_back(used);
    const std::size_t begin = table.simplices.size();
    if (used != 0) pulling.triangulate(used, {}, 0, table.simplices);
    for (std::size_t s = begin; s < table.simplices.size(); ++s) {
      Corners& corners = table.simplices[s];
      std::vector<Row> points;
      for (int k = 0; k <= n; ++k) points.push_back(thrice(cell, classes, corners[k]));
      if (orientation(points, n) < 0) std::swap(corners[0], corners[1]);
    }
    table.first.push_back(static_cast<std::uint32_t>(table.simplices.size()));
  }
  return table;
}

/// Appends the ascending paths from (i, j) to the last of both: pairs of a vertex below and one above.
void ascend(const std::vector<int>& below, const std::vector<int>& above, std::size_t i, std::size_t j,
            std::vector<std::array<int, 2>> path, std::vector<std::vector<std::array<int, 2>>>& out) {
  path.push_back({below[i], above[j]});
  if (i + 1 == below.size() && j + 1 == above.size()) {
    out.push_back(std::move(path));
    return;
  }
  if (i + 1 < below.size()) ascend(below, above, i + 1, j, path, out);
  if (j + 1 < above.size()) ascend(below, above, i, j + 1, path, out);
}

SliceTable build_slices(int n) {
  const LatticeCell cell = lattice_simplex(n);
  SliceTable table;
  table.dimension = n;
  table.first.push_back(0);
  for (unsigned set = 0; set < 1u << (n + 1); ++set) {
    std::vector<int> below, above;
    for (int v = 0; v <= n; ++v) (set >> v & 1 ? above : below).push_back(v);
    std::vector<std::vector<std::array<int, 2>>> paths;
    if (!below.empty() && !above.empty()) ascend(below, above, 0, 0, {}, paths);

    // A simplex with just these vertices at height 1, the others at 0: the first of each at the origin, each further one along
    // an axis of its own.
    std::vector<Row> at(n + 1);
    int axis = 0;
    for (std::size_t i = 1; i < below.size(); ++i) at[below[i]][axis++] = 1;
    for (std::size_t j = 1; j < above.size(); ++j) at[above[j]][axis++] = 1;
    for (const int v : above) at[v][n - 1] = 1;
    for (const auto& path : paths) {
      std::vector<Row> points;
      for (const auto& [b, a] : path) {
        points.emplace_back();
        for (int i = 0; i < n; ++i) points.back()[i] = at[b][i] + at[a][i];
      }
      const bool turned = (orientation(at, n) < 0) != (orientation(points, n - 1) < 0);
      SliceSimplex simplex;
      for (int k = 0; k < n; ++k) {
        const std::array<int, 2> edge{std::min(path[k][0], path[k][1]), std::max(path[k][0], path[k][1])};
        simplex.edge[k] = static_cast<std::uint8_t>(std::find(cell.edges.begin(), cell.edges.end(), edge) - cell.edges.begin());
        unsigned touched = 0;  // vertices on whose edges the facet opposite k has a corner
        for (int other = 0; other < n; ++other)
          if (other != k) touched |= 1u << path[other][0] | 1u << path[other][1];
        const unsigned missing = ((1u << (n + 1)) - 1) & ~touched;
        simplex.facet[k] = static_cast<std::int8_t>(missing == 0 ? -1 : std::countr_zero(missing));
      }
      if (turned) {
        std::swap(simplex.edge[0], simplex.edge[1]);
        std::swap(simplex.facet[0], simplex.facet[1]);
      }
      table.simplices.push_back(simplex);
    }
    table.first.push_back(static_cast<std::uint32_t>(table.simplices.size()));
  }
  return table;
}

/// The n-th of a family of tables, each built when it is first asked for.
template <class Table, Table (*build)(int)>
const Table& table_of(int n) {
  switch (n) {
    case 2: {
      static const Table table = build(2);
      return table;
    }
    case 3: {
      static const Table table = build(3);
      return table;
    }
    case 4: {
      static const Table table = build(4);
      return table;
    }
    case 5: {
      static const Table table = build(5);
      return table;
    }
    default:
      throw std::logic_error("simplex_table: " + std::to_string(n) + " dimensions; expected 2 to 5");
  }
}

}  // namespace

const SimplexTable& simplex_table(int n) { return table_of<SimplexTable, build_intervals>(n); }

const SliceTable& slice_table(int n) { return table_of<SliceTable, build_slices>(n); }

}  // namespace isostrata
