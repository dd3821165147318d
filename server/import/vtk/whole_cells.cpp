#include "import/vtk/whole_cells.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkCellArray.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <string>
#include <utility>

#include "import/imported/appended_file.h"
#include "import/imported/for_parts.h"
#include "tables/cell_type.h"

namespace isostrata {
namespace {

using Wide = std::pair<std::span<const std::int64_t>, std::shared_ptr<const void>>;

Wide widened(std::span<const vtkTypeInt32> values, const ReadRequest& request, const std::string& name) {
  AppendedFile<std::int64_t> file(request, name);
  for_parts(ScalarType::int32, std::as_bytes(values), [&](std::span<const std::int64_t> part) {
    file.add(part);
    return true;
  });
  return file.finish();
}

template <class Array>
std::optional<KeptCells> keep(vtkCellArray* cells, std::span<const unsigned char> types, std::int64_t points, const ReadRequest& request, Array* offset_array, Array* id_array) {
  if (!offset_array || !id_array) return std::nullopt;
  using Number = typename Array::ValueType;
  const std::size_t count = types.size();
  const std::span<const Number> offsets(offset_array->GetPointer(0), count > 0 ? count + 1 : 0);
  for (std::size_t c = 0; c < count; ++c)
    if (!holds_volume(types[c]) || offsets[c + 1] - offsets[c] != kPointsOfType[types[c]]) return std::nullopt;
  const std::span<const Number> ids(id_array->GetPointer(0), count > 0 ? static_cast<std::size_t>(offsets[count]) : 0);
  if (!std::all_of(ids.begin(), ids.end(), [&](Number id) { return id >= 0 && id < points; })) return std::nullopt;
  KeptCells kept;
  kept.types.assign(types.begin(), types.end());
  if (count == 0) return kept;
  if constexpr (sizeof(Number) == sizeof(std::int64_t)) {
    kept.own_offsets = {reinterpret_cast<const std::int64_t*>(offsets.data()), offsets.size()};
    kept.own_connectivity = {reinterpret_cast<const std::int64_t*>(ids.data()), ids.size()};
    kept.owner = std::make_shared<vtkSmartPointer<vtkCellArray>>(cells);
  } else {
    auto of_offsets = widened(offsets, request, "offsets.bin"), of_ids = widened(ids, request, "connectivity.bin");
    kept.own_offsets = of_offsets.first;
    kept.own_connectivity = of_ids.first;
    kept.owner = std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(of_offsets.second, of_ids.second);
  }
  return kept;
}

}  // namespace

std::optional<KeptCells> keep_whole_cells(vtkCellArray* cells, vtkUnsignedCharArray* types, std::int64_t points, const ReadRequest& request) {
  vtkDataArray *const offsets = cells->GetOffsetsArray(), *const ids = cells->GetConnectivityArray();
  const std::span<const unsigned char> all(types->GetPointer(0), static_cast<std::size_t>(types->GetNumberOfValues()));
  using Of64 = vtkAOSDataArrayTemplate<vtkTypeInt64>;
  using Of32 = vtkAOSDataArrayTemplate<vtkTypeInt32>;
  if (auto* const of_64 = Of64::FastDownCast(offsets)) return keep(cells, all, points, request, of_64, Of64::FastDownCast(ids));
  return keep(cells, all, points, request, Of32::FastDownCast(offsets), Of32::FastDownCast(ids));
}

}  // namespace isostrata
