#include "import/vtk/vtk_cells.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <map>
#include <tuple>
#include <unordered_map>

#include <boost/container_hash/hash.hpp>

#include "base/error.h"
#include "data/grids/hull_faces.h"
#include "data/grids/split_polyhedron.h"
#include "import/vtk/cell_checks.h"
#include "import/vtk/cell_counts.h"
#include "import/vtk/divide_cell.h"
#include "import/vtk/vtk_polyhedra.h"
#include "import/vtk/whole_cells.h"
#include "tables/cell_type.h"

namespace isostrata {
namespace {

struct Kept {
  CellType type = CellType::tetrahedron;
  int corners = 0;  // 0: not a cell that can be kept as it is
  bool linearised = false;
};

/// VTK numbers a cell's corners first, whatever its order.
Kept kept_as(int vtk_type) {
  switch (vtk_type) {
    case VTK_TETRA:
      return {CellType::tetrahedron, 4, false};
    case VTK_HEXAHEDRON:
    case VTK_VOXEL:
      return {CellType::hexahedron, 8, false};
    case VTK_WEDGE:
      return {CellType::wedge, 6, false};
    case VTK_PYRAMID:
      return {CellType::pyramid, 5, false};
    case VTK_BEZIER_TETRAHEDRON:
      return {CellType::tetrahedron, 4, true};
    case VTK_BEZIER_HEXAHEDRON:
      return {CellType::hexahedron, 8, true};
    case VTK_BEZIER_WEDGE:
      return {CellType::wedge, 6, true};
    case VTK_LAGRANGE_PYRAMID:  // VTK numbers them and knows no nodes of them
    case VTK_BEZIER_PYRAMID:
      return {CellType::pyramid, 5, true};
    // Of cells with an area and no volume; VTK's pixel is a quadrilateral with its last two corners exchanged.
    case VTK_TRIANGLE:
      return {CellType::triangle, 3, false};
    case VTK_QUAD:
    case VTK_PIXEL:
      return {CellType::quadrilateral, 4, false};
    case VTK_BEZIER_TRIANGLE:
      return {CellType::triangle, 3, true};
    case VTK_BEZIER_QUADRILATERAL:
      return {CellType::quadrilateral, 4, true};
    default:
      return {};
  }
}

bool is_split(int vtk_type) {
  return vtk_type == VTK_POLYHEDRON || vtk_type == VTK_PENTAGONAL_PRISM || vtk_type == VTK_HEXAGONAL_PRISM ||
         vtk_type == VTK_CONVEX_POINT_SET;
}

bool has_volume(int vtk_type) {
  const Kept as = kept_as(vtk_type);
  const auto divided = kind_of_divided(vtk_type);
  return is_split(vtk_type) || (divided && !is_flat(*divided)) || (as.corners > 0 && !is_flat(as.type));
}

/// Reads the cells one after another.
class CellKeeper {
 public:
  CellKeeper(vtkUnstructuredGrid* grid, const ReadRequest& request)
      : grid_(grid), cells_(grid->GetCells()), points_(grid->GetNumberOfPoints()), request_(request), checks_(request.file.filename().string(), points_), polyhedra_(grid, checks_) {}

  KeptCells run(std::vector<std::string>& notes) {
    vtkUnsignedCharArray* types = grid_->GetCellTypesArray();
    if (!cells_ || !types) return {};
    const vtkIdType count = cells_->GetNumberOfCells();
    if (types->GetNumberOfValues() != count)
      checks_.broken(std::to_string(types->GetNumberOfValues()) + " cell types for " + std::to_string(count) + " cells");
    checks_.offsets(cells_, "cell");
    polyhedra_.check();
    if (auto whole = keep_whole_cells(cells_, types, points_, request_)) return std::move(*whole);
    kept_.types.reserve(static_cast<std::size_t>(count));
    kept_.offsets.reserve(static_cast<std::size_t>(count) + 1);
    flat_ = true;
    for (vtkIdType c = 0; c < count && flat_; ++c) flat_ = !has_volume(types->GetValue(c));
    for (vtkIdType c = 0; c < count; ++c) find_edge_points(c, types->GetValue(c));
    for (vtkIdType c = 0; c < count; ++c) keep(c, types->GetValue(c));
    if (turned_) {
      edge_points_.nearly_in_line();
      kept_ = {};
      counts_ = {};
      next_hull_ = 0;
      middles_.clear();
      for (vtkIdType c = 0; c < count; ++c) keep(c, types->GetValue(c));
    }
    counts_.note(flat_, notes);
    if (static_cast<vtkIdType>(kept_.types.size()) == count && counts_.each_is_one()) kept_.source.clear();
    return std::move(kept_);
  }

 private:
  void find_edge_points(vtkIdType c, int vtk_type) {
    if (vtk_type == VTK_POLYHEDRON) {
      polyhedra_.read(c, faces_);
      edge_points_.add(faces_);
    } else if (vtk_type == VTK_CONVEX_POINT_SET && read_point_set(c)) {
      edge_points_.add(faces_);
      hulls_.push_back(faces_);
    }
  }

  void keep(vtkIdType c, int vtk_type) {
    switch (vtk_type) {
      case VTK_POLYHEDRON:
        polyhedra_.read(c, faces_);
        split(c, vtk_type);
        return;
      case VTK_PENTAGONAL_PRISM:
        read_prism(c, vtk_type, 5);
        split(c, vtk_type);
        return;
      case VTK_HEXAGONAL_PRISM:
        read_prism(c, vtk_type, 6);
        split(c, vtk_type);
        return;
      case VTK_CONVEX_POINT_SET:
        cells_->GetCellAtId(c, corners_);
        if (corners_->GetNumberOfIds() > static_cast<vtkIdType>(kMostHullPoints)) {
          ++counts_.skipped[vtk_type];
          return;
        }
        faces_ = hulls_[next_hull_++];
        split(c, vtk_type);
        return;
      default:
        break;
    }
    if (flat_ && (vtk_type == VTK_POLYGON || vtk_type == VTK_TRIANGLE_STRIP)) {
      keep_fan(c, vtk_type);
      return;
    }
    if (const auto kind = kind_of_divided(vtk_type); kind && is_flat(*kind) == flat_) {
      divide(c, vtk_type);
      return;
    }
    const Kept as = kept_as(vtk_type);
    if (as.corners == 0 || is_flat(as.type) != flat_) {
      ++counts_.skipped[vtk_type];
      return;
    }
    cells_->GetCellAtId(c, corners_);
    checks_.count(c, vtk_type, corners_->GetNumberOfIds(), as.corners, as.linearised);
    if (as.linearised) ++counts_.linearised[vtk_type];
    static constexpr std::array<vtkIdType, 8> kFromVoxel{0, 1, 3, 2, 4, 5, 7, 6};
    const bool by_axes = vtk_type == VTK_VOXEL || vtk_type == VTK_PIXEL;
    for (vtkIdType v = 0; v < as.corners; ++v)
      kept_.connectivity.push_back(checks_.point(c, corners_->GetId(by_axes ? kFromVoxel[static_cast<std::size_t>(v)] : v)));
    end_cell(c, as.type);
  }

  /// How cells of this type and number of nodes are divided, made once.
  const CellDivision& division(vtkIdType c, int vtk_type, vtkIdType nodes) {
    std::array<int, 3> orders{};
    vtkDataArray* const degrees = grid_->GetCellData()->GetHigherOrderDegrees();
    if (degrees && c < degrees->GetNumberOfTuples())
      for (int axis = 0; axis < std::min(3, degrees->GetNumberOfComponents()); ++axis)
        if (const double said = degrees->GetComponent(c, axis); said >= 1 && said <= 100) orders[static_cast<std::size_t>(axis)] = static_cast<int>(said);
    const auto key = std::make_tuple(vtk_type, nodes, orders);
    if (const auto known = divisions_.find(key); known != divisions_.end()) return known->second;
    try {
      return divisions_.emplace(key, divide_cell(vtk_type, nodes, orders)).first->second;
    } catch (const Error& error) {
      checks_.broken("cell " + std::to_string(c) + ", " + vtk_name(vtk_type) + ", has " + error.what());
    }
  }

  void divide(vtkIdType c, int vtk_type) {
    cells_->GetCellAtId(c, corners_);
    const CellDivision& made = division(c, vtk_type, corners_->GetNumberOfIds());
    cycle_.clear();
    for (vtkIdType v = 0; v < made.nodes; ++v) cycle_.push_back(checks_.point(c, corners_->GetId(v)));
    for (const MissingNode& missing : made.missing) cycle_.push_back(missing_node(missing));
    std::size_t at = 0;
    for (const CellType type : made.types) {
      for (int v = 0; v < topology(type).vertex_count; ++v, ++at)
        kept_.connectivity.push_back(cycle_[static_cast<std::size_t>(made.connectivity[at])]);
      end_cell(c, type);
    }
    CellCounts::Pieces& row = counts_.divided[vtk_type];
    ++row.cells;
    row.pieces += static_cast<std::int64_t>(made.types.size());
  }

  /// The point in the middle of the cell or of a face of it, which the neighbour may have made; cycle_ has the cell's nodes.
  std::int64_t missing_node(const MissingNode& missing) {
    AddedPoints& to = kept_.added;
    const std::int64_t number = points_ + static_cast<std::int64_t>(to.size());
    if (missing.face[0] >= 0) {
      std::array<std::int64_t, 4> corners;
      for (std::size_t i = 0; i < 4; ++i) corners[i] = cycle_[static_cast<std::size_t>(missing.face[i])];
      std::sort(corners.begin(), corners.end());
      if (const auto [entry, fresh] = middles_.try_emplace(corners, number); !fresh) return entry->second;
    }
    Vec3d position{};
    for (std::size_t i = 0; i < missing.nodes.size(); ++i) {
      const std::int64_t node = cycle_[static_cast<std::size_t>(missing.nodes[i])];
      position = position + missing.weights[i] * position_(node);
      to.points.push_back(node);
      to.weights.push_back(missing.weights[i]);
    }
    to.positions.push_back(position);
    to.first.push_back(to.points.size());
    return number;
  }

  /// A convex polygon as triangles about its first corner, or a strip as the triangles it is made of.
  void keep_fan(vtkIdType c, int vtk_type) {
    cells_->GetCellAtId(c, corners_);
    const vtkIdType n = corners_->GetNumberOfIds();
    checks_.count(c, vtk_type, n, 3, true);
    const bool strip = vtk_type == VTK_TRIANGLE_STRIP;
    for (vtkIdType i = 2; i < n; ++i) {
      const bool odd = strip && i % 2 == 1;
      const vtkIdType a = strip ? i - 2 : 0, b = i - 1;
      for (const vtkIdType v : {odd ? b : a, odd ? a : b, i}) kept_.connectivity.push_back(checks_.point(c, corners_->GetId(v)));
      end_cell(c, CellType::triangle);
    }
    CellCounts::Pieces& row = counts_.fans[vtk_type];
    ++row.cells;
    row.pieces += n - 2;
  }

  void end_cell(vtkIdType c, CellType type) {
    kept_.types.push_back(static_cast<std::uint8_t>(type));
    kept_.offsets.push_back(static_cast<std::int64_t>(kept_.connectivity.size()));
    kept_.source.push_back(c);
  }

  /// The hull of the cell's points; false if they are too many.
  bool read_point_set(vtkIdType c) {
    cells_->GetCellAtId(c, corners_);
    if (corners_->GetNumberOfIds() > static_cast<vtkIdType>(kMostHullPoints)) return false;
    std::vector<Vec3d> points;
    cycle_.clear();
    for (vtkIdType v = 0; v < corners_->GetNumberOfIds(); ++v) {
      cycle_.push_back(checks_.point(c, corners_->GetId(v)));
      points.push_back(position_(cycle_.back()));
    }
    hull_faces(points, cycle_, faces_);
    return true;
  }

  /// Two polygons of n points over each other.
  void read_prism(vtkIdType c, int vtk_type, vtkIdType n) {
    cells_->GetCellAtId(c, corners_);
    checks_.count(c, vtk_type, corners_->GetNumberOfIds(), 2 * n, false);
    const auto id = [&](vtkIdType v) { return checks_.point(c, corners_->GetId(v)); };
    faces_.clear();
    for (const vtkIdType first : {vtkIdType{0}, n}) {
      cycle_.clear();
      for (vtkIdType v = 0; v < n; ++v) cycle_.push_back(id(first + v));
      faces_.add(cycle_);
    }
    for (vtkIdType v = 0; v < n; ++v) {
      const vtkIdType next = (v + 1) % n;
      faces_.add(std::array<std::int64_t, 4>{id(v), id(next), id(n + next), id(n + v)});
    }
  }

  void split(vtkIdType c, int vtk_type) {
    split_polyhedron(faces_, position_, edge_points_, pieces_);
    if (pieces_.kind == SplitKind::open) {
      ++counts_.open[vtk_type];
      return;
    }
    const std::int64_t added = points_ + static_cast<std::int64_t>(kept_.added.size());
    std::size_t at = 0;
    for (const CellType type : pieces_.types) {
      for (int v = 0; v < topology(type).vertex_count; ++v, ++at)
        kept_.connectivity.push_back(pieces_.connectivity[at] == kAddedPoint ? added : pieces_.connectivity[at]);
      end_cell(c, type);
    }
    if (pieces_.kind == SplitKind::whole) {
      ++counts_.whole[vtk_type];
      return;
    }
    turned_ = turned_ || pieces_.turned;
    counts_.overlapping += pieces_.kind == SplitKind::overlapping;
    CellCounts::Pieces& row = counts_.split[vtk_type];
    ++row.cells;
    row.pieces += static_cast<std::int64_t>(pieces_.types.size());
    AddedPoints& to = kept_.added;
    to.positions.push_back(pieces_.added);
    to.points.insert(to.points.end(), pieces_.points.begin(), pieces_.points.end());
    to.weights.insert(to.weights.end(), pieces_.weights.begin(), pieces_.weights.end());
    to.first.push_back(to.points.size());
  }

  vtkUnstructuredGrid* grid_;
  vtkCellArray* cells_;
  vtkIdType points_;
  const ReadRequest& request_;
  const CellChecks checks_;
  VtkPolyhedra polyhedra_;
  KeptCells kept_;
  CellCounts counts_;
  bool flat_ = false;  // no cell of the file has a volume, so those with an area are kept
  bool turned_ = false;  // some piece of a polyhedron is
  vtkNew<vtkIdList> corners_;
  std::vector<std::int64_t> cycle_;
  PolyhedronFaces faces_;
  EdgePoints edge_points_;
  std::vector<PolyhedronFaces> hulls_;  // of the convex point sets, in their order
  std::size_t next_hull_ = 0;
  PolyhedronSplit pieces_;
  std::map<std::tuple<int, vtkIdType, std::array<int, 3>>, CellDivision> divisions_;
  std::unordered_map<std::array<std::int64_t, 4>, std::int64_t, boost::hash<std::array<std::int64_t, 4>>> middles_;  // of faces, by their corners in order
  const std::function<Vec3d(std::int64_t)> position_ = [this](std::int64_t id) {
    double p[3];
    grid_->GetPoint(id, p);
    return Vec3d{p[0], p[1], p[2]};
  };
};

}  // namespace

KeptCells keep_cells(vtkUnstructuredGrid* grid, const ReadRequest& request, std::vector<std::string>& notes) {
  return CellKeeper(grid, request).run(notes);
}

}  // namespace isostrata
