#include "bench/bench_device.h"

#include <boost/json.hpp>
#include <cmath>
#include <cstdio>
#include <vector>

#include "base/parallel.h"
#include "main/arguments.h"
#include "rendering/device/gl_extraction.h"

namespace isostrata {
namespace {

/// 0..255 over the array's range; what is not finite becomes 0.
double byte_of(const PointArray& array, double value) {
  return std::isfinite(value) && array.lower < array.upper ? 255 * (value - array.lower) / (array.upper - array.lower) : 0.0;
}

PointArray bytes_of(const PointArray& array) {
  PointArray out = array;
  out.type = ScalarType::uint8;
  std::visit(
      [&](auto values) {
        auto bytes = std::make_shared<std::vector<std::uint8_t>>(values.size());
        parallel_for(static_cast<std::int64_t>(values.size()), 1 << 16, [&](std::int64_t begin, std::int64_t end) {
          for (std::int64_t i = begin; i < end; ++i)
            (*bytes)[i] = static_cast<std::uint8_t>(std::lround(byte_of(array, static_cast<double>(values[i]))));
        });
        out.values = std::span<const std::uint8_t>(*bytes);
        out.storage = bytes;
      },
      array.values);
  return out;
}

}  // namespace

DeviceRun measure_on_device(const std::string& device, const std::string& data, const Grid& grid, const PointArray& array,
                            const Interval& interval, bool as_bytes, int repeat) {
  GlExtraction extraction(device);
  const Task& task = command_task();
  DeviceRun run;
  run.device = extraction.device();
  run.software = extraction.software();
  run.data = data;
  run.array = array.name;
  run.interval = as_bytes ? Interval{byte_of(array, interval.lower), byte_of(array, interval.upper)} : interval;
  const PointArray measured = as_bytes ? bytes_of(array) : array;
  run.type = to_string(measured.type);
  const GlLoadTimes times = extraction.load(grid, measured, task);
  run.upload_ms = times.upload_ms;
  run.index_ms = times.index_ms;
  const auto time = [&](GlExtent extent) {
    extraction.extract({&run.interval, 1}, extent, task);
    std::vector<double> ms;
    for (int i = 0; i < repeat; ++i) {
      const GlCounts counts = extraction.extract({&run.interval, 1}, extent, task);
      ms.push_back(counts.extract_ms);
      run.cells = counts.cells;
      run.bricks = counts.bricks;
      run.active_bricks = counts.active_bricks;
      run.active_cells = counts.active_cells;
      run.tetrahedra = counts.tetrahedra;
      run.points = counts.points;
      run.device_bytes = counts.device_bytes;
    }
    return spread_of(ms);
  };
  run.records = time(GlExtent::records);
  run.mesh = time(GlExtent::tetrahedra);
  return run;
}

boost::json::object to_json(const DeviceRun& run) {
  return {{"data", run.data},
          {"array", run.array},
          {"type", run.type},
          {"device", run.device},
          {"software", run.software},
          {"interval", boost::json::array{run.interval.lower, run.interval.upper}},
          {"cells", run.cells},
          {"bricks", run.bricks},
          {"active_bricks", run.active_bricks},
          {"active_cells", run.active_cells},
          {"tetrahedra", run.tetrahedra},
          {"points", run.points},
          {"device_bytes", run.device_bytes},
          {"upload_ms", run.upload_ms},
          {"index_ms", run.index_ms},
          {"records_ms", to_json(run.records)},
          {"ms", to_json(run.mesh)}};
}

void print_text(const DeviceRun& run) {
  std::printf("%s, %s (%s) %g:%g: %lld of %lld cells in %lld of %lld bricks, %lld tetrahedra, %lld points\n", run.data.c_str(),
              run.array.c_str(), run.type.c_str(), run.interval.lower, run.interval.upper,
              static_cast<long long>(run.active_cells), static_cast<long long>(run.cells),
              static_cast<long long>(run.active_bricks), static_cast<long long>(run.bricks),
              static_cast<long long>(run.tetrahedra), static_cast<long long>(run.points));
  std::printf("  once: sent in %.2f ms, indexed in %.2f ms; %.1f MB on the device\n", run.upload_ms, run.index_ms,
              static_cast<double>(run.device_bytes) / 1e6);
  std::printf("  records: min %.3f, median %.3f, max %.3f ms; with tetrahedra: min %.3f, median %.3f, max %.3f ms\n",
              run.records.min, run.records.median, run.records.max, run.mesh.min, run.mesh.median, run.mesh.max);
  std::printf("  on %s\n", run.device.c_str());
}

}  // namespace isostrata
