// What `isostrata partition` writes, read by VTK's readers as ParaView uses them: whole, and piece by piece.
#include <gtest/gtest.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkDataSetAttributes.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkRectilinearGrid.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredGrid.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLImageDataWriter.h>
#include <vtkXMLPDataReader.h>
#include <vtkXMLPImageDataReader.h>
#include <vtkXMLPRectilinearGridReader.h>
#include <vtkXMLPStructuredGridReader.h>
#include <vtkXMLPUnstructuredGridReader.h>

#include <array>
#include <boost/json.hpp>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "data/open/import_door.h"
#include "support/run_isostrata.h"
#include "support/sample_files.h"

namespace isostrata {
namespace {

vtkSmartPointer<vtkXMLPDataReader> reader_of(const std::string& list) {
  vtkSmartPointer<vtkXMLPDataReader> reader;
  if (list.ends_with(".pvti")) reader = vtkSmartPointer<vtkXMLPImageDataReader>::New();
  if (list.ends_with(".pvtr")) reader = vtkSmartPointer<vtkXMLPRectilinearGridReader>::New();
  if (list.ends_with(".pvts")) reader = vtkSmartPointer<vtkXMLPStructuredGridReader>::New();
  if (list.ends_with(".pvtu")) reader = vtkSmartPointer<vtkXMLPUnstructuredGridReader>::New();
  reader->SetFileName(list.c_str());
  return reader;
}

int mark(vtkDataSet* data, vtkIdType cell) {
  vtkDataArray* const marks = data->GetCellData()->GetArray(vtkDataSetAttributes::GhostArrayName());
  return marks ? static_cast<int>(marks->GetTuple1(cell)) : 0;
}

using Place = std::array<double, 3>;

Place place(vtkDataSet* data, vtkIdType point) {
  Place at;
  data->GetPoint(point, at.data());
  return at;
}

/// Cells that are not ghosts, hidden ones among them, each by its corners: as often as it is there.
std::map<std::multiset<Place>, int> own_cells(vtkDataSet* data) {
  std::map<std::multiset<Place>, int> out;
  for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c) {
    if (mark(data, c) & vtkDataSetAttributes::DUPLICATECELL) continue;
    vtkNew<vtkIdList> ids;
    data->GetCellPoints(c, ids);
    std::multiset<Place> corners;
    for (vtkIdType i = 0; i < ids->GetNumberOfIds(); ++i) corners.insert(place(data, ids->GetId(i)));
    ++out[corners];
  }
  return out;
}

std::map<std::multiset<Place>, int> own_cells(const Dataset& data) {
  std::map<std::multiset<Place>, int> out;
  std::array<std::int64_t, kMaxCellVertices> ids;
  for (std::int64_t c = 0; c < data.grid.cell_count(); ++c) {
    const int count = data.grid.cell_points(c, ids);
    std::multiset<Place> corners;
    for (int i = 0; i < count; ++i) {
      const Vec3d at = data.grid.point(ids[static_cast<std::size_t>(i)]);
      corners.insert({at.x, at.y, at.z});
    }
    ++out[corners];
  }
  return out;
}

TEST(ReadPartitions, VtkFindsEachCellOnceAndTheValuesOfEachPoint) {
  const testing::TemporaryFolder folder;
  int number = 0;
  std::set<std::string> kinds;
  for (const testing::SampleFile& file : testing::write_sample_files(folder)) {
    const std::string name = file.path.filename().string();
    if (name != "uniform.vti" && name != "rectilinear.vtr" && name != "curvilinear.vts" && name != "mixed.vtu" && name != "blanked.vti") continue;
    SCOPED_TRACE(name);
    const auto run = testing::run_isostrata("partition '" + file.path.string() + "' --parts 3 --json --out '" + (folder / std::to_string(++number)).string() + "'");
    ASSERT_EQ(run.status, 0) << run.err;
    const std::string list(boost::json::parse(run.out).at("list").as_string());
    const auto whole = open_import(file.path, {}, Task());
    const auto expected = own_cells(*whole);
    std::map<Place, double> values;
    for (std::int64_t p = 0; p < whole->grid.point_count(); ++p) {
      const Vec3d at = whole->grid.point(p);
      values[{at.x, at.y, at.z}] = whole->arrays[0].at(static_cast<std::size_t>(p));
    }
    const auto reader = reader_of(list);
    reader->Update();
    vtkDataSet* data = vtkDataSet::SafeDownCast(reader->GetOutputDataObject(0));
    ASSERT_TRUE(data);
    kinds.insert(data->GetClassName());
    EXPECT_EQ(own_cells(data), expected);
    if (!vtkUnstructuredGrid::SafeDownCast(data)) {
      EXPECT_EQ(data->GetNumberOfCells(), whole->grid.cell_count());
    } else {
      EXPECT_GT(data->GetNumberOfCells(), whole->grid.cell_count()) << "no ghosts";
    }
    vtkDataArray* const array = data->GetPointData()->GetArray(whole->arrays[0].name.c_str());
    ASSERT_TRUE(array);
    for (vtkIdType p = 0; p < data->GetNumberOfPoints(); ++p) {
      const auto at = values.find(place(data, p));
      ASSERT_NE(at, values.end());
      ASSERT_EQ(array->GetTuple1(p), at->second);
    }
    std::int64_t hidden = 0, expected_hidden = 0;
    for (vtkIdType c = 0; c < data->GetNumberOfCells(); ++c) hidden += mark(data, c) == vtkDataSetAttributes::HIDDENCELL;
    for (std::int64_t c = 0; c < whole->grid.cell_count(); ++c) expected_hidden += whole->grid.hidden(c);
    EXPECT_EQ(hidden, expected_hidden);

    // As three processes of ParaView read it.
    std::map<std::multiset<Place>, int> together;
    for (int piece = 0; piece < 3; ++piece) {
      const auto own = reader_of(list);
      own->UpdateInformation();
      own->UpdatePiece(piece, 3, 0);
      for (const auto& [corners, times] : own_cells(vtkDataSet::SafeDownCast(own->GetOutputDataObject(0)))) together[corners] += times;
    }
    EXPECT_EQ(together, expected);
  }
  EXPECT_EQ(kinds, (std::set<std::string>{"vtkImageData", "vtkRectilinearGrid", "vtkStructuredGrid", "vtkUnstructuredGrid"}));
}

TEST(ReadPartitions, PartsHaveTheUnitsOfTheWhole) {
  const testing::TemporaryFolder folder;
  vtkNew<vtkImageData> image;
  image->SetDimensions(4, 3, 3);
  vtkNew<vtkFloatArray> heat;
  heat->SetName("heat");
  for (vtkIdType p = 0; p < image->GetNumberOfPoints(); ++p) heat->InsertNextValue(static_cast<float>(p));
  heat->GetInformation()->Set(vtkDataArray::UNITS_LABEL(), "J < m-3");
  image->GetPointData()->AddArray(heat);
  vtkNew<vtkXMLImageDataWriter> writer;
  writer->SetInputData(image);
  writer->SetFileName((folder / "heat.vti").c_str());
  ASSERT_EQ(writer->Write(), 1);
  const auto run = testing::run_isostrata("partition '" + (folder / "heat.vti").string() + "' --parts 2 --json --out '" + (folder / "parts").string() + "'");
  ASSERT_EQ(run.status, 0) << run.err;
  const std::string list(boost::json::parse(run.out).at("list").as_string());
  vtkNew<vtkXMLImageDataReader> part;
  part->SetFileName((std::filesystem::path(list).parent_path() / "heat_0.vti").c_str());
  part->Update();
  vtkDataArray* const read = part->GetOutput()->GetPointData()->GetArray("heat");
  ASSERT_TRUE(read);
  ASSERT_TRUE(read->HasInformation() && read->GetInformation()->Has(vtkDataArray::UNITS_LABEL()));
  EXPECT_EQ(read->GetInformation()->Get(vtkDataArray::UNITS_LABEL()), std::string("J < m-3"));
}

}  // namespace
}  // namespace isostrata
