#include "extraction/layers/extract_at_time.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/stopwatch.h"
#include "data/dataset/array_or_first.h"
#include "extraction/combine/combine_ranges.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/space_time/time_steps.h"

namespace isostrata {
namespace {

/// The time that a request means, and its place among the steps. `any` is a step that is at hand.
TimePlace place_of(const LayerRequest& request, const Dataset& any, LayerTime& out) {
  if (request.time) {
    out.time = *request.time;
    return place_time(any.name, any.times, *request.time);
  }
  if (request.step < 0 || request.step >= static_cast<int>(any.times.size()))
    throw Error(ErrorCode::not_found, any.name + ": no step " + std::to_string(request.step) + "; it has steps 0 to " +
                                          std::to_string(any.times.size() - 1));
  out.time = any.times[request.step];
  return {request.step, request.step, 0};
}

/// Cuts the terms' ranges out of a slice, whose tetrahedra are those of any mesh. carry(name) brings an array to the slice's
/// points.
template <class Carry>
void combine_slice(const LayerRequest& request, SpaceTimeSlice& slice, const Carry& carry, Layers& layers, const Task& task) {
  const std::size_t np = slice.mesh.positions.size();
  check_budget(std::to_string(request.terms.size() + request.carry.size()) + " arrays at " + std::to_string(np) + " points",
               (request.terms.size() + request.carry.size()) * np * sizeof(double), request.max_bytes);
  std::vector<Buffer<double>> fields{std::move(slice.mesh.values)};
  std::vector<FieldTerm> chain;
  for (const RangeTerm& term : request.terms) {
    chain.push_back({term.op, static_cast<int>(fields.size()), term.range});
    fields.push_back(carry(term.array));
  }
  const std::size_t carried = fields.size();
  for (const std::string& other : request.carry) fields.push_back(carry(other));
  slice.points = {};
  Combined combined = combine_ranges(std::move(slice.mesh), request.intervals.size(), std::move(fields), chain,
                                     {.facets = request.facets, .max_bytes = request.max_bytes}, task);
  layers.mesh = std::move(combined.mesh);
  for (std::size_t i = 0; i < request.carry.size(); ++i) {
    const Buffer<double>& values = combined.fields[carried + i];
    layers.carried.push_back({request.carry[i], {values.begin(), values.end()}});
  }
}

}  // namespace

KeptSpaceTime::Asked KeptSpaceTime::get(const std::shared_ptr<const Dataset>& first, const std::shared_ptr<const Dataset>& second,
                                        const std::string& array, const std::vector<Interval>& intervals, bool complement,
                                        std::uint64_t max_bytes, const Task& task) {
  std::unique_lock lock(making_, std::defer_lock);
  while (!lock.try_lock_for(std::chrono::milliseconds(10))) task.check();  // another may be making one for seconds
  const bool there = volume_ && volume_->first() == first && volume_->second() == second && volume_->array() == array &&
                     intervals_ == intervals && volume_->complement() == complement;
  if (there) return {volume_, 0};
  volume_.reset();  // first: both at once may not fit
  Stopwatch stopwatch;
  volume_ = std::make_shared<const SpaceTimeVolume>(first, second, array, intervals, max_bytes, task, complement);
  intervals_ = intervals;
  return {volume_, stopwatch.lap_ms()};
}

void KeptSpaceTime::forget() {
  const std::scoped_lock lock(making_);
  volume_.reset();
}

std::shared_ptr<const Dataset> dataset_at_time(const LayerRequest& request, const StepSource& steps, LayerTime& time,
                                               const Task& task) {
  auto any = steps(request.time ? 0 : request.step, task);
  TimePlace place = place_of(request, *any, time);
  if (request.time && request.time_mode == TimeMode::step) {
    const int nearest = nearest_step(any->name, any->times, *request.time);
    place = {nearest, nearest, 0};
  }
  time.first = place.first;
  time.second = place.second;
  time.weight = place.weight;
  time.mode = place.weight == 0 ? TimeMode::step : TimeMode::interpolate;
  std::vector<std::string> names{array_or_first(*any, request.array).name};
  any.reset();
  const auto first = steps(place.first, task);
  if (place.weight == 0) return first;
  const auto want = [&](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const std::string& name : request.carry) want(name);
  for (const RangeTerm& term : request.terms) want(term.array);
  return between_steps(first, steps(place.second, task), place.weight, names, request.max_bytes, task);
}

std::optional<Layers> slice_space_time(const LayerRequest& request, const StepSource& steps, KeptSpaceTime* kept,
                                       const Task& task) {
  auto any = steps(request.time ? 0 : request.step, task);
  Layers layers;
  TimePlace place = place_of(request, *any, layers.time);
  const int last = static_cast<int>(any->times.size()) - 1;
  if (last == 0 || any->grid.flat()) return std::nullopt;
  const std::string name = array_or_first(*any, request.array).name;
  any.reset();
  if (place.first == place.second) {  // at a step: a pair that has it
    if (place.first == last)
      place = {last - 1, last, 1};
    else
      place.second = place.first + 1;
  }
  const auto first = steps(place.first, task), second = steps(place.second, task);
  const auto check_array = [&](const std::string& other) {  // before the work is done
    array_at_step(*first, other);
    array_at_step(*second, other);
  };
  for (const std::string& other : request.carry) check_array(other);
  for (const RangeTerm& term : request.terms) check_array(term.array);
  layers.time.mode = TimeMode::spacetime;
  layers.time.first = place.first;
  layers.time.second = place.second;
  layers.time.weight = place.weight;
  KeptSpaceTime for_once;
  const auto asked = (kept ? *kept : for_once)
                         .get(first, second, name, request.intervals, needs_complement(request.terms), request.max_bytes, task);
  const SpaceTimeVolume& volume = *asked.volume;
  layers.time.build_ms = asked.build_ms;
  layers.time.simplices = static_cast<std::int64_t>(volume.simplices());
  layers.time.bytes = volume.bytes();

  SliceOptions options;
  options.facets = request.facets;
  options.measure = request.terms.empty();
  options.max_bytes = request.max_bytes - std::min(request.max_bytes, volume.bytes());
  Stopwatch stopwatch;
  SpaceTimeSlice slice = volume.slice(place.weight, options, task);
  layers.time.slice_ms = stopwatch.lap_ms();
  const auto carry = [&](const std::string& other) {
    return volume.carry(slice, array_at_step(*first, other), array_at_step(*second, other));
  };
  if (request.terms.empty()) {
    for (const std::string& other : request.carry) {
      const Buffer<double> values = carry(other);
      layers.carried.push_back({other, {values.begin(), values.end()}});
    }
    layers.mesh = std::move(slice.mesh);
  } else {
    combine_slice(request, slice, carry, layers, task);
  }

  layers.dataset = place.weight == 1 ? second : first;
  if (place.weight > 0 && place.weight < 1 && volume.moves()) {
    std::vector<std::string> names{name};
    for (const std::string& other : request.carry)
      if (std::find(names.begin(), names.end(), other) == names.end()) names.push_back(other);
    layers.dataset = between_steps(first, second, place.weight, names, request.max_bytes, task);
  }
  return layers;
}

}  // namespace isostrata
