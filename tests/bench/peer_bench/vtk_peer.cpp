#include "vtk_peer.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkDataSetTriangleFilter.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkRectilinearGrid.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredGrid.h>
#include <vtkTableBasedClipDataSet.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <cmath>

namespace isostrata::peers {
namespace {

/// A VTK array over memory that stays ours. VTK's interface is not const; none of the filters here writes to its input.
template <class T>
vtkSmartPointer<vtkAOSDataArrayTemplate<T>> borrow(const T* data, std::size_t count, int components) {
  auto array = vtkSmartPointer<vtkAOSDataArrayTemplate<T>>::Take(
      vtkAOSDataArrayTemplate<T>::FastDownCast(vtkDataArray::CreateDataArray(vtkTypeTraits<T>::VTKTypeID())));
  array->SetNumberOfComponents(components);
  array->SetArray(const_cast<T*>(data), static_cast<vtkIdType>(count), 1);
  return array;
}

vtkSmartPointer<vtkPoints> borrow_points(const PointSpan& points) {
  auto out = vtkSmartPointer<vtkPoints>::New();
  std::visit(
      [&](auto span) {
        using Coordinate = std::remove_const_t<std::remove_reference_t<decltype(span[0].x)>>;
        static_assert(sizeof(span[0]) == 3 * sizeof(Coordinate));
        out->SetData(borrow<Coordinate>(&span.data()->x, span.size() * 3, 3));
      },
      points);
  return out;
}

vtkSmartPointer<vtkDataSet> borrow_grid(const UniformGrid& grid) {
  auto out = vtkSmartPointer<vtkImageData>::New();
  out->SetDimensions(static_cast<int>(grid.dims[0]), static_cast<int>(grid.dims[1]), static_cast<int>(grid.dims[2]));
  out->SetOrigin(grid.origin.x, grid.origin.y, grid.origin.z);
  out->SetSpacing(grid.spacing.x, grid.spacing.y, grid.spacing.z);
  return out;
}

vtkSmartPointer<vtkDataSet> borrow_grid(const RectilinearGrid& grid) {
  auto out = vtkSmartPointer<vtkRectilinearGrid>::New();
  out->SetDimensions(static_cast<int>(grid.dims[0]), static_cast<int>(grid.dims[1]), static_cast<int>(grid.dims[2]));
  const auto axis = [&](int a) { return borrow<double>(grid.axes[a].data(), grid.axes[a].size(), 1); };
  out->SetXCoordinates(axis(0));
  out->SetYCoordinates(axis(1));
  out->SetZCoordinates(axis(2));
  return out;
}

vtkSmartPointer<vtkDataSet> borrow_grid(const CurvilinearGrid& grid) {
  auto out = vtkSmartPointer<vtkStructuredGrid>::New();
  out->SetDimensions(static_cast<int>(grid.dims[0]), static_cast<int>(grid.dims[1]), static_cast<int>(grid.dims[2]));
  out->SetPoints(borrow_points(grid.points));
  return out;
}

vtkSmartPointer<vtkDataSet> borrow_grid(const UnstructuredGrid& grid) {
  auto out = vtkSmartPointer<vtkUnstructuredGrid>::New();
  out->SetPoints(borrow_points(grid.points));
  const auto ids = [](std::span<const std::int64_t> values) {
    vtkNew<vtkTypeInt64Array> array;
    array->SetArray(reinterpret_cast<vtkTypeInt64*>(const_cast<std::int64_t*>(values.data())),
                    static_cast<vtkIdType>(values.size()), 1);
    return vtkSmartPointer<vtkTypeInt64Array>(array);
  };
  vtkNew<vtkCellArray> cells;
  cells->SetData(ids(grid.offsets), ids(grid.connectivity));
  vtkNew<vtkUnsignedCharArray> types;
  types->SetArray(const_cast<std::uint8_t*>(grid.types.data()), static_cast<vtkIdType>(grid.types.size()), 1);
  out->SetCells(types, cells);
  return out;
}

}  // namespace

struct VtkPeer::Pipeline {
  std::string array;
  Interval interval;
  std::shared_ptr<const Dataset> owner;
  vtkSmartPointer<vtkDataSet> input;
  vtkSmartPointer<vtkUnstructuredGrid> result;
};

VtkPeer::VtkPeer(const Workload& workload) : pipeline_(std::make_unique<Pipeline>()) {
  if (!workload.dataset->grid.hidden_cells.empty())
    throw Error(ErrorCode::unsupported, workload.dataset->name + ": has hidden cells, which the peer's clip does not leave out");
  pipeline_->array = workload.array;
  pipeline_->interval = workload.interval;
  pipeline_->owner = workload.dataset;
  pipeline_->input = std::visit([](const auto& shape) { return borrow_grid(shape); }, workload.dataset->grid.shape);
  std::visit(
      [&](auto values) {
        using T = std::remove_const_t<typename decltype(values)::element_type>;
        const auto array = borrow<T>(values.data(), values.size(), 1);
        array->SetName(workload.array.c_str());
        pipeline_->input->GetPointData()->SetScalars(array);
      },
      workload.values().values);
}

VtkPeer::~VtkPeer() = default;

void VtkPeer::clip_twice() {
  vtkNew<vtkTableBasedClipDataSet> lower, upper;
  lower->SetInputData(pipeline_->input);
  lower->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, pipeline_->array.c_str());
  lower->SetValue(pipeline_->interval.lower);
  upper->SetInputConnection(lower->GetOutputPort());
  upper->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, pipeline_->array.c_str());
  upper->SetValue(pipeline_->interval.upper);
  upper->InsideOutOn();
  upper->Update();
  pipeline_->result = upper->GetOutput();
}

void VtkPeer::tetrahedralise() {
  vtkNew<vtkDataSetTriangleFilter> split;
  split->SetInputData(pipeline_->result);
  split->Update();
  pipeline_->result = split->GetOutput();
}

std::int64_t VtkPeer::cells() const { return pipeline_->result->GetNumberOfCells(); }

std::int64_t VtkPeer::not_tetrahedra() const {
  std::int64_t others = 0;
  for (vtkIdType cell = 0; cell < pipeline_->result->GetNumberOfCells(); ++cell)
    others += pipeline_->result->GetCellType(cell) != VTK_TETRA;
  return others;
}

double VtkPeer::volume() const {
  double sum = 0;
  vtkPoints* const points = pipeline_->result->GetPoints();
  for (vtkIdType cell = 0; cell < pipeline_->result->GetNumberOfCells(); ++cell) {
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    pipeline_->result->GetCellPoints(cell, count, ids);
    if (pipeline_->result->GetCellType(cell) != VTK_TETRA) continue;
    Vec3d p[4];
    for (int v = 0; v < 4; ++v) points->GetPoint(ids[v], &p[v].x);
    sum += std::abs(dot(p[1] - p[0], cross(p[2] - p[0], p[3] - p[0]))) / 6;
  }
  return sum;
}

void VtkPeer::forget() { pipeline_->result = nullptr; }

}  // namespace isostrata::peers
