// Cells that are not tetrahedra, pyramids, wedges or hexahedra, and cells that are not there: what the importer makes of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "data/files.h"
#include "support/truncated_cubes.h"
#include "support/vtk_text.h"

namespace isostrata {
namespace {

using test::Scratch;
using testing::VtuText;

double linear(const Vec3d& p) { return 1 + 2 * p.x - 3 * p.y + 0.5 * p.z; }

/// Each cell's volume taken positive, those that are not hidden.
double visible_volume(const Dataset& data) {
  double sum = 0;
  for (std::int64_t cell = 0; cell < data.grid.cell_count(); ++cell)
    if (!data.grid.hidden(cell)) sum += std::abs(test::cell_volume(data.grid, cell));
  return sum;
}

std::int64_t hidden_cells(const Dataset& data) {
  return std::count_if(data.grid.hidden_cells.begin(), data.grid.hidden_cells.end(), [](std::uint8_t hidden) { return hidden != 0; });
}

bool says(const Dataset& data, const std::string& part) {
  return std::any_of(data.notes.begin(), data.notes.end(),
                     [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

VtuText vtu_of(const test::PolyhedralMesh& mesh) {
  VtuText vtu;
  vtu.points = mesh.points;
  for (const auto& cell : mesh.cells) vtu.add_polyhedron(cell);
  std::vector<double> values;
  for (const Vec3d& p : mesh.points) values.push_back(linear(p));
  vtu.point_array("f", "Float64", values);
  return vtu;
}

TEST(ImportCells, PolyhedraFillTheirSpaceAndCarryEveryArray) {
  const Scratch scratch;
  const auto mesh = test::truncated_cubes({3, 3, 3}, 21);
  VtuText vtu = vtu_of(mesh);
  std::vector<int> bytes;
  std::vector<double> cell_numbers;
  for (std::size_t p = 0; p < mesh.points.size(); ++p) bytes.push_back(p % 2 ? 255 : 0);
  for (std::size_t c = 0; c < mesh.cells.size(); ++c) cell_numbers.push_back(7);
  vtu.point_array("byte", "UInt8", bytes);
  vtu.cell_array("seven", "Float64", cell_numbers);
  const auto data = test::open(scratch.write("p.vtu", vtu.text()));
  EXPECT_NEAR(visible_volume(*data), mesh.volume, 1e-12 * mesh.volume);
  EXPECT_GT(data->grid.point_count(), static_cast<std::int64_t>(mesh.points.size()));
  for (std::int64_t p = 0; p < data->grid.point_count(); ++p) {
    if (p < static_cast<std::int64_t>(mesh.points.size())) {
      ASSERT_EQ(data->grid.point(p), mesh.points[static_cast<std::size_t>(p)]) << "the file's points keep their numbers";
    }
    ASSERT_NEAR(data->array("f").at(static_cast<std::size_t>(p)), linear(data->grid.point(p)), 1e-12) << p;
    ASSERT_NEAR(data->array("seven").at(static_cast<std::size_t>(p)), 7, 1e-14);
    const double byte = data->array("byte").at(static_cast<std::size_t>(p));
    ASSERT_TRUE(byte >= 0 && byte <= 255 && byte == std::round(byte)) << byte;
  }
  EXPECT_TRUE(says(*data, "vtkPolyhedron split into"));
}

TEST(ImportCells, CellArraysAreAveragedOverTheCellsOfTheFileNotOverPieces) {
  // A hexagonal prism (14 pieces) on a hexahedron: their common points have the mean of two cells.
  const Scratch scratch;
  VtuText vtu;
  const double h = std::sqrt(0.75);
  for (const double z : {0.0, 1.0})
    for (const auto& [x, y] : std::vector<std::pair<double, double>>{{1, 0}, {0.5, h}, {-0.5, h}, {-1, 0}, {-0.5, -h}, {0.5, -h}})
      vtu.points.push_back({x, y, z});
  for (const double z : {0.0, 1.0})
    for (const double x : {-0.5, 0.5}) vtu.points.push_back({x, 2, z});
  vtu.add(16, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
  vtu.add(12, {1, 13, 12, 2, 7, 15, 14, 8});
  vtu.cell_array("c", "Float64", std::vector<double>{10, 20});
  const auto data = test::open(scratch.write("p.vtu", vtu.text()));
  for (const std::size_t p : {1u, 2u, 7u, 8u}) EXPECT_NEAR(data->array("c").at(p), 15, 1e-12) << p;
  EXPECT_NEAR(data->array("c").at(0), 10, 1e-12);
  EXPECT_NEAR(data->array("c").at(16), 10, 1e-12) << "the added point";
  EXPECT_NEAR(visible_volume(*data), 6 * h / 2 + (2 - h), 1e-12);
}

// More arrays than are averaged together, of several kinds and sizes, beside the mean as it is defined.
TEST(ImportCells, EachOfManyCellArraysHasTheMeanOfTheCellsAtAPoint) {
  const Scratch scratch;
  constexpr int n = 4, cells = n * n * n;
  const auto value = [](int array, int component, int cell) { return std::sin(1.0 + array + 0.5 * component) * cell + array; };
  const auto arrays = [&](const std::string& attributes) {
    std::string text = attributes;
    for (int a = 0; a < 20; ++a) {
      const char* const type = a % 3 == 0 ? "float" : a % 3 == 1 ? "double" : "int";
      const int components = a % 5 == 4 ? 3 : 1;
      text += (components == 3 ? "VECTORS a" : "SCALARS a") + std::to_string(a) + " " + type + (components == 3 ? "\n" : " 1\nLOOKUP_TABLE default\n");
      for (int c = 0; c < cells; ++c)
        for (int k = 0; k < components; ++k) text += (a % 3 == 2 ? std::to_string(std::lround(value(a, k, c))) : std::to_string(value(a, k, c))) + (k + 1 < components ? " " : "\n");
    }
    return text;
  };
  const std::string attributes = "CELL_DATA " + std::to_string(cells) + "\n";
  std::string points, hexahedra, types;
  const auto point = [](int i, int j, int k) { return i + (n + 1) * (j + (n + 1) * k); };
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) points += std::to_string(i) + " " + std::to_string(j) + " " + std::to_string(k) + "\n";
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        hexahedra += "8";
        for (const int at : {point(i, j, k), point(i + 1, j, k), point(i + 1, j + 1, k), point(i, j + 1, k), point(i, j, k + 1), point(i + 1, j, k + 1), point(i + 1, j + 1, k + 1), point(i, j + 1, k + 1)})
          hexahedra += " " + std::to_string(at);
        hexahedra += "\n";
        types += "12\n";
      }
  const std::string head = "# vtk DataFile Version 3.0\nmany\nASCII\n", count = std::to_string((n + 1) * (n + 1) * (n + 1));
  const std::string grid = head + "DATASET STRUCTURED_POINTS\nDIMENSIONS 5 5 5\nORIGIN 0 0 0\nSPACING 1 1 1\n" + arrays(attributes);
  const std::string mesh = head + "DATASET UNSTRUCTURED_GRID\nPOINTS " + count + " float\n" + points + "CELLS " + std::to_string(cells) + " " + std::to_string(9 * cells) + "\n" + hexahedra +
                           "CELL_TYPES " + std::to_string(cells) + "\n" + types + arrays(attributes);
  const auto boxes = test::open(scratch.write("boxes.vtk", grid)), cells_of_mesh = test::open(scratch.write("mesh.vtk", mesh));
  for (const PointArray& array : boxes->arrays)
    for (std::size_t p = 0; p < static_cast<std::size_t>(boxes->grid.point_count()); ++p)
      ASSERT_EQ(array.at(p), cells_of_mesh->array(array.name).at(p)) << "to the last bit, whichever way they were added: " << array.name << " at " << p;
  for (const auto& data : {boxes, cells_of_mesh}) {
    for (int a = 0; a < 20; ++a)
      for (int component = 0; component < (a % 5 == 4 ? 3 : 1); ++component) {
        const auto& array = data->array("a" + std::to_string(a) + (a % 5 == 4 ? std::string("_") + "xyz"[component] : ""));
        EXPECT_EQ(array.type, a % 3 == 0 ? ScalarType::float32 : ScalarType::float64);
        for (int k = 0; k <= n; ++k)
          for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i) {
              double sum = 0, used = 0;
              for (int at = 0; at < cells; ++at)
                if (const int ci = at % n, cj = at / n % n, ck = at / n / n; (ci == i || ci == i - 1) && (cj == j || cj == j - 1) && (ck == k || ck == k - 1)) {
                  const double exact = value(a, component, at);
                  sum += a % 3 == 2 ? std::round(exact) : exact;
                  ++used;
                }
              const double mean = array.at(static_cast<std::size_t>(point(i, j, k)));
              ASSERT_NEAR(mean, sum / used, 2e-5) << a << "_" << component << " at " << i << " " << j << " " << k;
            }
      }
  }
}

TEST(ImportCells, PrismsAreSplitAboutTheirMiddle) {
  const Scratch scratch;
  for (const std::size_t n : {5u, 6u}) {
    VtuText vtu;
    double area = 0;
    for (const double z : {0.0, 2.0})
      for (std::size_t i = 0; i < n; ++i) {
        const double angle = 2 * std::acos(-1.0) * static_cast<double>(i) / static_cast<double>(n);
        vtu.points.push_back({std::cos(angle), std::sin(angle), z});
      }
    area = static_cast<double>(n) / 2 * std::sin(2 * std::acos(-1.0) / static_cast<double>(n));
    std::vector<std::int64_t> ids(2 * n);
    for (std::size_t v = 0; v < 2 * n; ++v) ids[v] = static_cast<std::int64_t>(v);
    vtu.add(n == 5 ? 15 : 16, ids);
    const auto data = test::open(scratch.write("p.vtu", vtu.text()));
    EXPECT_NEAR(visible_volume(*data), 2 * area, 1e-12);
    EXPECT_EQ(data->cell_types.at("pyramid"), static_cast<std::int64_t>(n));
    EXPECT_NEAR(length(data->grid.point(static_cast<std::int64_t>(2 * n)) - Vec3d{0, 0, 1}), 0, 1e-12);
    EXPECT_EQ(data->cell_types.at("tetrahedron"), static_cast<std::int64_t>(2 * (n - 2)));
  }
}

TEST(ImportCells, ConvexPointSetsBecomeTheirHull) {
  const Scratch scratch;
  VtuText vtu;
  for (int p = 0; p < 12; ++p) vtu.points.push_back({double(p % 2), double(p / 2 % 2), double(p / 4)});
  vtu.points.push_back({0.5, 0.5, 3});
  vtu.add(41, {3, 0, 6, 1, 4, 7, 2, 5});        // a cube in no order
  vtu.add(41, {4, 5, 6, 7, 8, 9, 10, 11, 12});  // a cube with a roof on it
  vtu.add(41, {0, 1, 2, 3});                    // flat
  const auto data = test::open(scratch.write("c.vtu", vtu.text()));
  EXPECT_NEAR(visible_volume(*data), 1 + 4.0 / 3, 1e-12);
  EXPECT_EQ(data->cell_types, (std::map<std::string, std::int64_t>{{"hexahedron", 1}, {"pyramid", 5}, {"tetrahedron", 4}}));
}

TEST(ImportCells, ConvexPointSetsMayHaveManyPoints) {
  const Scratch scratch;
  VtuText vtu;
  std::vector<std::int64_t> ids;
  for (int p = 0; p < 125; ++p) {
    vtu.points.push_back({(p % 5) * 0.25, (p / 5 % 5) * 0.25, (p / 25) * 0.25});
    ids.push_back(p);
  }
  vtu.add(41, ids);
  const auto data = test::open(scratch.write("many.vtu", vtu.text()));
  EXPECT_NEAR(visible_volume(*data), 1, 1e-12);
}

TEST(ImportCells, LegacyFilesHaveTheirPolyhedraReadToo) {
  const Scratch scratch;
  // A cube with a roof: five quadrilaterals and four triangles.
  const auto data =
      test::open(scratch.write("p.vtk",
                               "# vtk DataFile Version 3.0\nmade by a test\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 9 double\n0 "
                               "0 0 1 0 0 1 1 0 0 1 0 0 0 1 "
                               "1 0 1 1 1 1 0 1 1 0.5 0.5 2\nCELLS 1 43\n42 9 4 0 3 2 1 4 0 1 5 4 4 1 2 6 5 4 2 3 7 6 4 3 0 4 7 "
                               "3 4 5 8 3 5 6 8 3 6 7 8 3 7 4 8\n"
                               "CELL_TYPES 1\n42\nPOINT_DATA 9\nSCALARS f double 1\nLOOKUP_TABLE default\n0 0 0 0 1 1 1 1 2\n"));
  EXPECT_EQ(data->cell_types, (std::map<std::string, std::int64_t>{{"pyramid", 5}, {"tetrahedron", 4}}));
  EXPECT_NEAR(visible_volume(*data), 4.0 / 3, 1e-12);
  EXPECT_NEAR(data->array("f").at(9), 6.0 / 9, 1e-12);
}

TEST(ImportCells, OpenAndDamagedPolyhedraEndInANoteOrAnError) {
  const Scratch scratch;
  const std::vector<std::vector<std::int64_t>> cube{{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                                    {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  const auto with = [&](const auto& change) {
    VtuText vtu;
    for (int p = 0; p < 8; ++p) vtu.points.push_back({double(p & 1), double(p >> 1 & 1), double(p >> 2)});
    vtu.add_polyhedron(cube);
    change(vtu);
    return scratch.write("p.vtu", vtu.text());
  };
  EXPECT_EQ(test::open(with([](VtuText&) {}))->cell_types, (std::map<std::string, std::int64_t>{{"hexahedron", 1}}));
  const auto open_one = test::open(with([](VtuText& v) {
    v.faces = {5, 4, 0, 4, 6, 2, 4, 1, 3, 7, 5, 4, 0, 1, 5, 4, 4, 2, 6, 7, 3, 4, 0, 2, 3, 1};
    v.face_offsets = {26};
  }));
  EXPECT_EQ(open_one->grid.cell_count(), 0);
  EXPECT_TRUE(says(*open_one, "do not close up"));
  const auto refused = [&](const char* what, const auto& change) {
    const Error error = test::refusal(with(change));
    EXPECT_EQ(error.code(), ErrorCode::bad_data) << what << ": " << error.what();
  };
  refused("a point that is not there", [](VtuText& v) { v.faces[4] = 8; });
  refused("a negative point", [](VtuText& v) { v.faces[4] = -1; });
  refused("a face longer than the stream", [](VtuText& v) { v.faces[26] = 40; });
  refused("too many faces", [](VtuText& v) { v.faces[0] = 7; });
}

TEST(ImportCells, LowerDimensionalCellsAreSkippedAndSaid) {
  const Scratch scratch;
  VtuText vtu;
  vtu.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  vtu.add(1, {0});
  vtu.add(3, {0, 1});
  vtu.add(5, {0, 1, 2});
  vtu.add(10, {0, 1, 2, 3});
  vtu.add(9, {0, 1, 2, 3});
  vtu.cell_array("c", "Int32", std::vector<int>{1, 2, 3, 4, 5});
  const auto data = test::open(scratch.write("p.vtu", vtu.text()));
  EXPECT_EQ(data->cell_types, (std::map<std::string, std::int64_t>{{"tetrahedron", 1}}));
  for (std::size_t p = 0; p < 4; ++p)
    EXPECT_EQ(data->array("c").at(p), 4) << "the tetrahedron's value, not its neighbours' in the list";
  for (const char* part : {"1 vtkVertex skipped", "1 vtkLine skipped", "1 vtkTriangle skipped", "1 vtkQuad skipped"})
    EXPECT_TRUE(says(*data, part)) << part;
}

TEST(ImportCells, DuplicatedPointsStayTwo) {
  const Scratch scratch;
  VtuText vtu;
  vtu.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
  vtu.add(10, {0, 1, 2, 3});
  vtu.add(10, {4, 6, 5, 7});
  vtu.point_array("f", "Float32", std::vector<double>{1, 1, 1, 1, 2, 2, 2, 2});
  const auto data = test::open(scratch.write("p.vtu", vtu.text()));
  EXPECT_EQ(data->grid.point_count(), 8);
  EXPECT_EQ(data->array("f").at(4), 2);
}

/// Five cubes in a row.
VtuText row_of_cubes() {
  VtuText vtu;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 6; ++i) vtu.points.push_back({double(i), double(j), double(k)});
  for (int c = 0; c < 5; ++c) vtu.add(12, {c, c + 1, c + 7, c + 6, c + 12, c + 13, c + 19, c + 18});
  return vtu;
}

TEST(GhostCells, DuplicatedRefinedAndHiddenCellsAreLeftOut) {
  const Scratch scratch;
  // 1 duplicate, 2 and 4 connectivity, 8 refined, 16 exterior, 32 hidden: VTK's vtkDataSetAttributes.
  for (const auto& [bit, hides] : std::map<int, bool>{{1, true}, {2, false}, {4, false}, {8, true}, {16, false}, {32, true}}) {
    const std::vector<int> marks{0, bit, 0, 0, bit};
    const std::string array = testing::data_array("vtkGhostType", "UInt8", marks);
    VtuText vtu = row_of_cubes();
    vtu.cell_arrays = array;
    for (const auto& file :
         {scratch.write("g.vtu", vtu.text()), scratch.write("g.vti", testing::vti_text({0, 0, 0}, {6, 2, 2}, "", array)),
          scratch.write("g.vts", testing::vts_text({6, 2, 2}, "", array))}) {
      const auto data = test::open(file);
      EXPECT_EQ(hidden_cells(*data), hides ? 2 : 0) << file << ", bit " << bit;
      EXPECT_NEAR(visible_volume(*data), hides ? 3 : 5, 1e-12) << file << ", bit " << bit;
      if (hides) {
        EXPECT_TRUE(data->grid.hidden(1) && data->grid.hidden(4)) << file;
      }
    }
  }
}

TEST(GhostCells, HiddenPointsHideTheirCellsAndDuplicatedPointsDoNot) {
  const Scratch scratch;
  std::vector<int> marks(24);
  marks[0] = 1;   // duplicate: of cell 0
  marks[14] = 2;  // hidden: of cells 1 and 2
  const std::string array = testing::data_array("vtkGhostType", "UInt8", marks);
  VtuText vtu = row_of_cubes();
  vtu.point_arrays = array;
  for (const auto& file :
       {scratch.write("g.vtu", vtu.text()), scratch.write("g.vti", testing::vti_text({0, 0, 0}, {6, 2, 2}, array)),
        scratch.write("g.vts", testing::vts_text({6, 2, 2}, array))}) {
    const auto data = test::open(file);
    EXPECT_EQ(hidden_cells(*data), 2) << file;
    EXPECT_TRUE(data->grid.hidden(1) && data->grid.hidden(2)) << file;
    EXPECT_NEAR(visible_volume(*data), 3, 1e-12) << file;
  }
}

TEST(GhostCells, HideEveryPieceOfASplitCell) {
  const Scratch scratch;
  const auto mesh = test::truncated_cubes({3, 3, 3}, 22);
  VtuText vtu = vtu_of(mesh);
  std::vector<int> marks(mesh.cells.size());
  marks[13] = 32;  // the cube in the middle, whose corners are cut
  vtu.cell_array("vtkGhostType", "UInt8", marks);
  const auto whole = test::open(scratch.write("w.vtu", vtu_of(mesh).text())),
             some = test::open(scratch.write("s.vtu", vtu.text()));
  double expected = 0;
  for (std::int64_t c = 0; c < some->grid.cell_count(); ++c)
    if (some->grid.hidden(c)) expected += std::abs(test::cell_volume(some->grid, c));
  EXPECT_GT(hidden_cells(*some), 10);
  EXPECT_GT(expected, 0.5);
  EXPECT_LT(expected, 1 + 1e-12);
  EXPECT_NEAR(visible_volume(*some), visible_volume(*whole) - expected, 1e-12);
}

TEST(GhostCells, AreReadWhateverIntegersTheyAreWrittenIn) {
  const Scratch scratch;
  const auto marked = [&](const char* type) {
    VtuText vtu = row_of_cubes();
    vtu.cell_array("vtkGhostType", type, std::vector<int>{32, 0, 0, 0, 0});
    return hidden_cells(*test::open(scratch.write("g.vtu", vtu.text())));
  };
  for (const char* type : {"UInt8", "Int32", "Int64"}) EXPECT_EQ(marked(type), 1) << type;
}

TEST(GhostCells, OfParallelUnstructuredPiecesAreCountedOnce) {
  // Cells 0..2 and 2..4 of the row: the first piece has cell 2 as a ghost.
  const Scratch scratch;
  const VtuText row = row_of_cubes();
  const auto piece = [&](int first, int count, std::vector<int> marks) {
    VtuText vtu;
    vtu.points = row.points;
    for (int c = first; c < first + count; ++c)
      vtu.add(12, {row.connectivity.begin() + 8 * c, row.connectivity.begin() + 8 * c + 8});
    vtu.cell_array("vtkGhostType", "UInt8", marks);
    return vtu.text();
  };
  scratch.write("p0.vtu", piece(0, 3, {0, 0, 1}));
  scratch.write("p1.vtu", piece(2, 3, {0, 0, 0}));
  const auto data = test::open(scratch.write(
      "p.pvtu",
      testing::vtk_file(
          "PUnstructuredGrid",
          "<PUnstructuredGrid GhostLevel=\"1\"><PCellData><PDataArray type=\"UInt8\" Name=\"vtkGhostType\"/></PCellData>"
          "<PPoints><PDataArray type=\"Float64\" NumberOfComponents=\"3\"/></PPoints><Piece Source=\"p0.vtu\"/>"
          "<Piece Source=\"p1.vtu\"/></PUnstructuredGrid>\n")));
  EXPECT_NEAR(visible_volume(*data), 5, 1e-12);
  EXPECT_EQ(data->grid.cell_count(), 5);
}

TEST(GhostCells, OfOverlappingStructuredPiecesDoNotTearAHole) {
  const Scratch scratch;
  const auto array = [](std::vector<int> marks) { return testing::data_array("vtkGhostType", "UInt8", marks); };
  // Cells 0..2 and 2..4; each marks what the other owns.
  scratch.write("p0.vti", testing::vti_text({0, 0, 0}, {4, 2, 2}, "", array({0, 0, 1})));
  scratch.write("p1.vti", testing::vti_text({1, 0, 0}, {5, 2, 2}, "", array({1, 0, 0, 0})));
  const auto data = test::open(scratch.write(
      "p.pvti",
      testing::vtk_file(
          "PImageData",
          "<PImageData WholeExtent=\"0 5 0 1 0 1\" GhostLevel=\"1\" Origin=\"0 0 0\" Spacing=\"1 1 1\"><PCellData>"
          "<PDataArray type=\"UInt8\" Name=\"vtkGhostType\"/></PCellData><Piece Extent=\"0 3 0 1 0 1\" Source=\"p0.vti\"/>"
          "<Piece Extent=\"1 5 0 1 0 1\" Source=\"p1.vti\"/></PImageData>\n")));
  EXPECT_EQ(data->grid.cell_count(), 5);
  EXPECT_NEAR(visible_volume(*data), 5, 1e-12);
}

}  // namespace
}  // namespace isostrata
