// Numbering the points of an interval mesh, each once.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "base/task.h"
#include "data/grids/grid.h"
#include "data/values/array.h"
#include "extraction/cells/active_cells.h"
#include "extraction/cells/iso_rules.h"
#include "extraction/mesh/interval_mesh.h"
#include "tables/interval_complex.h"

namespace isostrata {

/// The identity of a mesh point: the kept grid point a (b == a, isovalue 0), or the crossing of the grid edge a < b with an
/// isovalue.
struct PointKey {
  std::int64_t a = 0, b = 0;
  std::uint32_t isovalue = 0;  // into IsoRules::isovalues

  bool operator==(const PointKey&) const = default;
};

/// The key of an isovertex of a cell.
inline PointKey point_key(const CellTopology& cell, std::span<const std::int64_t> ids, const IsoRule& rule, int isovertex) {
  const int n = cell.vertex_count, e = static_cast<int>(cell.edges.size());
  if (isovertex < n) return {ids[isovertex], ids[isovertex], 0};
  const bool upper = isovertex >= n + e;
  const auto& edge = cell.edges[isovertex - n - (upper ? e : 0)];
  const std::int64_t a = ids[edge[0]], b = ids[edge[1]];
  const std::uint32_t isovalue = upper ? rule.upper_index : rule.lower_index;
  return a < b ? PointKey{a, b, isovalue} : PointKey{b, a, isovalue};
}

/// All points of the mesh, numbered by a, then b, then isovalue: the numbers do not depend on threads or on the order of cells.
/// Built by counting keys by their point a, which needs 8 bytes for each point of the grid.
class MeshPoints {
 public:
  /// Throws too_large (more than 2^32 points, or grids and requests past the key's range), cancelled.
  MeshPoints(const Grid& grid, std::span<const CellCase> cases, const IsoRules& rules, std::uint64_t max_bytes, const Task& task);

  std::int64_t size() const { return static_cast<std::int64_t>(keys_.size()); }
  /// The numbers of the isovertices (a set of bits) of a cell with the given points.
  void number(const CellTopology& cell, std::span<const std::int64_t> ids, const IsoRule& rule, std::uint32_t isovertices,
              std::array<std::uint32_t, kMaxIsoVertices>& numbers) const {
    for (std::uint32_t rest = isovertices; rest; rest &= rest - 1) {
      const int v = std::countr_zero(rest);
      numbers[v] = find(point_key(cell, ids, rule, v));
    }
  }
  /// The number of a point that is there.
  std::uint32_t find(const PointKey& key) const {
    const std::uint64_t packed = pack(key);
    const std::uint64_t* const begin = keys_.data() + first_[key.a];
    const std::uint64_t* const end = keys_.data() + first_[key.a + 1];
    const std::uint64_t* at = begin;
    if (end - begin > 16)  // many isovalues
      at = std::lower_bound(begin, end, packed);
    else
      while (*at != packed) ++at;
    return static_cast<std::uint32_t>(at - keys_.data());
  }
  /// Fills the mesh's positions, origins and, if asked for, values: [size()].
  void locate(const Grid& grid, const PointArray& array, const IsoRules& rules, bool values, IntervalMesh& mesh,
              const Task& task) const;

 private:
  static constexpr int kIsovalueBits = 17;  // up to 2 * 65535 isovalues
  static std::uint64_t pack(const PointKey& key) { return static_cast<std::uint64_t>(key.b) << kIsovalueBits | key.isovalue; }

  std::vector<std::uint32_t> first_;  // [grid points + 1] into keys_
  std::vector<std::uint64_t> keys_;   // [size()] b and isovalue, increasing within each a
};

/// Where the isovalue lies between a and b, in [0, 1]. fa and fb are on different sides of it.
inline double crossing_weight(double fa, double fb, double isovalue) {
  double numerator = isovalue - fa, denominator = fb - fa;
  if (!std::isfinite(numerator) || !std::isfinite(denominator)) {  // values near the ends of the range of double
    numerator = isovalue / 2 - fa / 2;
    denominator = fb / 2 - fa / 2;
  }
  return std::clamp(numerator / denominator, 0.0, 1.0);
}

/// Writes point `to` of the mesh: the grid point a.
inline void set_kept_point(IntervalMesh& mesh, std::uint32_t to, std::int64_t a, const Vec3d& at, double fa) {
  mesh.positions[to] = at;
  mesh.origins[to] = {a, a, 0.0};
  if (!mesh.values.empty()) mesh.values[to] = fa;
}

/// Writes point `to` of the mesh: where the edge from a to b crosses the isovalue. A coordinate that both ends share stays as it
/// is to the last bit, so plane faces of the domain stay plane.
inline void set_crossing(IntervalMesh& mesh, std::uint32_t to, std::int64_t a, const Vec3d& at_a, double fa, std::int64_t b,
                         const Vec3d& at_b, double fb, double isovalue) {
  const double weight = crossing_weight(fa, fb, isovalue);
  mesh.positions[to] = weight == 1 ? at_b : at_a + (at_b - at_a) * weight;
  mesh.origins[to] = {a, b, weight};
  if (!mesh.values.empty()) mesh.values[to] = isovalue;
}

}  // namespace isostrata
