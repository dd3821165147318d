#include <vtkMetaImageReader.h>
#include <vtkNew.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <istream>
#include <memory>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "import/bytes/mapped_file.h"
#include "import/bytes/parsed_number.h"
#include "import/images/nrrd_data.h"
#include "import/imported/place_image.h"
#include "import/limits/memory_limit.h"
#include "import/vtk/meta_header.h"
#include "import/vtk/read_image_in_place.h"
#include "import/vtk/read_vtk.h"
#include "import/vtk/vtk_pipeline.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

/// "slice_%03d.raw 1 64 1" are 64 files.
std::vector<std::string> files_of_pattern(const std::string& line, const std::string& name) {
  constexpr std::size_t kLongestPattern = 79;  // MetaIO's buffer
  const auto percent = line.find('%');
  char pattern[200] = "";
  int first = 0, last = 0, by = 1;
  const int found = std::sscanf(line.c_str(), "%199s %d %d %d", pattern, &first, &last, &by);
  const auto conversion = line.find_first_not_of("0123456789", percent + 1);
  const std::string text(pattern);
  if (found < 4 || by < 1 || last < first || (last - first) / by > 100'000 || conversion == std::string::npos || conversion > percent + 3 ||
      line[conversion] != 'd' || line.find('%', conversion) != std::string::npos || text.size() > kLongestPattern || conversion >= text.size())
    throw Error(ErrorCode::bad_data, name + ": ElementDataFile is '" + line +
                                         "'; expected a pattern with one number, the first, the last and the stride: slice_%03d.raw 1 64 1");
  const auto width = static_cast<std::size_t>(std::max(0, std::atoi(line.substr(percent + 1, conversion - percent - 1).c_str())));
  std::vector<std::string> files;
  for (int i = first; i <= last; i += by) {
    std::string number = std::to_string(i);
    if (number.size() < width) number.insert(0, width - number.size(), line[percent + 1] == '0' ? '0' : ' ');
    files.push_back(text.substr(0, percent) + number + text.substr(conversion + 1));
  }
  return files;
}

/// The header says LOCAL, a file, "LIST" and the files in the lines behind it, or a pattern.
std::vector<fs::path> data_files(const ReadRequest& request, const MetaHeader& header, std::istream& behind) {
  if (header.local()) return {request.file};
  std::vector<std::string> names;
  if (header.data.starts_with("LIST")) {
    for (std::string file; std::getline(behind, file);) {
      file.erase(file.find_last_not_of(" \t\r") + 1);
      if (!file.empty()) names.push_back(file);
    }
  } else if (header.data.find('%') == std::string::npos) {
    names.push_back(header.data);
  } else {
    names = files_of_pattern(header.data, request.file.filename().string());
  }
  std::vector<fs::path> files;
  for (const std::string& file : names) files.push_back(referred_file(request.file, file));
  return files;
}

/// How many files hold the values. "LIST 2" says that each holds two axes; if nothing is said it holds all but the last one.
std::int64_t expected_files(const MetaHeader& header, const std::vector<std::int64_t>& sizes, const std::string& name) {
  const bool list = header.data.starts_with("LIST");
  if (header.local() || (!list && header.data.find('%') == std::string::npos)) return 1;
  std::size_t axes = 0;
  if (list) std::istringstream(header.data.substr(4)) >> axes;
  if (axes == 0 || axes > sizes.size()) axes = sizes.size() - 1;
  std::int64_t files = 1;
  for (; axes < sizes.size(); ++axes) files = checked_product({files, sizes[axes]}, name);
  return files;
}

/// What NRRD calls the same.
NrrdHeader as_nrrd(const MetaHeader& header, ScalarType type, const std::vector<std::int64_t>& sizes) {
  NrrdHeader out;
  out.type = type;
  out.encoding = header.compressed() ? NrrdEncoding::gzip : header.binary() ? NrrdEncoding::raw : NrrdEncoding::text;
  out.big_endian = header.big_endian();
  out.byte_skip = header.binary() && !header.compressed() && header.field("HeaderSize") == "-1" ? -1 : 0;
  for (const std::int64_t size : sizes) out.axes.push_back({.size = size});
  return out;
}

/// All values, of all files. VTK's reader takes what is not there for zeros, a MET_LONG for eight bytes, and MET_LONG_LONG for nothing. Nothing of a header that
/// makes no sense here.
std::optional<FileArray> values_of(const ReadRequest& request, const MetaHeader& header, const std::vector<fs::path>& files, std::vector<std::string>& notes) {
  const std::string name = request.file.filename().string();
  const auto type = header.type();
  const auto channels = header.channels();
  const std::vector<std::int64_t> sizes = header.sizes();
  if (!type || !channels || sizes.empty()) return std::nullopt;
  const std::int64_t expected = expected_files(header, sizes, name);
  if (static_cast<std::int64_t>(files.size()) < expected)
    throw Error(ErrorCode::bad_data, name + ": names " + std::to_string(files.size()) + " files of values; expected " + std::to_string(expected) + " by its DimSize");
  std::int64_t values = *channels;
  for (const std::int64_t size : sizes) values = checked_product({values, size}, name);
  check_bytes(request, static_cast<std::uint64_t>(values) * size_of(*type), name);
  const NrrdHeader as = as_nrrd(header, *type, sizes);
  const std::uint64_t skip = parsed_number<std::uint64_t>(header.field("HeaderSize")).value_or(0);
  const std::uint64_t begin = skip == 0 && header.local() ? header.end : skip;
  auto all = std::make_shared<std::vector<std::byte>>();
  if (expected > 1) all->reserve(static_cast<std::size_t>(values) * size_of(*type));
  for (std::int64_t i = 0; i < expected; ++i) {
    const fs::path& file = files[static_cast<std::size_t>(i)];
    const MappedFile mapped(file);
    const auto from = std::min(mapped.bytes().size(), static_cast<std::size_t>(begin));
    auto part = decode_nrrd(mapped.bytes().subspan(from), as, values / expected, file.filename().string(), notes);
    if (expected == 1)
      *all = std::move(part);
    else
      all->insert(all->end(), part.begin(), part.end());
    request.progress(static_cast<double>(i + 1) / static_cast<double>(expected));
  }
  FileArray array;
  array.name = "MetaImage";  // as VTK's reader calls it
  array.type = *type;
  array.components = static_cast<int>(*channels);
  array.values = *all;
  array.storage = all;
  return array;
}

/// VTK's reader takes the spacing and the origin alone. Row i of the matrix is the direction of axis i, as ITK has it.
void turn_axes(Block& block, const MetaHeader& header, const std::string& name) {
  auto* const image = std::get_if<UniformGrid>(&block.grid.shape);
  std::string_view text;
  for (const char* field : {"Orientation", "Rotation", "TransformMatrix"})
    if (!header.field(field).empty()) text = header.field(field);
  if (!image || text.empty()) return;
  std::array<std::array<double, 3>, 3> step{};
  std::istringstream numbers{std::string(text)};
  double over = 0;
  for (auto& row : step)
    for (double& number : row)
      if (!(numbers >> number)) return;
  if (numbers >> over) return;  // of other than three axes
  const auto& [x, y, z] = step;
  if (x[0] * (y[1] * z[2] - y[2] * z[1]) - x[1] * (y[0] * z[2] - y[2] * z[0]) + x[2] * (y[0] * z[1] - y[1] * z[0]) == 0)
    throw Error(ErrorCode::bad_data, name + ": the directions of its axes, " + std::string(text.substr(0, 60)) + ", lie in one plane");
  for (std::size_t i = 0; i < 3; ++i)
    for (double& number : step[i]) number *= image->spacing[static_cast<int>(i)];
  const auto dims = image->dims;
  const Vec3d origin = image->origin;
  place_image(block, dims, {origin.x, origin.y, origin.z}, step, name);
}

}  // namespace

Imported read_meta_image(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  std::ifstream in(request.file, std::ios::binary);
  const MetaHeader header = read_meta_header(in, name);
  const std::vector<fs::path> files = data_files(request, header, in);
  std::uint64_t stored = 0;
  for (const fs::path& file : files) stored += fs::file_size(file);
  check_unpacked(header.declared_bytes(), stored, name);
  std::optional<Imported> imported = meta_image_in_place(request, header);
  if (!imported) {
    std::vector<std::string> notes;
    if (auto values = values_of(request, header, files, notes)) imported = placed_meta_image(request, header, std::move(*values));
    if (imported) imported->notes.insert(imported->notes.end(), notes.begin(), notes.end());
  }
  if (!imported) {
    vtkNew<vtkMetaImageReader> reader;
    reader->SetFileName(request.file.c_str());
    imported = run_reader(reader, request);
  }
  if (!imported->blocks.empty()) turn_axes(imported->blocks.front(), header, name);
  return std::move(*imported);
}

}  // namespace isostrata
