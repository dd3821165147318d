#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNIFTIImageHeader.h>
#include <vtkNIFTIImageReader.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "data/files/nifti_mark.h"
#include "data/files/recognise.h"
#include "import/imported/place_image.h"
#include "import/imported/vtk_messages.h"
#include "import/vtk/read_vtk.h"
#include "import/vtk/vtk_pipeline.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

/// Components [first, first + count) of each tuple, as the scaled numbers of the file where it scales them.
FileArray part_of(const FileArray& all, std::size_t first, std::size_t count, double slope, double intercept) {
  FileArray out = all;
  const auto of = static_cast<std::size_t>(all.components);
  const bool scaled = slope != 0 && (slope != 1 || intercept != 0);
  if (!scaled && count == of) return out;
  out.components = static_cast<int>(count);
  std::visit(
      [&](auto values) {
        using T = typename decltype(values)::value_type;
        const std::size_t tuples = values.size() / of;
        const auto fill = [&]<class Out>(Out) {
          auto [storage, to] = allocate<Out>(tuples * count);
          for (std::size_t p = 0; p < tuples; ++p)
            for (std::size_t c = 0; c < count; ++c) {
              const T value = values[p * of + first + c];
              to[p * count + c] = scaled ? static_cast<Out>(static_cast<double>(value) * slope + intercept) : static_cast<Out>(value);
            }
          out.values = std::as_bytes(to);
          out.storage = storage;
        };
        if (!scaled)
          fill(std::remove_const_t<T>{});
        else if (sizeof(T) <= 4)
          fill(float{});
        else
          fill(double{});
      },
      scalar_span(all.type, all.values));
  if (scaled) out.type = size_of(all.type) <= 4 ? ScalarType::float32 : ScalarType::float64;
  return out;
}

/// VTK's reader takes a header without these letters for that of a pair of files, and looks for the other one by a name that it does not have.
void check_magic(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  if (!name.ends_with(".nii") && !name.ends_with(".nii.gz")) return;
  std::array<char, 348> header{};
  const gzFile file = gzopen(request.file.c_str(), "rb");
  const int size = file ? gzread(file, header.data(), header.size()) : 0;
  if (file) gzclose(file);
  const std::string_view bytes(header.data(), header.size());
  if (size < 348 || !(bytes.substr(344, 3) == "n+1" || bytes.substr(4, 3) == "n+2"))
    throw Error(ErrorCode::bad_data, name + ": expected the letters n+1 or n+2 in its header, as one file of NIfTI has them");
}

/// Where there is no slope, some write NaN: nothing is scaled by it, as by 0.
double finite_or_0(double value) { return std::isfinite(value) ? value : 0; }

/// The file that VTK's reader is given: of a pair the header, whichever was named.
fs::path header_file(const fs::path& file) {
  std::error_code error;
  const fs::path other = other_of_nifti_pair(file);
  if (other.empty()) return file;
  const bool values = small_letters(file.extension().string()) == ".img";
  if (!values && !fs::is_regular_file(other, error))
    throw Error(ErrorCode::not_found, file.filename().string() + ": the header of a pair of NIfTI files; expected " + other.filename().string() + " with its values beside it");
  return values ? other : file;
}

/// Of a pair, which VTK's reader takes for whole if the values are short.
void check_values(const fs::path& header, vtkNIFTIImageReader& reader) {
  const fs::path values = other_of_nifti_pair(header);
  const vtkNIFTIImageHeader* const of = reader.GetNIFTIHeader();
  if (values.empty() || !of) return;
  auto* const facts = const_cast<vtkNIFTIImageHeader*>(of);
  std::int64_t points = 1;
  for (int d = 1; d <= std::min<std::int64_t>(facts->GetDim(0), 7); ++d) points = checked_product({points, std::max<std::int64_t>(facts->GetDim(d), 1)}, header.filename().string());
  const std::uint64_t bytes = static_cast<std::uint64_t>(checked_product({points, facts->GetBitPix()}, header.filename().string())) / 8, present = fs::file_size(values);
  if (bytes > present)
    throw Error(ErrorCode::bad_data, values.filename().string() + ": is cut off: " + std::to_string(bytes) + " bytes declared by " + header.filename().string() + ", " + std::to_string(present) + " present");
}

const char* unit_of(int code) { return code == 1 ? "m" : code == 2 ? "mm" : code == 3 ? "um" : nullptr; }

}  // namespace

Imported read_nifti(const ReadRequest& asked) {
  ReadRequest request = asked;
  request.file = header_file(asked.file);
  const std::string name = request.file.filename().string();
  check_magic(request);
  vtkNew<vtkNIFTIImageReader> reader;
  if (!reader->CanReadFile(request.file.c_str())) throw Error(ErrorCode::bad_data, name + ": is not a NIfTI file");
  reader->SetFileName(request.file.c_str());
  reader->TimeAsVectorOn();
  report_progress(reader, request);
  reader->UpdateInformation();
  throw_on_vtk_error(name);
  check_values(request.file, *reader);
  const int steps = std::max(1, reader->GetTimeDimension());
  const double between = reader->GetTimeSpacing();
  std::vector<double> times;
  for (int t = 0; t < steps; ++t) times.push_back(t * (between > 0 && std::isfinite(between) ? between : 1.0));
  check_step(request, times.size());

  const double slope = finite_or_0(reader->GetRescaleSlope()), intercept = finite_or_0(reader->GetRescaleIntercept());
  vtkMatrix4x4* matrix = reader->GetSFormMatrix() ? reader->GetSFormMatrix() : reader->GetQFormMatrix();
  ReadRequest all = request;
  all.step = 0;
  Imported imported = read_step(reader, all);
  imported.times = times;
  if (request.times_only) return imported;
  Block& block = imported.blocks.front();
  for (FileArray& array : block.arrays) {
    const int count = array.components / steps;
    if (count * steps != array.components || (count > 1 && steps > 1))
      throw Error(ErrorCode::unsupported, name + ": several numbers in each point at several times; expected one of both");
    array = part_of(array, static_cast<std::size_t>(request.step * count), static_cast<std::size_t>(count), slope, intercept);
    array.name = "intensity";
  }
  if (auto* image = std::get_if<UniformGrid>(&block.grid.shape); image && matrix) {
    std::array<double, 3> origin{};
    std::array<std::array<double, 3>, 3> step{};
    for (int a = 0; a < 3; ++a) {
      origin[static_cast<std::size_t>(a)] = matrix->GetElement(a, 3);
      for (int i = 0; i < 3; ++i) {
        origin[static_cast<std::size_t>(a)] += matrix->GetElement(a, i) * image->origin[i];
        step[static_cast<std::size_t>(i)][static_cast<std::size_t>(a)] = matrix->GetElement(a, i) * image->spacing[i];
      }
    }
    const auto dims = image->dims;
    place_image(block, dims, origin, step, name);
    imported.notes.push_back(std::string("placed by its ") + (reader->GetSFormMatrix() ? "sform" : "qform") + ": x to the right, y to the front, z up");
  }
  if (const vtkNIFTIImageHeader* header = reader->GetNIFTIHeader())
    if (const char* unit = unit_of(const_cast<vtkNIFTIImageHeader*>(header)->GetXYZTUnits() & 7))
      imported.axes = axes_in(unit);
  return imported;
}

}  // namespace isostrata
