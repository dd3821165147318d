// Imaris 5.5 (.ims): volumes in HDF5, a group for each resolution, time point and channel.
//
// "Imaris 5.5 File Format Description", imaris.oxinst.com: attributes are arrays of single letters; the arrays are as large as their chunks need, and the attributes say how much of them counts.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "import/bytes/parsed_number.h"
#include "import/hdf5/hdf5_file.h"
#include "import/imported/appended_file.h"
#include "import/imported/place_image.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

constexpr const char* kFinest = "DataSet/ResolutionLevel 0/TimePoint ";
constexpr int kMostTimePoints = 1'000'000, kMostImarisChannels = 1000;

std::string channel_path(int time, int channel) { return kFinest + std::to_string(time) + "/Channel " + std::to_string(channel); }

std::optional<double> real_attribute(const Hdf5File& file, const char* group, const std::string& name) {
  const auto value = parsed_number<double>(file.text(group, name));
  return value && std::isfinite(*value) ? value : std::nullopt;
}

/// Seconds of "2012-05-03 14:01:22.125".
std::optional<double> seconds_of(const std::string& date) {
  if (date.size() < 19) return std::nullopt;
  const auto number = [&](std::size_t at, std::size_t count) { return parsed_number<int>(std::string_view(date).substr(at, count)); };
  const auto year = number(0, 4), month = number(5, 2), day = number(8, 2), hour = number(11, 2), minute = number(14, 2);
  const auto second = parsed_number<double>(std::string_view(date).substr(17));
  if (!year || !month || !day || !hour || !minute || !second) return std::nullopt;
  const std::chrono::year_month_day of{std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)), std::chrono::day(static_cast<unsigned>(*day))};
  if (!of.ok()) return std::nullopt;
  return static_cast<double>(std::chrono::sys_days(of).time_since_epoch().count()) * 86400 + *hour * 3600 + *minute * 60 + *second;
}

/// Since the first; their numbers where the file does not say them, or they do not increase.
std::vector<double> imaris_times(const Hdf5File& file, int count, std::vector<std::string>& notes) {
  std::vector<double> times, numbers;
  for (int t = 0; t < count; ++t) {
    numbers.push_back(t);
    const auto seconds = count > 1 ? seconds_of(file.text("DataSetInfo/TimeInfo", "TimePoint" + std::to_string(t + 1))) : std::nullopt;
    if (seconds) times.push_back(times.empty() ? *seconds : *seconds - times.front());
  }
  if (times.size() != numbers.size()) return numbers;
  times.front() = 0;
  if (std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) != times.end()) return numbers;
  notes.push_back("times are in seconds since the first");
  return times;
}

}  // namespace

Imported read_imaris(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  const Hdf5File file(request.file, Hdf5Walk::none);
  int steps = 0, channels = 0;
  while (steps < kMostTimePoints && file.has((kFinest + std::to_string(steps)).c_str())) ++steps;
  while (channels < kMostImarisChannels && file.has(channel_path(0, channels).c_str())) ++channels;
  if (channels == 0) throw Error(ErrorCode::bad_data, name + ": Imaris without a channel at 'DataSet/ResolutionLevel 0/TimePoint 0'");
  Imported imported;
  imported.times = imaris_times(file, steps, imported.notes);
  check_step(request, imported.times.size());
  if (request.times_only) return imported;
  constexpr std::array kAxes{"X", "Y", "Z"};
  std::array<std::int64_t, 3> dims{};
  std::array<double, 3> origin{};
  std::array<std::array<double, 3>, 3> step{};
  bool placed = true;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::string said = file.text(channel_path(request.step, 0), std::string("ImageSize") + kAxes[a]);
    const auto size = parsed_number<std::int64_t>(said);
    if (!size || *size < 1) throw Error(ErrorCode::bad_data, name + ": ImageSize" + kAxes[a] + " '" + said.substr(0, 20) + "' of its first channel; expected a whole number of at least 1");
    dims[a] = *size;
    const auto least = real_attribute(file, "DataSetInfo/Image", "ExtMin" + std::to_string(a)), most = real_attribute(file, "DataSetInfo/Image", "ExtMax" + std::to_string(a));
    placed = placed && least && most && *most > *least;
    step[a][a] = placed ? (*most - *least) / static_cast<double>(*size) : 1;
    origin[a] = placed ? *least + step[a][a] / 2 : 0;
  }
  if (!placed) {
    origin = {};
    step = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    imported.notes.push_back("points 1 apart: the file says no extent");
  } else {
    imported.axes = axes_in(file.text("DataSetInfo/Image", "Unit"));
  }
  Block& block = imported.blocks.emplace_back();
  place_image(block, dims, origin, step, name);
  const std::vector<std::size_t> count{static_cast<std::size_t>(dims[2]), static_cast<std::size_t>(dims[1]), static_cast<std::size_t>(dims[0])};
  std::uint64_t bytes = 0;
  for (int c = 0; c < channels; ++c) {
    const std::string path = channel_path(request.step, c) + "/Data";
    const auto array = file.find(path);
    if (!array || array->shape.size() != 3 || !std::equal(count.begin(), count.end(), array->shape.begin(), std::less_equal<>()))
      throw Error(ErrorCode::bad_data, name + ": expected " + std::to_string(dims[0]) + " x " + std::to_string(dims[1]) + " x " + std::to_string(dims[2]) + " values at '" + path + "'");
    check_bytes(request, bytes += static_cast<std::uint64_t>(checked_product({dims[0], dims[1], dims[2], static_cast<std::int64_t>(size_of(array->type))}, name)), name);
    AppendedFile<std::byte> out(request, "array_" + std::to_string(c) + ".bin");
    const std::size_t layer = count[1] * count[2] * size_of(array->type), together = std::clamp<std::size_t>((std::size_t{64} << 20) / layer, 1, count[0]);
    std::vector<std::byte> values;
    for (std::size_t z = 0; z < count[0]; z += together) {
      const std::size_t layers = std::min(together, count[0] - z);
      values.resize(layers * layer);
      file.read(*array, {z, 0, 0}, {layers, count[1], count[2]}, values);
      out.add(values);
      request.progress((c + static_cast<double>(z + layers) / static_cast<double>(count[0])) / channels);
    }
    FileArray& one = block.arrays.emplace_back();
    const std::string called = file.text("DataSetInfo/Channel " + std::to_string(c), "Name");
    one.name = called.empty() || called == "(name not specified)" ? "channel " + std::to_string(c) : called;
    one.type = array->type;
    std::tie(one.values, one.storage) = out.finish();
  }
  return imported;
}

}  // namespace isostrata
