// What write_mesh wrote, read by VTK's readers: an independent view of the formats.
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkHDFReader.h>
#include <vtkNew.h>
#include <vtkPLYReader.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <map>

#include "data/dataset/analytic.h"
#include "extraction/files/write_mesh.h"
#include "extraction/small_grids.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

IntervalMesh torus(bool strict = false) {
  const Task task;
  const auto dataset = make_analytic("torus:24", {}, task);
  ExtractOptions options;
  options.facets = true;
  options.strict = strict;
  return extract_intervals(dataset->grid, dataset->arrays[0], std::vector<Interval>{{0.1, 0.3}, {0.3, 0.6}}, options, task);
}

Vec3d point(vtkDataSet* data, vtkIdType i) {
  std::array<double, 3> x;
  data->GetPoint(i, x.data());
  return {x[0], x[1], x[2]};
}

TEST(ReadWrittenMeshes, VtuAndVtkhdfGiveTheSameTetrahedraValuesAndVolumes) {
  const IntervalMesh mesh = torus();
  const testing::TemporaryFolder folder;
  std::vector<float> other;
  for (const Vec3d& x : mesh.positions) other.push_back(static_cast<float>(x.x - x.y));
  for (const int compression : {-1, 0, 1, 6}) {
    const bool hdf = compression < 0;
    SCOPED_TRACE(hdf ? "vtkhdf" : "compression " + std::to_string(compression));
    const std::string path = (folder / (hdf ? "mesh.vtkhdf" : "mesh.vtu")).string();
    WriteOptions options;
    if (!hdf) options.compression = compression;
    write_mesh(path, mesh, "distance", std::vector<MeshArray>{{"x - y <&>", other}}, options, Task());
    vtkNew<vtkXMLUnstructuredGridReader> xml;
    vtkNew<vtkHDFReader> reader;
    if (hdf) {
      ASSERT_TRUE(reader->CanReadFile(path.c_str()));
    }
    hdf ? reader->SetFileName(path.c_str()) : xml->SetFileName(path.c_str());
    hdf ? reader->Update() : xml->Update();
    vtkUnstructuredGrid* grid = hdf ? vtkUnstructuredGrid::SafeDownCast(reader->GetOutputDataObject(0)) : xml->GetOutput();
    ASSERT_TRUE(grid);
    ASSERT_EQ(grid->GetNumberOfCells(), static_cast<vtkIdType>(mesh.tetrahedra.size()));
    ASSERT_EQ(grid->GetNumberOfPoints(), static_cast<vtkIdType>(mesh.positions.size()));
    vtkDataArray* const values = grid->GetPointData()->GetArray("distance");
    vtkDataArray* const carried = grid->GetPointData()->GetArray("x - y <&>");
    vtkDataArray* const interval = grid->GetCellData()->GetArray("interval");
    vtkDataArray* const upper = grid->GetCellData()->GetArray("upper");
    ASSERT_TRUE(values && carried && interval && upper);
    for (vtkIdType p = 0; p < grid->GetNumberOfPoints(); ++p) {
      ASSERT_EQ(point(grid, p), mesh.positions[p]);
      ASSERT_EQ(values->GetTuple1(p), mesh.values[p]);
      ASSERT_EQ(static_cast<float>(carried->GetTuple1(p)), other[p]);
    }
    std::array<double, 2> volume{};
    for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c) {
      ASSERT_EQ(grid->GetCellType(c), VTK_TETRA);
      vtkIdType count = 0;
      const vtkIdType* ids = nullptr;
      grid->GetCellPoints(c, count, ids);
      ASSERT_EQ(count, 4);
      const int i = static_cast<int>(interval->GetTuple1(c));
      ASSERT_EQ(upper->GetTuple1(c), mesh.summaries[i].interval.upper);
      volume[i] += orient3d(point(grid, ids[0]), point(grid, ids[1]), point(grid, ids[2]), point(grid, ids[3])) / 6;
    }
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(volume[i], mesh.summaries[i].signed_volume, 1e-11 * volume[i]);
  }
}

TEST(ReadWrittenMeshes, VtkhdfOfNoneOfManyArraysAndOfAreas) {
  const testing::TemporaryFolder folder;
  const auto read = [&](const IntervalMesh& mesh, const std::vector<MeshArray>& more) {
    const std::string path = (folder / "mesh.vtkhdf").string();
    write_mesh(path, mesh, "f", more, {}, Task());
    vtkNew<vtkHDFReader> reader;
    reader->SetFileName(path.c_str());
    reader->Update();
    vtkNew<vtkUnstructuredGrid> grid;
    grid->ShallowCopy(reader->GetOutputDataObject(0));
    return vtkSmartPointer<vtkUnstructuredGrid>(grid);
  };
  IntervalMesh mesh = torus();
  std::vector<MeshArray> more;
  for (int i = 0; i < 40; ++i) more.push_back({"a/b " + std::to_string(i), std::vector<float>(mesh.positions.size(), static_cast<float>(i)), false});
  more.push_back({"in cells", std::vector<float>(mesh.tetrahedra.size(), 7), true});
  const auto many = read(mesh, more);
  EXPECT_EQ(many->GetPointData()->GetNumberOfArrays(), 41);
  for (int i = 0; i < 40; ++i) {
    vtkDataArray* const array = many->GetPointData()->GetArray(("a_b " + std::to_string(i)).c_str());
    ASSERT_TRUE(array) << i;
    EXPECT_EQ(array->GetTuple1(0), i);
  }
  ASSERT_TRUE(many->GetCellData()->GetArray("in cells"));
  EXPECT_EQ(many->GetCellData()->GetArray("in cells")->GetTuple1(5), 7);

  const Grid flat = uniform_grid({5, 4, 1});
  const IntervalMesh areas = extract(flat, point_array(std::vector<double>{0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0, 1, 2, 3, 4}), {{0.5, 2.5}});
  const auto triangles = read(areas, {});
  ASSERT_EQ(triangles->GetNumberOfCells(), static_cast<vtkIdType>(areas.facets.size()));
  EXPECT_EQ(triangles->GetCellType(0), VTK_TRIANGLE);
}

TEST(ReadWrittenMeshes, PlyGivesTheChosenFacets) {
  const IntervalMesh mesh = torus(true);
  const testing::TemporaryFolder folder;
  const std::string path = (folder / "mesh.ply").string();
  WriteOptions options;
  options.facets = {{FacetLabel::lower, {}}, {FacetLabel::upper, std::uint16_t{1}}};
  write_mesh(path, mesh, "distance", {}, options, Task());
  vtkNew<vtkPLYReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  vtkPolyData* data = reader->GetOutput();
  std::vector<const BoundaryFacet*> chosen;
  for (const BoundaryFacet& f : mesh.facets)
    if (f.label == FacetLabel::lower || (f.label == FacetLabel::upper && f.interval == 1)) chosen.push_back(&f);
  ASSERT_EQ(data->GetNumberOfCells(), static_cast<vtkIdType>(chosen.size()));
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c) {
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    data->GetCellPoints(c, count, ids);
    ASSERT_EQ(count, 3);
    for (int k = 0; k < 3; ++k) {  // the reader keeps single precision
      const Vec3d expected = mesh.positions[chosen[c]->points[k]];
      ASSERT_NEAR(length(point(data, ids[k]) - expected), 0, 1e-6);
    }
  }
}

TEST(ReadWrittenMeshes, StlGivesAllFacetsAndTheVolumeTheyEnclose) {
  const IntervalMesh mesh = torus();
  const testing::TemporaryFolder folder;
  const std::string path = (folder / "mesh.stl").string();
  write_mesh(path, mesh, "distance", {}, {}, Task());
  vtkNew<vtkSTLReader> reader;
  reader->SetFileName(path.c_str());
  reader->MergingOff();
  reader->Update();
  vtkPolyData* data = reader->GetOutput();
  ASSERT_EQ(data->GetNumberOfCells(), static_cast<vtkIdType>(mesh.facets.size()));
  double volume = 0;
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c) {
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    data->GetCellPoints(c, count, ids);
    ASSERT_EQ(count, 3);
    volume += dot(point(data, ids[0]), cross(point(data, ids[1]), point(data, ids[2]))) / 6;
  }
  EXPECT_NEAR(volume, total_signed_volume(mesh), 1e-5);
}

}  // namespace
}  // namespace isostrata
