#include "engine/engine/jobs.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "engine/engine/thumbnail.h"
#include "engine/messages/failure_of.h"
#include "engine/picture/export_mesh.h"
#include "engine/picture/interval_facts.h"
#include "engine/picture/layer_statistics.h"
#include "engine/picture/line_values.h"
#include "engine/picture/probe_scene.h"
#include "engine/picture/step_values.h"

namespace isostrata {
namespace {

std::uint64_t lane_of_dataset(const std::string& dataset) { return std::hash<std::string>()(dataset); }

/// Of a session; of none: of the dataset.
std::uint64_t lane_of(SessionKey session, const std::string& dataset) {
  return session != 0 ? session : lane_of_dataset(dataset) | std::uint64_t{1} << 63;
}

}  // namespace

Jobs::Jobs(JobOptions options, OpenDatasets& datasets, RunningOperations& operations, MemoryForJobs memory, FrameEngine::Sink sink)
    : options_(options), datasets_(datasets), operations_(operations), memory_(std::move(memory)), send_(std::move(sink)) {}

template <class Answer>
void Jobs::run(WorkClass of, SessionKey session, RequestId request, Operation& operation, const Answer& answer) {
  try {
    const Doing opening(options_.board, Stage::opening, session, request, operation.id());
    operation.task().check();
    const Work work(session, of, {&operation.task(), true, opening.waiting()});
    send_(answer(operation.task()));
  } catch (...) {
    send_(failure_of(std::current_exception(), session, request));
  }
  operation.finish();
}

template <class Request, class Answer>
void Jobs::answer(Lanes& lanes, std::uint64_t lane, WorkClass of, const Request& request, Answer answer) {
  if (Running operation = operations_.begin(request.session, request.request))
    lanes.post(lane, [this, of, request, answer = std::move(answer), operation = std::move(operation)] {
      run(of, request.session, request.request, *operation, [&](const Task& task) { return answer(request, task); });
    });
}

void Jobs::describe(const OpenRequest& request, Operation& operation, WorkClass of) {
  run(of, request.session, request.request, operation,
      [&](const Task& task) { return DatasetReady{request.session, request.request, datasets_.describe(request.dataset, task)}; });
}

void Jobs::post(const OpenRequest& request) {
  const Running operation = operations_.begin(request.session, request.request);
  if (!operation) return;
  if (request.all_ranges)
    readers_.post(lane_of_dataset(request.dataset), [this, request, operation] { read_ranges(request, operation); });
  else
    openers_.post(lane_of(request.session, request.dataset), [this, request, operation] { describe(request, *operation, WorkClass::scene); });
}

// One more step, then whoever else waits for the same series: what two sessions show is read once. The importers that are
// started here are as nice as the thread.
void Jobs::read_ranges(const OpenRequest& request, const Running& operation) {
  bool more = false;
  try {
    const Doing opening(options_.board, Stage::opening, request.session, request.request, operation->id());
    const Task& task = operation->task();
    const Work work(request.session, WorkClass::background, {&task, true, opening.waiting()});
    task.check();
    if (const auto next = datasets_.next_unknown(request.dataset, task)) {
      operation->report_part(next->known / next->steps, (next->known + 1) / next->steps, "reading the ranges of all steps");
      task.report(0, "reading");
      datasets_.read_ranges(request.dataset, next->step, task);
      more = true;
    }
  } catch (...) {
    send_(failure_of(std::current_exception(), request.session, request.request));
    return operation->finish();
  }
  if (more)
    readers_.post(lane_of_dataset(request.dataset), [this, request, operation] { read_ranges(request, operation); });
  else
    describe(request, *operation, WorkClass::background);
}

void Jobs::post(const HistogramRequest& request) {
  answer(counters_, lane_of(request.session, request.dataset), WorkClass::still, request,
         [this](const HistogramRequest& of, const Task& task) { return histogram(of, task); });
}

HistogramReady Jobs::histogram(const HistogramRequest& of, const Task& task) {
  const auto dataset = datasets_.acquire(datasets_.entry(of.dataset), of.step, task);
  const PointArray& named = dataset->array(of.array);
  const PointArray array = of.values == FieldValues::whole && named.cells ? as_array(*named.cells, named.name) : named;
  const ValueRange range = join(of.least, {array.lower, array.upper});
  std::vector<std::uint64_t> counts(static_cast<std::size_t>(std::clamp(of.bins, 0, 1 << 20)));
  if (!range.empty()) counts = datasets_.histogram(of.dataset, dataset, array, range, of.bins, task);
  return {of.session, of.request, of.dataset, of.step, of.array, range.lower, range.upper, std::move(counts)};
}

void Jobs::post(const StatisticsRequest& request) {
  answer(counters_, lane_of(request.session, request.dataset), WorkClass::still, request, [this](const StatisticsRequest& of, const Task& task) {
    const auto dataset = datasets_.acquire(datasets_.entry(of.dataset), of.step, task);
    const PointArray& array = dataset->array(of.array);
    return StatisticsReady{of.session, of.request, of.dataset, of.step, of.array, datasets_.statistics(of.dataset, dataset, array, task)};
  });
}

void Jobs::post(const ExportRequest& request) {
  answer(exporters_, request.session, WorkClass::background, request, [this](const ExportRequest& of, const Task& task) {
    const CatalogueEntry source = datasets_.entry(of.scene.dataset);
    const StepSource steps = datasets_.whole_steps(source);
    const std::uint64_t bytes = memory_.for_export(of);
    const auto room = memory_.lend(of.session, bytes, "this export");
    return ExportReady{of.session, of.request, export_mesh(steps, of.scene, of.path, of.options, {.memory = bytes}, task)};
  });
}

void Jobs::post(const MeasureRequest& request, std::shared_ptr<const ExtractedScene> ready) {
  answer(counters_, request.session, WorkClass::idle, request, [this, ready = std::move(ready)](const MeasureRequest& of, const Task& task) {
    return LayersMeasured{of.session, of.request, of.scene.revision, measured(of, ready, task)};
  });
}

/// How far a volume may be off is asked of the cells, which are not kept if pictures are made of bricks. If they need more than a quarter of the memory
/// that is free, that is left open.
std::vector<IntervalFacts> Jobs::measured(const MeasureRequest& request, const std::shared_ptr<const ExtractedScene>& ready, const Task& task) {
  const CatalogueEntry source = datasets_.entry(request.scene.dataset);
  const StepSource steps = datasets_.steps(source);
  if (ready && !ready->bricks) return interval_facts(*ready, request.scene, true, task);
  try {
    SceneAids aids;
    aids.max_bytes = memory_.quarter_of_free();
    const auto room = memory_.lend(request.session, aids.max_bytes, "measuring layers");
    Scene unscaled = request.scene;  // as the steps are
    unscaled.axis_scale = kUnscaled;
    return interval_facts(*extract_by(options_.ranks, {source.source, source.id}, steps, unscaled, nullptr, task, aids), unscaled, true, task);
  } catch (const Error& error) {
    if (!ready || error.code() != ErrorCode::too_large) throw;
    return interval_facts(*ready, request.scene, false, task);
  }
}

void Jobs::post(const ProbeRequest& request) {
  answer(probers_, request.session, WorkClass::still, request, [this](const ProbeRequest& of, const Task& task) {
    const CatalogueEntry source = datasets_.entry(of.scene.dataset);
    const ProbeFacts facts = probe_scene(datasets_.steps(source), of.scene, {of.x, of.y, of.width, of.height}, task);
    return ProbeReady{of.session, of.request, of.scene.revision, facts};
  });
}

void Jobs::post(const CurveRequest& request) {
  const Running operation = operations_.begin(request.session, request.request);
  if (!operation) return;
  (request.to ? probers_ : followers_).post(request.session, [this, request, operation] {
    run(request.to ? WorkClass::still : WorkClass::background, request.session, request.request, *operation, [&](const Task& task) {
      const CatalogueEntry source = datasets_.entry(request.scene.dataset);
      const StepSource steps = datasets_.steps(source);
      const auto begin_step = [&](int step, int of) {
        operation->report_part(double(step) / of, double(step + 1) / of, "reading values, step " + std::to_string(step + 1) + " of " + std::to_string(of));
        task.report(0, "reading");
      };
      return CurveReady{request.session, request.request, request.scene.revision,
                        request.to ? line_values(steps, request.scene, request.array, request.from, *request.to, task)
                                   : step_values(steps, request.scene, request.array, request.from, begin_step, task)};
    });
  });
}

void Jobs::post(const LayerStatisticsRequest& request) {
  answer(counters_, request.session, WorkClass::still, request, [this](const LayerStatisticsRequest& of, const Task& task) {
    const CatalogueEntry source = datasets_.entry(of.scene.dataset);
    const std::uint64_t bytes = memory_.quarter_of_free();
    const auto room = memory_.lend(of.session, bytes, "a layer's statistics");
    return LayerStatisticsReady{of.session, of.request, of.scene.revision, of.interval, layer_statistics(datasets_.steps(source), of.scene, of.interval, of.array, bytes, task)};
  });
}

void Jobs::post(const ThumbnailRequest& request) {
  answer(thumbnails_, lane_of(0, request.dataset), WorkClass::background, request, [this](const ThumbnailRequest& of, const Task& task) {
    return ThumbnailReady{of.session, of.request, make_thumbnail(datasets_, of.dataset, options_.max_bytes, memory_.lend_what_is_free, task)};
  });
}

}  // namespace isostrata
