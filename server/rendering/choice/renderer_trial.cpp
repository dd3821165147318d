#include "rendering/choice/renderer_trial.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <map>
#include <mutex>

#include "base/error.h"
#include "base/stopwatch.h"
#include "data/dataset/analytic.h"
#include "extraction/intervals/extract_intervals.h"
#include "rendering/compute/compute_renderer.h"
#include "rendering/raster/gl_renderer.h"

namespace isostrata {
namespace {

std::mutex mutex;
std::map<std::string, RendererTrial> trials;  // by the device's name, under the mutex
std::string latest;                           // report of the last one, under the mutex

/// Two intervals around a torus: 120 K tetrahedra on a GPU, 5 K on a software device. input.grid lives in the dataset.
DrawInput trial_input(bool software, std::shared_ptr<const Dataset>& dataset) {
  dataset = make_analytic(software ? "torus:16" : "torus:64", {}, Task{});
  ExtractOptions options;
  options.measure = false;
  const std::vector<Interval> intervals{{0.1, 0.2}, {0.2, 0.3}};
  IntervalMesh mesh = extract_intervals(dataset->grid, dataset->arrays[0], intervals, options, Task{});
  DrawInput input;
  input.grid = &dataset->grid;
  input.bounds = dataset->grid.bounds();
  for (std::size_t i = 0; i < intervals.size(); ++i) input.styles.emplace_back().color = default_interval_color(i);
  input.mesh = std::make_shared<const IntervalMesh>(std::move(mesh));
  input.width = software ? 96 : 1024;
  input.height = software ? 64 : 768;
  return input;
}

/// Of one renderer; its first frame, which compiles and uploads, does not count.
double fastest_ms(Renderer& renderer, DrawInput& input) {
  input.camera = view_of(input.bounds, "reset");
  renderer.draw(input);
  double fastest = std::numeric_limits<double>::infinity();
  for (const char* side : {"reset", "+x", "-y", "+z"}) {
    input.camera = view_of(input.bounds, side);
    const Stopwatch watch;
    renderer.draw(input);
    fastest = std::min(fastest, watch.elapsed_ms());
  }
  return fastest;
}

RendererTrial run_trial(const std::string& device) {
  std::shared_ptr<const Dataset> dataset;
  RendererTrial trial;
  DrawInput input;
  const auto attempt = [&](auto make, double& ms, std::string& error) {
    try {
      auto context = open_context(device);
      if (!input.mesh) {
        input = trial_input(context->software(), dataset);
        trial.device = context->device();
      }
      const std::unique_ptr<Renderer> renderer = make(std::move(context), device);
      ms = fastest_ms(*renderer, input);
    } catch (const Error& failure) {
      ms = 0;
      error = failure.what();
    }
  };
  const auto make_raster = [](std::unique_ptr<GlContext> context, const std::string& name) {
    return make_gl_renderer(std::move(context), name);
  };
  attempt(make_raster, trial.raster_ms, trial.raster_error);
  attempt(make_compute_renderer, trial.compute_ms, trial.compute_error);
  return trial;
}

}  // namespace

std::string RendererTrial::report() const {
  const auto figure = [](double ms, const std::string& error) {
    char text[64];
    std::snprintf(text, sizeof text, "%.2f ms", ms);
    return ms > 0 ? std::string(text) : "does not work: " + error;
  };
  const std::string by_raster = figure(raster_ms, raster_error), by_compute = figure(compute_ms, compute_error);
  return compute_is_faster() ? "compute: " + by_compute + " a frame in the trial; raster " + by_raster + " (" + device + ")"
                             : "raster: " + by_raster + " a frame in the trial; compute " + by_compute + " (" + device + ")";
}

std::unique_ptr<Renderer> make_faster_renderer(const std::string& device) {
  auto context = open_context(device);
  RendererTrial trial;
  {
    const std::lock_guard lock(mutex);
    const auto known = trials.find(context->device());
    if (known != trials.end()) {
      trial = known->second;
    } else {
      context->release();
      trial = run_trial(device);
      if (trial.raster_ms > 0 || trial.compute_ms > 0) trials[context->device()] = trial;
      latest = trial.report();
    }
  }
  context->make_current();
  if (!(trial.raster_ms > 0 || trial.compute_ms > 0))
    throw Error(ErrorCode::unavailable,
                context->device() + ": raster: " + trial.raster_error + "; compute: " + trial.compute_error);
  return trial.compute_is_faster() ? make_compute_renderer(std::move(context), device)
                                   : make_gl_renderer(std::move(context), device);
}

std::string renderer_trial_report() {
  const std::lock_guard lock(mutex);
  return latest;
}

}  // namespace isostrata
