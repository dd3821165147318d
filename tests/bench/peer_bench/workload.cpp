#include "workload.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "base/parallel.h"
#include "data/dataset/analytic.h"

namespace isostrata::peers {
namespace {

constexpr std::string_view kBytes = "torus-u8:";
constexpr double kByteRange = 1.5;  // that 0 to 255 stand for

std::shared_ptr<const Dataset> torus_in_bytes(const std::string& name) {
  const std::string_view digits = std::string_view(name).substr(kBytes.size());
  std::int64_t n = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), n);
  if (error != std::errc{} || end != digits.data() + digits.size() || n < 2 || n > 1024)
    throw Error(ErrorCode::invalid_argument, name + ": expected torus-u8:N, N from 2 to 1024");
  auto values = std::make_shared<std::vector<std::uint8_t>>(static_cast<std::size_t>(n * n * n));
  const double spacing = 2.0 / static_cast<double>(n - 1);
  const auto at = [&](std::int64_t i) { return -1 + spacing * static_cast<double>(i); };
  parallel_for(n, 1, [&](std::int64_t begin, std::int64_t finish) {
    for (std::int64_t k = begin; k < finish; ++k)
      for (std::int64_t j = 0; j < n; ++j)
        for (std::int64_t i = 0; i < n; ++i)
          (*values)[i + n * (j + n * k)] = static_cast<std::uint8_t>(
              std::min(255.0, std::lround(torus_distance({at(i), at(j), at(k)}) / kByteRange * 255) * 1.0));
  });
  auto dataset = std::make_shared<Dataset>();
  dataset->name = name;
  UniformGrid shape;
  shape.dims = {n, n, n};
  shape.origin = {-1, -1, -1};
  shape.spacing = {spacing, spacing, spacing};
  dataset->grid.shape = shape;
  dataset->bounds = dataset->grid.bounds();
  dataset->cell_types = count_cell_types(dataset->grid);
  PointArray array;
  array.name = "distance";
  array.type = ScalarType::uint8;
  array.values = std::span<const std::uint8_t>(*values);
  array.storage = values;
  measure_range(array);
  dataset->arrays.push_back(std::move(array));
  return dataset;
}

double four_digits(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", x);
  return std::atof(text);
}

}  // namespace

Workload open_workload(const std::string& data, const std::string& array, const Task& task) {
  Workload workload;
  workload.dataset = data.starts_with(kBytes) ? torus_in_bytes(data) : open_dataset(data, {}, task);
  if (workload.dataset->arrays.empty()) throw Error(ErrorCode::not_found, data + ": no point array; expected at least one");
  workload.array = array.empty() ? workload.dataset->arrays.front().name : workload.dataset->array(array).name;
  return workload;
}

Interval interval_through(const Workload& workload, double center, double share) {
  const Grid& grid = workload.dataset->grid;
  const std::int64_t cells = grid.cell_count();
  if (!(share > 0 && share <= 1) || cells == 0)
    throw Error(ErrorCode::invalid_argument, workload.dataset->name + ": expected cells, and a share of them in (0, 1]");
  // A cell is met by the interval from center - w to center + w where w is at least reach[cell].
  std::vector<float> reach(static_cast<std::size_t>(cells));
  std::visit(
      [&](auto values) {
        parallel_for(cells, 1 << 14, [&](std::int64_t begin, std::int64_t end) {
          std::array<std::int64_t, kMaxCellVertices> ids;
          for (std::int64_t cell = begin; cell < end; ++cell) {
            const int count = grid.cell_points(cell, ids);
            double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
            for (int v = 0; v < count; ++v) {
              const double f = static_cast<double>(values[ids[v]]);
              lowest = std::min(lowest, f);
              highest = std::max(highest, f);
            }
            reach[cell] = static_cast<float>(std::max(center - highest, lowest - center));
          }
        });
      },
      workload.values().values);
  const auto at =
      reach.begin() + std::min<std::int64_t>(cells - 1, static_cast<std::int64_t>(share * static_cast<double>(cells)));
  std::nth_element(reach.begin(), at, reach.end());
  const double thinnest = (workload.values().upper - workload.values().lower) / 100;
  const double half = four_digits(std::max<double>(*at, thinnest));
  return {center - half, center + half};
}

double usual_center(const std::string& data, const PointArray& array) {
  if (data.starts_with(kBytes)) return 0.25 / kByteRange * 255;
  if (data.starts_with("torus") || data.starts_with("tets") || data.starts_with("mixed")) return 0.25;
  return (array.lower + array.upper) / 2;
}

}  // namespace isostrata::peers
