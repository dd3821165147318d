#include "data/derived/coarse_error.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <mutex>
#include <variant>
#include <vector>

#include "base/parallel.h"

namespace isostrata {
namespace {

/// Differences are added up here, block by block.
class Differences {
 public:
  void add(double value, double coarse) {
    const double difference = std::abs(value - coarse);
    if (!std::isfinite(difference)) return;
    error_.largest = std::max(error_.largest, difference);
    sum_ += difference;
    ++error_.points;
  }
  void add(const Differences& block) {
    error_.largest = std::max(error_.largest, block.error_.largest);
    error_.points += block.error_.points;
    sum_ += block.sum_;
  }
  CoarseError all() const {
    CoarseError error = error_;
    if (error.points > 0) error.mean = sum_ / static_cast<double>(error.points);
    return error;
  }

 private:
  CoarseError error_;
  double sum_ = 0;
};

/// body(begin, end, differences) over blocks of [0, count).
CoarseError compare(std::int64_t count, std::int64_t grain, const Task& task,
                    const std::function<void(std::int64_t begin, std::int64_t end, Differences& differences)>& body) {
  std::mutex mutex;
  Differences all;
  parallel_for(count, grain, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    Differences block;
    body(begin, end, block);
    const std::lock_guard lock(mutex);
    all.add(block);
  });
  return all.all();
}

/// Where an index of the whole lies between two kept ones.
struct Between {
  std::size_t below, above;
  double share;  // of the way
};
Between between(std::int64_t index, std::int64_t stride, std::int64_t kept) {
  const std::int64_t below = index / stride, beyond = index % stride;
  return {static_cast<std::size_t>(below), static_cast<std::size_t>(std::min(below + 1, kept - 1)), static_cast<double>(beyond) / static_cast<double>(stride)};
}

/// A point that is kept counts for itself alone, whatever its neighbours are: 0 times NaN is not a value.
double mix(double a, double b, double share) { return share == 0 ? a : a + (b - a) * share; }

using Dims = std::array<std::int64_t, 3>;

template <class T>
void compare_row(std::span<const T> all, std::span<const T> kept, const Dims& of, const Dims& dims, const Dims& stride, std::int64_t j, std::int64_t k,
                 std::vector<double>& line, Differences& differences) {
  const Between y = between(j, stride[1], dims[1]), z = between(k, stride[2], dims[2]);
  const auto row = [&](std::size_t at_y, std::size_t at_z) {
    return kept.subspan((at_z * static_cast<std::size_t>(dims[1]) + at_y) * static_cast<std::size_t>(dims[0]), static_cast<std::size_t>(dims[0]));
  };
  const auto a = row(y.below, z.below), b = row(y.above, z.below), c = row(y.below, z.above), d = row(y.above, z.above);
  for (std::size_t i = 0; i < line.size(); ++i)
    line[i] = mix(mix(static_cast<double>(a[i]), static_cast<double>(b[i]), y.share), mix(static_cast<double>(c[i]), static_cast<double>(d[i]), y.share), z.share);
  const auto own = all.subspan(static_cast<std::size_t>((k * of[1] + j) * of[0]), static_cast<std::size_t>(of[0]));
  for (std::int64_t i = 0, last = (dims[0] - 1) * stride[0]; i <= last; ++i) {
    const Between x = between(i, stride[0], dims[0]);
    differences.add(static_cast<double>(own[static_cast<std::size_t>(i)]), mix(line[x.below], line[x.above], x.share));
  }
}

}  // namespace

CoarseError coarse_error(const Dataset& whole, const Dataset& coarse, const std::array<std::int64_t, 3>& stride, const std::string& array, const Task& task) {
  const Dims of = whole.grid.dims(), dims = coarse.grid.dims();
  const PointArray& kept = coarse.array(array);
  return std::visit(
      [&](auto all) {
        const auto some = std::get<decltype(all)>(kept.values);
        return compare((dims[2] - 1) * stride[2] + 1, 1, task, [&](std::int64_t begin, std::int64_t end, Differences& differences) {
          std::vector<double> line(static_cast<std::size_t>(dims[0]));
          for (std::int64_t k = begin; k < end; ++k)
            for (std::int64_t j = 0; j <= (dims[1] - 1) * stride[1]; ++j) compare_row(all, some, of, dims, stride, j, k, line, differences);
        });
      },
      whole.array(array).values);
}

CoarseError sampled_error(const Dataset& mesh, const Dataset& samples, const std::string& array, const Task& task) {
  const auto& grid = std::get<UniformGrid>(samples.grid.shape);
  const PointArray &values = mesh.array(array), &sampled = samples.array(array);
  // A sample beyond the last counts with no share, and is the last.
  const auto at = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    const auto& [nx, ny, nz] = grid.dims;
    return sampled.at(static_cast<std::size_t>((std::min(k, nz - 1) * ny + std::min(j, ny - 1)) * nx + std::min(i, nx - 1)));
  };
  return compare(mesh.grid.point_count(), 1 << 14, task, [&](std::int64_t begin, std::int64_t end, Differences& differences) {
    for (std::int64_t id = begin; id < end; ++id) {
      const Vec3d p = mesh.grid.point(id);
      Dims below{};
      Vec3d share;
      for (int a = 0; a < 3; ++a) {
        const auto axis = static_cast<std::size_t>(a);
        const double index = std::clamp((p[a] - grid.origin[a]) / grid.spacing[a], 0.0, static_cast<double>(grid.dims[axis] - 1));
        below[axis] = std::isfinite(index) ? static_cast<std::int64_t>(index) : 0;
        share[a] = index - static_cast<double>(below[axis]);
      }
      const auto& [i, j, k] = below;
      const auto along_x = [&, i = i](std::int64_t y, std::int64_t z) { return mix(at(i, y, z), at(i + 1, y, z), share.x); };
      const auto along_y = [&, j = j](std::int64_t z) { return mix(along_x(j, z), along_x(j + 1, z), share.y); };
      differences.add(values.at(static_cast<std::size_t>(id)), mix(along_y(k), along_y(k + 1), share.z));
    }
  });
}

}  // namespace isostrata
