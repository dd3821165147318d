#include "extraction/layers/first_layers.h"

#include <algorithm>
#include <array>
#include <limits>
#include <mutex>

#include "base/parallel.h"

namespace isostrata {
namespace {

constexpr int kBins = 512;
constexpr int kLayers = 4;

// Weighted ends instead of a width: upper - lower may overflow where the range is that of all doubles.
double between(const PointArray& array, double t) { return t >= 1 ? array.upper : array.lower * (1 - t) + array.upper * t; }

/// How many cells have their smallest, and their largest, value in each bin of the array's range.
struct CellRanges {
  std::array<std::int64_t, kBins> smallest{}, largest{};
  std::int64_t cells = 0;

  void add(const CellRanges& other) {
    for (int i = 0; i < kBins; ++i) smallest[i] += other.smallest[i], largest[i] += other.largest[i];
    cells += other.cells;
  }
};

CellRanges count_ranges(const Grid& grid, const PointArray& array, const Task& task) {
  const double half = array.upper / 2 - array.lower / 2;
  CellRanges total;
  std::mutex mutex;  // of total
  std::visit(
      [&](auto values) {
        parallel_for(grid.cell_count(), 1 << 15, [&](std::int64_t begin, std::int64_t end) {
          task.check();
          CellRanges own;
          std::array<std::int64_t, kMaxCellVertices> ids;
          for (std::int64_t cell = begin; cell < end; ++cell) {
            if (grid.hidden(cell)) continue;
            const int n = grid.cell_points(cell, ids);
            double smallest = std::numeric_limits<double>::infinity(), largest = -smallest, sum = 0;
            for (int v = 0; v < n; ++v) {
              const auto value = static_cast<double>(values[static_cast<std::size_t>(ids[v])]);
              smallest = std::min(smallest, value);
              largest = std::max(largest, value);
              sum += value * 0;  // NaN where a value is not finite
            }
            if (sum != 0) continue;
            const auto bin = [&](double value) {
              return std::clamp(static_cast<int>((value / 2 - array.lower / 2) / half * kBins), 0, kBins - 1);
            };
            ++own.smallest[bin(smallest)];
            ++own.largest[bin(largest)];
            ++own.cells;
          }
          std::lock_guard lock(mutex);
          total.add(own);
        });
      },
      array.values);
  return total;
}

/// Cells that meet the bins [first, last].
std::int64_t cells_cut(const CellRanges& ranges, int first, int last) {
  std::int64_t cells = ranges.cells;
  for (int i = 0; i < first; ++i) cells -= ranges.largest[i];
  for (int i = last + 1; i < kBins; ++i) cells -= ranges.smallest[i];
  return cells;
}

struct Layer {
  int first = 0, last = 0;  // bins
  std::int64_t cells = 0;
};

/// One bin thick, in the middle of the quarter.
Layer thinnest(const CellRanges& ranges, int quarter) {
  constexpr int kQuarter = kBins / kLayers;
  const int middle = quarter * kQuarter + kQuarter / 2;
  return {middle, middle, cells_cut(ranges, middle, middle)};
}

/// Grown evenly to both sides, at most to its quarter, while it cuts no more than its share. A layer about as thick as a cell
/// costs little more than the thinnest and is the least that can be seen, so half as many cells again are always allowed.
Layer grow(const CellRanges& ranges, Layer layer, std::int64_t share) {
  const int middle = layer.first;
  share = std::max(share, layer.cells + layer.cells / 2);
  for (int reach = 1; reach < kBins / kLayers / 2; ++reach) {
    const std::int64_t cells = cells_cut(ranges, middle - reach, middle + reach);
    if (cells > share) break;
    layer = {middle - reach, middle + reach, cells};
  }
  return layer;
}

}  // namespace

std::vector<Interval> first_layers(const Grid& grid, const PointArray& array, std::int64_t cell_budget, const Task& task) {
  if (!(array.lower < array.upper)) return {};
  std::vector<Layer> layers;
  if (grid.cell_count() <= cell_budget) {
    for (int i = 0; i < kLayers; ++i) layers.push_back({i * kBins / kLayers, (i + 1) * kBins / kLayers - 1, 0});
  } else {
    const CellRanges ranges = count_ranges(grid, array, task);
    std::int64_t cells = 0;
    for (int i = 0; i < kLayers; ++i) {
      layers.push_back(thinnest(ranges, i));
      cells += layers.back().cells;
    }
    while (cells > cell_budget && layers.size() > 1) {
      const auto costliest =
          std::max_element(layers.begin(), layers.end(), [](const Layer& a, const Layer& b) { return a.cells < b.cells; });
      cells -= costliest->cells;
      layers.erase(costliest);
    }
    for (Layer& layer : layers) layer = grow(ranges, layer, cell_budget / static_cast<std::int64_t>(layers.size()));
  }
  std::vector<Interval> intervals;
  for (const Layer& layer : layers) {
    const Interval interval{between(array, static_cast<double>(layer.first) / kBins),
                            between(array, static_cast<double>(layer.last + 1) / kBins)};
    if (interval.lower < interval.upper) intervals.push_back(interval);
  }
  return intervals;
}

}  // namespace isostrata
