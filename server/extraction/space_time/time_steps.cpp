#include "extraction/space_time/time_steps.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "extraction/mesh/memory_budget.h"

namespace isostrata {
namespace {

/// In as few digits as name the number.
std::string text(double number) {
  std::array<char, 32> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
  return {buffer.data(), end};
}

[[noreturn]] void differ(const Dataset& first, const Dataset& second, const std::string& how) {
  throw Error(ErrorCode::unsupported,
              first.name + ": steps " + std::to_string(first.step) + " and " + std::to_string(second.step) +
                  " are not one mesh: " + how +
                  "; a time between them needs the same cells at both (--time-mode step takes the nearest)");
}

std::string numbers(const std::array<std::int64_t, 3>& dims) {
  return std::to_string(dims[0]) + " x " + std::to_string(dims[1]) + " x " + std::to_string(dims[2]);
}

/// The first index at which two equally long spans differ, or their size.
template <class T>
std::size_t first_difference(std::span<const T> a, std::span<const T> b, const Task& task) {
  if (a.data() == b.data()) return a.size();
  std::atomic<std::size_t> found{a.size()};
  parallel_for(static_cast<std::int64_t>(a.size()), 1 << 18, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    const auto at =
        static_cast<std::size_t>(std::mismatch(a.begin() + begin, a.begin() + end, b.begin() + begin).first - a.begin());
    if (at == static_cast<std::size_t>(end)) return;
    std::size_t known = found.load();
    while (at < known && !found.compare_exchange_weak(known, at)) {
    }
  });
  return found.load();
}

/// Arrays in memory that a dataset keeps alive.
template <class T>
std::shared_ptr<std::vector<T>> owned(std::int64_t count) {
  return std::make_shared<std::vector<T>>(static_cast<std::size_t>(count));
}

template <class To>
PointArray between(const PointArray& first, const PointArray& second, double weight, const Task& task) {
  const auto count = static_cast<std::int64_t>(std::visit([](auto v) { return v.size(); }, first.values));
  const auto values = owned<To>(count);
  constexpr std::int64_t kBlock = 1 << 14;
  parallel_for(count, kBlock, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    To* const to = values->data();
    // One pass for each step, so that types need not be paired.
    std::visit(
        [&](auto from) {
          for (std::int64_t i = begin; i < end; ++i) to[i] = static_cast<To>(from[i]);
        },
        first.values);
    std::visit(
        [&](auto from) {
          for (std::int64_t i = begin; i < end; ++i) {
            const auto a = static_cast<double>(to[i]), b = static_cast<double>(from[i]);
            const double at = a == b ? a : a * (1 - weight) + b * weight;
            to[i] = std::isfinite(a) && std::isfinite(b) ? static_cast<To>(at) : std::numeric_limits<To>::quiet_NaN();
          }
        },
        second.values);
  });
  PointArray out;
  out.name = first.name;
  out.association = first.association;
  out.components = first.components;
  out.component = first.component;
  out.unit = first.unit;
  out.type = std::is_same_v<To, float> ? ScalarType::float32 : ScalarType::float64;
  out.values = std::span<const To>(*values);
  out.storage = values;
  measure_range(out);
  return out;
}

bool exact_in_float(const PointArray& array) {
  return std::visit(
      [](auto values) {
        using T = std::remove_const_t<typename decltype(values)::element_type>;
        return std::is_same_v<T, float> || sizeof(T) <= 2;
      },
      array.values);
}

std::shared_ptr<std::vector<Vec3d>> points_between(const Grid& first, const Grid& second, double weight, const Task& task) {
  const auto points = owned<Vec3d>(first.point_count());
  parallel_for(first.point_count(), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t i = begin; i < end; ++i) {
      const Vec3d a = first.point(i);
      (*points)[i] = a + (second.point(i) - a) * weight;
    }
  });
  return points;
}

bool same_points(const PointSpan& a, const PointSpan& b, const Task& task) {
  if (a.index() != b.index()) return false;
  return std::visit(
      [&](auto at_a) {
        const auto at_b = std::get<decltype(at_a)>(b);
        return first_difference(at_a, at_b, task) == at_a.size();
      },
      a);
}

/// The first step's points on their way, owned by what is returned; nothing if they stay.
struct MovedPoints {
  PointSpan points;
  std::shared_ptr<const void> storage;
};
MovedPoints move_points(const PointSpan& a, const PointSpan& b, const Grid& first, const Grid& second, double weight,
                        const Task& task) {
  if (same_points(a, b, task)) return {a, nullptr};
  const auto points = points_between(first, second, weight, task);
  return {std::span<const Vec3d>(*points), points};
}

Grid grid_between(const Dataset& earlier, const Dataset& later, double weight, const Task& task) {
  const Grid& first = earlier.grid;
  const Grid& second = later.grid;
  Grid out = first;
  std::shared_ptr<const void> points;
  if (auto* shape = std::get_if<UniformGrid>(&out.shape)) {
    const auto& other = std::get<UniformGrid>(second.shape);
    for (int axis = 0; axis < 3; ++axis)
      if ((shape->spacing[axis] > 0) != (other.spacing[axis] > 0))
        throw Error(ErrorCode::unsupported, earlier.name + ": the spacing along " + "xyz"[axis] + " is " +
                                                text(shape->spacing[axis]) + " at step " + std::to_string(earlier.step) +
                                                " and " + text(other.spacing[axis]) + " at step " + std::to_string(later.step) +
                                                ": the grid turns over on the way");
    if (!(shape->origin == other.origin)) shape->origin = lerp(shape->origin, other.origin, weight);
    if (!(shape->spacing == other.spacing)) shape->spacing = lerp(shape->spacing, other.spacing, weight);
  } else if (auto* rectilinear = std::get_if<RectilinearGrid>(&out.shape)) {
    const auto& other = std::get<RectilinearGrid>(second.shape);
    for (int axis = 0; axis < 3; ++axis) {
      auto& own = rectilinear->axes[axis];
      const auto& theirs = other.axes[axis];
      if (own.size() > 1 && (own[0] < own[1]) != (theirs[0] < theirs[1]))
        throw Error(ErrorCode::unsupported, earlier.name + ": the axis " + "xyz"[axis] + " runs the other way at step " +
                                                std::to_string(later.step) + ": the grid turns over on the way");
      for (std::size_t i = 0; i < own.size(); ++i)
        if (own[i] != theirs[i]) own[i] += (theirs[i] - own[i]) * weight;
    }
  } else if (auto* curvilinear = std::get_if<CurvilinearGrid>(&out.shape)) {
    auto moved = move_points(curvilinear->points, std::get<CurvilinearGrid>(second.shape).points, first, second, weight, task);
    curvilinear->points = moved.points;
    points = std::move(moved.storage);
  } else {
    auto& shape = std::get<UnstructuredGrid>(out.shape);
    auto moved = move_points(shape.points, std::get<UnstructuredGrid>(second.shape).points, first, second, weight, task);
    shape.points = moved.points;
    points = std::move(moved.storage);
  }
  std::shared_ptr<std::vector<std::uint8_t>> hidden;
  if (!second.hidden_cells.empty() && second.hidden_cells.data() != first.hidden_cells.data()) {
    hidden = owned<std::uint8_t>(first.cell_count());
    for (std::int64_t c = 0; c < first.cell_count(); ++c) (*hidden)[c] = first.hidden(c) || second.hidden(c);
    out.hidden_cells = *hidden;
  }
  using Kept = std::array<std::shared_ptr<const void>, 4>;
  out.storage = std::make_shared<const Kept>(Kept{first.storage, second.storage, points, hidden});
  return out;
}

}  // namespace

TimePlace place_time(const std::string& dataset, std::span<const double> times, double time) {
  if (times.empty()) throw Error(ErrorCode::bad_data, dataset + ": no time step");
  if (!(time >= times.front() && time <= times.back()))
    throw Error(ErrorCode::invalid_argument, dataset + ": time " + text(time) + " is outside its times; expected " +
                                                 (times.size() == 1 ? text(times.front()) + ", the time of its only step"
                                                                    : text(times.front()) + " to " + text(times.back())));
  TimePlace place;
  const auto after = std::upper_bound(times.begin(), times.end(), time) - times.begin();
  place.first = place.second = static_cast<int>(after) - 1;
  if (times[place.first] == time) return place;
  place.second = place.first + 1;
  place.weight = (time - times[place.first]) / (times[place.second] - times[place.first]);
  if (!(place.weight < 1)) {  // rounded to the end
    place.first = place.second;
    place.weight = 0;
  }
  if (place.weight == 0) place.second = place.first;
  return place;
}

int nearest_step(const std::string& dataset, std::span<const double> times, double time) {
  const TimePlace place = place_time(dataset, times, time);
  return time - times[place.first] <= times[place.second] - time ? place.first : place.second;
}

void check_same_cells(const Dataset& first, const Dataset& second, const Task& task) {
  const Grid& a = first.grid;
  const Grid& b = second.grid;
  if (a.shape.index() != b.shape.index())
    differ(first, second, std::string("the grid is ") + a.kind_name() + " at the one and " + b.kind_name() + " at the other");
  if (a.structured()) {
    if (a.dims() != b.dims()) differ(first, second, numbers(a.dims()) + " points and " + numbers(b.dims()) + " points");
    return;
  }
  const auto count = [&](std::int64_t at_a, std::int64_t at_b, const char* what) {
    if (at_a != at_b) differ(first, second, std::to_string(at_a) + " " + what + " and " + std::to_string(at_b) + " " + what);
  };
  count(a.point_count(), b.point_count(), "points");
  count(a.cell_count(), b.cell_count(), "cells");
  const auto& at_a = std::get<UnstructuredGrid>(a.shape);
  const auto& at_b = std::get<UnstructuredGrid>(b.shape);
  const std::size_t type = first_difference(at_a.types, at_b.types, task);
  if (type < at_a.types.size())
    differ(first, second,
           "cell " + std::to_string(type) + " is a " + std::string(topology(CellType{at_a.types[type]}).name) + " and a " +
               std::string(topology(CellType{at_b.types[type]}).name));
  const std::size_t id = first_difference(at_a.connectivity, at_b.connectivity, task);
  if (id < at_a.connectivity.size()) {
    const auto after = std::upper_bound(at_a.offsets.begin(), at_a.offsets.end(), static_cast<std::int64_t>(id));
    differ(first, second,
           "cell " + std::to_string(after - at_a.offsets.begin() - 1) + " joins other points (" +
               std::to_string(at_a.connectivity[id]) + " and " + std::to_string(at_b.connectivity[id]) + ")");
  }
}

bool points_move(const Grid& a, const Grid& b, const Task& task) {
  if (const auto* own = std::get_if<UniformGrid>(&a.shape)) {
    const auto& other = std::get<UniformGrid>(b.shape);
    return !(own->origin == other.origin && own->spacing == other.spacing);
  }
  if (const auto* own = std::get_if<RectilinearGrid>(&a.shape)) return own->axes != std::get<RectilinearGrid>(b.shape).axes;
  for (std::int64_t i = 0; i < a.point_count(); ++i) {
    if (i % 65536 == 0) task.check();
    if (!(a.point(i) == b.point(i))) return true;
  }
  return false;
}

const PointArray& array_at_step(const Dataset& dataset, const std::string& name) {
  try {
    return dataset.array(name);
  } catch (const Error& error) {
    throw Error(error.code(), "step " + std::to_string(dataset.step) + ": " + error.what());
  }
}

std::shared_ptr<const Dataset> between_steps(const std::shared_ptr<const Dataset>& first,
                                             const std::shared_ptr<const Dataset>& second, double weight,
                                             std::span<const std::string> arrays, std::uint64_t max_bytes, const Task& task) {
  task.report(0, "interpolating");
  check_same_cells(*first, *second, task);
  const auto np = static_cast<std::uint64_t>(first->grid.point_count());
  std::vector<std::pair<const PointArray*, const PointArray*>> pairs;
  std::uint64_t bytes = first->grid.rectilinear() ? 0 : np * sizeof(Vec3d);
  for (const std::string& name : arrays) {
    pairs.emplace_back(&array_at_step(*first, name), &array_at_step(*second, name));
    bytes += np * (exact_in_float(*pairs.back().first) && exact_in_float(*pairs.back().second) ? 4 : 8);
  }
  check_budget("the field between two steps", bytes, max_bytes);
  auto out = std::make_shared<Dataset>();
  out->name = first->name;
  out->times = first->times;
  out->step = first->step;
  out->cell_types = first->cell_types;
  out->grid = grid_between(*first, *second, weight, task);
  out->bounds = out->grid.bounds();
  for (const auto& [a, b] : pairs)
    out->arrays.push_back(exact_in_float(*a) && exact_in_float(*b) ? between<float>(*a, *b, weight, task)
                                                                   : between<double>(*a, *b, weight, task));
  task.check();
  return out;
}

}  // namespace isostrata
