#include "data/derived/proxy_grid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <tuple>

#include "base/finite.h"
#include "base/parallel.h"
#include "data/derived/proxy_cells.h"

namespace isostrata {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// In shares of the array's range; halves first, so that the width of all doubles is finite.
struct Shares {
  double lower = 0, half = 0;

  explicit Shares(const PointArray& array) : lower(array.lower), half(array.upper / 2 - array.lower / 2) {}
  double of(double value) const { return std::clamp((value / 2 - lower / 2) / half, 0.0, 1.0); }
};

Box3d finite_box(const Dataset& dataset) {
  if (!dataset.bounds.empty() && is_finite(dataset.bounds.lower) && is_finite(dataset.bounds.upper)) return dataset.bounds;
  Box3d box;
  for (std::int64_t id = 0, n = dataset.grid.point_count(); id < n; ++id)
    if (const Vec3d p = dataset.grid.point(id); is_finite(p)) box.include(p);
  return box;
}

int samples_along(double side, double longest) {
  if (!(side > 1e-9 * longest)) return 1;
  return std::clamp(static_cast<int>(std::lround(kMostProxySamples * side / longest)), kFewestProxySamples, kMostProxySamples);
}

/// Every s-th index of an axis.
std::vector<std::int64_t> strided(std::int64_t points, std::int64_t longest) {
  const std::int64_t stride = std::min<std::int64_t>((longest + kMostProxySamples - 1) / kMostProxySamples,
                                                     std::max<std::int64_t>(1, points / kFewestProxySamples));
  std::vector<std::int64_t> at;
  for (std::int64_t i = stride / 2; i < points; i += stride) at.push_back(i);
  return at;
}

template <class T>
void sample_uniform(ProxyGrid& proxy, const Grid& grid, const UniformGrid& shape, std::span<const T> all, const Shares& shares,
                    std::optional<double> missing) {
  const auto& dims = shape.dims;
  const std::int64_t longest = std::max({dims[0], dims[1], dims[2]});
  proxy.neighbour = 1.0 / static_cast<double>(std::max<std::int64_t>(longest - 1, 1));
  std::array<std::vector<std::int64_t>, 3> at;
  Vec3d spacing;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    at[axis] = strided(dims[axis], longest);
    proxy.dims[axis] = static_cast<int>(at[axis].size());
    spacing[a] = std::abs(shape.spacing[a]) / proxy.scale;
    const std::int64_t stride = at[axis].size() > 1 ? at[axis][1] - at[axis][0] : 1;
    proxy.step[a] = dims[axis] > 1 ? spacing[a] * static_cast<double>(stride) : 0;
    // A mirrored axis is walked from its far end, so that places grow with the samples' numbers.
    if (shape.spacing[a] < 0) std::reverse(at[axis].begin(), at[axis].end());
    proxy.corner[a] = shape.origin[a] + static_cast<double>(at[axis].front()) * shape.spacing[a];
  }
  const auto n =
      static_cast<std::size_t>(proxy.dims[0]) * static_cast<std::size_t>(proxy.dims[1]) * static_cast<std::size_t>(proxy.dims[2]);
  proxy.values.assign(n, kNone);
  proxy.slopes.assign(n, 0);
  for (auto& side : proxy.beside) side.assign(n, kNone);
  const std::array<std::int64_t, 3> jump{1, dims[0], dims[0] * dims[1]};
  const auto value = [&](std::int64_t id) -> float {
    const auto v = static_cast<double>(all[static_cast<std::size_t>(id)]);
    return std::isfinite(v) && v != missing ? static_cast<float>(shares.of(v)) : kNone;
  };
  const auto hidden = [&](const std::array<std::int64_t, 3>& i) {
    if (grid.hidden_cells.empty() || grid.cell_count() == 0) return false;
    std::int64_t cell = 0, width = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t cells = std::max<std::int64_t>(dims[a] - 1, 1);
      cell += width * std::min(i[a], cells - 1);
      width *= cells;
    }
    return grid.hidden(cell);
  };
  parallel_for(proxy.dims[2], 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t k = begin; k < end; ++k)
      for (int j = 0; j < proxy.dims[1]; ++j)
        for (int i = 0; i < proxy.dims[0]; ++i) {
          const std::array<std::int64_t, 3> index{at[0][static_cast<std::size_t>(i)], at[1][static_cast<std::size_t>(j)],
                                                  at[2][static_cast<std::size_t>(k)]};
          if (hidden(index)) continue;
          const std::int64_t id = index[0] + jump[1] * index[1] + jump[2] * index[2];
          const auto s =
              static_cast<std::size_t>(i) +
              static_cast<std::size_t>(proxy.dims[0]) *
                  (static_cast<std::size_t>(j) + static_cast<std::size_t>(proxy.dims[1]) * static_cast<std::size_t>(k));
          const float own = proxy.values[s] = value(id);
          double squares = 0;
          for (std::size_t a = 0; a < 3; ++a) {
            if (dims[a] < 2) continue;
            const bool down = index[a] > 0, up = index[a] + 1 < dims[a];
            const float low = down ? value(id - jump[a]) : kNone, high = up ? value(id + jump[a]) : kNone;
            proxy.beside[2 * a][s] = low;
            proxy.beside[2 * a + 1][s] = high;
            const float from = std::isnan(low) ? own : low, to = std::isnan(high) ? own : high;
            const int apart = (std::isnan(low) ? 0 : 1) + (std::isnan(high) ? 0 : 1);
            if (apart > 0) squares += std::pow((static_cast<double>(to) - from) / (apart * spacing[static_cast<int>(a)]), 2);
          }
          proxy.slopes[s] = std::isfinite(squares) ? static_cast<float>(std::sqrt(squares)) : 0;
        }
  });
}

/// Neighbours and slopes from the samples themselves.
void compare_samples(ProxyGrid& proxy) {
  const std::size_t n = proxy.size();
  proxy.slopes.assign(n, 0);
  for (auto& side : proxy.beside) side.assign(n, kNone);
  const std::array<std::size_t, 3> dims{static_cast<std::size_t>(proxy.dims[0]), static_cast<std::size_t>(proxy.dims[1]),
                                        static_cast<std::size_t>(proxy.dims[2])};
  const std::array<std::size_t, 3> jump{1, dims[0], dims[0] * dims[1]};
  for (std::size_t s = 0; s < n; ++s) {
    const float own = proxy.values[s];
    if (std::isnan(own)) continue;
    double squares = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t i = s / jump[a] % dims[a];
      const float low = i > 0 ? proxy.values[s - jump[a]] : kNone, high = i + 1 < dims[a] ? proxy.values[s + jump[a]] : kNone;
      proxy.beside[2 * a][s] = low;
      proxy.beside[2 * a + 1][s] = high;
      const float from = std::isnan(low) ? own : low, to = std::isnan(high) ? own : high;
      const int apart = (std::isnan(low) ? 0 : 1) + (std::isnan(high) ? 0 : 1);
      if (apart > 0) squares += std::pow((static_cast<double>(to) - from) / (apart * proxy.step[static_cast<int>(a)]), 2);
    }
    proxy.slopes[s] = static_cast<float>(std::sqrt(squares));
  }
}

/// Rim, fill and thickness, by counting faces between a sample and none.
void measure_domain(ProxyGrid& proxy) {
  const std::size_t n = proxy.size();
  proxy.rim.assign(n, 0);
  const std::array<std::size_t, 3> dims{static_cast<std::size_t>(proxy.dims[0]), static_cast<std::size_t>(proxy.dims[1]),
                                        static_cast<std::size_t>(proxy.dims[2])};
  const std::array<std::size_t, 3> jump{1, dims[0], dims[0] * dims[1]};
  std::array<std::int64_t, 3> faces{};
  for (std::size_t s = 0; s < n; ++s) {
    if (std::isnan(proxy.values[s])) continue;
    ++proxy.count;
    for (std::size_t a = 0; a < 3; ++a) {
      if (dims[a] < 2) continue;
      const std::size_t i = s / jump[a] % dims[a];
      const int open =
          (i == 0 || std::isnan(proxy.values[s - jump[a]])) + (i + 1 == dims[a] || std::isnan(proxy.values[s + jump[a]]));
      faces[a] += open;
      if (open) proxy.rim[s] = 1;
    }
  }
  proxy.fill = n ? static_cast<double>(proxy.count) / static_cast<double>(n) : 0;
  const Vec3d h = proxy.step;
  const bool flat = !(h.x > 0 && h.y > 0 && h.z > 0);
  const double area = static_cast<double>(faces[0]) * h.y * h.z + static_cast<double>(faces[1]) * h.x * h.z +
                      static_cast<double>(faces[2]) * h.x * h.y;
  const double volume = static_cast<double>(proxy.count) * h.x * h.y * h.z;
  proxy.thickness = flat || !(area > 0) ? 0 : 2 * volume / area / proxy.diagonal();
}

/// Gives every sample the value f(t), with the slope that follows from f's derivative there.
template <class F, class D>
void remap(ProxyGrid& proxy, F f, D derivative) {
  for (std::size_t s = 0; s < proxy.size(); ++s)
    if (!std::isnan(proxy.values[s]))
      proxy.slopes[s] = static_cast<float>(proxy.slopes[s] * derivative(static_cast<double>(proxy.values[s])));
  const auto move = [&](std::vector<float>& values) {
    for (float& t : values)
      if (!std::isnan(t)) t = static_cast<float>(std::clamp(f(static_cast<double>(t)), 0.0, 1.0));
  };
  move(proxy.values);
  for (auto& side : proxy.beside) move(side);
}

/// Where nearly all values lie in a small part of the range, a few that are far away would put all others into one bin: then [0,
/// 1] is the part, with what lies around it clamped. What then still grows by factors, not by steps (densities of galaxies,
/// concentrations), runs with its logarithm.
/// Returns the range to be looked at anew where single precision has no more to show of it.
std::optional<std::array<double, 2>> stretch(ProxyGrid& proxy) {
  constexpr double kBeyond = 0.001, kPart = 0.1;
  std::vector<float> some;
  for (const float t : proxy.values)
    if (!std::isnan(t)) some.push_back(t);
  if (some.size() < 2) return std::nullopt;
  const auto quantile = [&](double q) {
    const auto at = some.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(some.size() - 1));
    std::nth_element(some.begin(), at, some.end());
    return static_cast<double>(*at);
  };
  const double low = quantile(kBeyond), high = quantile(1 - kBeyond), median = proxy.value_at(quantile(0.5)),
               least_value = proxy.value_at(low);
  if (!(high > low)) return std::nullopt;
  if (high - low <= kPart) {
    const double from = std::max(0.0, low - (high - low) / 4), to = std::min(1.0, high + (high - low) / 4);
    const double lower = proxy.value_at(from), upper = proxy.value_at(to);
    if (!(lower < upper)) return std::nullopt;
    if (to - from < 1e-4) return std::array{lower, upper};
    remap(
        proxy, [&](double t) { return (t - from) / (to - from); }, [&](double) { return 1 / (to - from); });
    proxy.lower = lower;
    proxy.upper = upper;
  }
  constexpr double kLeastFactor = 200, kMostFactor = 1e7, kSkewed = 0.06;
  if (!(proxy.lower > 0) || proxy.thickness < 0.035 || proxy.share_at(median) > kSkewed) return std::nullopt;
  const double least = std::max(proxy.lower, least_value), factor = proxy.upper / least;
  if (!(factor >= kLeastFactor && factor <= kMostFactor)) return std::nullopt;
  const double width = proxy.upper - proxy.lower, lower = proxy.lower, decades = std::log(factor);
  const auto value = [=](double t) { return std::max(lower + t * width, least); };
  remap(
      proxy, [&](double t) { return std::log(value(t) / least) / decades; },
      [&](double t) { return width / value(t) / decades; });
  proxy.lower = least;
  proxy.logarithmic = true;
  return std::nullopt;
}

}  // namespace

double ProxyGrid::value_at(double t) const {
  return logarithmic ? lower * std::pow(upper / lower, t) : lower * (1 - t) + upper * t;
}
double ProxyGrid::share_at(double value) const {
  return logarithmic ? std::log(value / lower) / std::log(upper / lower) : (value / 2 - lower / 2) / (upper / 2 - lower / 2);
}

Vec3d ProxyGrid::place(std::size_t sample) const {
  const auto nx = static_cast<std::size_t>(dims[0]), ny = static_cast<std::size_t>(dims[1]);
  return {static_cast<double>(sample % nx) * step.x, static_cast<double>(sample / nx % ny) * step.y,
          static_cast<double>(sample / nx / ny) * step.z};
}

Vec3d ProxyGrid::sides() const { return {step.x * dims[0], step.y * dims[1], step.z * dims[2]}; }

ProxyGrid make_proxy(const Dataset& dataset, const PointArray& array, const Task& task, std::optional<double> missing) {
  ProxyGrid proxy;
  proxy.lower = array.lower;
  proxy.upper = array.upper;
  if (!(array.lower < array.upper)) return proxy;
  const Box3d box = finite_box(dataset);
  if (box.empty()) return proxy;
  const Vec3d size = box.upper - box.lower;
  const double longest = std::max({size.x, size.y, size.z});
  if (!(longest > 0) || !std::isfinite(longest)) return proxy;
  proxy.scale = longest;
  task.check();
  if (const auto* uniform = std::get_if<UniformGrid>(&dataset.grid.shape)) {
    std::visit([&](auto all) { sample_uniform(proxy, dataset.grid, *uniform, all, Shares(array), missing); }, array.values);
    measure_domain(proxy);
  } else {
    for (int a = 0; a < 3; ++a) {
      const int n = samples_along(size[a], longest);
      proxy.dims[static_cast<std::size_t>(a)] = n;
      proxy.step[a] = n > 1 ? size[a] / longest / n : 0;
      proxy.corner[a] = box.lower[a] + (n > 1 ? size[a] / n / 2 : 0);
    }
    proxy.neighbour = 1.0 / kMostProxySamples;
    proxy.values = sample_cells(dataset.grid, array, proxy, missing, task);
    compare_samples(proxy);
    measure_domain(proxy);
  }
  if (const auto closer = stretch(proxy)) {
    PointArray part = array;
    std::tie(part.lower, part.upper) = std::pair((*closer)[0], (*closer)[1]);
    return make_proxy(dataset, part, task, missing);
  }
  return proxy;
}

}  // namespace isostrata
