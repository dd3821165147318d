#include "extraction/cells/tetrahedron_cut.h"

#include <cmath>
#include <vector>

#include "extraction/cells/cell_geometry.h"
#include "tables/interval_complex.h"

namespace isostrata {
namespace {

constexpr int kEdges = 6;

// A vertex's class in the table: the sides of PointSide, with the range's two ends told apart from its middle.
enum : int { kBelow, kOnLowerEnd, kMiddle, kOnUpperEnd, kAbove, kAbsent, kClasses };

int class_of(PointSide side) {
  if (side & kAbsentValue) return kAbsent;
  if (side & kBelowRange) return kBelow;
  if (side & kAboveRange) return kAbove;
  if (!(side & kPastLower)) return kOnLowerEnd;
  return side & kBeforeUpper ? kMiddle : kOnUpperEnd;
}

/// 0 below, 1 in, 2 above the range.
int level(int vertex_class) { return vertex_class == kBelow ? 0 : vertex_class == kAbove ? 2 : 1; }

using Classes = std::array<int, 4>;
using Pieces = std::vector<CutPiece>;

enum class Region { below, inside, above };

/// The region's part of the tetrahedron, by the interval table: what is below a range is the inside of another one, which ends
/// where this one begins.
void add_region(const std::array<int, 4>& levels, Region region, Pieces& out) {
  static const std::array<std::uint8_t, kCutPoints> keys = [] {
    std::array<std::uint8_t, kCutPoints> all{};
    constexpr std::array<std::int64_t, 4> in_order{0, 1, 2, 3};
    order_isovertices(topology(CellType::tetrahedron), in_order, all);
    return all;
  }();
  int case_index = 0;
  for (int v = 3; v >= 0; --v) {
    const int vertex_class = region == Region::inside  ? levels[v]
                             : region == Region::below ? (levels[v] == 0 ? 1 : 2)
                                                       : (levels[v] == 2 ? 1 : 0);
    case_index = 3 * case_index + vertex_class;
  }
  std::array<std::array<IsoVertex, 4>, kMaxCaseTetrahedra> pulled;
  const int count = pull(interval_complex(CellType::tetrahedron), case_index, keys, pulled.data());
  for (int i = 0; i < count; ++i) {
    CutPiece piece{pulled[i], region == Region::inside};
    for (CutPoint& point : piece.points) {
      if (region == Region::below && point >= kFirstUpperCut)
        point -= kEdges;
      else if (region == Region::above && point >= kFirstLowerCut)
        point += kEdges;
    }
    out.push_back(piece);
  }
}

/// Vertex `apex` has no value: it is joined to the triangles into which the facet opposite falls.
void add_cone_over_facet(std::array<int, 4> levels, int apex, Pieces& out) {
  levels[apex] = 0;  // any class gives the same triangles
  Pieces all;
  for (const Region region : {Region::below, Region::inside, Region::above}) add_region(levels, region, all);
  for (const CutPiece& piece : all)
    for (const auto& facet : kTetrahedronFacets) {
      const CutPoint a = piece.points[facet[0]], b = piece.points[facet[1]], c = piece.points[facet[2]];
      if (!((cut_point_facets(a) & cut_point_facets(b) & cut_point_facets(c)) >> apex & 1)) continue;
      out.push_back({{static_cast<CutPoint>(apex), a, b, c}, false});
    }
}

/// Only the ends of an edge have values: its segments are joined to the opposite edge.
void add_cone_over_edge(const std::array<int, 4>& levels, int edge, Pieces& out) {
  const auto [a, b] = kCutEdges[edge];
  std::vector<CutPoint> along{a};
  const auto lower = static_cast<CutPoint>(kFirstLowerCut + edge), upper = static_cast<CutPoint>(kFirstUpperCut + edge);
  const bool rises = levels[a] < levels[b];
  const int low = rises ? levels[a] : levels[b], high = rises ? levels[b] : levels[a];
  if (low == 0 && high > 0) along.push_back(lower);
  if (low < 2 && high == 2) along.insert(rises ? along.end() : along.begin() + 1, upper);
  along.push_back(b);
  for (std::size_t i = 0; i + 1 < along.size(); ++i) {
    CutPiece piece{{0, 1, 2, 3}, false};
    piece.points[a] = along[i];
    piece.points[b] = along[i + 1];
    out.push_back(piece);
  }
}

/// A crossing whose edge ends on the isovalue is that end.
CutPoint merged(CutPoint point, const Classes& classes) {
  if (point < kFirstLowerCut) return point;
  const bool upper = point >= kFirstUpperCut;
  for (const std::uint8_t v : kCutEdges[(point - kFirstLowerCut) % kEdges])
    if (classes[v] == (upper ? kOnUpperEnd : kOnLowerEnd)) return v;
  return point;
}

bool repeats_a_point(const std::array<CutPoint, 4>& p) {
  return p[0] == p[1] || p[0] == p[2] || p[0] == p[3] || p[1] == p[2] || p[1] == p[3] || p[2] == p[3];
}

Pieces make_pieces(const Classes& classes) {
  std::array<int, 4> levels{};
  std::vector<int> absent, present;
  for (int v = 0; v < 4; ++v) {
    levels[v] = level(classes[v]);
    (classes[v] == kAbsent ? absent : present).push_back(v);
  }
  Pieces pieces;
  if (absent.empty()) {
    for (const Region region : {Region::below, Region::inside, Region::above}) add_region(levels, region, pieces);
  } else if (absent.size() == 1) {
    add_cone_over_facet(levels, absent[0], pieces);
  } else if (absent.size() == 2) {
    for (int e = 0; e < kEdges; ++e)
      if (kCutEdges[e][0] == present[0] && kCutEdges[e][1] == present[1]) add_cone_over_edge(levels, e, pieces);
  } else {
    pieces.push_back({{0, 1, 2, 3}, false});
  }
  for (CutPiece& piece : pieces)
    for (CutPoint& point : piece.points) point = merged(point, classes);
  std::erase_if(pieces, [](const CutPiece& piece) { return repeats_a_point(piece.points); });
  return pieces;
}

struct CutTable {
  std::vector<std::uint32_t> first{0};  // [6^4 + 1] into pieces
  Pieces pieces;
};

const CutTable& cut_table() {
  static const CutTable table = [] {
    CutTable made;
    for (int index = 0; index < kClasses * kClasses * kClasses * kClasses; ++index) {
      Classes classes;
      for (int v = 0, rest = index; v < 4; ++v, rest /= kClasses) classes[v] = rest % kClasses;
      const Pieces pieces = make_pieces(classes);
      made.pieces.insert(made.pieces.end(), pieces.begin(), pieces.end());
      made.first.push_back(static_cast<std::uint32_t>(made.pieces.size()));
    }
    return made;
  }();
  return table;
}

}  // namespace

PointSide side_of_range(double value, double lower, double upper) {
  if (!std::isfinite(value)) return kAbsentValue;
  if (value < lower) return kBelowRange;
  if (value > upper) return kAboveRange;
  return static_cast<PointSide>(kInRange | (value > lower ? kPastLower : 0) | (value < upper ? kBeforeUpper : 0));
}

std::uint8_t cut_point_facets(CutPoint point) {
  if (point < kFirstLowerCut) return static_cast<std::uint8_t>(0xf & ~(1u << point));
  const auto [a, b] = kCutEdges[(point - kFirstLowerCut) % kEdges];
  return static_cast<std::uint8_t>(0xf & ~(1u << a) & ~(1u << b));
}

std::span<const CutPiece> cut_pieces(std::array<PointSide, 4> sides) {
  const CutTable& table = cut_table();
  int index = 0;
  for (int v = 3; v >= 0; --v) index = kClasses * index + class_of(sides[v]);
  return {table.pieces.data() + table.first[index], table.pieces.data() + table.first[index + 1]};
}

}  // namespace isostrata
