// Hyper tree grids of VTK's own writer: what is read are their leaves.
#include <gtest/gtest.h>
#include <vtkBitArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkHyperTreeGrid.h>
#include <vtkHyperTreeGridNonOrientedGeometryCursor.h>
#include <vtkNew.h>
#include <vtkXMLHyperTreeGridWriter.h>

#include <array>
#include <cmath>
#include <random>
#include <string>

#include "data/files.h"

namespace isostrata {
namespace {

using test::Scratch;

struct Trees {
  std::array<int, 3> points{4, 3, 4};
  unsigned int branch = 2;
  unsigned int depth = 3;
  double masked = 0;
};

struct Written {
  double volume = 0;  // of the leaves that are not masked; in a plane their area
  std::int64_t leaves = 0;
};

double slope(const double p[3]) { return 1 + 2 * p[0] - 3 * p[1] + 0.5 * p[2]; }

/// Trees on uneven coordinates, refined by chance; "slope" at the middles of cells.
Written write_trees(const std::filesystem::path& file, const Trees& of, std::uint64_t seed, bool binary) {
  std::mt19937_64 random(seed);
  vtkNew<vtkHyperTreeGrid> grid;
  grid->SetDimensions(of.points.data());
  grid->SetBranchFactor(of.branch);
  for (int axis = 0; axis < 3; ++axis) {
    vtkNew<vtkDoubleArray> places;
    for (int i = 0; i < of.points[static_cast<std::size_t>(axis)]; ++i) places->InsertNextValue(axis + i + 0.25 * i * i);
    axis == 0 ? grid->SetXCoordinates(places) : axis == 1 ? grid->SetYCoordinates(places) : grid->SetZCoordinates(places);
  }
  vtkNew<vtkDoubleArray> values;
  values->SetName("slope");
  vtkNew<vtkBitArray> mask;
  Written out;
  vtkIdType before = 0, nodes = 0;
  vtkNew<vtkHyperTreeGridNonOrientedGeometryCursor> cursor;
  const auto visit = [&](const auto& self, unsigned int level) -> void {
    const vtkIdType node = cursor->GetGlobalNodeIndex();
    ++nodes;
    double middle[3], size[3];
    cursor->GetPoint(middle);
    std::copy_n(cursor->GetSize(), 3, size);
    const bool leaf = level == of.depth || random() % 3 != 0, masked = leaf && std::uniform_real_distribution<>()(random) < of.masked;
    values->InsertValue(node, slope(middle));
    mask->InsertValue(node, masked);
    if (leaf) {
      ++out.leaves;
      double volume = 1;
      for (int axis = 0; axis < 3; ++axis) volume *= of.points[static_cast<std::size_t>(axis)] > 1 ? size[axis] : 1;
      if (!masked) out.volume += volume;
      return;
    }
    cursor->SubdivideLeaf();
    for (unsigned char child = 0; child < cursor->GetNumberOfChildren(); ++child) {
      cursor->ToChild(child);
      self(self, level + 1);
      cursor->ToParent();
    }
  };
  for (vtkIdType tree = 0; tree < grid->GetMaxNumberOfTrees(); ++tree) {
    grid->InitializeNonOrientedGeometryCursor(cursor, tree, true);
    cursor->SetGlobalIndexStart(before);
    visit(visit, 0);
    before = nodes;
  }
  grid->GetCellData()->AddArray(values);
  if (of.masked > 0) grid->SetMask(mask);
  vtkNew<vtkXMLHyperTreeGridWriter> writer;
  writer->SetInputData(grid);
  writer->SetFileName(file.c_str());
  if (binary)
    writer->SetDataModeToBinary();  // 9.1 writes the ranges of appended arrays over the beginning of the file
  else
    writer->SetDataModeToAscii();
  EXPECT_TRUE(writer->Write());
  return out;
}

double measure(const Grid& grid) {
  double sum = 0;
  std::array<std::int64_t, kMaxCellVertices> ids{};
  for (std::int64_t cell = 0; cell < grid.cell_count(); ++cell) {
    if (grid.hidden(cell)) continue;
    const int n = grid.cell_points(cell, ids);
    if (!grid.flat()) sum += test::cell_volume(grid, cell);
    for (int i = 1; grid.flat() && i + 1 < n; ++i)
      sum += length(cross(grid.point(ids[static_cast<std::size_t>(i)]) - grid.point(ids[0]), grid.point(ids[static_cast<std::size_t>(i) + 1]) - grid.point(ids[0]))) / 2;
  }
  return sum;
}

TEST(ImportHyperTrees, TheirLeavesHaveTheirVolumeAndValues) {
  const Trees kinds[] = {{}, {.branch = 3, .depth = 2}, {.masked = 0.3}, {.points = {4, 5, 1}}, {.points = {1, 4, 3}}, {.points = {5, 1, 3}, .masked = 0.2}};
  for (const Trees& of : kinds)
    for (std::uint64_t seed = 1; seed < 4; ++seed) {
      SCOPED_TRACE(std::to_string(of.points[0]) + "x" + std::to_string(of.points[1]) + "x" + std::to_string(of.points[2]) + ", branch " + std::to_string(of.branch) + ", seed " + std::to_string(seed));
      const Scratch scratch;
      const Written written = write_trees(scratch / "trees.htg", of, seed, seed % 2 == 0);
      const auto data = test::open(scratch / "trees.htg");
      EXPECT_NEAR(measure(data->grid), written.volume, 1e-9 * written.volume);
      EXPECT_EQ(data->grid.flat(), of.points[0] == 1 || of.points[1] == 1 || of.points[2] == 1);
      ASSERT_EQ(data->arrays.size(), 1u);
      const PointArray& array = data->arrays.front();
      std::array<std::int64_t, kMaxCellVertices> ids{};
      std::int64_t whole = 0;
      for (std::int64_t cell = 0; cell < data->grid.cell_count(); ++cell) {
        const CellType type = data->grid.cell_type(cell);
        if (data->grid.hidden(cell) || (type != CellType::hexahedron && type != CellType::quadrilateral)) continue;
        data->grid.cell_points(cell, ids);
        const Vec3d middle = (data->grid.point(ids[0]) + data->grid.point(ids[type == CellType::hexahedron ? 6 : 2])) * 0.5;
        const double at[3] = {middle.x, middle.y, middle.z};
        ASSERT_NEAR(std::visit([&](auto v) { return static_cast<double>(v[static_cast<std::size_t>(cell)]); }, array.cells->values), slope(at), 1e-9);
        ++whole;
      }
      EXPECT_GT(whole, 0);
      EXPECT_LE(whole, written.leaves);
    }
}

TEST(ImportHyperTrees, CutShortTheyEndInAnError) {
  const Scratch scratch;
  write_trees(scratch / "trees.htg", {}, 1, false);
  const std::string bytes = test::read_bytes(scratch / "trees.htg");
  for (std::size_t length = 0; length + 30 < bytes.size(); length += 1 + bytes.size() / 23) {
    scratch.write("trees.htg", bytes.substr(0, length));
    EXPECT_NE(test::refusal(scratch / "trees.htg").code(), ErrorCode::internal) << length << " bytes";
  }
}

}  // namespace
}  // namespace isostrata
