#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkRectilinearGrid.h>
#include <vtkStructuredGrid.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "import/bytes/parsed_number.h"
#include "import/vtk/vtk_type.h"
#include "import/xdmf/xdmf_grid.h"

namespace isostrata {
namespace {

/// Of a structured topology, x first: the file has the slowest axis first.
std::array<int, 3> xdmf_dims(const XdmfElement& topology, std::size_t axes) {
  const std::string name = topology.file->filename().string();
  std::string said = topology.attribute("Dimensions");
  if (said.empty()) said = topology.attribute("NumberOfElements");
  std::vector<int> sizes;
  for (std::string_view rest = said;;) {
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t\r\n,"), rest.size()));
    if (rest.empty()) break;
    const std::string_view word = rest.substr(0, rest.find_first_of(" \t\r\n,"));
    const auto size = parsed_number<int>(word);
    if (!size || *size < 1) throw Error(ErrorCode::bad_data, name + ": a topology of Dimensions '" + said.substr(0, 100) + "'; expected whole numbers of at least 1");
    sizes.push_back(*size);
    rest.remove_prefix(word.size());
  }
  while (sizes.size() > axes && sizes.front() == 1) sizes.erase(sizes.begin());
  if (sizes.size() != axes) throw Error(ErrorCode::bad_data, name + ": a topology of Dimensions '" + said.substr(0, 100) + "'; expected " + std::to_string(axes) + " numbers");
  std::array<int, 3> dims{1, 1, 1};
  for (std::size_t a = 0; a < axes; ++a) dims[a] = sizes[axes - 1 - a];
  checked_product({dims[0], dims[1], dims[2]}, name);
  return dims;
}

std::vector<XdmfArray> xdmf_items(const XdmfElement& geometry, XdmfFile& file, XdmfValues& values, std::size_t expected, const std::string& type) {
  const std::vector<XdmfElement> items = file.children(geometry, "DataItem");
  if (items.size() != expected)
    throw Error(ErrorCode::bad_data, geometry.file->filename().string() + ": a geometry of type '" + type + "' has " + std::to_string(items.size()) + " DataItems; expected " + std::to_string(expected));
  std::vector<XdmfArray> out;
  for (const XdmfElement& item : items) out.push_back(values.read(item));
  return out;
}

/// Each place of `axes` numbers: those of one array together, or an array for each.
vtkSmartPointer<vtkPoints> xdmf_points(const XdmfElement& geometry, XdmfFile& file, XdmfValues& values, const ReadRequest& request, XdmfKept& keep) {
  const std::string name = geometry.file->filename().string();
  std::string type = geometry.word({"GeometryType", "Type"});
  if (type.empty()) type = "xyz";
  const bool apart = type == "x_y_z" || type == "x_y", flat = type == "xy" || type == "x_y";
  if (!apart && type != "xyz" && type != "xy") throw Error(ErrorCode::unsupported, name + ": a geometry of type '" + type + "' for points anywhere; expected XYZ, XY, X_Y_Z or X_Y");
  const std::size_t axes = flat ? 2 : 3;
  const std::vector<XdmfArray> parts = xdmf_items(geometry, file, values, apart ? axes : 1, type);
  const std::size_t numbers = parts.front().count(), count = apart ? numbers : numbers / axes;
  if ((!apart && numbers % axes != 0) || std::any_of(parts.begin(), parts.end(), [&](const XdmfArray& part) { return part.count() != numbers; }))
    throw Error(ErrorCode::bad_data, name + ": a geometry of type '" + type + "' of " + std::to_string(numbers) + " numbers" + (apart ? "; expected as many for each axis" : "; expected a multiple of " + std::to_string(axes)));
  const auto points = vtkSmartPointer<vtkPoints>::New();
  if (!apart && !flat) {
    points->SetData(vtk_array(parts.front(), 3, keep));
    return points;
  }
  check_bytes(request, 24 * static_cast<std::uint64_t>(count), name);
  vtkNew<vtkDoubleArray> data;
  data->SetNumberOfComponents(3);
  data->SetNumberOfTuples(static_cast<vtkIdType>(count));
  std::fill_n(data->GetPointer(0), 3 * count, 0.0);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const std::vector<double> from = parts[p].real();
    for (std::size_t i = 0; i < from.size(); ++i) data->GetPointer(0)[apart ? 3 * i + p : 3 * (i / axes) + i % axes] = from[i];
  }
  points->SetData(data);
  return points;
}

/// Origin and spacing, the slowest axis first as well.
vtkSmartPointer<vtkDataSet> xdmf_image(const std::array<int, 3>& dims, std::size_t axes, const XdmfElement& geometry, XdmfFile& file, XdmfValues& values) {
  const std::string name = geometry.file->filename().string(), type = geometry.word({"GeometryType", "Type"});
  if (!type.starts_with("origin_d")) throw Error(ErrorCode::unsupported, name + ": a geometry of type '" + type + "' for points at equal distances; expected ORIGIN_DXDYDZ or ORIGIN_DXDY");
  const std::vector<XdmfArray> parts = xdmf_items(geometry, file, values, 2, type);
  double place[2][3] = {{0, 0, 0}, {1, 1, 1}};
  for (std::size_t p = 0; p < 2; ++p) {
    const std::vector<double> numbers = parts[p].real();
    if (numbers.size() != axes && !(axes == 2 && numbers.size() == 3))
      throw Error(ErrorCode::bad_data, name + ": " + (p == 0 ? "an origin" : "a spacing") + " of " + std::to_string(numbers.size()) + " numbers; expected " + std::to_string(axes));
    for (std::size_t a = 0; a < numbers.size(); ++a) place[p][a] = numbers[numbers.size() - 1 - a];
    for (const double number : numbers)
      if (!std::isfinite(number)) throw Error(ErrorCode::bad_data, name + ": " + (p == 0 ? "an origin" : "a spacing") + " that is not a finite number");
  }
  const auto out = vtkSmartPointer<vtkImageData>::New();
  out->SetDimensions(dims.data());
  out->SetOrigin(place[0]);
  out->SetSpacing(place[1]);
  return out;
}

vtkSmartPointer<vtkDataSet> xdmf_rectilinear(const std::array<int, 3>& dims, std::size_t axes, const XdmfElement& geometry, XdmfFile& file, XdmfValues& values, XdmfKept& keep) {
  const std::string name = geometry.file->filename().string(), type = geometry.word({"GeometryType", "Type"});
  if (type.starts_with("origin_d")) return xdmf_image(dims, axes, geometry, file, values);
  if (type != "vxvyvz" && type != "vxvy") throw Error(ErrorCode::unsupported, name + ": a geometry of type '" + type + "' for axes of places; expected VXVYVZ or VXVY");
  const std::vector<XdmfArray> parts = xdmf_items(geometry, file, values, type == "vxvy" ? 2 : 3, type);
  const auto out = vtkSmartPointer<vtkRectilinearGrid>::New();
  out->SetDimensions(dims.data());
  vtkNew<vtkDoubleArray> zero;
  zero->InsertNextValue(0);
  out->SetZCoordinates(zero);
  for (std::size_t a = 0; a < parts.size(); ++a) {
    if (parts[a].count() != static_cast<std::size_t>(dims[a]))
      throw Error(ErrorCode::bad_data, name + ": axis " + "xyz"[a] + " has " + std::to_string(parts[a].count()) + " places; the topology says " + std::to_string(dims[a]));
    const auto array = vtk_array(parts[a], 1, keep);
    if (a == 0) out->SetXCoordinates(array);
    if (a == 1) out->SetYCoordinates(array);
    if (a == 2) out->SetZCoordinates(array);
  }
  return out;
}

}  // namespace

vtkSmartPointer<vtkDataArray> vtk_array(const XdmfArray& array, int components, XdmfKept& keep) {
  const auto out = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(vtk_type_of(array.type)));
  out->SetNumberOfComponents(components);
  keep.push_back(array.storage);
  if (!array.values.empty()) out->SetVoidArray(const_cast<std::byte*>(array.values.data()), static_cast<vtkIdType>(array.count()), 1);
  return out;
}

vtkSmartPointer<vtkDataSet> xdmf_grid(const XdmfElement& topology, const XdmfElement& geometry, XdmfFile& file, XdmfValues& values, const ReadRequest& request, XdmfKept& keep) {
  const std::string type = topology.word({"TopologyType", "Type"});
  const std::size_t axes = type.starts_with("2d") ? 2 : 3;
  const std::string shape = type.starts_with("2d") || type.starts_with("3d") ? type.substr(2) : "";
  if (shape == "corectmesh") return xdmf_image(xdmf_dims(topology, axes), axes, geometry, file, values);
  if (shape == "rectmesh") return xdmf_rectilinear(xdmf_dims(topology, axes), axes, geometry, file, values, keep);
  if (shape == "smesh") {
    const auto out = vtkSmartPointer<vtkStructuredGrid>::New();
    out->SetDimensions(xdmf_dims(topology, axes).data());
    out->SetPoints(xdmf_points(geometry, file, values, request, keep));
    return out;
  }
  const auto out = xdmf_cells(topology, file, values, request);
  out->SetPoints(xdmf_points(geometry, file, values, request, keep));
  return out;
}

}  // namespace isostrata
