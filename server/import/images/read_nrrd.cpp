#include "import/images/read_nrrd.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "import/bytes/mapped_file.h"
#include "import/images/nrrd_data.h"
#include "import/images/nrrd_header.h"
#include "import/imported/place_image.h"

namespace isostrata {
namespace {

constexpr std::int64_t kMostNrrdComponents = 256;

struct NrrdAxes {
  std::vector<std::size_t> space, component;
  std::optional<std::size_t> time;
};

/// Which of x, y and z an axis runs along; nothing if it runs along none of them alone.
std::optional<int> along_one(const NrrdAxis& axis) {
  if (!axis.direction) return std::nullopt;
  std::optional<int> found;
  for (int a = 0; a < 3; ++a) {
    if ((*axis.direction)[static_cast<std::size_t>(a)] == 0) continue;
    if (found) return std::nullopt;
    found = a;
  }
  return found;
}

/// Puts axes of space that run along z, x and y in the order of x, y and z: a grid that is uniform then, and would be curvilinear.
void order_axes(const NrrdHeader& header, std::vector<std::size_t>& space) {
  if (space.size() != 3) return;
  std::vector<std::size_t> ordered(3, header.axes.size());
  for (const std::size_t a : space) {
    const auto along = along_one(header.axes[a]);
    if (!along || ordered[static_cast<std::size_t>(*along)] != header.axes.size()) return;
    ordered[static_cast<std::size_t>(*along)] = a;
  }
  space = ordered;
}

NrrdAxes sort_axes(const NrrdHeader& header, const std::string& name) {
  NrrdAxes axes;
  std::int64_t components = 1;
  for (std::size_t a = 0; a < header.axes.size(); ++a) {
    switch (header.axes[a].role) {
      case NrrdRole::space:
        axes.space.push_back(a);
        break;
      case NrrdRole::time:
        axes.time = a;
        break;
      case NrrdRole::component:
        axes.component.push_back(a);
        components = checked_product({components, header.axes[a].size}, name);
    }
  }
  if (components > kMostNrrdComponents)
    throw Error(ErrorCode::unsupported, name + ": " + std::to_string(components) +
                                            " components in each point; expected at most " + std::to_string(kMostNrrdComponents));
  order_axes(header, axes.space);
  return axes;
}

std::vector<std::byte> load_values(const ReadRequest& request, const NrrdHeader& header, const MappedFile& main,
                                   std::vector<std::string>& notes) {
  const std::string name = request.file.filename().string();
  if (header.data_files.empty())
    return decode_nrrd(main.bytes().subspan(std::min(header.length, main.bytes().size())), header, header.values(), name, notes);
  const auto files = static_cast<std::int64_t>(header.data_files.size());
  if (header.values() % files != 0)
    throw Error(ErrorCode::bad_data, name + ": " + std::to_string(header.values()) + " values do not divide into " +
                                         std::to_string(files) + " data files");
  std::vector<std::byte> all;
  for (const std::string& data_file : header.data_files) {
    const auto path = referred_file(request.file, data_file);
    const MappedFile mapped(path);
    auto part = decode_nrrd(mapped.bytes(), header, header.values() / files, path.filename().string(), notes);
    if (files == 1) return part;
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

/// [points][components] at one time step, x fastest.
FileArray gather(const NrrdHeader& header, const NrrdAxes& axes, std::span<const std::byte> values, int step, const std::string& named) {
  const std::size_t width = size_of(header.type);
  std::vector<std::size_t> strides(header.axes.size());
  std::size_t stride = 1;
  for (std::size_t a = 0; a < header.axes.size(); ++a) {
    strides[a] = stride;
    stride *= static_cast<std::size_t>(header.axes[a].size);
  }
  std::vector<std::size_t> component_offsets{0};
  for (const std::size_t a : axes.component) {
    std::vector<std::size_t> more;
    for (std::int64_t i = 0; i < header.axes[a].size; ++i)
      for (const std::size_t offset : component_offsets) more.push_back(offset + static_cast<std::size_t>(i) * strides[a]);
    component_offsets = std::move(more);
  }
  std::array<std::size_t, 3> n{1, 1, 1}, s{0, 0, 0};
  for (std::size_t i = 0; i < axes.space.size(); ++i) {
    n[i] = static_cast<std::size_t>(header.axes[axes.space[i]].size);
    s[i] = strides[axes.space[i]];
  }
  const std::size_t first = axes.time ? static_cast<std::size_t>(step) * strides[*axes.time] : 0;

  FileArray array;
  array.name = named;
  array.type = header.type;
  array.components = static_cast<int>(component_offsets.size());
  auto [storage, out] = allocate<std::byte>(n[0] * n[1] * n[2] * component_offsets.size() * width);
  std::byte* to = out.data();
  for (std::size_t k = 0; k < n[2]; ++k)
    for (std::size_t j = 0; j < n[1]; ++j) {
      const std::size_t row = first + k * s[2] + j * s[1];
      if (component_offsets.size() == 1 && s[0] == 1) {
        std::memcpy(to, values.data() + row * width, n[0] * width);
        to += n[0] * width;
        continue;
      }
      for (std::size_t i = 0; i < n[0]; ++i)
        for (const std::size_t offset : component_offsets) {
          std::memcpy(to, values.data() + (row + i * s[0] + offset) * width, width);
          to += width;
        }
    }
  array.values = out;
  array.storage = storage;
  return array;
}

/// The step's values as they lie in the one file that has them, if they are what gather() would copy: x, y and z in this order, then time.
std::optional<FileArray> in_place(const ReadRequest& request, const NrrdHeader& header, const NrrdAxes& axes, const std::shared_ptr<const MappedFile>& main,
                                  const std::string& named, std::vector<std::string>& notes) {
  const bool in_order = axes.component.empty() && (!axes.time || *axes.time + 1 == header.axes.size()) &&
                        std::is_sorted(axes.space.begin(), axes.space.end());
  if (!in_order || header.data_files.size() > 1 || header.encoding != NrrdEncoding::raw) return std::nullopt;
  std::string name = request.file.filename().string();
  std::shared_ptr<const MappedFile> of = main;
  auto bytes = main->bytes().subspan(std::min(header.length, main->bytes().size()));
  if (!header.data_files.empty()) {
    const auto path = referred_file(request.file, header.data_files.front());
    of = std::make_shared<const MappedFile>(path);
    bytes = of->bytes();
    name = path.filename().string();
  }
  if (bytes.size() / size_of(header.type) < static_cast<std::uint64_t>(header.values())) return std::nullopt;  // said by whoever copies
  std::vector<std::string> own;
  const auto all = nrrd_in_place(bytes, header, header.values(), name, own);
  if (!all) return std::nullopt;
  const std::size_t steps = axes.time ? static_cast<std::size_t>(header.axes[*axes.time].size) : 1;
  const std::size_t step_bytes = all->size() / steps;
  FileArray array;
  array.name = named;
  array.type = header.type;
  array.values = all->subspan(static_cast<std::size_t>(request.step) * step_bytes, step_bytes);
  array.storage = of;
  if (reinterpret_cast<std::uintptr_t>(array.values.data()) % size_of(array.type) != 0) return std::nullopt;
  notes.insert(notes.end(), own.begin(), own.end());
  return array;
}

/// Where an axis without direction begins and how far apart its samples are.
std::pair<double, double> along(const NrrdAxis& axis, double origin, const std::string& name) {
  double spacing = axis.spacing.value_or(1.0);
  if (axis.lower && axis.upper && !axis.spacing && axis.size > 1) {
    spacing = (*axis.upper - *axis.lower) / static_cast<double>(axis.cell_centered ? axis.size : axis.size - 1);
    origin = *axis.lower + (axis.cell_centered ? spacing / 2 : 0);
  } else if (axis.lower) {
    origin = *axis.lower;
  }
  if (spacing == 0 || !std::isfinite(spacing))
    throw Error(ErrorCode::bad_data, name + ": a spacing of " + std::to_string(spacing) + "; expected any finite value but 0");
  return {origin, spacing};
}

void place(Block& block, const NrrdHeader& header, const NrrdAxes& axes, const std::string& name) {
  std::array<std::int64_t, 3> dims{1, 1, 1};
  bool directions = false;
  for (std::size_t i = 0; i < axes.space.size(); ++i) {
    dims[i] = header.axes[axes.space[i]].size;
    directions = directions || header.axes[axes.space[i]].direction;
  }
  const auto origin = header.origin.value_or(std::array<double, 3>{0, 0, 0});
  if (!directions) {
    UniformGrid uniform;
    uniform.dims = dims;
    uniform.origin = {origin[0], origin[1], origin[2]};
    for (std::size_t i = 0; i < axes.space.size(); ++i) {
      const auto [begin, spacing] = along(header.axes[axes.space[i]], origin[i], name);
      uniform.origin[static_cast<int>(i)] = begin;
      uniform.spacing[static_cast<int>(i)] = spacing;
    }
    block.grid.shape = uniform;
    return;
  }

  std::array<std::array<double, 3>, 3> step{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (std::size_t i = 0; i < axes.space.size(); ++i) {
    if (!header.axes[axes.space[i]].direction)
      throw Error(ErrorCode::bad_data, name + ": space directions are given for some axes of space only");
    step[i] = *header.axes[axes.space[i]].direction;
  }
  place_image(block, dims, origin, step, name);
}

}  // namespace

Imported read_nrrd(const ReadRequest& request) {
  const auto file = std::make_shared<const MappedFile>(request.file);
  const auto bytes = file->bytes();
  const NrrdHeader header = parse_nrrd_header({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, request.file.filename().string());
  return read_described(request, header, file, "scalars");
}

Imported read_described(const ReadRequest& request, const NrrdHeader& header, const std::shared_ptr<const MappedFile>& file, const std::string& array) {
  const std::string name = request.file.filename().string();
  const NrrdAxes axes = sort_axes(header, name);
  Imported imported;
  if (axes.time) {
    const NrrdAxis& time = header.axes[*axes.time];
    if (time.size > 1'000'000)
      throw Error(ErrorCode::too_large, name + ": " + std::to_string(time.size) + " time steps; expected at most 1000000");
    const double spacing = time.spacing && *time.spacing > 0 ? *time.spacing : 1.0;
    imported.times.clear();
    for (std::int64_t t = 0; t < time.size; ++t)
      imported.times.push_back(time.lower.value_or(0.0) + static_cast<double>(t) * spacing);
  }
  check_step(request, imported.times.size());
  const std::int64_t all = checked_product({header.values(), static_cast<std::int64_t>(size_of(header.type))}, name);
  Block block;
  place(block, header, axes, name);
  if (auto there = in_place(request, header, axes, file, array, imported.notes)) {
    block.arrays.push_back(std::move(*there));
  } else {
    check_bytes(request, static_cast<std::uint64_t>(all), name);
    const std::vector<std::byte> values = load_values(request, header, *file, imported.notes);
    request.progress(0.4);
    block.arrays.push_back(gather(header, axes, values, request.step, array));
  }
  block.arrays.back().unit = header.unit;
  const bool in_space = header.origin || header.space_units[0] != "" || std::any_of(header.axes.begin(), header.axes.end(), [](const NrrdAxis& axis) { return axis.direction.has_value(); });
  for (std::size_t a = 0; a < axes.space.size(); ++a) imported.axes[a].unit = in_space ? header.space_units[a] : header.axes[axes.space[a]].unit;
  imported.blocks.push_back(std::move(block));
  return imported;
}

}  // namespace isostrata
