// Files of VTK's own writers, in every encoding: the importer reads what was written.
#include <gtest/gtest.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSetWriter.h>
#include <vtkDoubleArray.h>
#include <vtkExodusIIWriter.h>
#include <vtkFieldData.h>
#include <vtkGenericCell.h>
#include <vtkIdList.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkInformationVector.h>
#include <vtkMetaImageWriter.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkMultiBlockDataSetAlgorithm.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkRectilinearGrid.h>
#include <vtkSmartPointer.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkStructuredGrid.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLImageDataWriter.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLRectilinearGridWriter.h>
#include <vtkXMLStructuredGridWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <cmath>

#include "data/files.h"
#include "data/open/import_door.h"
#include "extraction/intervals/extract_intervals.h"
#include "support/mutated_files.h"
#include "support/places.h"

namespace isostrata {
namespace {

using test::Scratch;

constexpr std::array kKinds{"image", "rectilinear", "structured", "unstructured"};
constexpr std::array<int, 3> kDims{7, 5, 4};
constexpr const char* kUnit = "kg m<2> & \"s\"";

/// Values that tell most places from each other and that text of any precision keeps.
double place_value(vtkIdType i, int component, bool with_sign) {
  return static_cast<double>((37 * i + 11 * component) % 101) - (with_sign ? 50 : 0);
}

vtkSmartPointer<vtkDataArray> array_of(int type, const std::string& name, int components, vtkIdType tuples) {
  auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
  array->SetName(name.c_str());
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(tuples);
  const bool with_sign = array->GetDataTypeMin() < 0;
  for (vtkIdType i = 0; i < tuples; ++i)
    for (int c = 0; c < components; ++c) array->SetComponent(i, c, place_value(i, c, with_sign) * (type == VTK_DOUBLE ? 0.125 : 1));
  return array;
}

/// One array of each type of number, a vector and a tensor at the points; one of several types and a vector in the cells.
void add_arrays(vtkDataSet* data) {
  for (const auto& [type, name] : std::vector<std::pair<int, std::string>>{{VTK_SIGNED_CHAR, "i8"},
                                                                           {VTK_UNSIGNED_CHAR, "u8"},
                                                                           {VTK_SHORT, "i16"},
                                                                           {VTK_UNSIGNED_SHORT, "u16"},
                                                                           {VTK_INT, "i32"},
                                                                           {VTK_UNSIGNED_INT, "u32"},
                                                                           {VTK_LONG_LONG, "i64"},
                                                                           {VTK_UNSIGNED_LONG_LONG, "u64"},
                                                                           {VTK_FLOAT, "f32"},
                                                                           {VTK_DOUBLE, "f64"}})
    data->GetPointData()->AddArray(array_of(type, name, 1, data->GetNumberOfPoints()));
  data->GetPointData()->AddArray(array_of(VTK_FLOAT, "vector", 3, data->GetNumberOfPoints()));
  data->GetPointData()->AddArray(array_of(VTK_DOUBLE, "tensor", 9, data->GetNumberOfPoints()));
  data->GetCellData()->AddArray(array_of(VTK_UNSIGNED_CHAR, "in cells u8", 1, data->GetNumberOfCells()));
  data->GetCellData()->AddArray(array_of(VTK_DOUBLE, "in cells f64", 1, data->GetNumberOfCells()));
  data->GetCellData()->AddArray(array_of(VTK_FLOAT, "in cells vector", 3, data->GetNumberOfCells()));
  for (vtkDataArray* array : {data->GetPointData()->GetArray("f32"), data->GetPointData()->GetArray("vector"), data->GetCellData()->GetArray("in cells f64")})
    array->GetInformation()->Set(vtkDataArray::UNITS_LABEL(), kUnit);
}

Vec3d sheared(int i, int j, int k) { return {i + 0.25 * j, 0.5 * j - 0.125 * k, k * 2.0 + 0.25 * i}; }

/// `first`: index of the first point, for kinds that have an extent.
vtkSmartPointer<vtkDataSet> sample(const std::string& kind, std::array<int, 3> first = {0, 0, 0}) {
  const int extent[6] = {first[0], first[0] + kDims[0] - 1, first[1], first[1] + kDims[1] - 1, first[2], first[2] + kDims[2] - 1};
  vtkSmartPointer<vtkDataSet> out;
  vtkNew<vtkPoints> points;
  for (int k = 0; k < kDims[2]; ++k)
    for (int j = 0; j < kDims[1]; ++j)
      for (int i = 0; i < kDims[0]; ++i) {
        const Vec3d p = sheared(i, j, k);
        points->InsertNextPoint(p.x, p.y, p.z);
      }
  if (kind == "image") {
    const auto image = vtkSmartPointer<vtkImageData>::New();
    image->SetExtent(const_cast<int*>(extent));
    image->SetOrigin(-1, 2.5, 10);
    image->SetSpacing(0.5, 0.25, 3);
    out = image;
  } else if (kind == "rectilinear") {
    const auto grid = vtkSmartPointer<vtkRectilinearGrid>::New();
    grid->SetExtent(const_cast<int*>(extent));
    for (int a = 0; a < 3; ++a) {
      vtkNew<vtkDoubleArray> axis;
      for (int i = 0; i < kDims[static_cast<std::size_t>(a)]; ++i) axis->InsertNextValue(a == 1 ? -0.5 * i : i + 0.125 * i * i);
      a == 0 ? grid->SetXCoordinates(axis) : a == 1 ? grid->SetYCoordinates(axis) : grid->SetZCoordinates(axis);
    }
    out = grid;
  } else if (kind == "structured") {
    const auto grid = vtkSmartPointer<vtkStructuredGrid>::New();
    grid->SetExtent(const_cast<int*>(extent));
    grid->SetPoints(points);
    out = grid;
  } else {
    const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
    grid->SetPoints(points);
    const auto at = [&](int i, int j, int k) { return static_cast<vtkIdType>(i + kDims[0] * (j + kDims[1] * k)); };
    for (int k = 0; k + 1 < kDims[2]; ++k)
      for (int j = 0; j + 1 < kDims[1]; ++j)
        for (int i = 0; i + 1 < kDims[0]; ++i) {
          const vtkIdType c[8] = {at(i, j, k),     at(i + 1, j, k),     at(i + 1, j + 1, k),     at(i, j + 1, k),
                                  at(i, j, k + 1), at(i + 1, j, k + 1), at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1)};
          if (i % 2) {
            grid->InsertNextCell(VTK_HEXAHEDRON, 8, c);
            continue;
          }
          const vtkIdType wedges[2][6] = {{c[0], c[1], c[2], c[4], c[5], c[6]}, {c[0], c[2], c[3], c[4], c[6], c[7]}};
          for (const auto& wedge : wedges) grid->InsertNextCell(VTK_WEDGE, 6, wedge);
        }
    out = grid;
  }
  add_arrays(out);
  vtkNew<vtkDoubleArray> time;
  time->SetName("TimeValue");
  time->InsertNextValue(2.5);
  out->GetFieldData()->AddArray(time);
  return out;
}

const std::map<std::string, ScalarType>& types_by_name() {
  static const std::map<std::string, ScalarType> types{{"i8", ScalarType::int8},     {"u8", ScalarType::uint8},
                                                       {"i16", ScalarType::int16},   {"u16", ScalarType::uint16},
                                                       {"i32", ScalarType::int32},   {"u32", ScalarType::uint32},
                                                       {"i64", ScalarType::int64},   {"u64", ScalarType::uint64},
                                                       {"f32", ScalarType::float32}, {"f64", ScalarType::float64}};
  return types;
}

Vec3d point_of(vtkDataSet* data, vtkIdType p) {
  double x[3];
  data->GetPoint(p, x);
  return {x[0], x[1], x[2]};
}

/// Points, cells and arrays of the dataset are those of VTK's object; a cell array is, at each point, the mean of the point's cells.
void expect_same(const Dataset& opened, vtkDataSet* written, bool with_units = true) {
  ASSERT_EQ(opened.grid.point_count(), written->GetNumberOfPoints());
  ASSERT_EQ(opened.grid.cell_count(), written->GetNumberOfCells());
  const auto points = static_cast<std::size_t>(written->GetNumberOfPoints());
  for (std::size_t p = 0; p < points; ++p)
    ASSERT_EQ(opened.grid.point(static_cast<std::int64_t>(p)), point_of(written, static_cast<vtkIdType>(p))) << "point " << p;
  std::array<std::int64_t, kMaxCellVertices> ids{};
  vtkNew<vtkIdList> list;
  for (vtkIdType c = 0; c < written->GetNumberOfCells(); ++c) {
    const int n = opened.grid.cell_points(c, ids);
    written->GetCellPoints(c, list);
    std::vector<std::int64_t> ours(ids.begin(), ids.begin() + n), theirs(list->begin(), list->end());
    if (written->GetCellType(c) == VTK_VOXEL) std::swap(theirs[2], theirs[3]), std::swap(theirs[6], theirs[7]);
    ASSERT_EQ(ours, theirs) << "cell " << c;
  }
  for (const auto& [name, type] : types_by_name()) {
    const PointArray& array = opened.array(name);
    EXPECT_EQ(array.type, type) << name;
    for (std::size_t p = 0; p < points; ++p)
      ASSERT_EQ(array.at(p), written->GetPointData()->GetArray(name.c_str())->GetComponent(static_cast<vtkIdType>(p), 0)) << name;
  }
  const auto expect_vector = [&](const std::string& name, int components, const auto& value) {
    const PointArray& magnitude = opened.array(name);
    EXPECT_EQ(magnitude.components, components) << name;
    for (std::size_t p = 0; p < points; ++p) {
      double squares = 0;
      for (int c = 0; c < components; ++c) squares += value(p, c) * value(p, c);
      ASSERT_NEAR(magnitude.at(p), std::sqrt(squares), 1e-5 * (1 + std::sqrt(squares))) << name;
      if (components != 3) continue;
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(opened.array(name + "_" + "xyz"[c]).at(p), value(p, c), 1e-5 * (1 + std::abs(value(p, c)))) << name << c;
    }
  };
  for (const auto& [name, components] : std::map<std::string, int>{{"vector", 3}, {"tensor", 9}})
    expect_vector(name, components, [array = written->GetPointData()->GetArray(name.c_str())](std::size_t p, int c) {
      return array->GetComponent(static_cast<vtkIdType>(p), c);
    });
  const auto mean = [&](vtkDataArray* array, std::size_t p, int c) {
    written->GetPointCells(static_cast<vtkIdType>(p), list);
    double sum = 0;
    for (vtkIdType i = 0; i < list->GetNumberOfIds(); ++i) sum += array->GetComponent(list->GetId(i), c);
    return sum / static_cast<double>(list->GetNumberOfIds());
  };
  for (const std::string name : {"in cells u8", "in cells f64"}) {
    const PointArray& array = opened.array(name);
    EXPECT_EQ(array.association, Association::cell_averaged) << name;
    for (std::size_t p = 0; p < points; ++p)
      ASSERT_NEAR(array.at(p), mean(written->GetCellData()->GetArray(name.c_str()), p, 0), 1e-5) << name << " at " << p;
  }
  if (with_units) {
    for (const char* name : {"f32", "vector", "vector_y", "in cells f64", "f64"}) EXPECT_EQ(opened.array(name).unit, name != std::string("f64") ? kUnit : "") << name;
  }
  expect_vector("in cells vector", 3, [&](std::size_t p, int c) {
    return mean(written->GetCellData()->GetArray("in cells vector"), p, c);
  });
}

/// How a .vt? file is encoded.
struct Encoding {
  int mode = vtkXMLWriter::Appended;
  bool base64 = false;  // of appended data
  int compressor = vtkXMLWriter::NONE;
  bool wide = true;  // headers of 64 bits
  bool big = false;

  std::string name() const {
    return std::string(mode == vtkXMLWriter::Ascii ? "ascii" : mode == vtkXMLWriter::Binary ? "inline" : base64 ? "base64" : "raw") +
           (compressor == vtkXMLWriter::NONE   ? ""
            : compressor == vtkXMLWriter::ZLIB ? "_zlib"
            : compressor == vtkXMLWriter::LZ4  ? "_lz4"
                                               : "_lzma") +
           (wide ? "_64" : "_32") + (big ? "_big" : "");
  }
};

std::vector<Encoding> encodings() {
  std::vector<Encoding> all{{vtkXMLWriter::Ascii}};
  for (const int compressor : {vtkXMLWriter::NONE, vtkXMLWriter::ZLIB, vtkXMLWriter::LZ4, vtkXMLWriter::LZMA})
    for (const bool wide : {false, true})
      for (const bool big : {false, true}) {
        all.push_back({vtkXMLWriter::Binary, false, compressor, wide, big});
        all.push_back({vtkXMLWriter::Appended, wide == big, compressor, wide, big});
      }
  return all;
}

std::filesystem::path write_xml(const Scratch& scratch, const std::string& stem, vtkDataSet* data, const Encoding& encoding = {}) {
  vtkSmartPointer<vtkXMLWriter> writer;
  if (vtkImageData::SafeDownCast(data)) writer = vtkSmartPointer<vtkXMLImageDataWriter>::New();
  if (vtkRectilinearGrid::SafeDownCast(data)) writer = vtkSmartPointer<vtkXMLRectilinearGridWriter>::New();
  if (vtkStructuredGrid::SafeDownCast(data)) writer = vtkSmartPointer<vtkXMLStructuredGridWriter>::New();
  if (vtkUnstructuredGrid::SafeDownCast(data)) writer = vtkSmartPointer<vtkXMLUnstructuredGridWriter>::New();
  if (vtkPolyData::SafeDownCast(data)) writer = vtkSmartPointer<vtkXMLPolyDataWriter>::New();
  const auto file = scratch / (stem + "." + writer->GetDefaultFileExtension());
  writer->SetInputData(data);
  writer->SetFileName(file.c_str());
  writer->SetDataMode(encoding.mode);
  writer->SetEncodeAppendedData(encoding.base64);
  writer->SetCompressorType(encoding.compressor);
  writer->SetBlockSize(128);  // bytes: blocks for several threads in an array
  encoding.wide ? writer->SetHeaderTypeToUInt64() : writer->SetHeaderTypeToUInt32();
  encoding.big ? writer->SetByteOrderToBigEndian() : writer->SetByteOrderToLittleEndian();
  EXPECT_EQ(writer->Write(), 1) << file;
  return file;
}

std::filesystem::path write_legacy(const Scratch& scratch, const std::string& name, vtkDataSet* data, bool binary, int version) {
  vtkNew<vtkDataSetWriter> writer;
  const auto file = scratch / name;
  writer->SetInputData(data);
  writer->SetFileName(file.c_str());
  writer->SetFileVersion(version);
  binary ? writer->SetFileTypeToBinary() : writer->SetFileTypeToASCII();
  EXPECT_EQ(writer->Write(), 1) << file;
  return file;
}

class EachKind : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(ImportWhatVtkWrites, EachKind, ::testing::ValuesIn(kKinds),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(EachKind, InEveryXmlEncoding) {
  const Scratch scratch;
  for (const Encoding& encoding : encodings()) {
    SCOPED_TRACE(encoding.name());
    const auto data = sample(GetParam(), {3, -2, 5});
    const auto opened = test::open(write_xml(scratch, encoding.name(), data, encoding));
    expect_same(*opened, data);
    EXPECT_EQ(opened->times, std::vector<double>{2.5});
    if (HasFatalFailure()) return;
  }
}

TEST(ImportWhatVtkWrites, AStepOnTheMeshOfOneInMemoryBringsItsValuesAlone) {
  for (const Encoding& encoding : encodings()) {
    if (encoding.mode == vtkXMLWriter::Ascii || encoding.compressor == vtkXMLWriter::LZMA || encoding.big) continue;  // those are VTK's reader's
    SCOPED_TRACE(encoding.name());
    const Scratch scratch;
    const auto data = sample("unstructured");
    data->GetCellData()->Initialize();
    write_xml(scratch, "step_0", data, encoding);
    for (vtkIdType p = 0; p < data->GetNumberOfPoints(); ++p) data->GetPointData()->GetArray("f32")->SetTuple1(p, 1.5 * static_cast<double>(p));
    write_xml(scratch, "step_1", data, encoding);
    vtkUnstructuredGrid::SafeDownCast(data)->GetPoints()->SetPoint(3, 1, 2, 3);
    write_xml(scratch, "step_2", data, encoding);
    ImportOptions options;
    options.importer = std::filesystem::path(isostrata::places::binaries()) / "isostrata-import";
    options.like = open_import(scratch / "step_*.vtu", options, Task());
    for (const int step : {1, 2}) {
      options.step = step;
      const auto opened = open_import(scratch / "step_*.vtu", options, Task());
      EXPECT_EQ(opened->grid.storage == options.like->grid.storage, step == 1);
      EXPECT_EQ(opened->array("f32").at(5), 7.5);
      EXPECT_EQ(opened->grid.point(3) == options.like->grid.point(3), step == 1);
    }
  }
}

TEST_P(EachKind, InLegacyTextAndBytes) {
  const Scratch scratch;
  for (const int version : {42, 51})
    for (const bool binary : {false, true}) {
      SCOPED_TRACE(std::to_string(version) + (binary ? " bytes" : " text"));
      const auto data = sample(GetParam());
      expect_same(*test::open(write_legacy(scratch, "x.vtk", data, binary, version)), data);
      if (HasFatalFailure()) return;
    }
}

/// Structured grids in two pieces along x that meet in a plane of points; of the unstructured one, cells in turn.
TEST_P(EachKind, InPieces) {
  const Scratch scratch;
  const std::string kind = GetParam();
  const auto whole = sample(kind);
  std::string pieces, element;
  const char* extension = "";
  const auto extent_text = [](const int (&e)[6]) {
    std::string text;
    for (const int n : e) text += std::to_string(n) + " ";
    return text;
  };
  const int whole_extent[6] = {0, kDims[0] - 1, 0, kDims[1] - 1, 0, kDims[2] - 1};
  for (int half = 0; half < 2; ++half) {
    vtkSmartPointer<vtkDataSet> part;
    const std::string stem = "piece" + std::to_string(half);
    std::string attributes;
    if (kind == "unstructured") {
      const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
      grid->SetPoints(vtkUnstructuredGrid::SafeDownCast(whole)->GetPoints());
      grid->GetPointData()->ShallowCopy(whole->GetPointData());
      grid->GetCellData()->CopyAllocate(whole->GetCellData());
      vtkNew<vtkIdList> ids;
      for (vtkIdType c = 0; c < whole->GetNumberOfCells(); ++c) {
        if (c % 2 != half) continue;
        whole->GetCellPoints(c, ids);
        grid->GetCellData()->CopyData(whole->GetCellData(), c, grid->InsertNextCell(whole->GetCellType(c), ids));
      }
      part = grid;
    } else {
      int extent[6] = {half ? 3 : 0, half ? kDims[0] - 1 : 3, 0, kDims[1] - 1, 0, kDims[2] - 1};
      part = vtkSmartPointer<vtkDataSet>::Take(whole->NewInstance());
      part->DeepCopy(whole);
      part->Crop(extent);
      attributes = " Extent=\"" + extent_text(extent) + "\"";
    }
    const auto file = write_xml(scratch, stem, part);
    pieces += "<Piece" + attributes + " Source=\"" + file.filename().string() + "\"/>\n";
  }
  const auto arrays = [](vtkDataSetAttributes* of) {
    std::string text;
    for (int i = 0; i < of->GetNumberOfArrays(); ++i) {
      vtkDataArray* array = of->GetArray(i);
      static const std::map<int, std::string> names{{VTK_SIGNED_CHAR, "Int8"}, {VTK_UNSIGNED_CHAR, "UInt8"},
                                                    {VTK_SHORT, "Int16"},      {VTK_UNSIGNED_SHORT, "UInt16"},
                                                    {VTK_INT, "Int32"},        {VTK_UNSIGNED_INT, "UInt32"},
                                                    {VTK_LONG_LONG, "Int64"},  {VTK_UNSIGNED_LONG_LONG, "UInt64"},
                                                    {VTK_FLOAT, "Float32"},    {VTK_DOUBLE, "Float64"}};
      text += "<PDataArray type=\"" + names.at(array->GetDataType()) + "\" Name=\"" + array->GetName() +
              "\" NumberOfComponents=\"" + std::to_string(array->GetNumberOfComponents()) + "\"/>\n";
    }
    return text;
  };
  if (kind == "image") element = "PImageData", extension = "pvti";
  if (kind == "rectilinear") element = "PRectilinearGrid", extension = "pvtr";
  if (kind == "structured") element = "PStructuredGrid", extension = "pvts";
  if (kind == "unstructured") element = "PUnstructuredGrid", extension = "pvtu";
  std::string attributes = " GhostLevel=\"0\"", places;
  if (kind != "unstructured") attributes += " WholeExtent=\"" + extent_text(whole_extent) + "\"";
  if (kind == "image") attributes += " Origin=\"-1 2.5 10\" Spacing=\"0.5 0.25 3\"";
  if (kind == "rectilinear")
    for (const char* axis : {"x", "y", "z"}) places += "<PDataArray type=\"Float64\" Name=\"" + std::string(axis) + "\"/>";
  if (kind == "rectilinear") places = "<PCoordinates>" + places + "</PCoordinates>\n";
  if (kind == "structured" || kind == "unstructured")
    places = "<PPoints><PDataArray type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\"/></PPoints>\n";
  const auto opened = test::open(scratch.write(
      std::string("whole.") + extension,
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + element + "\" version=\"1.0\" byte_order=\"LittleEndian\">\n<" + element +
          attributes + ">\n<PPointData>" + arrays(whole->GetPointData()) + "</PPointData>\n<PCellData>" +
          arrays(whole->GetCellData()) + "</PCellData>\n" + places + pieces + "</" + element + ">\n</VTKFile>\n"));
  if (kind != "unstructured") {
    expect_same(*opened, whole, kind == "unstructured");  // VTK's readers of lists of structured pieces may drop them
    return;
  }
  // Cells come in another order, and points may be there once or twice.
  EXPECT_EQ(opened->grid.cell_count(), whole->GetNumberOfCells());
  std::map<std::array<double, 3>, vtkIdType> at;
  for (vtkIdType p = 0; p < whole->GetNumberOfPoints(); ++p) {
    const Vec3d x = point_of(whole, p);
    at[{x.x, x.y, x.z}] = p;
  }
  for (const auto& [name, type] : types_by_name()) {
    const PointArray& array = opened->array(name);
    EXPECT_EQ(array.type, type);
    for (std::int64_t p = 0; p < opened->grid.point_count(); ++p) {
      const Vec3d x = opened->grid.point(p);
      ASSERT_EQ(at.count({x.x, x.y, x.z}), 1u);
      ASSERT_EQ(array.at(static_cast<std::size_t>(p)),
                whole->GetPointData()->GetArray(name.c_str())->GetComponent(at.at({x.x, x.y, x.z}), 0));
    }
  }
}

/// The solid that all of an array's range holds.
double solid_volume(const Dataset& data) {
  ExtractOptions options;
  const IntervalMesh mesh =
      extract_intervals(data.grid, data.arrays.at(0), std::vector<Interval>{{-1e9, 1e9}}, options, Task());
  return mesh.summaries.at(0).signed_volume;
}

/// A linear cell with the same corners, for cells whose points VTK does not place by itself.
int linear_counterpart(int type) {
  switch (type) {
    case VTK_LAGRANGE_TETRAHEDRON:
    case VTK_BEZIER_TETRAHEDRON:
      return VTK_TETRA;
    case VTK_LAGRANGE_HEXAHEDRON:
    case VTK_BEZIER_HEXAHEDRON:
      return VTK_HEXAHEDRON;
    case VTK_LAGRANGE_WEDGE:
    case VTK_BEZIER_WEDGE:
      return VTK_WEDGE;
    case VTK_LAGRANGE_PYRAMID:
    case VTK_BEZIER_PYRAMID:
      return VTK_PYRAMID;
    default:
      return type;
  }
}

/// Of the cell in its own coordinates, whose order does not matter: 1 for a hexahedron.
double parametric_volume(vtkCell& cell) {
  const int faces = cell.GetNumberOfFaces();
  if (faces == 4) return 1.0 / 6;
  const double* at = cell.GetParametricCoords();
  if (faces == 5 && cell.GetNumberOfEdges() == 8) {  // pyramids' coordinates are not the same in all of VTK's
    const auto point = [&](int p) { return Vec3d{at[3 * p], at[3 * p + 1], at[3 * p + 2]}; };
    return (std::abs(orient3d(point(0), point(1), point(2), point(4))) + std::abs(orient3d(point(0), point(2), point(3), point(4)))) / 6;
  }
  if (faces == 5) return 1.0 / 2;
  if (faces == 6) return 1;
  const int n = faces - 2;  // a prism over the polygon of its first n points
  double twice = 0;
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    twice += at[3 * i] * at[3 * next + 1] - at[3 * next] * at[3 * i + 1];
  }
  return std::abs(twice) / 2;
}

TEST(ImportWhatVtkWrites, CellsOfEveryTypeHaveTheirVolumeOrANote) {
  const Scratch scratch;
  int solids = 0;
  for (int type = 1; type < VTK_NUMBER_OF_CELL_TYPES; ++type) {
    if (type == VTK_POLYHEDRON || type == VTK_CONVEX_POINT_SET) continue;  // these have no points of their own: tests/laws
    const auto cell = vtkSmartPointer<vtkCell>::Take(vtkGenericCell::InstantiateCell(linear_counterpart(type)));
    if (!cell) continue;
    const int dimension = cell->GetCellDimension();
    if (dimension < 3 && type >= VTK_LAGRANGE_CURVE) continue;  // curves and surfaces that have no points before they have an order
    SCOPED_TRACE("type " + std::to_string(type) + ", " + cell->GetClassName());
    const double* places = cell->GetParametricCoords();
    if (!places) {
      EXPECT_LT(dimension, 3) << "its points are not known";
      continue;
    }
    const double shear = type == VTK_VOXEL ? 0 : 1;  // voxels are upright
    for (const double sign : {1, -1}) {
      vtkNew<vtkUnstructuredGrid> grid;
      vtkNew<vtkPoints> points;
      points->SetDataTypeToDouble();
      std::vector<vtkIdType> ids;
      for (int p = 0; p < cell->GetNumberOfPoints(); ++p) {
        Vec3d u{places[3 * p], places[3 * p + 1], places[3 * p + 2]};
        if (type == VTK_QUADRATIC_PYRAMID && p >= 9) u = 0.5 * (u + Vec3d{0, 0, 0.5});  // half way to the tip, which VTK's coordinates leave out
        ids.push_back(points->InsertNextPoint(2 * u.x + shear * 0.5 * u.y, 3 * u.y + shear * 0.25 * u.z, sign * (u.z + shear * u.x)));
      }
      const double scale = 6 + shear * 0.125;  // the map's determinant
      grid->SetPoints(points);
      grid->InsertNextCell(type, static_cast<vtkIdType>(ids.size()), ids.data());
      grid->GetPointData()->AddArray(array_of(VTK_FLOAT, "f", 1, points->GetNumberOfPoints()));
      const auto opened = test::open(write_xml(scratch, "cell", grid));
      EXPECT_GE(opened->grid.point_count(), points->GetNumberOfPoints());
      if (dimension < 2) {
        EXPECT_EQ(opened->notes.size(), 1u) << "one note says what is left out";
      }
      if (dimension < 3) continue;
      ++solids;
      const double expected = scale * parametric_volume(*cell);
      EXPECT_NEAR(std::abs(solid_volume(*opened)), expected, 1e-6 * expected) << sign;
    }
  }
  EXPECT_GE(solids, 2 * 20);
}

/// Two blocks, of hexahedra and of tetrahedra, at three times.
class TwoBlocks : public vtkMultiBlockDataSetAlgorithm {
 public:
  static TwoBlocks* New();
  vtkTypeMacro(TwoBlocks, vtkMultiBlockDataSetAlgorithm);
  static double value(const Vec3d& p, double time) { return p.x + 2 * p.y * time - p.z; }

 protected:
  TwoBlocks() { SetNumberOfInputPorts(0); }
  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector* out) override {
    static const double times[] = {0.5, 1, 2.25};
    static const double range[] = {0.5, 2.25};
    out->GetInformationObject(0)->Set(vtkStreamingDemandDrivenPipeline::TIME_STEPS(), times, 3);
    out->GetInformationObject(0)->Set(vtkStreamingDemandDrivenPipeline::TIME_RANGE(), range, 2);
    return 1;
  }
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* out) override {
    vtkInformation* information = out->GetInformationObject(0);
    const bool asked = information->Has(vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP());
    const double time = asked ? information->Get(vtkStreamingDemandDrivenPipeline::UPDATE_TIME_STEP()) : 0.5;
    auto* blocks = vtkMultiBlockDataSet::GetData(out);
    for (unsigned b = 0; b < 2; ++b) {
      vtkNew<vtkUnstructuredGrid> grid;
      vtkNew<vtkPoints> points;
      points->SetDataTypeToDouble();
      for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 2; ++j)
          for (int i = 0; i < 4; ++i) points->InsertNextPoint(i + 3.0 * b, j, k);
      grid->SetPoints(points);
      for (vtkIdType i = 0; i < 3; ++i) {
        const vtkIdType c[8] = {i, i + 1, i + 5, i + 4, i + 8, i + 9, i + 13, i + 12};
        if (b == 0) grid->InsertNextCell(VTK_HEXAHEDRON, 8, c);
        for (const auto& [first, second] : std::vector<std::pair<int, int>>{{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}}) {
          const vtkIdType t[4] = {c[0], c[first], c[second], c[6]};
          if (b == 1) grid->InsertNextCell(VTK_TETRA, 4, t);
        }
      }
      vtkNew<vtkDoubleArray> f;
      f->SetName("f");
      for (vtkIdType p = 0; p < points->GetNumberOfPoints(); ++p) f->InsertNextValue(value(point_of(grid, p), time));
      grid->GetPointData()->AddArray(f);
      blocks->SetBlock(b, grid);
    }
    if (asked) blocks->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), time);
    return 1;
  }
};
vtkStandardNewMacro(TwoBlocks);

TEST(ImportWhatVtkWrites, ExodusWithItsBlocksAndSteps) {
  const Scratch scratch;
  vtkNew<TwoBlocks> source;
  vtkNew<vtkExodusIIWriter> writer;
  const auto file = scratch / "two.e";
  writer->SetInputConnection(source->GetOutputPort());
  writer->SetFileName(file.c_str());
  writer->WriteAllTimeStepsOn();
  writer->SetStoreDoubles(1);
  writer->Write();
  for (int step = 0; step < 3; ++step) {
    const auto opened = test::open(file, step);
    EXPECT_EQ(opened->times, (std::vector<double>{0.5, 1, 2.25}));
    EXPECT_EQ(opened->cell_types, (std::map<std::string, std::int64_t>{{"hexahedron", 3}, {"tetrahedron", 18}}));
    EXPECT_NEAR(solid_volume(*opened), 6, 1e-12);
    const PointArray& f = opened->array("f");
    for (std::int64_t p = 0; p < opened->grid.point_count(); ++p)
      ASSERT_NEAR(f.at(static_cast<std::size_t>(p)),
                  TwoBlocks::value(opened->grid.point(p), opened->times[static_cast<std::size_t>(step)]), 1e-12)
          << "step " << step << " point " << p;
  }
  OpenOptions beyond;
  beyond.step = 3;
  EXPECT_EQ(test::refusal(file, beyond).code(), ErrorCode::not_found);
}

TEST(ImportWhatVtkWrites, MetaImagesInOneFileOrTwo) {
  const Scratch scratch;
  const auto image = sample("image");
  for (const char* name : {"u8", "i16", "f32"})
    for (const bool compressed : {false, true})
      for (const char* file_name : {"x.mha", "x.mhd"}) {
        SCOPED_TRACE(std::string(name) + " " + file_name + (compressed ? " compressed" : ""));
        vtkNew<vtkImageData> one;
        one->CopyStructure(image);
        one->GetPointData()->SetScalars(image->GetPointData()->GetArray(name));
        vtkNew<vtkMetaImageWriter> writer;
        const auto file = scratch / file_name;
        writer->SetInputData(one);
        writer->SetFileName(file.c_str());
        writer->SetCompression(compressed);
        writer->Write();
        const auto opened = test::open(file);
        ASSERT_EQ(opened->grid.point_count(), one->GetNumberOfPoints());
        const PointArray& array = opened->arrays.at(0);
        for (vtkIdType p = 0; p < one->GetNumberOfPoints(); ++p) {
          ASSERT_EQ(opened->grid.point(p), point_of(one, p));
          ASSERT_EQ(array.at(static_cast<std::size_t>(p)), one->GetPointData()->GetArray(0)->GetComponent(p, 0));
        }
      }
}

TEST(ImportWhatVtkWrites, SurfacesAreRefused) {
  const Scratch scratch;
  const auto surface = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  const vtkIdType triangle[3] = {points->InsertNextPoint(0, 0, 0), points->InsertNextPoint(1, 0, 0), points->InsertNextPoint(0, 1, 0)};
  surface->SetPoints(points);
  surface->AllocateExact(1, 3);
  surface->InsertNextCell(VTK_TRIANGLE, 3, triangle);
  EXPECT_EQ(test::refusal(write_xml(scratch, "surface", surface)).code(), ErrorCode::unsupported);
  for (const bool binary : {false, true})
    EXPECT_EQ(test::refusal(write_legacy(scratch, "surface.vtk", surface, binary, 51)).code(), ErrorCode::unsupported);
}

TEST(ImportWhatVtkWrites, MutatedFilesEndInADatasetOrAnError) {
  const Scratch scratch;
  std::vector<std::pair<std::string, std::string>> files;
  const auto add = [&](const std::filesystem::path& file) { files.emplace_back(file.filename().string(), test::read_bytes(file)); };
  std::size_t turn = 0;
  for (const Encoding& encoding : encodings()) {
    if (encoding.wide == encoding.big) add(write_xml(scratch, encoding.name(), sample(kKinds[turn++ % kKinds.size()]), encoding));
  }
  for (const char* kind : kKinds) add(write_legacy(scratch, std::string(kind) + ".vtk", sample(kind), true, 51));
  testing::expect_datasets_or_errors(files, 80);
}

}  // namespace
}  // namespace isostrata
