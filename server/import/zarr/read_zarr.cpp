#include <algorithm>

#include "data/files/zarr_folder.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"
#include "import/zarr/zarr_array.h"
#include "import/zarr/zarr_block.h"
#include "import/zarr/zarr_chunks.h"
#include "import/zarr/zarr_fields.h"
#include "import/zarr/zarr_image.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostTimes = 1'000'000;
constexpr std::int64_t kMostChannels = 1000;
constexpr std::size_t kNone = ZarrBox::kNone;

/// An array and what its axes mean.
struct Found {
  ZarrArray array;
  ZarrImage image;
  bool named = false;  // by an image
};

/// A level that is opened by its own folder has its meaning in the one above, which may be out of reach.
std::optional<ZarrImage> image_above(const fs::path& folder) {
  const std::vector<fs::path> files = zarr_files_above(folder);
  if (files.empty()) return std::nullopt;
  try {
    ZarrStore above(files.front().parent_path());
    return read_zarr_image(above, ZarrStore(folder).name());
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// Nothing if the folder is neither an array nor an image.
std::optional<Found> find(ZarrStore& store, const fs::path& folder) {
  if (auto array = read_zarr_array(store, "")) {
    if (auto image = image_above(folder)) return Found{std::move(*array), std::move(*image), true};
    return Found{std::move(*array), {}};
  }
  auto image = read_zarr_image(store, "");
  if (!image) return std::nullopt;
  auto array = read_zarr_array(store, image->level);
  if (!array) throw Error(ErrorCode::bad_data, store.name_of(image->level) + ": expected .zarray or zarr.json in it, as the array of a level has; 'multiscales' names it");
  return Found{std::move(*array), std::move(*image), true};
}

/// Which axis is time, and which are x, y, z and the channels of the box.
struct Roles {
  ZarrBox box;
  std::size_t time = kNone;
};

Roles roles_of(const ZarrArray& array, const std::vector<ZarrAxis>& axes) {
  Roles roles;
  roles.box.at.assign(axes.size(), 0);
  std::vector<std::size_t> space;
  const auto take = [&](std::size_t& place, std::size_t axis, const char* what) {
    if (place != kNone) throw Error(ErrorCode::unsupported, array.file + ": two axes of " + what + "; expected one at most");
    place = axis;
  };
  for (std::size_t a = 0; a < axes.size(); ++a) {
    if (axes[a].role == ZarrRole::time) take(roles.time, a, "time");
    if (axes[a].role == ZarrRole::channel) take(roles.box.axes[3], a, "channels");
    if (axes[a].role == ZarrRole::space) space.push_back(a);
    if (axes[a].role == ZarrRole::other && array.shape[a] > 1)
      throw Error(ErrorCode::unsupported, array.file + ": the axis '" + axes[a].name + "' has " + std::to_string(array.shape[a]) + " places; expected time, channels and space alone");
  }
  if (space.empty() || space.size() > 3)
    throw Error(ErrorCode::unsupported, array.file + ": " + std::to_string(axes.size()) + " axes, " + std::to_string(space.size()) +
                                            " of them of space; expected one to three, and beside them axes that are named t and c");
  std::reverse(space.begin(), space.end());  // the last is x, unless their names say otherwise
  const auto called = [&](const char* name) { return std::find_if(space.begin(), space.end(), [&](std::size_t a) { return axes[a].name == name; }); };
  if (called("x") != space.end() && called("y") != space.end()) {
    std::iter_swap(space.begin(), called("x"));
    std::iter_swap(space.begin() + 1, called("y"));
  }
  std::copy(space.begin(), space.end(), roles.box.axes.begin());
  for (std::size_t b = 0; b < 4; ++b)
    if (roles.box.axes[b] != kNone) roles.box.size[b] = array.shape[roles.box.axes[b]];
  if (roles.box.size[3] > kMostChannels) throw Error(ErrorCode::too_large, array.file + ": " + std::to_string(roles.box.size[3]) + " channels; expected at most " + std::to_string(kMostChannels));
  return roles;
}

std::vector<double> times_of(const ZarrArray& array, const std::vector<ZarrAxis>& axes, std::size_t time) {
  if (time == kNone) return {0.0};
  if (static_cast<std::size_t>(array.shape[time]) > kMostTimes) throw Error(ErrorCode::too_large, array.file + ": more than " + std::to_string(kMostTimes) + " steps");
  std::vector<double> times;
  const double scale = axes[time].scale > 0 ? axes[time].scale : 1;
  for (std::int64_t t = 0; t < array.shape[time]; ++t) times.push_back(axes[time].translation + scale * static_cast<double>(t));
  return times;
}

void place(Block& block, const ZarrBox& box, const std::vector<ZarrAxis>& axes, const std::string& name) {
  std::array<double, 3> origin{};
  std::array<std::array<double, 3>, 3> step{};
  for (std::size_t b = 0; b < 3; ++b) {
    const std::size_t axis = box.axes[b];
    origin[b] = axis == kNone ? 0 : axes[axis].translation;
    step[b][b] = axis == kNone ? 1 : axes[axis].scale;
  }
  place_image(block, {box.size[0], box.size[1], box.size[2]}, origin, step, name);
}

void take_units(const ZarrBox& box, const std::vector<ZarrAxis>& axes, std::size_t time, Imported& imported) {
  for (std::size_t b = 0; b < 3; ++b)
    if (box.axes[b] != kNone) imported.axes[b] = {axes[box.axes[b]].name, axes[box.axes[b]].unit};
  if (time != kNone && !axes[time].unit.empty()) imported.notes.push_back("times are in " + axes[time].unit);
}

}  // namespace

Imported read_zarr(const ReadRequest& request) {
  ZarrStore store(request.file);
  const std::optional<Found> one = find(store, request.file);
  if (!one) {
    if (auto fields = read_zarr_fields(store, request)) return std::move(*fields);
    refuse_zarr_group(store);
  }
  const Found& found = *one;
  const ZarrArray& array = found.array;
  const ZarrImage& image = found.image;
  std::vector<ZarrAxis> axes = image.axes;
  if (axes.empty() && found.named && array.shape.size() == 5)
    for (const char* name : {"t", "c", "z", "y", "x"}) axes.push_back({name, name[0] == 't' ? ZarrRole::time : name[0] == 'c' ? ZarrRole::channel : ZarrRole::space, {}});
  if (axes.empty()) axes = axes_by_name(array);
  if (axes.size() != array.shape.size())
    throw Error(ErrorCode::bad_data, array.file + ": an array of " + std::to_string(array.shape.size()) + " axes; 'multiscales' names " + std::to_string(axes.size()));
  Roles roles = roles_of(array, axes);
  Imported imported;
  imported.times = times_of(array, axes, roles.time);
  check_step(request, imported.times.size());
  if (request.times_only) return imported;
  if (roles.time != kNone) roles.box.at[roles.time] = request.step;

  const ZarrBox& box = roles.box;
  const std::int64_t points = checked_product({box.size[0], box.size[1], box.size[2]}, array.file);
  const auto bytes = static_cast<std::uint64_t>(checked_product({points, static_cast<std::int64_t>(size_of(array.type))}, array.file));
  check_bytes(request, static_cast<std::uint64_t>(checked_product({static_cast<std::int64_t>(bytes), box.size[3]}, array.file)), store.name());
  Block block;
  place(block, box, axes, array.file);
  const auto called = [&](std::size_t c) -> std::string {
    if (c < image.channels.size() && !image.channels[c].empty()) return image.channels[c];
    if (box.axes[3] != kNone) return "channel " + std::to_string(c);
    return found.named ? "intensity" : fs::path(store.name()).stem().string();
  };
  const ZarrCount count = add_zarr_arrays(store, array, box, request, called, block);
  imported.blocks.push_back(std::move(block));
  imported.notes = image.notes;
  take_units(box, axes, roles.time, imported);
  if (!found.named) imported.notes.push_back("an array alone, which no image explains: its last axis is x; points 1 apart");
  note_missing(count, imported.notes);
  return imported;
}

}  // namespace isostrata
