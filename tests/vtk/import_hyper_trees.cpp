// Hyper tree grids of VTK's own writer: what is read are their leaves.
#include <gtest/gtest.h>
#include <vtkBitArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkHyperTreeGrid.h>
#include <vtkHyperTreeGridNonOrientedGeometryCursor.h>
#include <vtkNew.h>
#include <vtkXMLHyperTreeGridWriter.h>
#include <vtkXMLWriter.h>

#include <array>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "data/files.h"
#include "support/mutated_files.h"

namespace isostrata {
namespace {

using test::Scratch;

struct Trees {
  std::array<int, 3> points{4, 3, 4};
  unsigned int branch = 2;
  unsigned int depth = 3;
  double masked = 0;
  bool transposed = false;
};

/// How VTK writes them.
struct Form {
  int mode = vtkXMLWriter::Ascii, packed = vtkXMLWriter::NONE, version = 2;
  bool big_endian = false;
};

struct Written {
  double volume = 0;  // of the leaves that are not masked; in a plane their area
  std::int64_t leaves = 0;
};

double slope(const double p[3]) { return 1 + 2 * p[0] - 3 * p[1] + 0.5 * p[2]; }

/// Trees on uneven coordinates, refined by chance; "slope" at the middles of cells.
Written write_trees(const std::filesystem::path& file, const Trees& of, std::uint64_t seed, const Form& form) {
  std::mt19937_64 random(seed);
  vtkNew<vtkHyperTreeGrid> grid;
  grid->SetDimensions(of.points.data());
  grid->SetBranchFactor(of.branch);
  grid->SetTransposedRootIndexing(of.transposed);
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
  writer->SetDataMode(form.mode);
  writer->SetCompressorType(form.packed);
  writer->SetByteOrder(form.big_endian ? vtkXMLWriter::BigEndian : vtkXMLWriter::LittleEndian);
  if constexpr (requires { writer->SetDataSetMajorVersion(1); }) writer->SetDataSetMajorVersion(form.version);
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
  const Trees kinds[] = {{}, {.branch = 3, .depth = 2}, {.masked = 0.3}, {.points = {4, 5, 1}}, {.points = {1, 4, 3}}, {.points = {5, 1, 3}, .masked = 0.2}, {.masked = 0.1, .transposed = true}};
  for (const Trees& of : kinds)
    for (std::uint64_t seed = 1; seed < 4; ++seed) {
      SCOPED_TRACE(std::to_string(of.points[0]) + "x" + std::to_string(of.points[1]) + "x" + std::to_string(of.points[2]) + ", branch " + std::to_string(of.branch) + ", seed " + std::to_string(seed));
      const Scratch scratch;
      const Written written = write_trees(scratch / "trees.htg", of, seed, {.mode = seed % 2 == 0 ? vtkXMLWriter::Binary : vtkXMLWriter::Ascii});
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

TEST(ImportHyperTrees, AreTheSameInEveryForm) {
  const Scratch scratch;
  const Trees of{.masked = 0.2};
  write_trees(scratch / "trees.htg", of, 5, {});
  const auto first = test::open(scratch / "trees.htg");
  int forms = 0;
  for (const int mode : {vtkXMLWriter::Ascii, vtkXMLWriter::Binary, vtkXMLWriter::Appended})
    for (const int packed : {vtkXMLWriter::NONE, vtkXMLWriter::ZLIB, vtkXMLWriter::LZ4})
      for (const bool big : {false, true})
        for (const int version : {1, 2}) {
          SCOPED_TRACE("mode " + std::to_string(mode) + ", packed " + std::to_string(packed) + (big ? ", big-endian" : "") + ", version " + std::to_string(version));
          const std::string name = "form" + std::to_string(++forms) + ".htg";
          write_trees(scratch / name, of, 5, {.mode = mode, .packed = packed, .version = version, .big_endian = big});
          // VTK 9.1 writes the ranges of appended arrays over the beginning of the file if it packs them.
          if (!test::read_bytes(scratch / name).starts_with("<?xml")) continue;
          const auto data = test::open(scratch / name);
          ASSERT_EQ(data->grid.point_count(), first->grid.point_count());
          ASSERT_EQ(data->grid.cell_count(), first->grid.cell_count());
          EXPECT_EQ(data->notes, first->notes);
          for (std::int64_t p = 0; p < data->grid.point_count(); ++p) ASSERT_EQ(data->grid.point(p), first->grid.point(p));
          for (std::int64_t c = 0; c < data->grid.cell_count(); ++c) ASSERT_EQ(data->grid.hidden(c), first->grid.hidden(c));
          for (std::size_t p = 0; p < static_cast<std::size_t>(data->grid.point_count()); ++p) {
            const double value = data->arrays.front().at(p), expected = first->arrays.front().at(p);
            ASSERT_TRUE(std::isnan(expected) ? std::isnan(value) : std::abs(value - expected) < 1e-9) << value << " and " << expected;
          }
        }
  EXPECT_GE(forms, 36);
}

TEST(ImportHyperTrees, CutShortTheyEndInAnError) {
  const Scratch scratch;
  for (const int version : {1, 2}) {
    write_trees(scratch / "trees.htg", {}, 1, {.version = version});
    const std::string bytes = test::read_bytes(scratch / "trees.htg");
    for (std::size_t length = 0; length + 30 < bytes.size(); length += 1 + bytes.size() / 23) {
      scratch.write("trees.htg", bytes.substr(0, length));
      EXPECT_NE(test::refusal(scratch / "trees.htg").code(), ErrorCode::internal) << length << " bytes";
    }
  }
}

/// No damage makes the reader crash: it believes no number before it was checked.
TEST(ImportHyperTrees, DamagedTheyEndInADatasetOrAnError) {
  const Scratch scratch;
  std::vector<std::pair<std::string, std::string>> files;
  for (const int version : {1, 2})
    for (const int mode : {vtkXMLWriter::Ascii, vtkXMLWriter::Binary}) {
      write_trees(scratch / "trees.htg", {.points = {3, 3, 2}, .depth = 2, .masked = 0.1}, 1, {.mode = mode, .packed = mode == vtkXMLWriter::Ascii ? vtkXMLWriter::NONE : vtkXMLWriter::ZLIB, .version = version});
      files.emplace_back("trees.htg", test::read_bytes(scratch / "trees.htg"));
    }
  EXPECT_EQ(testing::expect_datasets_or_errors(files, 80), 0);
}

}  // namespace
}  // namespace isostrata
