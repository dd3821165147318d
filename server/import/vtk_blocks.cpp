#include "import/vtk_blocks.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkAbstractArray.h>
#include <vtkBitArray.h>
#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkRectilinearGrid.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <cmath>
#include <cstring>
#include <optional>

#include "import/vtk_cells.h"

namespace isostrata {
namespace {

std::optional<ScalarType> scalar_type(int vtk_type) {
  switch (vtk_type) {
    case VTK_CHAR:
    case VTK_SIGNED_CHAR:
      return ScalarType::int8;
    case VTK_UNSIGNED_CHAR:
      return ScalarType::uint8;
    case VTK_SHORT:
      return ScalarType::int16;
    case VTK_UNSIGNED_SHORT:
      return ScalarType::uint16;
    case VTK_INT:
      return ScalarType::int32;
    case VTK_UNSIGNED_INT:
      return ScalarType::uint32;
    case VTK_LONG:
    case VTK_LONG_LONG:
    case VTK_ID_TYPE:
      return ScalarType::int64;
    case VTK_UNSIGNED_LONG:
    case VTK_UNSIGNED_LONG_LONG:
      return ScalarType::uint64;
    case VTK_FLOAT:
      return ScalarType::float32;
    case VTK_DOUBLE:
      return ScalarType::float64;
    default:
      return std::nullopt;
  }
}

/// Keeps the VTK array alive and shows its values; copies only what has another memory layout.
FileArray shared_array(vtkDataArray* array) {
  FileArray out;
  vtkSmartPointer<vtkDataArray> owner = array;
  if (vtkBitArray* bits = vtkBitArray::SafeDownCast(array)) {
    const auto n = static_cast<std::size_t>(bits->GetNumberOfValues());
    auto [storage, values] = allocate<std::uint8_t>(n);
    for (std::size_t i = 0; i < n; ++i) values[i] = bits->GetValue(static_cast<vtkIdType>(i)) ? 1 : 0;
    out.type = ScalarType::uint8;
    out.values = std::as_bytes(values);
    out.storage = storage;
  } else {
    out.type = *scalar_type(array->GetDataType());
    if (!array->HasStandardMemoryLayout()) {
      owner = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(array->GetDataType()));
      owner->DeepCopy(array);
    }
    const std::size_t bytes = static_cast<std::size_t>(owner->GetNumberOfValues()) * size_of(out.type);
    out.values = {static_cast<const std::byte*>(bytes ? owner->GetVoidPointer(0) : nullptr), bytes};
    out.storage = std::make_shared<vtkSmartPointer<vtkDataArray>>(owner);
  }
  out.components = array->GetNumberOfComponents();
  return out;
}

/// Only the tuples of the cells that were kept.
FileArray gathered(const FileArray& all, const std::vector<std::int64_t>& source) {
  FileArray out = all;
  const std::size_t tuple = size_of(all.type) * static_cast<std::size_t>(all.components);
  auto [storage, bytes] = allocate<std::byte>(tuple * source.size());
  for (std::size_t c = 0; c < source.size(); ++c)
    std::memcpy(bytes.data() + c * tuple, all.values.data() + static_cast<std::size_t>(source[c]) * tuple, tuple);
  out.values = bytes;
  out.storage = storage;
  return out;
}

void add_arrays(vtkDataSetAttributes* attributes, bool on_cells, vtkIdType tuples, const std::vector<std::int64_t>& source,
                Block& block, const std::string& name, std::vector<std::string>& notes) {
  for (int i = 0; i < attributes->GetNumberOfArrays(); ++i) {
    vtkAbstractArray* abstract = attributes->GetAbstractArray(i);
    if (!abstract) continue;
    const std::string array_name =
        abstract->GetName() && *abstract->GetName() ? abstract->GetName() : "array " + std::to_string(i);
    if (array_name == vtkDataSetAttributes::GhostArrayName()) continue;  // hidden_cells has it
    vtkDataArray* array = vtkDataArray::SafeDownCast(abstract);
    if (!array || (array->GetDataType() != VTK_BIT && !scalar_type(array->GetDataType()))) {
      notes.push_back("array '" + array_name + "' skipped: it holds " + abstract->GetDataTypeAsString() + ", not numbers");
      continue;
    }
    if (array->GetNumberOfTuples() != tuples || array->GetNumberOfComponents() < 1)
      throw Error(ErrorCode::bad_data, name + ": array '" + array_name + "' has " + std::to_string(array->GetNumberOfTuples()) +
                                           " tuples; expected " + std::to_string(tuples));
    FileArray shared = shared_array(array);
    if (!source.empty()) shared = gathered(shared, source);
    shared.name = array_name;
    shared.on_cells = on_cells;
    block.arrays.push_back(std::move(shared));
  }
}

/// vtkGhostType: duplicated, refined and hidden cells are not part of the volume, nor are cells that use a hidden point.
void add_hidden_cells(vtkDataSet* data, const std::vector<std::int64_t>& source, Block& block) {
  constexpr unsigned kCell =
      vtkDataSetAttributes::DUPLICATECELL | vtkDataSetAttributes::REFINEDCELL | vtkDataSetAttributes::HIDDENCELL;
  constexpr unsigned kPoint = vtkDataSetAttributes::HIDDENPOINT;
  auto* cell_ghosts =
      vtkUnsignedCharArray::SafeDownCast(data->GetCellData()->GetAbstractArray(vtkDataSetAttributes::GhostArrayName()));
  auto* point_ghosts =
      vtkUnsignedCharArray::SafeDownCast(data->GetPointData()->GetAbstractArray(vtkDataSetAttributes::GhostArrayName()));
  const std::int64_t cells = block.grid.cell_count();
  const vtkIdType file_cells = source.empty() ? cells : data->GetNumberOfCells();
  if (cell_ghosts && cell_ghosts->GetNumberOfValues() != file_cells) cell_ghosts = nullptr;
  if (point_ghosts && point_ghosts->GetNumberOfValues() != block.grid.point_count()) point_ghosts = nullptr;
  if (!cell_ghosts && !point_ghosts) return;

  auto [storage, hidden] = allocate<std::uint8_t>(static_cast<std::size_t>(cells));
  bool any = false;
  std::array<std::int64_t, kMaxCellVertices> ids{};
  for (std::int64_t c = 0; c < cells; ++c) {
    const std::int64_t in_file = source.empty() ? c : source[static_cast<std::size_t>(c)];
    bool hide = cell_ghosts && (cell_ghosts->GetValue(in_file) & kCell);
    if (point_ghosts && !hide) {
      const int n = block.grid.cell_points(c, ids);
      for (int v = 0; v < n; ++v) hide = hide || (point_ghosts->GetValue(ids[static_cast<std::size_t>(v)]) & kPoint);
    }
    hidden[static_cast<std::size_t>(c)] = hide;
    any = any || hide;
  }
  if (!any) return;
  block.grid.hidden_cells = hidden;
  block.grid.storage =
      std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(block.grid.storage, storage);
}

/// Positions in single or double precision; other types become double.
std::pair<PointSpan, std::shared_ptr<const void>> shared_points(vtkPoints* points) {
  if (!points || points->GetNumberOfPoints() == 0) return {std::span<const Vec3f>(), nullptr};
  vtkSmartPointer<vtkDataArray> data = points->GetData();
  const bool single = data->GetDataType() == VTK_FLOAT;
  if ((!single && data->GetDataType() != VTK_DOUBLE) || !data->HasStandardMemoryLayout()) {
    auto copy = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(single ? VTK_FLOAT : VTK_DOUBLE));
    copy->DeepCopy(data);
    data = copy;
  }
  const auto n = static_cast<std::size_t>(data->GetNumberOfTuples());
  auto owner = std::make_shared<vtkSmartPointer<vtkDataArray>>(data);
  if (single) return {std::span<const Vec3f>(static_cast<const Vec3f*>(data->GetVoidPointer(0)), n), owner};
  return {std::span<const Vec3d>(static_cast<const Vec3d*>(data->GetVoidPointer(0)), n), owner};
}

std::array<std::int64_t, 3> checked_dims(const int (&d)[3], const std::string& name) {
  checked_product({d[0], d[1], d[2]}, name);
  return {d[0], d[1], d[2]};
}

void set_image(vtkImageData* image, Block& block, const std::string& name) {
  int d[3];
  image->GetDimensions(d);
  const auto dims = checked_dims(d, name);
  const int* extent = image->GetExtent();
  const double* spacing = image->GetSpacing();
  vtkMatrix3x3* direction = image->GetDirectionMatrix();
  if (!direction || direction->IsIdentity()) {
    UniformGrid grid;
    grid.dims = dims;
    for (int a = 0; a < 3; ++a) {
      grid.spacing[a] = spacing[a];
      grid.origin[a] = image->GetOrigin()[a] + extent[2 * a] * spacing[a];
    }
    block.grid.shape = grid;
    return;
  }
  const auto n = static_cast<std::size_t>(checked_product({dims[0], dims[1], dims[2]}, name));
  auto [storage, points] = allocate<Vec3d>(n);
  std::size_t at = 0;
  for (int k = 0; k < d[2]; ++k)
    for (int j = 0; j < d[1]; ++j)
      for (int i = 0; i < d[0]; ++i) {
        double p[3];
        image->TransformIndexToPhysicalPoint(extent[0] + i, extent[2] + j, extent[4] + k, p);
        points[at++] = {p[0], p[1], p[2]};
      }
  block.grid.shape = CurvilinearGrid{dims, std::span<const Vec3d>(points)};
  block.grid.storage = storage;
}

void set_rectilinear(vtkRectilinearGrid* source, Block& block, const std::string& name) {
  int d[3];
  source->GetDimensions(d);
  RectilinearGrid grid;
  grid.dims = checked_dims(d, name);
  vtkDataArray* const axes[3] = {source->GetXCoordinates(), source->GetYCoordinates(), source->GetZCoordinates()};
  bool monotone = true;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto n = static_cast<std::size_t>(d[a]);
    if (!axes[a] || axes[a]->GetNumberOfTuples() < d[a])
      throw Error(ErrorCode::bad_data, name + ": axis " + "xyz"[a] + " has " +
                                           std::to_string(axes[a] ? axes[a]->GetNumberOfTuples() : 0) +
                                           " coordinates; expected " + std::to_string(d[a]));
    grid.axes[a].resize(n);
    for (std::size_t i = 0; i < n; ++i) grid.axes[a][i] = axes[a]->GetComponent(static_cast<vtkIdType>(i), 0);
    for (std::size_t i = 1; i < n; ++i)
      monotone = monotone && (grid.axes[a][1] > grid.axes[a][0] ? grid.axes[a][i] > grid.axes[a][i - 1]
                                                                : grid.axes[a][i] < grid.axes[a][i - 1]);
  }
  if (monotone) {
    block.grid.shape = std::move(grid);
    return;
  }
  auto [storage, points] = allocate<Vec3d>(static_cast<std::size_t>(checked_product({d[0], d[1], d[2]}, name)));
  std::size_t at = 0;
  for (const double z : grid.axes[2])
    for (const double y : grid.axes[1])
      for (const double x : grid.axes[0]) points[at++] = {x, y, z};
  block.grid.shape = CurvilinearGrid{grid.dims, std::span<const Vec3d>(points)};
  block.grid.storage = storage;
}

void append_dataset(vtkDataSet* data, const ReadRequest& request, std::vector<Block>& blocks, std::vector<std::string>& notes) {
  const std::string name = request.file.filename().string();
  Block block;
  std::vector<std::int64_t> source;
  if (auto* image = vtkImageData::SafeDownCast(data)) {
    set_image(image, block, name);
  } else if (auto* rectilinear = vtkRectilinearGrid::SafeDownCast(data)) {
    set_rectilinear(rectilinear, block, name);
  } else if (auto* structured = vtkStructuredGrid::SafeDownCast(data)) {
    int d[3];
    structured->GetDimensions(d);
    auto [points, owner] = shared_points(structured->GetPoints());
    const std::int64_t expected = checked_product({d[0], d[1], d[2]}, name);
    const std::int64_t present = structured->GetPoints() ? structured->GetPoints()->GetNumberOfPoints() : 0;
    if (present != expected)
      throw Error(ErrorCode::bad_data, name + ": " + std::to_string(d[0]) + "x" + std::to_string(d[1]) + "x" +
                                           std::to_string(d[2]) + " points declared, " + std::to_string(present) + " present");
    block.grid.shape = CurvilinearGrid{{d[0], d[1], d[2]}, points};
    block.grid.storage = owner;
  } else if (auto* unstructured = vtkUnstructuredGrid::SafeDownCast(data)) {
    auto cells = std::make_shared<KeptCells>(keep_cells(unstructured, name, notes));
    auto [points, owner] = shared_points(unstructured->GetPoints());
    source = cells->source;
    block.grid.shape = UnstructuredGrid{points, cells->types, cells->offsets, cells->connectivity};
    block.grid.storage = std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(owner, cells);
  } else {
    throw Error(ErrorCode::unsupported, name + ": holds a " + data->GetClassName() + "; expected a grid with 3-D cells");
  }
  add_hidden_cells(data, source, block);
  add_arrays(data->GetPointData(), false, block.grid.point_count(), {}, block, name, notes);
  if (block.grid.cell_count() > 0)
    add_arrays(data->GetCellData(), true, source.empty() ? block.grid.cell_count() : data->GetNumberOfCells(), source, block,
               name, notes);
  else if (data->GetCellData()->GetNumberOfArrays() > 0)
    notes.push_back(std::to_string(data->GetCellData()->GetNumberOfArrays()) + " cell arrays skipped: there are no 3-D cells");
  blocks.push_back(std::move(block));
}

}  // namespace

void append_vtk_blocks(vtkDataObject* object, const ReadRequest& request, std::vector<Block>& blocks,
                       std::vector<std::string>& notes) {
  const std::string name = request.file.filename().string();
  if (auto* composite = vtkCompositeDataSet::SafeDownCast(object)) {
    auto at = vtkSmartPointer<vtkCompositeDataIterator>::Take(composite->NewIterator());
    at->SkipEmptyNodesOn();
    for (at->InitTraversal(); !at->IsDoneWithTraversal(); at->GoToNextItem()) {
      auto* leaf = vtkDataSet::SafeDownCast(at->GetCurrentDataObject());
      if (leaf && leaf->GetNumberOfPoints() > 0) append_dataset(leaf, request, blocks, notes);
    }
  } else if (auto* data = vtkDataSet::SafeDownCast(object)) {
    append_dataset(data, request, blocks, notes);
  } else {
    throw Error(ErrorCode::unsupported,
                name + ": holds a " + (object ? object->GetClassName() : "nothing") + "; expected a grid with 3-D cells");
  }
  if (blocks.empty()) throw Error(ErrorCode::bad_data, name + ": holds no points");
}

}  // namespace isostrata
