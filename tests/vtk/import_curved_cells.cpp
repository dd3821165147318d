// Quadratic and Lagrange cells, written by VTK, are read as linear cells between all of their nodes.
#include <gtest/gtest.h>
#include <vtkCell.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkGenericCell.h>
#include <vtkHigherOrderHexahedron.h>
#include <vtkHigherOrderQuadrilateral.h>
#include <vtkHigherOrderWedge.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "data/files.h"
#include "extraction/facets/boundary_facets.h"
#include "extraction/intervals/extract_intervals.h"

namespace isostrata {
namespace {

using test::Scratch;

constexpr int kSide = 2;  // cubes along each side of a mesh

/// A kind of curved cell: `shape` is the linear cell that says which corners it has.
struct Curved {
  std::string name;
  int type = 0, shape = 0;
  int nodes = 0;  // of a Lagrange cell; 0: as VTK has it
  std::array<int, 3> spaces{2, 2, 2};
  int pieces = 8;  // of one cell

  bool lagrange() const { return nodes > 0; }
};

std::ostream& operator<<(std::ostream& out, const Curved& curved) { return out << curved.name; }

const std::vector<Curved>& kinds() {
  static const std::vector<Curved> all{
      {"quadratic_tetrahedra", VTK_QUADRATIC_TETRA, VTK_TETRA},
      {"quadratic_hexahedra", VTK_QUADRATIC_HEXAHEDRON, VTK_HEXAHEDRON},
      {"hexahedra_of_24", VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON, VTK_HEXAHEDRON},
      {"hexahedra_of_27", VTK_TRIQUADRATIC_HEXAHEDRON, VTK_HEXAHEDRON},
      {"quadratic_wedges", VTK_QUADRATIC_WEDGE, VTK_WEDGE},
      {"wedges_of_18", VTK_BIQUADRATIC_QUADRATIC_WEDGE, VTK_WEDGE},
      {"wedges_straight_upward", VTK_QUADRATIC_LINEAR_WEDGE, VTK_WEDGE, 0, {2, 2, 1}, 4},
      {"quadratic_pyramids", VTK_QUADRATIC_PYRAMID, VTK_PYRAMID, 0, {2, 2, 2}, 10},
      {"lagrange_tetrahedra_2", VTK_LAGRANGE_TETRAHEDRON, VTK_TETRA, 10},
      {"lagrange_tetrahedra_4", VTK_LAGRANGE_TETRAHEDRON, VTK_TETRA, 35, {4, 4, 4}, 64},
      {"lagrange_hexahedra_3", VTK_LAGRANGE_HEXAHEDRON, VTK_HEXAHEDRON, 64, {3, 3, 3}, 27},
      {"lagrange_hexahedra_by_axis", VTK_LAGRANGE_HEXAHEDRON, VTK_HEXAHEDRON, 24, {3, 2, 1}, 6},
      {"lagrange_wedges_3", VTK_LAGRANGE_WEDGE, VTK_WEDGE, 40, {3, 3, 3}, 27},
      {"lagrange_wedges_by_axis", VTK_LAGRANGE_WEDGE, VTK_WEDGE, 18, {2, 2, 2}, 8},
  };
  return all;
}

/// Weights of a linear cell's corners at a place of its reference cell.
std::vector<double> corner_weights(int shape, const Vec3d& u) {
  if (shape == VTK_TETRA) return {1 - u.x - u.y - u.z, u.x, u.y, u.z};
  if (shape == VTK_WEDGE) {
    const double t = 1 - u.x - u.y;
    return {t * (1 - u.z), u.x * (1 - u.z), u.y * (1 - u.z), t * u.z, u.x * u.z, u.y * u.z};
  }
  const double x = 1 - u.x, y = 1 - u.y, z = 1 - u.z;
  return {x * y * z, u.x * y * z, u.x * u.y * z, x * u.y * z, x * y * u.z, u.x * y * u.z, u.x * u.y * u.z, x * u.y * u.z};
}

/// By node, the weights of the corners: VTK's own places of the nodes, but for the pyramid's, which are the middles of its edges.
std::vector<std::vector<double>> node_weights(const Curved& kind) {
  std::vector<std::vector<double>> out;
  if (kind.shape == VTK_PYRAMID) {
    for (std::size_t v = 0; v < 5; ++v) out.emplace_back(5, 0.0)[v] = 1;
    for (const auto& [a, b] : std::vector<std::pair<std::size_t, std::size_t>>{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}})
      out.emplace_back(5, 0.0)[a] = 0.5, out.back()[b] = 0.5;
    return out;
  }
  const auto cell = vtkSmartPointer<vtkCell>::Take(vtkGenericCell::InstantiateCell(kind.type));
  if (kind.lagrange()) {
    cell->PointIds->SetNumberOfIds(kind.nodes);
    cell->Points->SetNumberOfPoints(kind.nodes);
    cell->Initialize();
    if (auto* hexahedron = vtkHigherOrderHexahedron::SafeDownCast(cell)) hexahedron->SetOrder(kind.spaces[0], kind.spaces[1], kind.spaces[2]);
    if (auto* wedge = vtkHigherOrderWedge::SafeDownCast(cell)) wedge->SetOrder(kind.spaces[0], kind.spaces[1], kind.spaces[2], kind.nodes);
  }
  const double* at = cell->GetParametricCoords();
  for (vtkIdType p = 0; p < cell->GetNumberOfPoints(); ++p) out.push_back(corner_weights(kind.shape, {at[3 * p], at[3 * p + 1], at[3 * p + 2]}));
  return out;
}

/// The corners of the cells of one unit cube.
std::vector<std::vector<Vec3d>> cells_of_cube(int shape, const Vec3d& at) {
  std::vector<Vec3d> c;
  for (const Vec3d& v : {Vec3d{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}) c.push_back(at + v);
  if (shape == VTK_HEXAHEDRON) return {c};
  if (shape == VTK_WEDGE) return {{c[0], c[1], c[2], c[4], c[5], c[6]}, {c[0], c[2], c[3], c[4], c[6], c[7]}};
  std::vector<std::vector<Vec3d>> out;
  if (shape == VTK_TETRA) {
    for (const auto& [a, b] : std::vector<std::pair<std::size_t, std::size_t>>{{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}})
      out.push_back({c[0], c[a], c[b], c[6]});
  } else {
    for (const auto& f : std::vector<std::array<std::size_t, 4>>{{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}})
      out.push_back({c[f[0]], c[f[1]], c[f[2]], c[f[3]], at + Vec3d{0.5, 0.5, 0.5}});
  }
  return out;
}

/// Bends everything inside the block and leaves each of its sides in its plane.
Vec3d bent(const Vec3d& p) {
  const auto bump = [](double x) { return std::sin(std::numbers::pi * x / kSide); };
  return {p.x + 0.06 * bump(p.x) * std::cos(p.y), p.y + 0.05 * bump(p.y) * std::cos(2 * p.z), p.z + 0.04 * bump(p.z) * std::sin(3 * p.x)};
}

double linear(const Vec3d& p) { return 1 + 2 * p.x - 3 * p.y + 0.5 * p.z; }

std::shared_ptr<const Dataset> written_and_read(const Scratch& scratch, vtkUnstructuredGrid* grid) {
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  const auto file = scratch / "curved.vtu";
  writer->SetInputData(grid);
  writer->SetFileName(file.c_str());
  EXPECT_EQ(writer->Write(), 1);
  return test::open(file);
}

struct Mesh {
  vtkNew<vtkUnstructuredGrid> grid;
  vtkNew<vtkPoints> points;
  std::map<std::array<long, 3>, vtkIdType> number;
  vtkNew<vtkDoubleArray> degrees;

  Mesh() {
    points->SetDataTypeToDouble();
    grid->SetPoints(points);
    degrees->SetName("degrees");
    degrees->SetNumberOfComponents(3);
  }

  void add_cube(const Curved& kind, const Vec3d& at) {
    const auto weights = node_weights(kind);
    for (const auto& corners : cells_of_cube(kind.shape, at)) {
      std::vector<vtkIdType> ids;
      for (const auto& of : weights) {
        Vec3d p{};
        for (std::size_t v = 0; v < corners.size(); ++v) p = p + of[v] * corners[v];
        const auto [entry, fresh] = number.try_emplace({std::lround(p.x * 1e6), std::lround(p.y * 1e6), std::lround(p.z * 1e6)}, points->GetNumberOfPoints());
        if (fresh) {
          const Vec3d to = bent(p);
          points->InsertNextPoint(to.x, to.y, to.z);
        }
        ids.push_back(entry->second);
      }
      grid->InsertNextCell(kind.type, static_cast<vtkIdType>(ids.size()), ids.data());
      degrees->InsertNextTuple3(kind.spaces[0], kind.spaces[1], kind.spaces[2]);
    }
  }

  std::shared_ptr<const Dataset> open(const Scratch& scratch, bool with_degrees) {
    vtkNew<vtkDoubleArray> f;
    f->SetName("f");
    for (vtkIdType p = 0; p < points->GetNumberOfPoints(); ++p) {
      double x[3];
      points->GetPoint(p, x);
      f->InsertNextValue(linear({x[0], x[1], x[2]}));
    }
    grid->GetPointData()->AddArray(f);
    if (with_degrees) grid->GetCellData()->SetHigherOrderDegrees(degrees);
    return written_and_read(scratch, grid);
  }
};

/// The block is filled once: no piece is missing, doubled or turned, and inside it every facet has its partner.
void expect_filled_block(const Dataset& data) {
  const Task task;
  ExtractOptions options;
  options.facets = true;
  const PointArray& f = data.array("f");
  const double middle = 0.5 * (f.lower + f.upper);
  const IntervalMesh mesh = extract_intervals(data.grid, f, std::vector<Interval>{{f.lower, middle}, {middle, f.upper}}, options, task);
  double sum = 0;
  for (const IntervalSummary& summary : mesh.summaries) {
    EXPECT_EQ(summary.inverted, 0);
    sum += summary.signed_volume;
  }
  EXPECT_NEAR(sum, kSide * kSide * kSide, 1e-9);
  EXPECT_EQ(count_unmatched_facets(mesh, task), 0);
  for (const BoundaryFacet& facet : mesh.facets) {
    if (facet.label != FacetLabel::domain) continue;
    const auto in_side = [&](double Vec3d::*axis) {
      return std::ranges::any_of(std::array{0.0, double(kSide)}, [&](double side) {
        return std::ranges::all_of(facet.points, [&](auto p) { return std::abs(mesh.positions[p].*axis - side) < 1e-9; });
      });
    };
    ASSERT_TRUE(in_side(&Vec3d::x) || in_side(&Vec3d::y) || in_side(&Vec3d::z)) << "a facet inside the block has no partner";
  }
}

class CurvedCells : public ::testing::TestWithParam<Curved> {};
INSTANTIATE_TEST_SUITE_P(Import, CurvedCells, ::testing::ValuesIn(kinds()), [](const auto& info) { return info.param.name; });

TEST_P(CurvedCells, FillTheirBlockBetweenAllOfTheirNodes) {
  const Scratch scratch;
  const Curved& kind = GetParam();
  Mesh mesh;
  for (int i = 0; i < kSide * kSide * kSide; ++i) mesh.add_cube(kind, Vec3d(i % kSide, i / kSide % kSide, i / (kSide * kSide)));
  const vtkIdType nodes = mesh.points->GetNumberOfPoints(), cells = mesh.grid->GetNumberOfCells();
  const auto data = mesh.open(scratch, kind.lagrange());
  ASSERT_EQ(data->grid.cell_count(), cells * kind.pieces);
  ASSERT_EQ(data->notes.size(), 1u);
  EXPECT_NE(data->notes[0].find(" divided into " + std::to_string(cells * kind.pieces) + " linear cells between their nodes"), std::string::npos)
      << data->notes[0];
  for (std::int64_t p = 0; p < data->grid.point_count(); ++p) {
    const Vec3d at = data->grid.point(p);
    if (p < nodes) {
      double x[3];
      mesh.points->GetPoint(p, x);
      ASSERT_EQ(at, (Vec3d{x[0], x[1], x[2]})) << "nodes stay where they are";
    }
    ASSERT_NEAR(data->array("f").at(static_cast<std::size_t>(p)), linear(at), 1e-12) << "point " << p;
  }
  // Nodes of a face that no cell has are made once for the two cells that meet there.
  std::map<std::array<long, 3>, int> places;
  for (std::int64_t p = 0; p < data->grid.point_count(); ++p) {
    const Vec3d at = data->grid.point(p);
    EXPECT_EQ(++places[(std::array{std::lround(at.x * 1e7), std::lround(at.y * 1e7), std::lround(at.z * 1e7)})], 1);
  }
  expect_filled_block(*data);
}

TEST(ImportCurvedCells, OfAllShapesMeetFaceToFace) {
  const Scratch scratch;
  Mesh mesh;
  const auto kind = [](const std::string& name) { return *std::ranges::find(kinds(), name, &Curved::name); };
  // Columns, so that the diagonals of triangles meet triangles: hexahedra beside pyramids, wedges by themselves above each other.
  for (int k = 0; k < kSide; ++k) {
    mesh.add_cube(kind("quadratic_hexahedra"), Vec3d(0, 0, k));
    mesh.add_cube(kind("quadratic_pyramids"), Vec3d(1, 0, k));
    mesh.add_cube(kind("quadratic_wedges"), Vec3d(0, 1, k));
    mesh.add_cube(kind("quadratic_pyramids"), Vec3d(1, 1, k));
  }
  expect_filled_block(*mesh.open(scratch, false));
}

TEST(ImportCurvedCells, HaveTheValuesOfTheirShapeFunctionsWhereANodeIsMissing) {
  for (const int type : {VTK_QUADRATIC_HEXAHEDRON, VTK_QUADRATIC_WEDGE}) {
    const Scratch scratch;
    const auto cell = vtkSmartPointer<vtkCell>::Take(vtkGenericCell::InstantiateCell(type));
    const double* at = cell->GetParametricCoords();
    vtkNew<vtkUnstructuredGrid> grid;
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    vtkNew<vtkDoubleArray> f;
    f->SetName("f");
    std::vector<vtkIdType> ids;
    for (int p = 0; p < cell->GetNumberOfPoints(); ++p) {
      ids.push_back(points->InsertNextPoint(at + 3 * p));
      f->InsertNextValue((37 * p + 11) % 23);
    }
    grid->SetPoints(points);
    grid->InsertNextCell(type, static_cast<vtkIdType>(ids.size()), ids.data());
    grid->GetPointData()->AddArray(f);
    const auto data = written_and_read(scratch, grid);
    EXPECT_EQ(data->grid.point_count(), type == VTK_QUADRATIC_HEXAHEDRON ? 27 : 18);
    std::vector<double> shape(ids.size());
    for (std::int64_t p = 0; p < data->grid.point_count(); ++p) {
      const Vec3d place = data->grid.point(p);
      const double u[3] = {place.x, place.y, place.z};
      grid->GetCell(0)->InterpolateFunctions(u, shape.data());
      double expected = 0;
      for (std::size_t i = 0; i < shape.size(); ++i) expected += shape[i] * f->GetValue(static_cast<vtkIdType>(i));
      EXPECT_NEAR(data->array("f").at(static_cast<std::size_t>(p)), expected, 1e-12) << "type " << type << ", point " << p;
    }
  }
}

TEST(ImportCurvedCells, WithAnAreaAreDividedToo) {
  for (const auto& [type, nodes, pieces, kind] : std::vector<std::tuple<int, vtkIdType, std::int64_t, CellType>>{
           {VTK_QUADRATIC_TRIANGLE, 6, 4, CellType::triangle},
           {VTK_BIQUADRATIC_TRIANGLE, 7, 4, CellType::triangle},
           {VTK_LAGRANGE_TRIANGLE, 10, 9, CellType::triangle},
           {VTK_QUADRATIC_QUAD, 8, 4, CellType::quadrilateral},
           {VTK_BIQUADRATIC_QUAD, 9, 4, CellType::quadrilateral},
           {VTK_QUADRATIC_LINEAR_QUAD, 6, 2, CellType::quadrilateral},
           {VTK_LAGRANGE_QUADRILATERAL, 16, 9, CellType::quadrilateral}}) {
    SCOPED_TRACE(type);
    const Scratch scratch;
    const auto cell = vtkSmartPointer<vtkCell>::Take(vtkGenericCell::InstantiateCell(type));
    cell->PointIds->SetNumberOfIds(nodes);
    cell->Points->SetNumberOfPoints(nodes);
    cell->Initialize();
    if (auto* lagrange = vtkHigherOrderQuadrilateral::SafeDownCast(cell)) lagrange->SetOrder(3, 3);
    const double* at = cell->GetParametricCoords();
    vtkNew<vtkUnstructuredGrid> grid;
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    std::vector<vtkIdType> ids;
    for (vtkIdType p = 0; p < nodes; ++p) ids.push_back(points->InsertNextPoint(at + 3 * p));
    grid->SetPoints(points);
    grid->InsertNextCell(type, nodes, ids.data());
    const auto data = written_and_read(scratch, grid);
    ASSERT_EQ(data->grid.cell_count(), pieces);
    double area = 0;
    std::array<std::int64_t, kMaxCellVertices> corner{};
    for (std::int64_t c = 0; c < pieces; ++c) {
      EXPECT_EQ(data->grid.cell_type(c), kind);
      const int n = data->grid.cell_points(c, corner);
      for (int v = 1; v + 1 < n; ++v) {
        const auto point = [&](int i) { return data->grid.point(corner[static_cast<std::size_t>(i)]); };
        area += 0.5 * cross(point(v) - point(0), point(v + 1) - point(0)).z;
      }
    }
    EXPECT_NEAR(area, kind == CellType::triangle ? 0.5 : 1, 1e-12) << "with the sign of the whole cell";
  }
}

TEST(ImportCurvedCells, OfAWrongNumberOfNodesAreRefused) {
  for (const auto& [type, nodes, expected] : std::vector<std::tuple<int, int, std::string>>{
           {VTK_QUADRATIC_TETRA, 9, "cell 0, vtkQuadraticTetra, has 9 nodes; expected 10"},
           {VTK_LAGRANGE_HEXAHEDRON, 9, "cell 0, vtkLagrangeHexahedron, has 9 nodes; expected those of 1 to 10 spaces along each edge"},
           {VTK_LAGRANGE_TETRAHEDRON, 11, "cell 0, vtkLagrangeTetra, has 11 nodes; expected those of 1 to 10 spaces"}}) {
    const Scratch scratch;
    std::string text = "# vtk DataFile Version 5.1\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS " + std::to_string(nodes) + " double\n";
    for (int p = 0; p < nodes; ++p) text += std::to_string(p % 2) + " " + std::to_string(p / 2 % 2) + " " + std::to_string(p / 4) + "\n";
    text += "CELLS 2 " + std::to_string(nodes) + "\nOFFSETS vtktypeint64\n0 " + std::to_string(nodes) + "\nCONNECTIVITY vtktypeint64\n";
    for (int p = 0; p < nodes; ++p) text += std::to_string(p) + " ";
    text += "\nCELL_TYPES 1\n" + std::to_string(type) + "\n";
    const Error error = test::refusal(scratch.write("x.vtk", text));
    EXPECT_EQ(error.code(), ErrorCode::bad_data);
    EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace isostrata
