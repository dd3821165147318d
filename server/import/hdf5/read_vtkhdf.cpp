#include <vtkDataArraySelection.h>
#include <vtkHDFReader.h>
#include <vtkImageData.h>
#include <vtkNew.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "import/imported/vtk_messages.h"
#include "import/vtk/read_vtk.h"
#include "import/vtk/vtk_pipeline.h"
#ifdef ISOSTRATA_READS_HDF5
#include "import/hdf5/hdf5_file.h"
#endif

namespace isostrata {
namespace {

#ifdef ISOSTRATA_READS_HDF5
constexpr std::string_view kCells = "VTKHDF/CellData/", kField = "VTKHDF/FieldData/";

/// The components of an array of so many cells; nothing if it does not have a value for each.
std::optional<int> components_of(const StoredArray& array, std::int64_t cells) {
  const std::size_t tuples = std::accumulate(array.shape.begin(), array.shape.end() - 1, std::size_t{1}, std::multiplies<>());
  if (array.values() == static_cast<std::size_t>(cells)) return 1;
  return tuples == static_cast<std::size_t>(cells) ? std::optional(static_cast<int>(array.shape.back())) : std::nullopt;
}

std::pair<std::shared_ptr<const void>, std::span<const std::byte>> all_of(const Hdf5File& file, const StoredArray& array) {
  auto [storage, bytes] = allocate<std::byte>(array.values() * size_of(array.type));
  file.read(array, std::vector<std::size_t>(array.shape.size()), array.shape, bytes);
  return {storage, bytes};
}

/// VTK 9.1 takes arrays on the cells of an image, and its time, for ones on its points, and reads nothing.
void add_rest_of_image(const ReadRequest& request, Imported& imported) {
  const std::string name = request.file.filename().string();
  const Hdf5File file(request.file);
  Block& block = imported.blocks.front();
  const std::int64_t cells = block.grid.cell_count();
  std::uint64_t bytes = 0;
  for (const StoredArray& array : file.arrays()) {
    if (array.name == std::string(kField) + "TimeValue" && array.values() == 1) {
      const auto [kept, value] = all_of(file, array);
      const double time = std::visit([](auto values) { return static_cast<double>(values.front()); }, scalar_span(array.type, value));
      if (std::isfinite(time)) imported.times = {time};
    }
    if (!array.name.starts_with(kCells)) continue;
    FileArray out;
    out.name = array.name.substr(kCells.size());
    const std::optional<int> components = components_of(array, cells);
    if (!components || out.name == "vtkGhostType") {
      imported.notes.push_back("array '" + out.name + "' skipped: this VTK does not read arrays on the cells of an image" + (components ? "" : ", and it has not a value for each of them"));
      continue;
    }
    check_bytes(request, bytes += array.values() * size_of(array.type), name);
    out.on_cells = true;
    out.components = *components;
    out.type = array.type;
    std::tie(out.storage, out.values) = all_of(file, array);
    block.arrays.push_back(std::move(out));
  }
}

Imported read_image_by_parts(const ReadRequest& request) {
  vtkNew<vtkHDFReader> reader;
  reader->SetFileName(request.file.c_str());
  reader->UpdateInformation();
  reader->GetCellDataArraySelection()->DisableAllArrays();
  reader->GetFieldDataArraySelection()->DisableAllArrays();
  Imported imported = run_reader(reader, request);
  if (imported.blocks.size() == 1) add_rest_of_image(request, imported);
  return imported;
}
#endif

}  // namespace

Imported read_vtkhdf(const ReadRequest& request) {
  vtkNew<vtkHDFReader> reader;
  if (!reader->CanReadFile(request.file.c_str()))
    throw Error(ErrorCode::bad_data, request.file.filename().string() + ": has no group VTKHDF of a version and a type that this VTK reads");
  reader->SetFileName(request.file.c_str());
#ifdef ISOSTRATA_READS_HDF5
  try {
    return run_reader(reader, request);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::bad_data || !vtkImageData::SafeDownCast(reader->GetOutputDataObject(0))) throw;
    take_vtk_errors("");
  }
  return read_image_by_parts(request);
#else
  return run_reader(reader, request);
#endif
}

}  // namespace isostrata
