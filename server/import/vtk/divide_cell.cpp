#include "import/vtk/divide_cell.h"

#include <vtkCell.h>
#include <vtkCellType.h>
#include <vtkGenericCell.h>
#include <vtkHigherOrderHexahedron.h>
#include <vtkHigherOrderQuadrilateral.h>
#include <vtkHigherOrderTetra.h>
#include <vtkHigherOrderTriangle.h>
#include <vtkHigherOrderWedge.h>
#include <vtkIdList.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "base/error.h"

namespace isostrata {
namespace {

using At = std::array<int, 3>;         // a node's place on the lattice of the reference cell
using Sum = std::map<int, double>;     // weights by node
constexpr int kMostSpaces = 10;        // of VTK's Lagrange cells

/// The linear cell that a divided one is bent from, and whether its number of nodes says how fine it is.
struct Family {
  CellType type = CellType::tetrahedron;
  bool known = false, lagrange = false;
};

Family family_of(int vtk_type) {
  switch (vtk_type) {
    case VTK_QUADRATIC_TRIANGLE:
    case VTK_BIQUADRATIC_TRIANGLE:
      return {CellType::triangle, true, false};
    case VTK_LAGRANGE_TRIANGLE:
      return {CellType::triangle, true, true};
    case VTK_QUADRATIC_QUAD:
    case VTK_BIQUADRATIC_QUAD:
    case VTK_QUADRATIC_LINEAR_QUAD:
      return {CellType::quadrilateral, true, false};
    case VTK_LAGRANGE_QUADRILATERAL:
      return {CellType::quadrilateral, true, true};
    case VTK_QUADRATIC_TETRA:
      return {CellType::tetrahedron, true, false};
    case VTK_LAGRANGE_TETRAHEDRON:
      return {CellType::tetrahedron, true, true};
    case VTK_QUADRATIC_HEXAHEDRON:
    case VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON:
    case VTK_TRIQUADRATIC_HEXAHEDRON:
      return {CellType::hexahedron, true, false};
    case VTK_LAGRANGE_HEXAHEDRON:
      return {CellType::hexahedron, true, true};
    case VTK_QUADRATIC_WEDGE:
    case VTK_QUADRATIC_LINEAR_WEDGE:
    case VTK_BIQUADRATIC_QUADRATIC_WEDGE:
      return {CellType::wedge, true, false};
    case VTK_LAGRANGE_WEDGE:
      return {CellType::wedge, true, true};
    case VTK_QUADRATIC_PYRAMID:
    case VTK_TRIQUADRATIC_PYRAMID:
      return {CellType::pyramid, true, false};
    default:
      return {};
  }
}

/// How many nodes a cell has with so many spaces along its axes: those of tetrahedra and triangles are alike, and those of a wedge's triangle.
std::int64_t lattice_size(CellType type, const At& n) {
  const std::int64_t a = n[0] + 1, b = n[1] + 1, c = n[2] + 1;
  switch (type) {
    case CellType::triangle:
      return a * (a + 1) / 2;
    case CellType::quadrilateral:
      return a * b;
    case CellType::tetrahedron:
      return a * (a + 1) * (a + 2) / 6;
    case CellType::wedge:
      return a * (a + 1) / 2 * c;
    default:
      return a * b * c;
  }
}

/// VTK numbers some Lagrange cells of two spaces with bubbles: 7 nodes of a triangle, 15 of a tetrahedron, 21 of a wedge.
bool has_bubbles(CellType type, std::int64_t nodes) {
  return (type == CellType::triangle && nodes == 7) || (type == CellType::tetrahedron && nodes == 15) ||
         (type == CellType::wedge && nodes == 21);
}

At spaces_of_lagrange(CellType type, std::int64_t nodes, const At& said) {
  if (has_bubbles(type, nodes)) return {2, 2, 2};
  const bool free = type != CellType::triangle && type != CellType::tetrahedron;
  if (free && said[0] > 0 && said[1] > 0 && (said[2] > 0 || type == CellType::quadrilateral) &&
      *std::max_element(said.begin(), said.end()) <= kMostSpaces && (type != CellType::wedge || said[0] == said[1]) &&
      lattice_size(type, said) == nodes)
    return said;
  for (int n = 1; n <= kMostSpaces; ++n)
    if (lattice_size(type, {n, n, n}) == nodes) return {n, n, n};
  throw Error(ErrorCode::bad_data, std::to_string(nodes) + " nodes; expected those of 1 to " + std::to_string(kMostSpaces) +
                                       " spaces along each edge" + (said[0] > 0 ? " or of HigherOrderDegrees" : ""));
}

/// VTK's own places of the nodes in the reference cell, in [0, 1]^3.
vtkSmartPointer<vtkCell> reference_cell(int vtk_type, const Family& family, std::int64_t nodes, const At& n) {
  auto cell = vtkSmartPointer<vtkCell>::Take(vtkGenericCell::InstantiateCell(vtk_type));
  if (!family.lagrange) return cell;
  cell->PointIds->SetNumberOfIds(nodes);
  cell->Points->SetNumberOfPoints(nodes);
  cell->Initialize();
  if (auto* hexahedron = vtkHigherOrderHexahedron::SafeDownCast(cell)) hexahedron->SetOrder(n[0], n[1], n[2]);
  if (auto* wedge = vtkHigherOrderWedge::SafeDownCast(cell)) wedge->SetOrder(n[0], n[1], n[2], nodes);
  if (auto* quadrilateral = vtkHigherOrderQuadrilateral::SafeDownCast(cell)) quadrilateral->SetOrder(n[0], n[1]);
  return cell;
}

/// The nodes by their places, and what is made of them.
class Divider {
 public:
  Divider(int vtk_type, const Family& family, std::int64_t nodes, At said) : type_(family.type) {
    if (family.lagrange) spaces_ = spaces_of_lagrange(type_, nodes, said);
    const auto cell = reference_cell(vtk_type, family, nodes, spaces_);
    if (cell->GetNumberOfPoints() != nodes)
      throw Error(ErrorCode::bad_data, std::to_string(nodes) + " nodes; expected " + std::to_string(cell->GetNumberOfPoints()));
    out_.nodes = static_cast<int>(nodes);
    if (type_ == CellType::pyramid) return;
    const double* places = cell->GetParametricCoords();
    if (!family.lagrange)
      for (std::size_t axis = 0; axis < 3; ++axis) spaces_[axis] = has_middle(places, nodes, axis) ? 2 : 1;
    for (int node = 0; node < out_.nodes; ++node) place(node, places + 3 * node);
  }

  CellDivision run() {
    switch (type_) {
      case CellType::pyramid:
        pyramids();
        break;
      case CellType::tetrahedron:
        tetrahedra();
        break;
      case CellType::triangle:
      case CellType::wedge:
        triangles();
        break;
      default:
        boxes();
    }
    return std::move(out_);
  }

 private:
  /// Whether a node lies in the middle of an edge along this axis.
  static bool has_middle(const double* places, std::int64_t nodes, std::size_t axis) {
    for (std::int64_t node = 0; node < nodes; ++node) {
      const double* p = places + 3 * node;
      if (p[axis] == 0.5 && p[(axis + 1) % 3] == 0 && p[(axis + 2) % 3] == 0) return true;
    }
    return false;
  }

  void place(int node, const double* at) {
    At on{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double steps = at[axis] * spaces_[axis];
      if (std::abs(steps - std::round(steps)) > 1e-6) return;  // a bubble
      on[axis] = static_cast<int>(std::round(steps));
    }
    node_at_.emplace(on, node);
  }

  /// The node there, or the missing one, which is made when it is first asked for.
  int node(const At& at) {
    if (const auto found = node_at_.find(at); found != node_at_.end()) return found->second;
    MissingNode missing;
    for (const auto& [node, weight] : weights_at(at)) missing.nodes.push_back(node), missing.weights.push_back(weight);
    if (const auto corners = corners_of_face(at); corners.size() == 4)
      for (std::size_t i = 0; i < 4; ++i) missing.face[i] = node_at_.at(corners[i]);
    return add_missing(at, std::move(missing));
  }

  int add_missing(const At& at, MissingNode missing) {
    const int number = out_.nodes + static_cast<int>(out_.missing.size());
    out_.missing.push_back(std::move(missing));
    node_at_.emplace(at, number);
    return number;
  }

  /// Round the quadrilateral face whose middle is there: only with two spaces is a node missing. Empty for the middle of a hexahedron.
  std::vector<At> corners_of_face(const At& at) const {
    std::array<std::pair<At, At>, 2> ends;  // of the two edges that cross in the middle
    std::size_t crossing = 0;
    const auto along = [&](const At& step) {
      if (crossing < 2) ends[crossing] = {step, {-step[0], -step[1], -step[2]}};
      ++crossing;
    };
    if (type_ == CellType::wedge) {
      along(at[0] == 0 ? At{0, 1, 0} : at[1] == 0 ? At{1, 0, 0} : At{1, -1, 0});
      along({0, 0, 1});
    } else {
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (at[axis] == 1 && spaces_[axis] == 2) {
          At step{};
          step[axis] = 1;
          along(step);
        }
    }
    if (crossing != 2) return {};
    const auto plus = [](const At& a, const At& b) { return At{a[0] + b[0], a[1] + b[1], a[2] + b[2]}; };
    const auto& [first, second] = ends;
    return {plus(plus(at, first.second), second.second), plus(plus(at, first.first), second.second),
            plus(plus(at, first.first), second.first), plus(plus(at, first.second), second.first)};
  }

  static At middle(const At& a, const At& b) { return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2}; }

  Sum weights_at(const At& at) const {
    if (const auto found = node_at_.find(at); found != node_at_.end()) {
      if (found->second < out_.nodes) return {{found->second, 1.0}};
      const MissingNode& made = out_.missing[static_cast<std::size_t>(found->second - out_.nodes)];
      Sum sum;
      for (std::size_t i = 0; i < made.nodes.size(); ++i) sum[made.nodes[i]] = made.weights[i];
      return sum;
    }
    Sum sum;
    const auto add = [&](const At& from, double weight) {
      for (const auto& [node, w] : weights_at(from)) sum[node] += weight * w;
    };
    if (const auto corners = corners_of_face(at); corners.size() == 4) {
      for (std::size_t i = 0; i < 4; ++i) {
        add(corners[i], -0.25);
        add(middle(corners[i], corners[(i + 1) % 4]), 0.5);
      }
    } else {  // the middle of a hexahedron, from its faces, edges and corners
      for (int i = 0; i < 27; ++i) {
        const At from{i % 3, i / 3 % 3, i / 9};
        const int middles = (from[0] == 1) + (from[1] == 1) + (from[2] == 1);
        if (middles < 3) add(from, middles == 2 ? 0.5 : middles == 1 ? -0.25 : 0.125);
      }
    }
    std::erase_if(sum, [](const auto& entry) { return entry.second == 0; });
    return sum;
  }

  void add(CellType type, std::initializer_list<At> corners) {
    out_.types.push_back(type);
    for (const At& corner : corners) out_.connectivity.push_back(node(corner));
  }

  /// Turned round where its corners are in the order of a mirrored cell.
  void add_tetrahedron(const At& a, At b, At c, const At& d) {
    const auto edge = [&](const At& to) { return At{to[0] - a[0], to[1] - a[1], to[2] - a[2]}; };
    const At u = edge(b), v = edge(c), w = edge(d);
    const int volume = u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
    if (volume < 0) std::swap(b, c);
    add(CellType::tetrahedron, {a, b, c, d});
  }

  /// A lattice of tetrahedra that stand, octahedra between four of those, and tetrahedra that hang.
  void tetrahedra() {
    const int n = spaces_[0];
    for (int k = 0; k < n; ++k)
      for (int j = 0; j + k < n; ++j)
        for (int i = 0; i + j + k < n; ++i) {
          const auto at = [&](int x, int y, int z) { return At{i + x, j + y, k + z}; };
          add_tetrahedron(at(0, 0, 0), at(1, 0, 0), at(0, 1, 0), at(0, 0, 1));
          if (i + j + k + 1 < n) {
            const std::array<At, 4> ring{at(0, 1, 0), at(0, 0, 1), at(1, 0, 1), at(1, 1, 0)};
            for (std::size_t r = 0; r < 4; ++r) add_tetrahedron(at(1, 0, 0), at(0, 1, 1), ring[r], ring[(r + 1) % 4]);
          }
          if (i + j + k + 2 < n) add_tetrahedron(at(1, 1, 0), at(1, 0, 1), at(0, 1, 1), at(1, 1, 1));
        }
  }

  /// Triangles that point up and down, as they are or as layers of wedges.
  void triangles() {
    const int n = spaces_[0];
    const auto piece = [&](int k, const At& a, const At& b, const At& c) {
      const auto up = [&](const At& at) { return At{at[0], at[1], k + 1}; };
      if (type_ == CellType::triangle)
        add(CellType::triangle, {a, b, c});
      else
        add(CellType::wedge, {a, b, c, up(a), up(b), up(c)});
    };
    for (int k = 0; k < (type_ == CellType::triangle ? 1 : spaces_[2]); ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i + j < n; ++i) {
          piece(k, {i, j, k}, {i + 1, j, k}, {i, j + 1, k});
          if (i + j + 1 < n) piece(k, {i + 1, j, k}, {i + 1, j + 1, k}, {i, j + 1, k});
        }
  }

  void boxes() {
    for (int k = 0; k < (type_ == CellType::quadrilateral ? 1 : spaces_[2]); ++k)
      for (int j = 0; j < spaces_[1]; ++j)
        for (int i = 0; i < spaces_[0]; ++i) {
          const auto at = [&](int x, int y, int z) { return At{i + x, j + y, k + z}; };
          if (type_ == CellType::quadrilateral)
            add(type_, {at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0)});
          else
            add(type_, {at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0), at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)});
        }
  }

  /// 4 corners of the base, its edges' middles from 5, those of the edges to the tip from 9, perhaps the base's middle at 13.
  void pyramids() {
    int base = 13;
    if (out_.nodes < 14) {
      MissingNode middle{{0, 1, 2, 3, 5, 6, 7, 8}, {-0.25, -0.25, -0.25, -0.25, 0.5, 0.5, 0.5, 0.5}, {0, 1, 2, 3}};
      base = out_.nodes;
      out_.missing.push_back(std::move(middle));
    }
    const auto piece = [&](CellType type, std::initializer_list<int> nodes) {
      out_.types.push_back(type);
      out_.connectivity.insert(out_.connectivity.end(), nodes);
    };
    for (int i = 0; i < 4; ++i) {
      const int next = 5 + i, before = 5 + (i + 3) % 4;
      piece(CellType::pyramid, {i, next, base, before, 9 + i});
      piece(CellType::tetrahedron, {next, 9 + (i + 1) % 4, base, 9 + i});
    }
    piece(CellType::pyramid, {9, 10, 11, 12, 4});
    piece(CellType::pyramid, {12, 11, 10, 9, base});
  }

  CellType type_;
  At spaces_{1, 1, 1};
  std::map<At, int> node_at_;
  CellDivision out_;
};

}  // namespace

std::optional<CellType> kind_of_divided(int vtk_type) {
  const Family family = family_of(vtk_type);
  return family.known ? std::optional(family.type) : std::nullopt;
}

CellDivision divide_cell(int vtk_type, std::int64_t nodes, std::array<int, 3> orders) {
  return Divider(vtk_type, family_of(vtk_type), nodes, orders).run();
}

}  // namespace isostrata
