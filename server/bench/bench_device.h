// `bench extract --device`: extraction on a device, timed apart from sending the field there.
#pragma once

#include <boost/json/object.hpp>
#include <string>

#include "bench/bench_sums.h"
#include "data/dataset/dataset.h"
#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

struct DeviceRun {
  std::string data, array, type, device;
  bool software = false;
  Interval interval;
  std::int64_t cells = 0, bricks = 0, active_bricks = 0, active_cells = 0, tetrahedra = 0, points = 0;
  std::uint64_t device_bytes = 0;
  double upload_ms = 0, index_ms = 0;  // once an array
  Spread records, mesh;                // ms a request: cell records alone; records, points and tetrahedra
};

/// Extracts `repeat` times each, after one that makes room. as_bytes: the array is scaled to 0..255 and rounded first, and the
/// interval with it. Throws what GlExtraction does.
DeviceRun measure_on_device(const std::string& device, const std::string& data, const Grid& grid, const PointArray& array,
                            const Interval& interval, bool as_bytes, int repeat);

boost::json::object to_json(const DeviceRun& run);
void print_text(const DeviceRun& run);

}  // namespace isostrata
