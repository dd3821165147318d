#include "import/vtk/vtk_blocks.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkAbstractArray.h>
#include <vtkBitArray.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCompositeDataIterator.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkIdList.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkRectilinearGrid.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredGrid.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <optional>
#include <tuple>
#include <type_traits>

#include "data/parts/partition.h"
#include "import/vtk/vtk_cells.h"

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
  if (const char* unit = array->HasInformation() ? array->GetInformation()->Get(vtkDataArray::UNITS_LABEL()) : nullptr) out.unit = unit;
  return out;
}

/// Values for the points that splitting cells added, after the file's.
FileArray with_added_points(const FileArray& all, const AddedPoints& added) {
  FileArray out = all;
  const auto components = static_cast<std::size_t>(all.components);
  const std::size_t before = all.values.size();
  auto [storage, bytes] = allocate<std::byte>(before + added.size() * components * size_of(all.type));
  if (before > 0) std::memcpy(bytes.data(), all.values.data(), before);
  std::visit(
      [&](auto values) {
        using T = typename decltype(values)::value_type;
        T* to = reinterpret_cast<T*>(bytes.data() + before);
        for (std::size_t i = 0; i < added.size(); ++i)
          for (std::size_t c = 0; c < components; ++c) {
            double sum = 0;
            for (std::size_t k = added.first[i]; k < added.first[i + 1]; ++k)
              sum += added.weights[k] * static_cast<double>(values[static_cast<std::size_t>(added.points[k]) * components + c]);
            if constexpr (std::is_integral_v<T>) {
              // The largest double below 2^63 or 2^64 is the most that may be converted.
              constexpr double kMost = static_cast<double>(std::numeric_limits<T>::max());
              const double most = sizeof(T) == 8 ? std::nextafter(kMost, 0.0) : kMost;
              sum = std::clamp(std::round(sum), static_cast<double>(std::numeric_limits<T>::lowest()), most);
            }
            *to++ = static_cast<T>(sum);
          }
      },
      scalar_span(all.type, all.values));
  out.values = bytes;
  out.storage = storage;
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

/// Where a dataset's arrays go.
struct Destination {
  Block& block;
  const AddedPoints& added;
  const std::string& name;
  std::vector<std::string>& notes;
};

void add_arrays(vtkDataSetAttributes* attributes, bool on_cells, vtkIdType tuples, const Destination& to) {
  const auto& [block, added, name, notes] = to;
  for (int i = 0; i < attributes->GetNumberOfArrays(); ++i) {
    vtkAbstractArray* abstract = attributes->GetAbstractArray(i);
    if (!abstract) continue;
    const std::string array_name = name_or_place(abstract->GetName() ? abstract->GetName() : "", block.arrays.size() + 1);
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
    if (!on_cells && array_name == kGlobalPoints && attributes->GetGlobalIds() == array && shared.type == ScalarType::int64 && shared.components == 1) {
      if (added.size() == 0) block.global_points = std::move(shared);
      continue;
    }
    if (on_cells && !block.source.empty()) shared = gathered(shared, block.source);
    if (!on_cells && added.size() > 0) shared = with_added_points(shared, added);
    shared.name = array_name;
    shared.on_cells = on_cells;
    block.arrays.push_back(std::move(shared));
  }
}

/// vtkGhostType of cells or points, whatever integers it is written in; nothing if there is none.
vtkDataArray* ghosts(vtkDataSetAttributes* attributes, vtkIdType expected, const char* of, const std::string& name) {
  vtkDataArray* array = vtkDataArray::SafeDownCast(attributes->GetAbstractArray(vtkDataSetAttributes::GhostArrayName()));
  if (array && array->GetNumberOfValues() != expected)
    throw Error(ErrorCode::bad_data, name + ": vtkGhostType has " + std::to_string(array->GetNumberOfValues()) + " values for " +
                                         std::to_string(expected) + " " + of);
  return array;
}

bool is_set(vtkDataArray* ghosts, std::int64_t at, unsigned bits) {
  return ghosts && (static_cast<std::int64_t>(ghosts->GetComponent(at, 0)) & bits) != 0;
}

/// vtkGhostType: refined and hidden cells are not part of the volume, nor are duplicated ones, whose originals are in another
/// piece (kGhostCell), nor cells that use a hidden point. Duplicated points belong to cells as any others do. Where the pieces of a structured
/// grid were put together, each cell is there once and `each_cell_once` says so: then the marks of duplicates, which overlapping
/// pieces leave at their seams, mean nothing.
void add_hidden_cells(vtkDataSet* data, bool each_cell_once, Block& block, const std::string& name) {
  const std::int64_t cells = block.grid.cell_count();
  const bool all_kept = block.source.empty();
  const vtkIdType file_cells = all_kept ? cells : data->GetNumberOfCells();
  if (file_cells == 0) return;
  vtkDataArray* cell_ghosts = ghosts(data->GetCellData(), file_cells, "cells", name);
  vtkDataArray* point_ghosts = ghosts(data->GetPointData(), data->GetNumberOfPoints(), "points", name);
  if (!cell_ghosts && !point_ghosts) return;

  const unsigned cell_bits = vtkDataSetAttributes::REFINEDCELL | vtkDataSetAttributes::HIDDENCELL;
  const unsigned ghost_bits = each_cell_once ? 0u : static_cast<unsigned>(vtkDataSetAttributes::DUPLICATECELL);
  auto* unstructured = vtkUnstructuredGrid::SafeDownCast(data);
  vtkNew<vtkIdList> points;
  std::array<std::int64_t, kMaxCellVertices> ids{};
  const auto uses_hidden_point = [&](std::int64_t cell, std::int64_t in_file) {
    if (!point_ghosts) return false;
    if (unstructured) {  // of all points of the cell in the file: those that its pieces do not have, too
      unstructured->GetCells()->GetCellAtId(in_file, points);
      for (vtkIdType v = 0; v < points->GetNumberOfIds(); ++v)
        if (const vtkIdType id = points->GetId(v);
            id >= 0 && id < data->GetNumberOfPoints() && is_set(point_ghosts, id, vtkDataSetAttributes::HIDDENPOINT))
          return true;
      return false;
    }
    const int n = block.grid.cell_points(cell, ids);
    return std::any_of(ids.begin(), ids.begin() + n,
                       [&](std::int64_t id) { return is_set(point_ghosts, id, vtkDataSetAttributes::HIDDENPOINT); });
  };
  auto [storage, hidden] = allocate<std::uint8_t>(static_cast<std::size_t>(cells));
  bool any = false;
  for (std::int64_t c = 0; c < cells; ++c) {
    const std::int64_t in_file = all_kept ? c : block.source[static_cast<std::size_t>(c)];
    const bool hide = is_set(cell_ghosts, in_file, cell_bits) || uses_hidden_point(c, in_file);
    const std::uint8_t how = hide ? 1 : is_set(cell_ghosts, in_file, ghost_bits) ? kGhostCell : 0;
    hidden[static_cast<std::size_t>(c)] = how;
    any = any || how != 0;
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

/// The file's points and those that were added, in the file's precision.
std::pair<PointSpan, std::shared_ptr<const void>> with_added_points(const PointSpan& points, const AddedPoints& added) {
  return std::visit(
      [&](auto span) -> std::pair<PointSpan, std::shared_ptr<const void>> {
        using V = std::remove_const_t<typename decltype(span)::element_type>;
        using T = decltype(V::x);
        auto [storage, all] = allocate<V>(span.size() + added.size());
        V* to = std::copy(span.begin(), span.end(), all.data());
        for (const Vec3d& at : added.positions) *to++ = {static_cast<T>(at.x), static_cast<T>(at.y), static_cast<T>(at.z)};
        return {std::span<const V>(all), storage};
      },
      points);
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
      grid.spacing[a] = d[a] == 1 && spacing[a] == 0 ? 1 : spacing[a];  // of one slice it has no meaning
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

void append_dataset(vtkDataSet* data, const ReadRequest& request, bool joined_pieces, std::vector<Block>& blocks,
                    std::vector<std::string>& notes) {
  const std::string name = request.file.filename().string();
  Block block;
  AddedPoints added;
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
    auto cells = std::make_shared<KeptCells>(keep_cells(unstructured, request, notes));
    auto [points, owner] = shared_points(unstructured->GetPoints());
    block.source = std::move(cells->source);
    added = std::move(cells->added);
    block.added_points = static_cast<std::int64_t>(added.size());
    if (added.size() > 0) std::tie(points, owner) = with_added_points(PointSpan(points), added);
    block.grid.shape = UnstructuredGrid{points, cells->types, cells->owner ? cells->own_offsets : cells->offsets,
                                        cells->owner ? cells->own_connectivity : cells->connectivity};
    block.grid.storage = std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(owner, cells);
  } else {
    throw Error(ErrorCode::unsupported, name + ": holds a " + data->GetClassName() + "; expected a grid with 3-D cells");
  }
  add_hidden_cells(data, joined_pieces && block.grid.structured(), block, name);
  const Destination to{block, added, name, notes};
  add_arrays(data->GetPointData(), false, block.grid.point_count() - block.added_points, to);
  if (block.grid.cell_count() > 0)
    add_arrays(data->GetCellData(), true, block.source.empty() ? block.grid.cell_count() : data->GetNumberOfCells(), to);
  else if (data->GetCellData()->GetNumberOfArrays() > 0)
    notes.push_back(std::to_string(data->GetCellData()->GetNumberOfArrays()) + " cell arrays skipped: there are no cells with a volume or an area");
  blocks.push_back(std::move(block));
}

}  // namespace

void append_vtk_blocks(vtkDataObject* object, const ReadRequest& request, bool joined_pieces, std::vector<Block>& blocks,
                       std::vector<std::string>& notes) {
  const std::string name = request.file.filename().string();
  if (auto* composite = vtkCompositeDataSet::SafeDownCast(object)) {
    auto at = vtkSmartPointer<vtkCompositeDataIterator>::Take(composite->NewIterator());
    at->SkipEmptyNodesOn();
    int surfaces = 0;
    for (at->InitTraversal(); !at->IsDoneWithTraversal(); at->GoToNextItem()) {
      auto* leaf = vtkDataSet::SafeDownCast(at->GetCurrentDataObject());
      if (!leaf || leaf->GetNumberOfPoints() == 0) continue;
      if (vtkPolyData::SafeDownCast(leaf)) {
        ++surfaces;
        continue;
      }
      append_dataset(leaf, request, joined_pieces, blocks, notes);
      const char* called = at->HasCurrentMetaData() ? at->GetCurrentMetaData()->Get(vtkCompositeDataSet::NAME()) : nullptr;
      if (called && std::strncmp(called, "Unnamed", 7) != 0) blocks.back().name = called;
    }
    if (surfaces > 0 && !blocks.empty()) notes.push_back(std::to_string(surfaces) + " surfaces skipped: other blocks have grids");
    if (surfaces > 0 && blocks.empty()) throw Error(ErrorCode::unsupported, name + ": holds surfaces alone; expected a grid with 3-D cells");
  } else if (auto* data = vtkDataSet::SafeDownCast(object)) {
    append_dataset(data, request, joined_pieces, blocks, notes);
  } else {
    throw Error(ErrorCode::unsupported,
                name + ": holds a " + (object ? object->GetClassName() : "nothing") + "; expected a grid with 3-D cells");
  }
  if (blocks.empty()) throw Error(ErrorCode::bad_data, name + ": holds no points");
}

}  // namespace isostrata
